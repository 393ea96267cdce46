"""Locations of databases: an SQLite file or the URL of a server."""

from __future__ import annotations

import os
import re
import shutil
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from hcsearch.basics.errors import DatabaseError, NoDatabaseError, printable
from hcsearch.store.failures import NO_LOCKS_MESSAGE
from hcsearch.system.machine import locks_files

if TYPE_CHECKING:
    from sqlalchemy import URL

_SERVERS = ("postgresql", "postgresql+psycopg")
_OPEN = ("host", "hostaddr", "port", "user")
"""Options of a URL whose values messages show; values of all others may be secret."""

_LOOSE = {"host": r"[@=&;\s]", "hostaddr": r"[@=&;\s]", "port": r"[^\d,]", "user": r"[:@=&;\s]", "database": r"[:@=&;]"}
"""Characters in a part of a URL that show a password or an option typed into it by mistake."""
_MISTYPED = re.compile(r"(postgres|sqlite)[\w+]*(:|//)", re.IGNORECASE)
"""The beginning of a mistyped URL."""
_SECRET = re.compile(r"(pass|pwd|pw|secret|token)\w*\s*(=|%3d)|\b(host|hostaddr|user|dbname)\s*=.*\s", re.IGNORECASE)
"""An option of libpq or of a URL that may hold a secret, or a connection string of libpq."""
MAX_LOCATION_BYTES = 500
"""Longest path in bytes; SQLite takes 512 including the names of its journals."""

FileIdentity = tuple[int, int]
"""Device and inode number of a file."""

LOCATION_EXAMPLES = "give a path, sqlite:///PATH, or postgresql+psycopg://USER@HOST/NAME"


@dataclass(frozen=True)
class Location:
    """The location of a database; `text` is shown to users (passwords hidden), either `path` or `url` is set."""

    text: str
    path: Path | None = None
    url: URL | None = None


def parse_location(text: str | Path) -> Location:
    """Parse a path or an SQLAlchemy URL; DatabaseError if it is neither."""
    if not isinstance(text, (str, Path)):
        raise DatabaseError(f"{text!r} names no database: {LOCATION_EXAMPLES}")
    text = str(text)
    if not text or text == ":memory:":
        raise DatabaseError(f"{_shown(text)!r} names no database that lasts: {LOCATION_EXAMPLES}")
    if "://" not in text:
        if _MISTYPED.match(text) or _SECRET.search(text):
            raise _unreadable()
        return _file(text)
    url = _url(text)
    if url.drivername in ("sqlite", "sqlite+pysqlite"):
        return _sqlite_file(url)
    if url.drivername not in _SERVERS:
        raise DatabaseError(f"databases of the kind {url.drivername!r} are not supported: {LOCATION_EXAMPLES}")
    if _is_loose(url) or not text.isprintable():
        raise _unreadable()
    hidden = url.update_query_dict({name: "***" for name in url.query if name not in _OPEN})
    shown = hidden.render_as_string(hide_password=True).replace("%2A%2A%2A", "***")
    return Location(shown, url=url.set(drivername=_SERVERS[-1]))


def _url(text: str) -> URL:
    """Parse an SQLAlchemy URL, with the name of its database unquoted."""
    from sqlalchemy import make_url  # noqa: PLC0415 - loads slowly, and a path needs none of it
    from sqlalchemy.exc import ArgumentError  # noqa: PLC0415 - as above

    try:
        url = make_url(text)
    except (ArgumentError, ValueError) as error:
        raise _unreadable() from error
    # versions 2.0 of SQLAlchemy leave names of databases percent-encoded
    if url.database and make_url("sqlite:///%20").database == "%20":
        url = url.set(database=unquote(url.database))
    return url


def _is_loose(url: URL) -> bool:
    """Return whether parts of a URL may contain parts of a password, or misplaced options.

    A password with an unescaped @, : or / spills into the other parts.
    """
    from sqlalchemy.exc import ArgumentError  # noqa: PLC0415 - loads slowly

    parts = [("host", url.host), ("user", url.username), ("database", url.database)]
    parts += [(name, value) for name, values in url.normalized_query.items() if name in _OPEN for value in values]
    if any(value and re.search(_LOOSE[name], value) for name, value in parts):
        return True
    try:
        url.get_dialect()().create_connect_args(url)
    except ArgumentError:  # hosts and ports of different number
        return True
    return False


