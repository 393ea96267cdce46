"""Opening a database, for writing or read-only, and its transactions."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

from sqlalchemy import Connection, Engine
from sqlalchemy.exc import ProgrammingError

from hcsearch.basics.errors import DatabaseError, HcsearchError, NoDatabaseError
from hcsearch.store import postgresql, sqlite
from hcsearch.store.failures import FileChangedError, detail_of, explaining_failures
from hcsearch.store.location import (
    LOCATION_EXAMPLES,
    FileIdentity,
    Location,
    check_writable,
    file_identity,
    is_filled,
    parse_location,
)
from hcsearch.store.migrate import (
    check_revision,
    current_revision,
    foreign_database_error,
    refuse_foreign_database,
    upgrade_schema,
)
from hcsearch.store.schema import SCHEMA_REVISION

LOCK_TIMEOUT = 60.0
"""How long to wait for another program's lock, in seconds."""


@dataclass(frozen=True)
class Database:
    """An open database. `location` is its name for messages, without any password; `path` is its file, if it is one.

    identity : of the file, where no other may take its place; made : whether it was made when it was opened. held : the
    connection of a snapshot.
    """

    engine: Engine
    location: str
    readonly: bool
    path: Path | None = None
    identity: FileIdentity | None = None
    made: bool = False
    held: Connection | None = None

    @contextmanager
    def snapshot(self) -> Iterator[Database]:
        """Give the database as it is now: all that is read of it is read in one transaction."""
        with self.reading() as connection:
            if self.path is None:
                yield replace(self, held=connection.execution_options(isolation_level="REPEATABLE READ"))
                return
            with sqlite.read_transaction(connection) if self.readonly else nullcontext():
                yield replace(self, held=connection)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Give a connection for reading; ChangedError where the file changed in a way that no lock shows."""
        if self.held is not None:
            yield self.held
            return
        with self._in_place(), explaining_failures(self.location, self.path), self.engine.connect() as connection:
            try:
                yield connection
            except BaseException as error:
                if isinstance(error, Exception) and self._has_changed(connection):
                    raise FileChangedError(self.location) from error
                raise
            if self._has_changed(connection):
                raise FileChangedError(self.location)

    def _has_changed(self, connection: Connection) -> bool:
        return self.path is not None and sqlite.is_outdated(self.path, sqlite.opened_stamp(connection))

    @contextmanager
    def writing(self, *, durable: bool = True) -> Iterator[Connection]:
        """Give a connection in a transaction that holds the write lock; an exception leaves nothing behind.

        durable : whether it survives a power failure once it is committed, for which a commit waits for the disk; else
            that holds once a later durable one is committed. A file is consistent either way.
        """
        if self.readonly:
            raise DatabaseError(f"database {self.location} is open read-only: open it with open_database to write")
        engine = self.engine.execution_options(hcsearch_begin="IMMEDIATE", hcsearch_durable=durable)
        with self._in_place(), explaining_failures(self.location, self.path), engine.begin() as connection:
            yield connection

    @contextmanager
    def _in_place(self) -> Iterator[None]:
        """Refuse to go on, before and after a transaction, when the name leads to another file than was opened."""
        self.check_place()
        try:
            yield
        except DatabaseError:
            self.check_place()  # the reason for whatever else has failed
            raise
        self.check_place()

    def check_place(self) -> None:
        """DatabaseError when a watched file was removed, renamed or replaced: SQLite would not notice."""
        if self.identity is None:
            return
        assert self.path is not None
        if file_identity(self.path) != self.identity:
            raise DatabaseError(
                f"database {self.location} was removed, renamed or replaced by another program while it was in use: "
                "put it back with its -wal file, or give the same command again, from the start"
            )

    def fingerprint(self) -> tuple[int, ...]:
        """Return what changes when a file is written to; the minute for a server, whose changes are not seen here."""
        return (int(time.monotonic() // 60.0),) if self.path is None else sqlite.sizes_and_times(self.path)

    def watched(self) -> Database:
        """The same database, which refuses to go on when its name leads to another file by then."""
        return self if self.path is None else replace(self, identity=file_identity(self.path))

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()
        if self.readonly and self.path is not None:
            sqlite.remove_empty_log(self.path)

    def __enter__(self) -> Database:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()
        # What is refused leaves nothing behind.
        if self.made and isinstance(error, HcsearchError) and self.path and file_identity(self.path) == self.identity:
            sqlite.remove_empty_database(self.path)


def open_database(location: str | Path, *, create: bool, timeout: float = LOCK_TIMEOUT) -> Database:
    """Open a database for writing, and upgrade an older one; use it in a `with` statement.

    location : the path of an SQLite file, or the URL of an SQLite or PostgreSQL database.
    create : whether a database that does not exist is made. timeout : how long to wait for another program's lock, s.

    Errors: DatabaseError for a database that does not exist, is damaged, locked, newer than this program, or not
    writable, and for another program's file. Nothing is changed on disk then.
    """
    place = parse_location(location)
    if place.url is not None:
        return _open_server(place, create=create, readonly=False, timeout=timeout)
    assert place.path is not None
    sqlite.check_sqlite_version()
    with explaining_failures(place.text, place.path):
        made = not is_filled(place)
        _prepare_file(place, create=create, timeout=timeout)
        identity = file_identity(place.path)
        engine = sqlite.writing_engine(place.path, timeout)
        engine.connect().close()
    database = Database(engine, place.text, readonly=False, path=place.path, identity=identity, made=made)
    try:
        database.check_place()
    except DatabaseError:
        database.close()
        raise
    return database


def open_readonly(location: str | Path, *, timeout: float = LOCK_TIMEOUT) -> Database:
    """Open a database so that no statement can change it; use it in a `with` statement.

    location, timeout : as in `open_database`, with the same errors. An older database is refused, not upgraded.
    """
    place = parse_location(location)
    if place.url is not None:
        return _open_server(place, create=False, readonly=True, timeout=timeout)
    assert place.path is not None
    sqlite.check_sqlite_version()
    with explaining_failures(place.text, place.path):
        if not is_filled(place):
            raise _missing(place)
        check_revision(place.text, _revision(place, timeout) or "", upgradable=False)
        engine = sqlite.reading_engine(place.path, timeout)
        engine.connect().close()
    return Database(engine, place.text, readonly=True, path=place.path)


def _prepare_file(place: Location, *, create: bool, timeout: float) -> None:
    """Create or upgrade a file where needed, and look again: only what is on disk in the end counts."""
    for _ in range(3):
        filled = is_filled(place)
        if not filled and not create:
            raise _missing(place)
        revision = _revision(place, timeout) if filled else None
        if revision is None and not create:
            raise _missing(place)
        if revision is not None:
            check_revision(place.text, revision, upgradable=True)
        check_writable(place)
        if revision == SCHEMA_REVISION:
            return
        _upgrade_file(place, timeout)
    raise DatabaseError(
        f"database {place.text} vanishes while it is made: find the program that removes it, or name another file"
    )


def _revision(place: Location, timeout: float) -> str | None:
    """Return the revision of a filled file; None when it is an SQLite database without any table."""
    assert place.path is not None
    first_look = sqlite.read_header(place.path, timeout)
    if first_look.version is not None:
        return first_look.version
    if not first_look.empty:
        raise foreign_database_error(place.text)
    return None


def _upgrade_file(place: Location, timeout: float) -> None:
    assert place.path is not None
    existed = place.path.exists()
    engine = sqlite.upgrading_engine(place.path, timeout)
    try:
        with engine.execution_options(hcsearch_begin="IMMEDIATE").begin() as connection:
            upgrade_schema(connection, place.text)
    except BaseException:
        engine.dispose()
        if not existed and place.path.exists() and place.path.stat().st_size == 0:
            place.path.unlink()
        raise
    engine.dispose()


def _missing(place: Location) -> NoDatabaseError:
    return NoDatabaseError(
        f"there is no hcsearch database at {place.text}: make one with `hcsearch enumerate`, or name another with --db"
    )


def _open_server(place: Location, *, create: bool, readonly: bool, timeout: float) -> Database:
    assert place.url is not None
    try:
        engine = postgresql.server_engine(place.url, timeout, readonly=readonly)
    except ImportError as error:
        remedy = "install it with pip install 'hcsearch[postgresql]'"
        raise DatabaseError(f"database {place.text} needs the Python module psycopg: {remedy}") from error
    try:
        with explaining_failures(place.text):
            _try_server(engine, place)
            _prepare_server(engine, place, create=create, readonly=readonly)
    except BaseException:
        engine.dispose()
        raise
    return Database(engine, place.text, readonly=readonly)


def _try_server(engine: Engine, place: Location) -> None:
    try:
        engine.connect().close()
    except (ProgrammingError, UnicodeError) as error:
        detail = detail_of(error.orig if isinstance(error, ProgrammingError) else error)
        raise DatabaseError(
            f"the URL {place.text} has an option that cannot be used ({detail}): {LOCATION_EXAMPLES}"
        ) from error


def _prepare_server(engine: Engine, place: Location, *, create: bool, readonly: bool) -> None:
    """Create or upgrade the schema where needed. One that is there needs no lock, and waits for no writer."""
    with engine.connect() as connection:
        revision = current_revision(connection)
        if revision is None:
            refuse_foreign_database(connection, place.text)
    if revision is None and not create:
        raise _missing(place)
    if revision is not None:
        check_revision(place.text, revision, upgradable=not readonly)
    if revision != SCHEMA_REVISION:
        with engine.execution_options(hcsearch_begin="IMMEDIATE").begin() as connection:
            upgrade_schema(connection, place.text)
