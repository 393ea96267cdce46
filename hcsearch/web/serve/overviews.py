"""What stands above a list of designs: a title, how many of them open, and facets with counts."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import Database, SlowQueryError, count_values, summarize
from hcsearch.web.report.headline import StageCounts, headline_of, title_of
from hcsearch.web.serve.jobs import BusyError, ResultCache
from hcsearch.web.serve.long_lists import LongLists
from hcsearch.web.serve.requests import FACETS, ListRequest

OVERVIEW_SECONDS = 2.0
"""Time limit of all counts above a list together, in seconds; a list that takes longer has none."""
SLOW_OVERVIEW_SECONDS = 30.0
"""Time for which an overview that takes too long is not computed again, in seconds."""
MAX_FACET_VALUES = 20
"""Largest number of values that a facet offers."""
MAX_KEPT_OVERVIEWS = 200
"""Capacity of the cache of overviews."""


@dataclass(frozen=True)
class ListFacet:
    """A column of designs with values to choose from.

    values : (value, number of designs that have it among those that fit all else, whether it is chosen).
    """

    name: str
    values: Sequence[tuple[object, int, bool]]


@dataclass(frozen=True)
class Overview:
    """Title, sentence and facets of a list; empty where counting takes too long."""

    title: str
    sentence: str
    facets: Sequence[ListFacet]


NO_OVERVIEW = Overview("", "", ())


class Overviews:
    """A cache of overviews, valid while the database is unchanged."""

    def __init__(self) -> None:
        self._cache: ResultCache[tuple[Overview, float]] = ResultCache(MAX_KEPT_OVERVIEWS)  # and until when it is valid

    def of(self, database: Database, list_request: ListRequest, long_lists: LongLists) -> Overview:
        """Return the overview of a list of designs; `NO_OVERVIEW` if it takes too long or gets no turn."""
        key = (list_request.query, list_request.facets, list_request.scene, database.fingerprint())
        with suppress(KeyError):
            overview, end = self._cache[key]
            if time.monotonic() < end:
                return overview
        try:
            overview = long_lists(lambda seconds: _overview_of(database, list_request, seconds), OVERVIEW_SECONDS)
            end = math.inf
        except SlowQueryError:
            overview, end = NO_OVERVIEW, time.monotonic() + SLOW_OVERVIEW_SECONDS
        except (BusyError, DatabaseError):  # the list itself says what is damaged, if it concerns its rows
            return NO_OVERVIEW
        self._cache[key] = overview, end
        return overview


def _overview_of(database: Database, list_request: ListRequest, seconds: float) -> Overview:
    """Return an overview; SlowQueryError if its counts together take longer than a time limit."""
    end = time.monotonic() + seconds

    def left() -> float:
        return max(0.0, end - time.monotonic())

    query = list_request.selection
    counts = summarize(database, query, list_request.scene, seconds=left())
    facets = filter(None, (_facet(database, list_request, name, left) for name in FACETS))
    return Overview(title_of(counts.sizes, counts.array), headline_of(StageCounts.of(counts), query), tuple(facets))


def _facet(database: Database, list_request: ListRequest, name: str, left: Callable[[], float]) -> ListFacet | None:
    """Return a facet; None where the designs do not differ in it, or in too many values, and none is chosen.

    left : returns the remaining seconds.
    """
    chosen = dict(list_request.facets).get(name, ())

    def counts_in(query: str) -> list[tuple[object, int]] | None:
        return count_values(database, query, name, MAX_FACET_VALUES, list_request.scene, seconds=left())

    counts = counts_in(list_request.selection_but(name))
    if counts is None and chosen:  # of too many values, only the chosen ones
        counts = counts_in(list_request.selection)
    values = [(value, count, str(value) in chosen) for value, count in counts or ()]
    known = {str(value) for value, _, _ in values}
    values += [(value, 0, True) for value in chosen if value not in known]
    return ListFacet(name, tuple(values)) if len(values) > 1 or chosen else None
