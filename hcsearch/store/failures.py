"""What goes wrong below, as one line that names the remedy."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy.exc import DBAPIError, IntegrityError, ProgrammingError

from hcsearch.errors import DatabaseError

LOCKED = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)

_CAUSES = {
    **dict.fromkeys(LOCKED, "is locked by another program: wait until that has finished, then try again"),
    sqlite3.SQLITE_CORRUPT: "is damaged: restore a copy of it, or salvage its rows with `sqlite3 FILE .recover`",
    sqlite3.SQLITE_NOTADB: "is not an SQLite database: name another file",
    sqlite3.SQLITE_READONLY: "cannot be written: allow writing to the file and its folder, or name another file",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened: check the permissions of the file and its folder, or name another file",
    sqlite3.SQLITE_FULL: "cannot grow, the disk is full: make room, or name a file on another disk",
    sqlite3.SQLITE_IOERR: "cannot be read or written, the disk reports an error: name a file on another disk",
}


def primary_code(error: BaseException | None) -> int:
    """Return SQLite's primary result code of an error; 0 when it has none."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


def is_refusal(error: BaseException) -> bool:
    """Whether a statement was not run because it would change something on a read-only connection."""
    told = ("not authorized", "authorization denied", "read-only")  # some refusals come without their code
    return primary_code(error) in (sqlite3.SQLITE_AUTH, sqlite3.SQLITE_READONLY) or any(t in str(error) for t in told)


def is_of_database(error: BaseException) -> bool:
    """Whether the file or the system is at fault, and not a statement."""
    return primary_code(error) in _CAUSES


@contextmanager
def explained(location: str) -> Iterator[None]:
    """Turn the failures of drivers into DatabaseError; faults of this program pass through as they are."""
    try:
        yield
    except (IntegrityError, ProgrammingError):
        raise
    except sqlite3.Error as error:
        raise _explain(location, error) from error
    except DBAPIError as error:
        raise _explain(location, error.orig) from error


def _explain(location: str, error: BaseException | None) -> DatabaseError:
    cause = _CAUSES.get(primary_code(error))
    if cause is None:
        detail = (str(error).strip() or type(error).__name__).splitlines()[0]
        is_file = isinstance(error, sqlite3.Error)
        remedy = (
            "restore a copy, or name another file" if is_file else "check that the server runs and the URL is right"
        )
        cause = f"cannot be used ({detail}): {remedy}"
    return DatabaseError(f"database {location} {cause}")
