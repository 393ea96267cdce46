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
"""Longest wait for the lock of another program, in seconds."""


@dataclass(frozen=True)
class Database:
    """An open database. `location` is its name for messages, without any password; `path` is its file, if it is one.

    identity : of the file, if its replacement is to be detected. made : whether opening created it. held : the
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
        """Yield a snapshot of the database, which is read in one transaction."""
        with self.reading() as connection:
            if self.path is None:
                yield replace(self, held=connection.execution_options(isolation_level="REPEATABLE READ"))
                return
            with sqlite.read_transaction(connection) if self.readonly else nullcontext():
                yield replace(self, held=connection)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Yield a connection for reading; ChangedError if the file changed without a lock."""
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
        """Yield a connection in a transaction that holds the write lock; an exception rolls it back.

        durable : whether the commit waits for the disk, so that it survives a power failure; otherwise it does once a
            later durable transaction is committed. A file is consistent either way.
        """
        if self.readonly:
            raise DatabaseError(f"database {self.location} is open read-only: open it with open_database to write")
        engine = self.engine.execution_options(hcsearch_begin="IMMEDIATE", hcsearch_durable=durable)
        with self._in_place(), explaining_failures(self.location, self.path), engine.begin() as connection:
            yield connection

    @contextmanager
    def _in_place(self) -> Iterator[None]:
        """Check before and after a transaction that the path still leads to the opened file."""
        self.check_place()
        try:
            yield
        except DatabaseError:
            self.check_place()  # the cause of any other failure
            raise
        self.check_place()

    def check_place(self) -> None:
        """Raise DatabaseError if a watched file was removed, renamed or replaced, which SQLite does not notice."""
        if self.identity is None:
            return
        assert self.path is not None
        if file_identity(self.path) != self.identity:
            raise DatabaseError(
                f"database {self.location} was removed, renamed or replaced by another program while it was in use: "
                "put it back with its -wal file, or give the same command again, from the start"
            )

    def fingerprint(self) -> tuple[int, ...]:
        """Return a value that changes with every write to the file; for a server, the current minute."""
        return (int(time.monotonic() // 60.0),) if self.path is None else sqlite.sizes_and_times(self.path)

    def watched(self) -> Database:
        """Return this database, watched: transactions fail once its path leads to another file."""
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
        # A refused database is left without traces.
        if self.made and isinstance(error, HcsearchError) and self.path and file_identity(self.path) == self.identity:
            sqlite.remove_empty_database(self.path)


def open_database(location: str | Path, *, create: bool, timeout: float = LOCK_TIMEOUT) -> Database:
    """Open a database for writing, upgrading an older one; for a `with` statement.

    location : the path of an SQLite file, or the URL of an SQLite or PostgreSQL database.
    create : whether to create a database that does not exist. timeout : longest wait for another program's lock, s.

    Errors: DatabaseError for a database that does not exist, is damaged, locked, newer than this program, or not
    writable, and for the file of another program. In these cases nothing changes on disk.
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
    """Open a database read-only: no statement can change it; for a `with` statement.

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
    """Create or upgrade a file if needed, and check the result on disk."""
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
    """Return the schema revision of a file with content; None for an SQLite database without tables."""
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
    """Create or upgrade the schema of a server if needed; a current one takes no lock and waits for no writer."""
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
