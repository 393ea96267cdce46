"""Lists: pages of the rows of a view, with designs as cards."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from markupsafe import Markup

from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import (
    SCENIC,
    Database,
    best_creases,
    check_scene,
    count_rows,
    foldings_with_paths,
    scene_names,
    select_page,
)
from hcsearch.store.columns import VIEWS
from hcsearch.store.conditions import quantities_named
from hcsearch.store.quantity import Quantity
from hcsearch.store.queries import VIEW_KEYS
from hcsearch.web.player.player_page import as_script
from hcsearch.web.report.data import (
    BEST_FIRST_ORDER,
    ReportData,
    deployments_of,
    foldings_of,
    motions_of,
    panel_size_in,
)
from hcsearch.web.report.script_data import CARD_COLUMNS, CARD_HEADS, page_data
from hcsearch.web.report.templating import database_option_text
from hcsearch.web.serve.jobs import BusyError, ResultCache
from hcsearch.web.serve.long_lists import LongLists
from hcsearch.web.serve.overviews import NO_OVERVIEW, Overviews
from hcsearch.web.serve.requests import ListRequest, check_query, design_address, motion_address
from hcsearch.web.serve.template_pages import render_page

CARDS_PER_PAGE, ROWS_PER_PAGE = 48, 100
"""Rows of a page: designs as cards, and rows of tables."""
MAX_COUNTED_ROWS = 100_000
"""Largest count of rows; beyond it, a list only reports that there are more."""
MAX_KEPT_COUNTS = 500
"""Capacity of the cache of counts."""


class RowCounts:
    """A cache of row counts of queries, valid while the database is unchanged; None above `MAX_COUNTED_ROWS`."""

    def __init__(self) -> None:
        self._cache: ResultCache[int | None] = ResultCache(MAX_KEPT_COUNTS)

    def of(self, database: Database, list_request: ListRequest, seconds: float) -> int | None:
        """Return the number of rows of a query, counted within a time limit."""
        key = (list_request.view, list_request.selection, list_request.scene, database.fingerprint())
        with suppress(KeyError):
            return self._cache[key]
        count = count_rows(
            database,
            list_request.selection,
            most=MAX_COUNTED_ROWS + 1,
            view=list_request.view,
            scene=list_request.scene,
            seconds=seconds,
        )
        self._cache[key] = None if count > MAX_COUNTED_ROWS else count
        return None if count > MAX_COUNTED_ROWS else count


@dataclass(frozen=True)
class ListPage:
    """The rows of a list on one page.

    first : number of the first row, from 1. total : of all rows; None for more than `MAX_COUNTED_ROWS`. last : number
    of the last page, if known.
    """

    rows: Sequence[Mapping[str, Any]]
    first: int
    total: int | None
    last: int | None


def order_of_list(database: Database, list_request: ListRequest, counts: RowCounts, seconds: float) -> str:
    """Return the sort specification of a list: designs come best first unless another order is asked for.

    More than `MAX_COUNTED_ROWS` designs come as they are stored, since sorting them takes long.
    """
    if list_request.sort or list_request.view != "designs":
        return list_request.sort
    check_scene(database, list_request.scene)  # before anything is kept under its name
    return "" if counts.of(database, list_request, seconds) is None else BEST_FIRST_ORDER


def list_page_of(database: Database, list_request: ListRequest, counts: RowCounts, seconds: float) -> ListPage:
    """Return the rows of a page and the total number of rows; SlowQueryError beyond a time limit."""
    end = time.monotonic() + seconds
    order = order_of_list(database, list_request, counts, seconds)
    size = page_row_count(list_request)
    skip = (list_request.number - 1) * size
    selected = select_page(
        database,
        list_request.selection,
        sort=order,
        skip=skip,
        count=size,
        view=list_request.view,
        scene=list_request.scene,
        seconds=max(0.0, end - time.monotonic()),
    )
    rows = selected.records()
    # the end of the list gives its length without counting
    is_end = len(rows) < size and (rows or not skip)
    total = skip + len(rows) if is_end else counts.of(database, list_request, end - time.monotonic())
    return ListPage(rows, skip + 1, total, None if total is None else max(1, -(-total // size)))


def page_row_count(list_request: ListRequest) -> int:
    """Return the number of rows per page."""
    return CARDS_PER_PAGE if list_request.view == "designs" and list_request.shape == "cards" else ROWS_PER_PAGE


def render_list(
    database: Database, list_request: ListRequest, counts: RowCounts, overviews: Overviews, long_lists: LongLists
) -> tuple[str, int]:
    """Return the HTML page of a list and its HTTP status; a faulty query gives an error message in the page."""
    wrong, status, page, overview = "", 200, ListPage([], 1, 0, 1), NO_OVERVIEW
    quantities = list(usual_columns(list_request.view))
    try:
        check_query(list_request.query, list_request.view)
        if list_request.columns:
            quantities = quantities_named(list_request.view, list_request.columns)
        page = long_lists(lambda seconds: list_page_of(database, list_request, counts, seconds))
        if list_request.view == "designs" and page.total is not None:
            overview = overviews.of(database, list_request, long_lists)
    except (DatabaseError, BusyError):
        raise
    except HcsearchError as error:
        wrong, status = str(error), 400
    scenes = list(dict.fromkeys((DEFAULT_SCENE_NAME, *scene_names(database))))
    cards = list_request.view == "designs" and list_request.shape == "cards"
    text = render_page(
        "list.html",
        list_request=list_request
        if list_request.scene in scenes
        else replace(list_request, scene=list_request.default_scene),
        page=page,
        overview=overview,
        wrong=wrong,
        cards=cards,
        most=MAX_COUNTED_ROWS,
        scenes=scenes,
        scenic=list_request.view in SCENIC,
        all_quantities=VIEWS[list_request.view],
        quantities=quantities,
        shown={quantity.name for quantity in quantities} if list_request.columns or not cards else CARD_COLUMNS,
        heads=CARD_HEADS,
        file_columns=",".join((*CARD_HEADS, list_request.columns))
        if cards and list_request.columns
        else list_request.columns,
        orders=_orders(list_request, page),
        payload=_payload(database, list_request, page) if cards else "",
        location=database.location,
    )
    return text, status


def usual_columns(view: str) -> tuple[Quantity, ...]:
    """Return all columns of a view as tables show them: the keys, the status, then the others."""
    first = (*VIEW_KEYS[view], "status")
    place = {
        quantity.name: first.index(quantity.name) if quantity.name in first else len(first) for quantity in VIEWS[view]
    }
    return tuple(sorted(VIEWS[view], key=lambda quantity: place[quantity.name]))


def _orders(list_request: ListRequest, page: ListPage) -> list[tuple[str, str]]:
    """Return the selectable orders as (specification, words), including the requested one; the better end first."""
    is_sorted = list_request.view == "designs" and page.total is not None
    orders = [("", "best first" if is_sorted else "as stored")]
    for quantity in VIEWS[list_request.view]:
        if quantity.kind != "text":
            ends = [(quantity.name, "smallest first"), (f"-{quantity.name}", "largest first")]
            ends.sort(key=lambda end: end[0] != quantity.better_first)
            orders += [(specification, f"{quantity.title}, {words}") for specification, words in ends]
    if list_request.sort not in dict(orders):
        orders.append((list_request.sort, list_request.sort))
    return orders


def _payload(database: Database, list_request: ListRequest, page: ListPage) -> Markup:
    """Return the data of the designs on a page for the script that draws them."""
    ids = [row["id"] for row in page.rows]
    results: dict[str, Any] = {}
    if ids:
        results = {
            "foldings": foldings_of(database, ids, list_request.scene),
            "best": best_creases(database, ids, list_request.scene),
            "motions": motions_of(database, ids, list_request.scene),
            "deployments": deployments_of(database, ids, list_request.scene),
            "players": {
                key: motion_address(*key, list_request.scene_parameter)
                for key in foldings_with_paths(database, ids, list_request.scene)
            },
        }
    data = ReportData(
        title="",
        designs=page.rows,
        total=len(ids),
        scene=list_request.scene,
        database_option=database_option_text(database),
        size=panel_size_in(database, list_request.scene),
        page_address=design_address("{id}", list_request.scene_parameter),
        **results,
    )
    # Trusted: JSON with HTML marks escaped.
    return Markup(as_script(page_data(data)))
