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

from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.store import postgresql, sqlite
from hcsearch.store.failures import FileChangedError, detail_of, explaining_failures
from hcsearch.store.location import (
    LOCATION_EXAMPLES,
    FileIdentity,
    Location,
    check_writable,
    file_identity,
    is_filled,
    missing_error,
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

    identity : of the file, if its replacement is to be detected. was_created : whether opening created it.
    snapshot_connection : the connection of a snapshot.
    """

    engine: Engine
    location: str
    readonly: bool
    path: Path | None = None
    identity: FileIdentity | None = None
    was_created: bool = False
    snapshot_connection: Connection | None = None

    @contextmanager
    def snapshot(self) -> Iterator[Database]:
        """Yield a snapshot of the database, which is read in one transaction."""
        with self.reading() as connection:
            if self.path is None:
                yield replace(self, snapshot_connection=connection.execution_options(isolation_level="REPEATABLE READ"))
                return
            with sqlite.read_transaction(connection) if self.readonly else nullcontext():
                yield replace(self, snapshot_connection=connection)

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Yield a connection for reading; ChangedError if the file changed without a lock."""
        if self.snapshot_connection is not None:
            yield self.snapshot_connection
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()
        # A refused database is left without traces.
        if (
            self.was_created
            and isinstance(error, HcsearchError)
            and self.path
            and file_identity(self.path) == self.identity
        ):
            sqlite.remove_empty_database(self.path)


def open_database(location: str | Path, *, create: bool, timeout: float = LOCK_TIMEOUT) -> Database:
    """Open a database for writing, upgrading an older one; for a `with` statement.

    Parameters
    ----------
    location
        The path of an SQLite file, or the URL of an SQLite or PostgreSQL database.
    create
        Whether to create a database that does not exist.
    timeout
        Longest wait for another program's lock, s.

    Returns
    -------
    Database
        The open database.

    Raises
    ------
    DatabaseError
        For a database that does not exist, is damaged, locked, newer than this program, or not writable, and for the
        file of another program. In these cases nothing changes on disk.
    """
    parsed = parse_location(location)
    if parsed.url is not None:
        return _open_server(parsed, create=create, readonly=False, timeout=timeout)
    assert parsed.path is not None
    sqlite.check_sqlite_version()
    with explaining_failures(parsed.text, parsed.path):
        was_created = not is_filled(parsed)
        _prepare_file(parsed, create=create, timeout=timeout)
        identity = file_identity(parsed.path)
        engine = sqlite.writing_engine(parsed.path, timeout)
        engine.connect().close()
    database = Database(
        engine, parsed.text, readonly=False, path=parsed.path, identity=identity, was_created=was_created
    )
    try:
        database.check_place()
    except DatabaseError:
        database.close()
        raise
    return database


def open_readonly(location: str | Path, *, timeout: float = LOCK_TIMEOUT) -> Database:
    """Open a database read-only: no statement can change it; for a `with` statement.

    Parameters
    ----------
    location, timeout
        As in `open_database`, with the same errors. An older database is refused, not upgraded.

    Returns
    -------
    Database
        The open database.
    """
    parsed = parse_location(location)
    if parsed.url is not None:
        return _open_server(parsed, create=False, readonly=True, timeout=timeout)
    assert parsed.path is not None
    sqlite.check_sqlite_version()
    with explaining_failures(parsed.text, parsed.path):
        if not is_filled(parsed):
            raise missing_error(parsed)
        check_revision(parsed.text, _revision(parsed, timeout) or "", upgradable=False)
        engine = sqlite.reading_engine(parsed.path, timeout)
        engine.connect().close()
    return Database(engine, parsed.text, readonly=True, path=parsed.path)


def _prepare_file(location: Location, *, create: bool, timeout: float) -> None:
    """Create or upgrade a file if needed, and check the result on disk."""
    for _ in range(3):
        filled = is_filled(location)
        if not filled and not create:
            raise missing_error(location)
        revision = _revision(location, timeout) if filled else None
        if revision is None and not create:
            raise missing_error(location)
        if revision is not None:
            check_revision(location.text, revision, upgradable=True)
        check_writable(location)
        if revision == SCHEMA_REVISION:
            return
        _upgrade_file(location, timeout)
    raise DatabaseError(
        f"database {location.text} vanishes while it is made: find the program that removes it, or name another file"
    )


def _revision(location: Location, timeout: float) -> str | None:
    """Return the schema revision of a file with content; None for an SQLite database without tables."""
    assert location.path is not None
    first_look = sqlite.read_header(location.path, timeout)
    if first_look.version is not None:
        return first_look.version
    if not first_look.has_no_tables:
        raise foreign_database_error(location.text)
    return None


def _upgrade_file(location: Location, timeout: float) -> None:
    assert location.path is not None
    existed = location.path.exists()
    engine = sqlite.upgrading_engine(location.path, timeout)
    try:
        with engine.execution_options(hcsearch_begin="IMMEDIATE").begin() as connection:
            upgrade_schema(connection, location.text)
    except BaseException:
        engine.dispose()
        if not existed and location.path.exists() and location.path.stat().st_size == 0:
            location.path.unlink()
        raise
    engine.dispose()


def _open_server(location: Location, *, create: bool, readonly: bool, timeout: float) -> Database:
    assert location.url is not None
    try:
        engine = postgresql.server_engine(location.url, timeout, readonly=readonly)
    except ImportError as error:
        remedy = "install it with pip install 'hcsearch[postgresql]'"
        raise DatabaseError(f"database {location.text} needs the Python module psycopg: {remedy}") from error
    try:
        with explaining_failures(location.text):
            _try_server(engine, location)
            _prepare_server(engine, location, create=create, readonly=readonly)
    except BaseException:
        engine.dispose()
        raise
    return Database(engine, location.text, readonly=readonly)


def _try_server(engine: Engine, location: Location) -> None:
    try:
        engine.connect().close()
    except (ProgrammingError, UnicodeError) as error:
        detail = detail_of(error.orig if isinstance(error, ProgrammingError) else error)
        raise DatabaseError(
            f"the URL {location.text} has an option that cannot be used ({detail}): {LOCATION_EXAMPLES}"
        ) from error


def _prepare_server(engine: Engine, location: Location, *, create: bool, readonly: bool) -> None:
    """Create or upgrade the schema of a server if needed; a current one takes no lock and waits for no writer."""
    with engine.connect() as connection:
        revision = current_revision(connection)
        if revision is None:
            refuse_foreign_database(connection, location.text)
    if revision is None and not create:
        raise missing_error(location)
    if revision is not None:
        check_revision(location.text, revision, upgradable=not readonly)
    if revision != SCHEMA_REVISION:
        with engine.execution_options(hcsearch_begin="IMMEDIATE").begin() as connection:
            upgrade_schema(connection, location.text)
