"""A report on a query, from the database to a file."""

from __future__ import annotations

import errno
from dataclasses import replace
from pathlib import Path

from hcsearch.errors import HcsearchError, QueryError
from hcsearch.report.fetching import BEST_FIRST, fetch
from hcsearch.report.page import render
from hcsearch.scenes import DEFAULT
from hcsearch.store import Database

LIMIT = 2000
"""Designs on a page unless told otherwise: more make it slow to search."""


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
    """Write the report on the designs that a query selects, and return its path; folders are made where missing.

    database : from `open_readonly`.
    limit : designs on the page, None for all; the numbers on the page count all of them in any case.
    scene : whose verdicts are shown.
    HcsearchError: no design is selected, or the file cannot be written.
    """
    data = fetch(database, query, limit, sort, scene)
    if not data.total:
        raise QueryError(f"no design satisfies {query!r}: see `hcsearch query` for what there is")
    page = render(replace(data, title=title) if title else data)
    target = Path(path)
    try:
        _spare_databases(target)
        target.parent.mkdir(parents=True, exist_ok=True)
        # Undecodable bytes of a command line arrive as lone surrogates, which no file holds.
        target.write_bytes(page.encode(errors="replace"))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise HcsearchError(
            f"cannot write the report to {target}: {reason}; name another file, in a folder that can be written"
        ) from error
    return target


def _spare_databases(target: Path) -> None:
    """Refuse to overwrite a database, which a slip in the order of two file names would do."""
    if target.is_file():
        with target.open("rb") as file:
            if file.read(15) == b"SQLite format 3":
                raise FileExistsError(errno.EEXIST, "it is a database")
