"""A report on a query, from the database to a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hcsearch.errors import QueryError
from hcsearch.report.fetching import BEST_FIRST, fetch
from hcsearch.report.page import render
from hcsearch.scenes import DEFAULT
from hcsearch.store import Database
from hcsearch.system.outputs import write_output

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
    scene: str = DEFAULT,
) -> Path:
    """Write the report on the designs that a query selects, and return its path.

    database : from `open_readonly`.
    limit : designs on the page, None for all; the numbers on the page count all of them in any case.
    scene : whose verdicts are shown.
    QueryError: no design is selected. OutputError: the file cannot be written.
    """
    data = fetch(database, query, limit, sort, scene)
    if not data.total:
        raise QueryError(f"no design satisfies {query!r}: see `hcsearch query` for what there is")
    page = render(replace(data, title=title) if title else data)
    write_output(path, page)
    return Path(path)
