"""Failures of database drivers as errors of one line, with the remedy."""

from __future__ import annotations

import logging
import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from hcsearch.basics.errors import DatabaseError
from hcsearch.system.machine import locks_files

# A pool logs the traceback of an error in the return of a connection. It still raises an interrupt; after other errors
# it discards the connection, whose transaction has ended. The log is of no use where logging is not set up.
logging.getLogger("sqlalchemy.pool").addHandler(logging.NullHandler())

P = ParamSpec("P")
T = TypeVar("T")

_TRIES = 5

LOCKED_CODES = (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)

_WAIT = "is locked by another program: wait until that has finished, then try again"
NO_LOCKS_MESSAGE = (
    "is on a disk that does not lock files, as some network disks: name one on a local disk, or use PostgreSQL"
)
_FILE_CAUSES = {
    **dict.fromkeys(LOCKED_CODES, _WAIT),
    sqlite3.SQLITE_CORRUPT: "is damaged: restore a copy of it, or salvage its rows with `sqlite3 FILE .recover`",
    sqlite3.SQLITE_NOTADB: "is not an SQLite database: name another file",
    sqlite3.SQLITE_READONLY: "cannot be written: allow writing to the file and its folder, or name another file",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened: check the permissions of the file and its folder, or name another file",
    sqlite3.SQLITE_FULL: "cannot grow, the disk is full: make room, or name a file on another disk",
    sqlite3.SQLITE_IOERR: "cannot be read or written, the disk reports an error: name a file on another disk",
}

_LOST = "has lost its connection ({detail}): see that the server runs, then give the same command again"
# SQLSTATE codes and their classes, the first two characters.
_SERVER_CAUSES: dict[str, str | None] = {
    "08": _LOST,
    "08P01": None,  # a placeholder in a statement
    "22021": "holds what is no text ({detail}): restore a copy, or mend it with psql",
    "25006": "cannot be written, its server only reads ({detail}): name the primary server",
    "28": "refuses the user ({detail}): check the user and the password",
    "3D000": "does not exist ({detail}): make it with createdb, or name another",
    "3F000": "has no schema to use ({detail}): set the search path of the user, as to public",
    "40": "refuses the transaction ({detail}): try again",
    "42501": "refuses the user ({detail}): grant the right, or name another user in the URL",
    "53100": "cannot grow, the disk of the server is full: make room there",
    "53": "cannot be used, the server is short of resources ({detail}): try again later",
    "55P03": _WAIT,
    "57": _LOST,
    "57014": "has stopped the statement ({detail}): raise the limit of the server, or ask for less",
    "58": "cannot be read or written, the server reports an error ({detail}): see its log",
    "XX": "is damaged, or its server has a fault ({detail}): see the log of the server",
}
_OF_VALUES = "is damaged ({detail}): restore a copy of it, or mend it with `sqlite3 FILE`"
_UNREACHED = "cannot be used ({detail}): check that the server runs, has this database, and takes the user and password"


class FileChangedError(DatabaseError):
    """A file was written to while it was read without locks, so that the result may be inconsistent."""

    def __init__(self, location: str) -> None:
        super().__init__(
            f"database {location} is being written to, in a folder where this user must not write, so that SQLite "
            "cannot lock it: give the command again, or copy the file to a folder of your own"
        )


def retry_if_changed(read: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function that only reads and returns all at once: repeat it if the file changed meanwhile."""

    @wraps(read)
    def reading(*arguments: P.args, **options: P.kwargs) -> T:
        for _ in range(_TRIES):
            with suppress(FileChangedError):
                return read(*arguments, **options)
        return read(*arguments, **options)

    return reading


def primary_code(error: BaseException | None) -> int:
    """Return the primary result code of SQLite for an error; 0 without one."""
    return getattr(error, "sqlite_errorcode", 0) & 0xFF


def is_refusal(error: BaseException) -> bool:
    """Return whether a statement was refused because it would write on a read-only connection."""
    refusals = ("not authorized", "authorization denied", "read-only")  # some refusals carry no code
    code = primary_code(error)
    return code in (sqlite3.SQLITE_AUTH, sqlite3.SQLITE_READONLY) or any(words in str(error) for words in refusals)


def is_of_database(error: BaseException | None) -> bool:
    """Return whether the file, the server, the system or an interrupt caused an error, not the statement."""
    return _cause(error) is not None or primary_code(error) == sqlite3.SQLITE_INTERRUPT


def is_of_values(error: BaseException | None) -> bool:
    """Return whether values read by a statement caused an error: bytes that are no text, overflow of a sum."""
    # SQLite has no separate code for these
    words = ("Could not decode to UTF-8", "integer overflow")
    by_words = isinstance(error, sqlite3.Error) and str(error).startswith(words)
    return by_words or getattr(error, "sqlstate", None) == "22021"


@contextmanager
def explaining_failures(location: str, path: Path | None = None) -> Iterator[None]:
    """Turn failures of drivers into DatabaseError; other exceptions pass unchanged.

    path : of a file. SQLite also calls it locked if its file system has no locks.
    """
    from sqlalchemy.exc import DBAPIError, IntegrityError, ProgrammingError  # noqa: PLC0415 - loads slowly

    try:
        yield
    except sqlite3.Error as error:
        raise _explain(location, error, path) from error
    except DBAPIError as error:
        if isinstance(error, IntegrityError | ProgrammingError) and not is_of_database(error.orig):
            raise
        raise _explain(location, error.orig, path, lost=error.connection_invalidated) from error


_VALUES = re.compile(r"""(\b(?:value|service)\b[^"']*)(["']).*\2""")
"""Values of URL options in messages of drivers, which may be secret."""


def detail_of(error: BaseException | None) -> str:
    """Return the message of a driver on one line, without values of URL options."""
    return _VALUES.sub(r"\1***", (str(error).strip() or type(error).__name__).splitlines()[0])


def _explain(
    location: str, error: BaseException | None, path: Path | None = None, *, lost: bool = False
) -> BaseException:
    if primary_code(error) == sqlite3.SQLITE_INTERRUPT:
        return KeyboardInterrupt()  # an interrupt that the driver swallowed, see `sqlite.connect`
    detail = detail_of(error)
    cause = _cause(error)
    if lost and cause == _UNREACHED:  # a server may end a connection without a reason
        cause = _LOST
    if primary_code(error) in LOCKED_CODES and path is not None and not locks_files(path.absolute().parent):
        cause = NO_LOCKS_MESSAGE
    if cause is None:
        cause = "cannot be used ({detail}): restore a copy, or name another" + " file" * isinstance(
            error, sqlite3.Error
        )
    return DatabaseError(f"database {location} {cause.format(detail=detail)}")


def _cause(error: BaseException | None) -> str | None:
    state = getattr(error, "sqlstate", None)
    if state:
        return _SERVER_CAUSES.get(state, _SERVER_CAUSES.get(state[:2]))
    if hasattr(error, "sqlstate") and any(kind.__name__ == "OperationalError" for kind in type(error).__mro__):
        # The connection failed, so the server gave no code. (The driver is an extra, and not imported here.)
        return _UNREACHED
    if is_of_values(error):
        return _OF_VALUES
    return _FILE_CAUSES.get(primary_code(error))
