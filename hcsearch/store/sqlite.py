"""Connections to SQLite files: read-write with real transactions, read-only behind an authorizer, and a first look."""

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
"""The oldest SQLite that knows tables that are STRICT."""

PROGRESS_HANDLER_STEPS = 100_000  # of SQLite's virtual machine


@dataclass(frozen=True)
class FileInspection:
    """What a file holds at first sight: `version` of our schema, None where the file is not ours; no tables at all."""

    version: str | None
    empty: bool


def check_sqlite_version() -> None:
    """DatabaseError where the SQLite of this Python is too old: it calls a good database damaged."""
    if sqlite3.sqlite_version_info < MIN_SQLITE_VERSION:
        needed = ".".join(map(str, MIN_SQLITE_VERSION[:2]))
        raise DatabaseError(
            f"the SQLite of this Python is {sqlite3.sqlite_version}, hcsearch needs {needed} or newer: use another "
            "Python, or a PostgreSQL database"
        )


def connect_file(path: Path, mode: str, timeout: float) -> sqlite3.Connection:
    """Open a file; mode is `ro`, `rw`, `rwc` or `ro&immutable=1`, timeout the wait for locks in seconds."""
    # Quoted as bytes, so that ?, #, % and names that are not UTF-8 stay part of the path.
    uri = f"file://{quote(os.fsencode(path.absolute()))}?mode={mode}"
    # No implicit transactions: they would begin late, and not before DDL. `_begin` begins them.
    connection = sqlite3.connect(uri, uri=True, timeout=timeout, isolation_level=None, check_same_thread=False)
    # A look at signals every few milliseconds: Ctrl-C in it ends a long statement with SQLITE_INTERRUPT.
    connection.set_progress_handler(lambda: 0, PROGRESS_HANDLER_STEPS)
    return connection


FileStamp = tuple[int, int, int, bytes, bool]
"""What a change of a file changes: its number, size and time, SQLite's counter of changes, whether it has a log."""

_STAMP = "stamp"
_TRIES = 5


def file_stamp_of(path: Path) -> FileStamp:
    """The stamp of a file as it is now, of which this process holds no lock: closing a file gives up all of them."""
    with path.open("rb") as file:
        counter = file.read(28)[24:]
    return *_status(path), counter, _has_content(path, "-wal")


def _status(path: Path) -> tuple[int, int, int]:
    """The number, size and time of a file, which is not opened."""
    status = path.stat()
    return status.st_ino, status.st_size, status.st_mtime_ns


def sizes_and_times(path: Path) -> tuple[int, ...]:
    """Time and size of a file and of its log, none of which is opened."""
    stamps: list[int] = []
    for file in (path, path.with_name(path.name + "-wal")):
        if file.exists():
            status = file.stat()
            stamps += [status.st_mtime_ns, status.st_size]
    return tuple(stamps)


def is_outdated(path: Path, opened: FileStamp | None) -> bool:
    """Whether a file that was opened without locks, with this stamp, has been written to since; False for others."""
    return opened is not None and opened != file_stamp_of(path)


def opened_stamp(connection: Connection) -> FileStamp | None:
    """The stamp of the file when a connection opened it without locks; None where SQLite locks it."""
    opened: FileStamp | None = connection.info.get(_STAMP)
    return opened


def read_header(path: Path, timeout: float) -> FileInspection:
    """Look at a file without changing anything on disk, if it is not in use."""
    for _ in range(_TRIES):
        before = _status(path)
        try:
            seen = _looked(path, timeout)
        except sqlite3.DatabaseError:
            if _status(path) == before:
                raise
            continue  # what was read of a file that changes may be in pieces
        if _status(path) == before:
            break
    else:
        return _look(path, "ro", timeout)  # somebody goes on writing, and SQLite's locks say when to read
    return seen


def _looked(path: Path, timeout: float) -> FileInspection:
    # Where there is the memory of a log, its file may be in use, in this process too. Closing a file that was opened in
    # any other way than by SQLite, with its locks, would give up all locks that this process has on it: another one
    # could then take away the log of a writer that is at work.
    used = path.with_name(path.name + "-shm").exists()
    # An immutable connection leaves no -wal and -shm files behind, but sees only what is in the main file.
    if not used and not _has_content(path, "-journal"):
        if not _has_content(path, "-wal"):
            return _look(path, "ro&immutable=1", timeout)
        if not _has_our_number(path):
            # Ours has its number before it has a log. A look into the log of another program would leave a -shm.
            return FileInspection(None, empty=False)
    try:
        return _look(path, "ro", timeout)
    except sqlite3.OperationalError as error:
        if primary_code(error) != sqlite3.SQLITE_READONLY:
            raise
        # A writer was killed: SQLite must be let undo its half-written transaction before anyone can read.
        return _look(path, "rw", timeout)


def _has_content(path: Path, suffix: str) -> bool:
    """Whether the journal of this kind lies beside the file, and is not empty."""
    journal = path.with_name(path.name + suffix)
    return journal.exists() and journal.stat().st_size > 0


