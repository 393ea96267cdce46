"""Count circuits without storing them."""

from __future__ import annotations

from dataclasses import dataclass

from hcsearch.api.enumerating import chosen_search, chosen_workers
from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Keep
from hcsearch.designs.grid import Array, Grid
from hcsearch.search.enumeration import ArraySearch, Search, count_array
from hcsearch.search.pipeline import DesignCount, count_designs, counting_seconds, duration_text
from hcsearch.search.pipeline.run import AnnounceSentence, RunProgress


@dataclass(frozen=True)
class CircuitCount:
    """The number of circuits that a search keeps, in total and up to symmetry.

    search : the counted search. circuits, classes : number of circuits, and of classes up to symmetry.
    """

    search: Search
    keep: Keep
    circuits: int
    classes: int


def count(
    *,
    grid: str | Grid | None = None,
    n: int | None = None,
    array: str | Array | None = None,
    keep: Keep = "all",
    jobs: int | None = None,
    scheduler: str | None = None,
    progress: RunProgress | None = None,
    announce: AnnounceSentence | None = None,
) -> CircuitCount:
    """Count the circuits of all arrays of n cells, or of one array, as `hcsearch count` does.

    grid, n, array, keep, jobs, scheduler, progress, announce : as in `enumerate_into`.

    >>> from hcsearch import count
    >>> counted = count(grid="square", array="6x6")
    >>> counted.circuits, counted.classes
    (1072, 149)
    """
    check_kinds(count, locals())
    search, crew = chosen_search(grid, n, array, keep), chosen_workers(jobs, scheduler)
    is_single_array = isinstance(search, ArraySearch) and keep == "all"
    if scheduler is not None and is_single_array:
        raise HcsearchError("circuits of one array are counted in this process: leave out --scheduler")
    crew.check_cluster()
    seconds = None if keep == "all" else counting_seconds(search)
    if seconds is not None and announce is not None:
        announce(f"about {duration_text(seconds)} of core time to count")
    if is_single_array:
        assert isinstance(search, ArraySearch)
        totals = count_array(search.array, progress)
        counted = DesignCount(totals.classes, totals.circuits)
    else:
        counted = count_designs(search, keep, crew, progress)
    return CircuitCount(search, keep, counted.circuits, counted.classes)
