"""Databases as users name them: by a path, a URL, an open one, or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TypeAlias

from hcsearch import store
from hcsearch.basics.errors import DatabaseError
from hcsearch.store.location import refuse_missing_file
from hcsearch.system.machine import default_database

Place: TypeAlias = "str | Path | store.Database"


def database_location(db: Place | None) -> str:
    """Return the location of a database: the one that is named, else HCSEARCH_DB, else hcsearch.sqlite."""
    if db is None or isinstance(db, str | Path):
        return default_database() if db is None else str(db)
    return db.location


def reading_database(db: Place | None) -> AbstractContextManager[store.Database]:
    """Open a database to read."""
    if db is None or isinstance(db, str | Path):
        location = database_location(db)
        refuse_missing_file(location)
        return store.open_readonly(location)
    return nullcontext(db)


def writing_database(db: Place | None, *, create: bool) -> AbstractContextManager[store.Database]:
    """Open a database to write."""
    if db is None or isinstance(db, str | Path):
        return store.open_database(database_location(db), create=create)
    return nullcontext(db)


@contextmanager
def database_snapshot(db: Place | None) -> Iterator[tuple[store.Database | None, DatabaseError | None]]:
    """Open a database to read all in one transaction; give the error in its place where that cannot be done."""
    try:
        opened = reading_database(db)
    except DatabaseError as error:
        yield None, error
        return
    with opened as database, database.snapshot() as held:
        yield held, None
