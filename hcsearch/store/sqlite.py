"""Connections to SQLite files: read-write with real transactions, read-only with an authorizer, and inspection."""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from sqlalchemy import Connection, Engine, Pool, QueuePool, create_engine, event
from sqlalchemy.exc import DisconnectionError

from hcsearch.basics.errors import DatabaseError
from hcsearch.store.failures import LOCKED_CODES, primary_code
from hcsearch.store.schema import APPLICATION_ID, VERSION_TABLE

_READING = (sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ, sqlite3.SQLITE_FUNCTION, sqlite3.SQLITE_RECURSIVE)

MIN_SQLITE_VERSION = (3, 37, 0)
"""The oldest SQLite with STRICT tables."""

PROGRESS_HANDLER_STEPS = 100_000  # instructions of SQLite's virtual machine


@dataclass(frozen=True)
class FileInspection:
    """The result of inspecting a file: schema version, None for a foreign file; whether it has no tables."""

    version: str | None
    has_no_tables: bool


def check_sqlite_version() -> None:
    """Raise DatabaseError if the SQLite of this Python is too old; it would report sound databases as damaged."""
    if sqlite3.sqlite_version_info < MIN_SQLITE_VERSION:
        needed = ".".join(map(str, MIN_SQLITE_VERSION[:2]))
        raise DatabaseError(
            f"the SQLite of this Python is {sqlite3.sqlite_version}, hcsearch needs {needed} or newer: use another "
            "Python, or a PostgreSQL database"
        )


def connect_file(path: Path, mode: str, timeout: float) -> sqlite3.Connection:
    """Open a file; mode is `ro`, `rw`, `rwc` or `ro&immutable=1`, timeout the longest wait for locks in seconds."""
    # Quoted as bytes, so that ?, #, % and bytes outside UTF-8 stay part of the path.
    uri = f"file://{quote(os.fsencode(path.absolute()))}?mode={mode}"
    # No implicit transactions, which begin late and not before DDL; `_begin` begins them.
    connection = sqlite3.connect(uri, uri=True, timeout=timeout, isolation_level=None, check_same_thread=False)
    # A check for signals every few milliseconds: Ctrl-C ends a long statement with SQLITE_INTERRUPT.
    connection.set_progress_handler(lambda: 0, PROGRESS_HANDLER_STEPS)
    return connection


FileStamp = tuple[int, int, int, bytes, bool]
"""A fingerprint of a file: inode number, size, time, the change counter of SQLite, presence of a log."""

_STAMP = "stamp"
_TRIES = 5


def file_stamp_of(path: Path) -> FileStamp:
    """Return the current stamp of a file on which this process holds no lock, as closing a file releases all locks."""
    with path.open("rb") as file:
        counter = file.read(28)[24:]
    return *_status(path), counter, _has_content(path, "-wal")


def _status(path: Path) -> tuple[int, int, int]:
    """Return inode number, size and time of a file without opening it."""
    status = path.stat()
    return status.st_ino, status.st_size, status.st_mtime_ns


def sizes_and_times(path: Path) -> tuple[int, ...]:
    """Return times and sizes of a file and its log without opening them."""
    stamps: list[int] = []
    for file in (path, path.with_name(path.name + "-wal")):
        if file.exists():
            status = file.stat()
            stamps += [status.st_mtime_ns, status.st_size]
    return tuple(stamps)


def is_outdated(path: Path, opened: FileStamp | None) -> bool:
    """Return whether a file opened without locks has changed since its stamp; False without a stamp."""
    return opened is not None and opened != file_stamp_of(path)


def opened_stamp(connection: Connection) -> FileStamp | None:
    """Return the stamp of a file when a connection opened it without locks; None if SQLite locks it."""
    opened: FileStamp | None = connection.info.get(_STAMP)
    return opened


def read_header(path: Path, timeout: float) -> FileInspection:
    """Inspect a file; nothing changes on disk unless the file is in use."""
    for _ in range(_TRIES):
        status = _status(path)
        try:
            result = _looked(path, timeout)
        except sqlite3.DatabaseError:
            if _status(path) == status:
                raise
            continue  # reads of a changing file may be inconsistent
        if _status(path) == status:
            break
    else:
        return _look(path, "ro", timeout)  # a writer is active, so the locks of SQLite are needed
    return result


