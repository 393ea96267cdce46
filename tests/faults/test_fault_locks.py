"""Locks that another program holds: waited for, or refused in one line; readers do not wait."""

import subprocess
import sys
import time
from contextlib import contextmanager

import pytest

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import open_database
from tests.faults.fault_tools import (
    MANY,
    MOST,
    PATIENCE,
    SMALL,
    Running,
    assert_one_line,
    copy,
    look,
    progress,
    run,
    wait_for,
)

HELD = 2.0  # seconds that a lock is held
HOLDER = """
import sqlite3, sys, time
connection = sqlite3.connect(sys.argv[1], isolation_level=None, timeout=0)
print("ready", flush=True)
sys.stdin.readline()
while True:
    try:
        connection.execute("BEGIN " + sys.argv[2])
        break
    except sqlite3.OperationalError:
        time.sleep(0.0005)  # more stubborn than SQLite's own wait: a busy writer leaves gaps of milliseconds
print("held", flush=True)
sys.stdin.read()
"""


class Holder:
    """Another process, which takes the lock of a database and gives it back when it is told to."""

    def __init__(self, path, kind):
        line = [sys.executable, "-c", HOLDER, str(path), kind]
        self._process = subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout.readline() == "ready\n"

    def take(self):
        self._process.stdin.write("take\n")
        self._process.stdin.flush()
        assert self._process.stdout.readline() == "held\n"

    def release(self):
        self._process.stdin.close()
        self._process.wait(PATIENCE)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.release()
        self._process.stdout.close()


@contextmanager
def held(path, kind):
    with Holder(path, kind) as holder:
        holder.take()
        yield holder


def test_lock_that_is_released_is_waited_for(tmp_path, reference, law):
    """A database in use, and a file that another program is about to fill: both at once, to wait only once."""
    old, new = copy(reference(MANY).path, tmp_path / "old.sqlite"), tmp_path / "new.sqlite"
    before = reference(MANY).state.finished
    with (
        held(old, "IMMEDIATE") as old_lock,
        held(new, "EXCLUSIVE") as new_lock,
        Running(*SMALL.into(old)) as first,
        Running(*SMALL.into(new)) as second,
    ):
        time.sleep(HELD)
        assert not first.ended
        assert not second.ended
        assert progress(old) == (1, len(before))
        old_lock.release()
        new_lock.release()
        for running in (first, second):
            code, _, err = running.end()
            assert (code, err) == (0, "")
    law("lock", old, MANY, SMALL, injected=1, before=before)
    law("lock", new, SMALL, injected=1, before=frozenset())


@pytest.mark.slow
def test_lock_taken_in_mid_run_is_waited_for_and_readers_go_on(tmp_path, law):
    path = tmp_path / "designs.sqlite"
    with Holder(path, "IMMEDIATE") as holder, Running(*MOST.into(path)) as running:
        wait_for(running, path, 1)
        holder.take()
        at_lock, state = progress(path), look(path, rows=False)
        query = run("query", "--db", path, "--sql", "SELECT count(*) AS n FROM designs", "--format", "csv")
        assert (query.returncode, query.stderr) == (0, "")
        assert query.stdout == f"n\n{state.designs}\n"
        assert progress(path) == at_lock
        assert not running.ended
        holder.release()
        code, _, err = running.end()
        assert (code, err) == (0, "")
    law("lock", path, MOST, injected=1, before=state.finished)


@pytest.mark.parametrize("kind", ["IMMEDIATE", "EXCLUSIVE"])
def test_short_timeout_is_refused_in_one_line(tmp_path, kind):
    path = tmp_path / "designs.sqlite"
    open_database(str(path), create=True).close()
    with held(path, kind), open_database(str(path), create=False, timeout=0.1) as database:
        start = time.monotonic()
        with pytest.raises(DatabaseError, match="locked by another program") as caught, database.writing():
            pass
        assert time.monotonic() - start < 5
        assert_one_line(f"hcsearch: {caught.value}\n")
        query = run("query", "--db", path, "--sql", "SELECT count(*) AS n FROM designs", "--format", "csv")
        assert (query.returncode, query.stdout, query.stderr) == (0, "n\n0\n", "")


def test_short_timeout_on_a_new_file_is_refused_in_one_line(tmp_path):
    path = tmp_path / "designs.sqlite"
    with held(path, "EXCLUSIVE"):
        with pytest.raises(DatabaseError, match="locked by another program") as caught:
            open_database(str(path), create=True, timeout=0.1)
        assert_one_line(f"hcsearch: {caught.value}\n")
    open_database(str(path), create=True, timeout=0.1).close()
