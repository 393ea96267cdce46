"""Databases of every earlier schema, and SIGKILL while one is upgraded."""

import signal
import sqlite3
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from hcsearch.store import open_database
from hcsearch.store.schema import REVISION
from tests.faults.fault_tools import JOURNALS, MANY, PATIENCE, SMALL, Running, copied, copy, look, seeded, wait_until
from tests.faults.next_schema import NEXT

OLD = sorted((Path(__file__).parents[1] / "store" / "old").glob("*.sql"))
AHEAD = Path(__file__).with_name("next_schema.py")
COPYING = 0.1  # seconds: an upgrade takes about as long after it has begun to write


def version(path):
    with copied(path) as copy, closing(sqlite3.connect(copy)) as connection:
        return connection.execute("SELECT max(version_num) FROM hcsearch_version").fetchone()[0]


def designs(path):
    """The columns of each design, by circuit."""
    with copied(path) as copy, closing(sqlite3.connect(copy)) as connection:
        connection.row_factory = sqlite3.Row
        return {row["circuit"]: dict(row) for row in connection.execute("SELECT * FROM designs")}


@pytest.mark.parametrize("old", OLD, ids=lambda file: file.stem)
def test_old_database_keeps_its_rows_and_takes_a_run(tmp_path, law, old):
    path, upgraded = tmp_path / "designs.sqlite", tmp_path / "upgraded.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(old.read_text())
    open_database(str(copy(path, upgraded)), create=False).close()
    before, also = designs(path), look(upgraded)
    law("earlier schema", path, SMALL, injected=1, before=look(path, rows=False).finished, also=also)
    assert version(path) == REVISION
    after = designs(path)
    for circuit, columns in before.items():
        # until schema 0007 these were of the path, and are of the deployment now
        moved = {"needed_margin", "least_gap"} if old.stem < "0007" and columns["status"] == "deploys" else set()
        assert {item for item in columns.items() if item[0] not in moved} <= after[circuit].items()


@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.slow)])
def test_upgrade_that_is_killed_leaves_the_old_or_the_new(tmp_path, reference, law, kills):
    state, source = reference(MANY).state, reference(MANY).path
    ahead = (sys.executable, str(AHEAD), str(tmp_path / "scripts"))
    path = tmp_path / "designs.sqlite"
    chance = seeded(f"{kills} kills of an upgrade")
    for _ in range(kills):
        for suffix in ("", *JOURNALS, "-shm"):
            path.with_name(path.name + suffix).unlink(missing_ok=True)
        copy(source, path)
        log = path.with_name(f"{path.name}-wal")
        with Running(*MANY.into(path), program=ahead) as running:
            assert wait_until(lambda r=running, log=log: r.ended or (log.exists() and log.stat().st_size), PATIENCE)
            time.sleep(chance.uniform(0, COPYING))
            _, _, err = running.end(signal.SIGKILL)
            assert err == ""
        assert version(path) in (REVISION, NEXT)
        left = look(path)
        assert left.finished == state.finished
        assert left.rows == state.rows
    law("SIGKILL in an upgrade", path, MANY, injected=kills, before=state.finished, program=ahead)
    assert version(path) == NEXT
