"""Databases as users name them: by a path, a URL, an open one, or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import Database, open_database, open_readonly
from hcsearch.system.machine import default_database

Place = str | Path | Database


def database_location(db: Place | None) -> str:
    """Return the location of a database: the one that is named, else HCSEARCH_DB, else hcsearch.sqlite."""
    if isinstance(db, Database):
        return db.location
    return default_database() if db is None else str(db)


def reading_database(db: Place | None) -> AbstractContextManager[Database]:
    """Open a database to read."""
    return nullcontext(db) if isinstance(db, Database) else open_readonly(database_location(db))


def writing_database(db: Place | None, *, create: bool) -> AbstractContextManager[Database]:
    """Open a database to write."""
    return nullcontext(db) if isinstance(db, Database) else open_database(database_location(db), create=create)


@contextmanager
def database_snapshot(db: Place | None) -> Iterator[tuple[Database | None, DatabaseError | None]]:
    """Open a database to read all in one transaction; give the error in its place where that cannot be done."""
    try:
        opened = reading_database(db)
    except DatabaseError as error:
        yield None, error
        return
    with opened as database, database.snapshot() as held:
        yield held, None