def _looked(path: Path, timeout: float) -> FileInspection:
    # If the shared memory of a log exists, the file may be in use, also by this process. Closing a file that was opened
    # without SQLite and its locks would release all locks of this process on it: another process could then remove the
    # log of an active writer.
    used = path.with_name(path.name + "-shm").exists()
    # An immutable connection leaves no -wal and -shm files, but sees only the content of the main file.
    if not used and not _has_content(path, "-journal"):
        if not _has_content(path, "-wal"):
            return _look(path, "ro&immutable=1", timeout)
        if not _has_our_number(path):
            # A file of this program has its id before any log. Reading the log of another program leaves a -shm.
            return FileInspection(None, has_no_tables=False)
    try:
        return _look(path, "ro", timeout)
    except sqlite3.OperationalError as error:
        if primary_code(error) != sqlite3.SQLITE_READONLY:
            raise
        # A writer was killed: SQLite must roll back its transaction before anyone can read.
        return _look(path, "rw", timeout)


def _has_content(path: Path, suffix: str) -> bool:
    """Return whether a file has a non-empty journal of the kind of a suffix."""
    journal = path.with_name(path.name + suffix)
    return journal.exists() and journal.stat().st_size > 0


def _has_our_number(path: Path) -> bool:
    """Return whether the header of a file has the application id of this program; the log is not read."""
    with path.open("rb") as file:
        return file.read(72)[68:] == APPLICATION_ID.to_bytes(4, "big")


def _look(path: Path, mode: str, timeout: float) -> FileInspection:
    connection = connect_file(path, mode, timeout)
    try:
        ours = connection.execute("PRAGMA application_id").fetchone()[0] == APPLICATION_ID
        tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema")}
        version = None
        if ours and VERSION_TABLE in tables:
            newest = connection.execute(f"SELECT max(version_num) FROM {VERSION_TABLE}").fetchone()[0]
            version = None if newest is None else str(newest)
        return FileInspection(version, not tables)
    finally:
        connection.close()


def writing_engine(path: Path, timeout: float) -> Engine:
    """Return an engine for reading and writing an existing database, with write-ahead log and foreign keys."""

    def creator() -> sqlite3.Connection:
        connection = connect_file(path, "rw", timeout)
        _use_write_ahead_log(connection, timeout)
        connection.execute("PRAGMA foreign_keys=ON")
        connection.execute("PRAGMA wal_autocheckpoint=4000")  # pages; at 1000, bulk inserts wait for the disk
        connection.execute("PRAGMA cache_size=-262144")  # KiB; accesses to the index of circuits are scattered
        return connection

    return _engine(creator, QueuePool)


def upgrading_engine(path: Path, timeout: float) -> Engine:
    """Return an engine that may create the file; foreign keys are off, as altering a table may copy and drop it."""
    return _engine(lambda: connect_file(path, "rwc", timeout), QueuePool)


def reading_engine(path: Path, timeout: float) -> Engine:
    """Return an engine on which no statement can change any file."""
    stamps: dict[int, FileStamp] = {}

    def creator() -> sqlite3.Connection:
        log = path.with_name(path.name + "-wal")
        # SQLite cannot create its shared memory with the locks where this user must not write. Others may write
        # there, so the stamp of the file is checked around each statement.
        sealed = not os.access(path.absolute().parent, os.W_OK) and not log.exists()
        opened = file_stamp_of(path) if sealed else None
        connection = connect_file(path, "ro&immutable=1" if sealed else "ro", timeout)
        connection.execute("PRAGMA query_only=ON")
        connection.execute("PRAGMA trusted_schema=OFF")
        if opened is not None:
            stamps[id(connection)] = opened
        return connection

    def connected(connection: sqlite3.Connection, record: Any) -> None:
        # Not in the creator: SQLAlchemy runs a PRAGMA on its first connection before it calls this listener.
        connection.set_authorizer(_authorize)
        record.info[_STAMP] = stamps.pop(id(connection), None)

    def taken(_connection: sqlite3.Connection, record: Any, _proxy: object) -> None:
        if is_outdated(path, record.info[_STAMP]):
            raise DisconnectionError("the file has changed")  # the pool reopens it

    # No BEGIN, which the authorizer would refuse: each statement is a snapshot.
    # A connection per reading thread: no thread waits for another.
    engine = create_engine("sqlite://", creator=creator, poolclass=QueuePool, max_overflow=-1)
    event.listen(engine, "connect", connected)
    event.listen(engine, "checkout", taken)
    return engine


