"""Lists: pages of the rows of a view, designs as cards; lists that take long run a few at once.

Nobody knows beforehand which those are. Each list has a short time at first; one that takes more begins again with the
whole time, when few enough others do. Some wait for that, and one more is refused.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from markupsafe import Markup

from hcsearch.basics.errors import DatabaseError, HcsearchError, QueryError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import (
    SCENIC,
    Database,
    SlowQueryError,
    best_creases,
    count_rows,
    foldings_with_paths,
    scene_names,
    select_page,
)
from hcsearch.store.columns import VIEWS
from hcsearch.store.queries import STATEMENT_SECONDS
from hcsearch.web.player.player_page import as_script
from hcsearch.web.report.data import ReportData, deployments_of, foldings_of, motions_of, panel_size_in
from hcsearch.web.report.script_data import page_data
from hcsearch.web.report.templating import database_option_text
from hcsearch.web.serve.jobs import BusyError, ResultCache
from hcsearch.web.serve.requests import ListRequest, check_query, design_address, motion_address
from hcsearch.web.serve.template_pages import render_page

T = TypeVar("T")

SHORT_LIST_SECONDS = 0.3
"""Seconds that any list may take."""
MAX_LONG_LISTS, MAX_WAITING_LISTS = 4, 8
"""Lists at once that take longer, and those that wait for their turn, for as long as one may take."""


class LongLists:
    """Asks for lists: `most` at once may take more than `short` seconds, and `waiting` more wait for that."""

    def __init__(
        self,
        most: int = MAX_LONG_LISTS,
        waiting: int = MAX_WAITING_LISTS,
        short: float = SHORT_LIST_SECONDS,
        seconds: float = STATEMENT_SECONDS,
    ) -> None:
        self._short, self._seconds = short, seconds
        self._turns, self._room = threading.BoundedSemaphore(most), threading.BoundedSemaphore(most + waiting)

    def __call__(self, ask: Callable[[float], T]) -> T:
        """What a question gives. ask : takes the seconds that it has, and raises SlowQueryError after them.

        BusyError where it takes long and enough others do; QueryError where it takes too long.
        """
        try:
            return ask(self._short)
        except SlowQueryError:
            pass
        if not self._room.acquire(blocking=False):
            raise _busy()
        try:
            return self._in_turn(ask)
        finally:
            self._room.release()

    def _in_turn(self, ask: Callable[[float], T]) -> T:
        if not self._turns.acquire(timeout=self._seconds):
            raise _busy()
        try:
            return ask(self._seconds)
        except SlowQueryError:
            raise QueryError(
                f"the query takes more than {self._seconds:g} s here: narrow it, as with grid= and n=, or ask "
                "`hcsearch query`"
            ) from None
        finally:
            self._turns.release()


def _busy() -> BusyError:
    return BusyError(
        "this list takes long, and so do others right now: try again in a few seconds, or narrow it, as with grid= "
        "and n="
    )


CARDS_PER_PAGE, ROWS_PER_PAGE = 48, 100
"""Rows of a page."""
MAX_COUNTED_ROWS = 100_000
"""Rows that are counted; beyond, there are more than so many."""
MAX_KEPT_COUNTS = 500
"""Counts kept in memory."""


class RowCounts:
    """How many rows queries select, kept while the database is as it was; `None` for more than `MAX_COUNTED_ROWS`."""

    def __init__(self) -> None:
        self._kept: ResultCache[int | None] = ResultCache(MAX_KEPT_COUNTS)

    def of(self, database: Database, asked: ListRequest, seconds: float) -> int | None:
        """The number of rows of a query, counted within some seconds."""
        key = (asked.view, asked.query, asked.scene, database.fingerprint())
        with suppress(KeyError):
            return self._kept[key]
        count = count_rows(
            database, asked.query, most=MAX_COUNTED_ROWS + 1, view=asked.view, scene=asked.scene, seconds=seconds
        )
        self._kept[key] = None if count > MAX_COUNTED_ROWS else count
        return None if count > MAX_COUNTED_ROWS else count


@dataclass(frozen=True)
class ListPage:
    """What a page shows of a list.

    first : number of the first row, from 1. total : of all rows; None for more than `MAX_COUNTED_ROWS`. last : page,
    where known.
    """

    rows: Sequence[Mapping[str, Any]]
    first: int
    total: int | None
    last: int | None


def list_page_of(database: Database, asked: ListRequest, counts: RowCounts, seconds: float) -> ListPage:
    """The rows of a page, and how many there are in all; SlowQueryError where that takes more than some seconds."""
    end = time.monotonic() + seconds
    size = page_row_count(asked)
    skip = (asked.number - 1) * size
    selected = select_page(
        database,
        asked.query,
        sort=asked.sort,
        skip=skip,
        count=size,
        view=asked.view,
        scene=asked.scene,
        seconds=seconds,
    )
    rows = selected.records()
    # the end of the list says how long it is, and nothing is counted
    ended = len(rows) < size and (rows or not skip)
    total = skip + len(rows) if ended else counts.of(database, asked, end - time.monotonic())
    return ListPage(rows, skip + 1, total, None if total is None else max(1, -(-total // size)))


def page_row_count(asked: ListRequest) -> int:
    """How many rows a page has."""
    return CARDS_PER_PAGE if asked.view == "designs" and asked.shape == "cards" else ROWS_PER_PAGE


def render_list(database: Database, asked: ListRequest, counts: RowCounts, long_lists: LongLists) -> tuple[str, int]:
    """The page of a list, and its status: with what is wrong with the query, where something is."""
    wrong, status, page = "", 200, ListPage([], 1, 0, 1)
    try:
        check_query(asked.query)
        page = long_lists(lambda seconds: list_page_of(database, asked, counts, seconds))
    except (DatabaseError, BusyError):
        raise
    except HcsearchError as error:
        wrong, status = str(error), 400
    scenes = list(dict.fromkeys((DEFAULT_SCENE_NAME, *scene_names(database))))
    text = render_page(
        "list.html",
        asked=asked if asked.scene in scenes else replace(asked, scene=asked.usual),
        page=page,
        wrong=wrong,
        most=MAX_COUNTED_ROWS,
        scenes=scenes,
        scenic=asked.view in SCENIC,
        quantities=VIEWS[asked.view],
        orders=_orders(asked),
        payload=_payload(database, asked, page) if asked.view == "designs" and asked.shape == "cards" else "",
        location=database.location,
    )
    return text, status


def _orders(asked: ListRequest) -> list[tuple[str, str]]:
    """Orders to choose from, as (specification, words); the one that is asked for among them."""
    numbers = [quantity for quantity in VIEWS[asked.view] if quantity.kind != "text"]
    orders = [("", "as stored")]
    for quantity in numbers:
        orders += [(f"-{quantity.name}", f"{quantity.title}, largest first")]
        orders += [(quantity.name, f"{quantity.title}, smallest first")]
    if asked.sort not in dict(orders):
        orders.append((asked.sort, asked.sort))
    return orders


def _payload(database: Database, asked: ListRequest, page: ListPage) -> Markup:
    """The data of the designs of a page, for the script that draws them."""
    ids = [row["id"] for row in page.rows]
    known: dict[str, Any] = {}
    if ids:
        known = {
            "foldings": foldings_of(database, ids, asked.scene),
            "best": best_creases(database, ids, asked.scene),
            "motions": motions_of(database, ids, asked.scene),
            "tried": deployments_of(database, ids, asked.scene),
            "players": {
                key: motion_address(*key, asked.named) for key in foldings_with_paths(database, ids, asked.scene)
            },
        }
    data = ReportData(
        title="",
        designs=page.rows,
        total=len(ids),
        scene=asked.scene,
        where=database_option_text(database),
        size=panel_size_in(database, asked.scene),
        pages=design_address("{id}", asked.named),
        **known,
    )
    # Trusted: JSON without a mark of HTML in it.
    return Markup(as_script(page_data(data)))
