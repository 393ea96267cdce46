"""A report on a query, or the page of a design, from the database to a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from hcsearch.basics.errors import QueryError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, open_readonly
from hcsearch.system.outputs import write_output
from hcsearch.web.report.design_fetching import design_data
from hcsearch.web.report.design_page import render_design
from hcsearch.web.report.fetching import BEST_FIRST, fetch
from hcsearch.web.report.page import render

LIMIT = 20_000
"""Designs on a page by default: so many are searched and sorted at once."""


def write_report(
    database: Database,
    query: str,
    path: Path | str,
    *,
    limit: int | None = LIMIT,
    sort: str = BEST_FIRST,
    title: str = "",
    scene: str = DEFAULT_SCENE_NAME,
) -> Path:
    """Write the report on the designs that a query selects, and return its path.

    database : from `open_readonly`.
    limit : designs on the page, None for all; the numbers on the page count all of them in any case.
    scene : whose verdicts are shown.
    QueryError: no design is selected. OutputError: the file cannot be written.
    """
    data = fetch(database, query, limit, sort, scene)
    if not data.total:
        raise QueryError(f"no design satisfies {query!r}: see `hcsearch query` for those of the database")
    page = render(replace(data, title=title) if title else data)
    write_output(path, page)
    return Path(path)


def write_design(
    circuit: Circuit,
    foldings: Sequence[Folding],
    path: Path | str,
    *,
    db: str,
    number: int | None = None,
    scene: str = DEFAULT_SCENE_NAME,
) -> Path:
    """Write the page of a design, and return its path.

    foldings : that are shown. db : names the database, which is asked where it has a number for the design.
    OutputError: the file cannot be written. SceneError: the database has no such scene.
    """
    if number is None:
        data = design_data(circuit, foldings, db, None, 0)
    else:
        with open_readonly(db) as database:
            data = design_data(circuit, foldings, db, database, number, scene)
    write_output(path, render_design(data))
    return Path(path)