def _unreadable() -> DatabaseError:
    """Return the error for an unreadable URL, without the URL, which may contain a password."""
    marks = "a password with @ as %40, : as %3A and / as %2F, or in PGPASSWORD"
    return DatabaseError(f"the database URL cannot be read: {LOCATION_EXAMPLES}, {marks}")


def _sqlite_file(url: URL) -> Location:
    if not url.database or url.database == ":memory:":
        raise DatabaseError(f"the SQLite URL names no database that lasts: {LOCATION_EXAMPLES}")
    if url.query or url.database.startswith("file:") or url.host:
        raise DatabaseError(
            "the SQLite URL has options or a host, which are not supported: give sqlite:///PATH or a path"
        )
    return _file(url.database)


def _file(path: str) -> Location:
    if "\0" in path:
        raise DatabaseError(f"{_shown(path)!r} names no database that lasts: {LOCATION_EXAMPLES}")
    try:
        length = max(len(os.fsencode(spelling)) for spelling in _places(path))
    except UnicodeEncodeError as error:
        raise DatabaseError(f"{_shown(path)} is no path that this system can have: {LOCATION_EXAMPLES}") from error
    if length > MAX_LOCATION_BYTES:
        raise DatabaseError(
            f"the path of database {_shown(Path(path).name)} has {length} bytes and SQLite takes {MAX_LOCATION_BYTES}: "
            "name a file in a folder with a shorter path"
        )
    return Location(_shown(path), path=Path(path))


def _places(path: str) -> Iterator[str | Path]:
    """Yield the absolute path of a file, as written and with links resolved: SQLite limits the length of both."""
    yield Path(path).absolute()
    yield os.path.realpath(path)


def _shown(path: str) -> str:
    """Return a path on one printable line, without a password if it may be a mistyped URL."""
    return printable(re.sub(":.*@", ":***@", path, flags=re.DOTALL))


def is_filled(location: Location) -> bool:
    """Return whether the file of a location exists and is not empty; DatabaseError if it is no file."""
    path = _path(location)
    try:
        status = path.stat()
    except FileNotFoundError:
        return False
    except OSError as error:
        reason = f"cannot be opened ({error.strerror}): name another file"
        raise DatabaseError(f"database {location.text} {reason}") from error
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder: name a file in it" if stat.S_ISDIR(status.st_mode) else "not a file: name another"
        raise DatabaseError(f"database {location.text} is {kind}")
    return status.st_size > 0


def missing_error(location: Location) -> NoDatabaseError:
    """Return the error for a database that does not exist."""
    return NoDatabaseError(
        f"there is no hcsearch database at {location.text}: make one with `hcsearch enumerate`, or name another with "
        "--db"
    )


def refuse_missing_file(text: str | Path) -> None:
    """Raise NoDatabaseError if a location is a path without a database, for which SQLAlchemy need not be loaded."""
    location = parse_location(text)
    if location.path is not None and not is_filled(location):
        raise missing_error(location)


def file_identity(path: Path) -> FileIdentity | None:
    """Return device and inode of a file, which identify it under any name; None if it does not exist."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


def check_writable(location: Location) -> None:
    """Raise DatabaseError if a file or its folder is not writable, before anything is changed."""
    path = _path(location)
    folder = path.absolute().parent
    if not folder.is_dir():
        shown = _shown(str(folder))
        raise DatabaseError(f"database {location.text} cannot be made, there is no folder {shown}: make it first")
    # SQLite keeps its journal beside the file.
    for target in (folder, path) if path.exists() else (folder,):
        if not os.access(target, os.W_OK):
            remedy = f"allow writing to {_shown(str(target))}, or name another file"
            raise DatabaseError(f"database {location.text} cannot be written: {remedy}")
    if not locks_files(folder):
        raise DatabaseError(f"database {location.text} {NO_LOCKS_MESSAGE}")


def _path(location: Location) -> Path:
    assert location.path is not None, "a server has no file"
    return location.path


def room_at(location: str) -> int | None:
    """Return the size in bytes to which a database file can grow; None for a server."""
    path = parse_location(location).path
    if path is None:
        return None
    folder = path.absolute().parent
    while not folder.is_dir():
        folder = folder.parent
    return shutil.disk_usage(folder).free + (path.stat().st_size if path.is_file() else 0)