@contextmanager
def read_transaction(connection: Connection) -> Iterator[None]:
    """Hold a read transaction on a connection of `reading_engine`, so that all reads see one snapshot."""
    raw = connection.connection.driver_connection
    assert isinstance(raw, sqlite3.Connection)

    def run(statement: str) -> None:
        raw.set_authorizer(None)  # the authorizer refuses BEGIN otherwise
        try:
            raw.execute(statement)
        finally:
            raw.set_authorizer(_authorize)

    run("BEGIN")
    try:
        yield
    finally:
        run("ROLLBACK")


def remove_empty_log(path: Path) -> None:
    """Let SQLite remove the empty -wal and -shm files left by a reader, unless the file is in use."""
    log = path.with_name(path.name + "-wal")
    with suppress(OSError, sqlite3.Error):
        # A killed writer left a log with content: its checkpoint is up to the next writer.
        if log.stat().st_size > 0 or not os.access(path, os.W_OK):
            return
        # The last connection that closes the file removes them if it may write; the locks of SQLite tell which is last.
        with closing(connect_file(path, "rw", timeout=0)) as connection:
            connection.execute("SELECT name FROM sqlite_schema").fetchone()


def remove_empty_database(path: Path) -> None:
    """Remove a database of this program without rows, unless it is in use."""
    with suppress(OSError, sqlite3.Error), closing(connect_file(path, "rw", timeout=0)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")  # refused while there are other connections
        connection.execute("BEGIN EXCLUSIVE")
        tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
        if not any(connection.execute(f'SELECT 1 FROM "{name}"').fetchone() for name in tables - {VERSION_TABLE}):
            path.unlink()


def _authorize(action: int, _first: str | None, second: str | None, _database: str | None, _trigger: str | None) -> int:
    """Allow the actions of a SELECT; refuse ATTACH, PRAGMA and every change before they run."""
    if action not in _READING or (action == sqlite3.SQLITE_FUNCTION and (second or "").lower() == "load_extension"):
        return sqlite3.SQLITE_DENY
    return sqlite3.SQLITE_OK


def _engine(creator: Callable[[], sqlite3.Connection], pool: type[Pool]) -> Engine:
    engine = create_engine("sqlite://", creator=creator, poolclass=pool)
    event.listen(engine, "begin", _begin)
    return engine


def _begin(connection: Connection) -> None:
    options = connection.get_execution_options()
    if "hcsearch_durable" in options:
        # FULL waits for the disk at each commit; with NORMAL a power failure may undo the last commits, as a whole.
        connection.exec_driver_sql(f"PRAGMA synchronous={'FULL' if options['hcsearch_durable'] else 'NORMAL'}")
    # IMMEDIATE takes the write lock at once: a transaction that read first could not get it after another commit.
    connection.exec_driver_sql(f"BEGIN {options.get('hcsearch_begin', 'DEFERRED')}")


def _use_write_ahead_log(connection: sqlite3.Connection, timeout: float) -> None:
    """Switch to the write-ahead log; repeated, since SQLite may refuse concurrent switches without a wait."""
    deadline = time.monotonic() + timeout
    while True:
        try:
            connection.execute("PRAGMA journal_mode=WAL")
        except sqlite3.OperationalError as error:
            if primary_code(error) not in LOCKED_CODES or time.monotonic() > deadline:
                connection.close()
                raise
            time.sleep(0.01)
        else:
            return