def _has_our_number(path: Path) -> bool:
    """Whether the header of a file says that it is ours; without its log, the rest of the file may be in pieces."""
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
    """Return an engine for reading and writing an existing database of ours: write-ahead log, foreign keys checked."""

    def creator() -> sqlite3.Connection:
        connection = connect_file(path, "rw", timeout)
        _use_write_ahead_log(connection, timeout)
        connection.execute("PRAGMA foreign_keys=ON")
        connection.execute("PRAGMA wal_autocheckpoint=4000")  # pages; at 1000, bulk inserts wait for the disk
        connection.execute("PRAGMA cache_size=-262144")  # KiB; the index of circuits is hit all over
        return connection

    return _engine(creator, QueuePool)


def upgrading_engine(path: Path, timeout: float) -> Engine:
    """Return an engine that may create the file; foreign keys are off, since altering a table may copy and drop it."""
    return _engine(lambda: connect_file(path, "rwc", timeout), QueuePool)


def reading_engine(path: Path, timeout: float) -> Engine:
    """Return an engine on which no statement can change anything, here or in any other file."""
    stamps: dict[int, FileStamp] = {}

    def creator() -> sqlite3.Connection:
        log = path.with_name(path.name + "-wal")
        # SQLite cannot make its shared memory, which holds its locks, where this user must not write. Others may write
        # there, so that the file is looked at around each statement.
        sealed = not os.access(path.absolute().parent, os.W_OK) and not log.exists()
        opened = file_stamp_of(path) if sealed else None
        connection = connect_file(path, "ro&immutable=1" if sealed else "ro", timeout)
        connection.execute("PRAGMA query_only=ON")
        connection.execute("PRAGMA trusted_schema=OFF")
        if opened is not None:
            stamps[id(connection)] = opened
        return connection

    def connected(connection: sqlite3.Connection, record: Any) -> None:
        # Not in the creator: SQLAlchemy asks a PRAGMA of its first connection, before it calls this listener.
        connection.set_authorizer(_authorize)
        record.info[_STAMP] = stamps.pop(id(connection), None)

    def taken(_connection: sqlite3.Connection, record: Any, _proxy: object) -> None:
        if is_outdated(path, record.info[_STAMP]):
            raise DisconnectionError("the file has changed")  # the pool opens it anew

    # No BEGIN, which the authorizer would refuse: one statement is one snapshot.
    # As many connections as there are threads that read: none waits for another to end.
    engine = create_engine("sqlite://", creator=creator, poolclass=QueuePool, max_overflow=-1)
    event.listen(engine, "connect", connected)
    event.listen(engine, "checkout", taken)
    return engine


@contextmanager
def read_transaction(connection: Connection) -> Iterator[None]:
    """Read all that follows on a connection of `reading_engine` as the file is now."""
    raw = connection.connection.driver_connection
    assert isinstance(raw, sqlite3.Connection)

    def run(statement: str) -> None:
        raw.set_authorizer(None)  # which refuses it in statements of users
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
    """Let SQLite remove the empty -wal and the -shm that a reader leaves, unless someone uses the file."""
    log = path.with_name(path.name + "-wal")
    with suppress(OSError, sqlite3.Error):
        # A log with content is what a killed writer left: moving it into the file is up to the next writer.
        if log.stat().st_size > 0 or not os.access(path, os.W_OK):
            return
        # The last connection to close the file removes them, if it may write; SQLite knows by its locks which is last.
        with closing(connect_file(path, "rw", timeout=0)) as connection:
            connection.execute("SELECT name FROM sqlite_schema").fetchone()


def remove_empty_database(path: Path) -> None:
    """Remove a database of ours that holds no rows, unless someone else uses it."""
    with suppress(OSError, sqlite3.Error), closing(connect_file(path, "rw", timeout=0)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")  # refused while there are other connections
        connection.execute("BEGIN EXCLUSIVE")
        tables = {name for (name,) in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
        if not any(connection.execute(f'SELECT 1 FROM "{name}"').fetchone() for name in tables - {VERSION_TABLE}):
            path.unlink()


def _authorize(action: int, _first: str | None, second: str | None, _database: str | None, _trigger: str | None) -> int:
    """Allow what a SELECT needs; ATTACH, PRAGMA and every change are refused before they run."""
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
        # FULL waits for the disk at each commit; after NORMAL ones a power failure may undo the last commits, whole.
        connection.exec_driver_sql(f"PRAGMA synchronous={'FULL' if options['hcsearch_durable'] else 'NORMAL'}")
    # IMMEDIATE takes the write lock at once: a transaction that read first could not get it after another's commit.
    connection.exec_driver_sql(f"BEGIN {options.get('hcsearch_begin', 'DEFERRED')}")


def _use_write_ahead_log(connection: sqlite3.Connection, timeout: float) -> None:
    """Switch to the write-ahead log; two processes that switch at once may be refused without a wait, so try again."""
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
