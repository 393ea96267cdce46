"""Databases, as functions of Python are given them."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from hcsearch.store import Database, open_database, open_readonly
from hcsearch.system.machine import default_database

Place = str | Path | Database


def located(db: str | Path | None) -> str:
    """The location of a database: the one that is named, else HCSEARCH_DB, else hcsearch.sqlite."""
    return default_database() if db is None else str(db)


def reading(db: Place | None) -> AbstractContextManager[Database]:
    """A database, open to read."""
    return nullcontext(db) if isinstance(db, Database) else open_readonly(located(db))


def writing(db: Place | None, *, create: bool) -> AbstractContextManager[Database]:
    """A database, open to write."""
    return nullcontext(db) if isinstance(db, Database) else open_database(located(db), create=create)
