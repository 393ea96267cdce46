"""Databases of an earlier schema, and SIGKILL while one is upgraded."""

import signal
import sqlite3
import time
from contextlib import closing

import pytest

from hcsearch.designs.records import WorkKey
from hcsearch.store import find_circuit, open_database, select
from hcsearch.store.schema import SCHEMA_REVISION
from tests.faults.fault_tools import (
    JOURNALS,
    MANY,
    OTHER,
    PATIENCE,
    SMALL,
    Running,
    copied,
    copy,
    look,
    seeded,
    wait_until,
)
from tests.judging import judge
from tests.next_schema import NEXT, program_ahead

COPYING = 0.1  # seconds: an upgrade takes about as long after it has begun to write


def version(path):
    with copied(path) as copy, closing(sqlite3.connect(copy)) as connection:
        return connection.execute("SELECT max(version_num) FROM hcsearch_version").fetchone()[0]


def designs(path):
    """The columns of each design, by circuit."""
    with copied(path) as copy, closing(sqlite3.connect(copy)) as connection:
        connection.row_factory = sqlite3.Row
        return {row["circuit"]: dict(row) for row in connection.execute("SELECT * FROM designs")}


def test_old_database_keeps_its_rows_and_takes_a_run(tmp_path, reference, law):
    path = copy(reference(OTHER).path, tmp_path / "designs.sqlite")
    with open_database(str(path), create=False) as database:
        moving = select(database, "untwisted", columns="design_id,crease", view="foldings", limit=2).rows
        for (number, crease), status in zip(moving, ("deploys", "movable"), strict=True):
            _, circuit = find_circuit(database, str(number))
            judge(database, [(circuit, crease, status, None, None)], work=WorkKey("square", OTHER.n, "", "all"))
    before, state = designs(path), look(path)
    assert version(path) == SCHEMA_REVISION
    ahead = program_ahead(tmp_path / "scripts")
    law("earlier schema", path, SMALL, injected=1, before=state.finished, also=state, program=ahead)
    assert version(path) == NEXT
    after = designs(path)
    assert {circuit: after[circuit] for circuit in before} == before


@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.slow)])
def test_upgrade_that_is_killed_leaves_the_old_or_the_new(tmp_path, reference, law, kills):
    state, source = reference(MANY).state, reference(MANY).path
    ahead = program_ahead(tmp_path / "scripts")
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
        assert version(path) in (SCHEMA_REVISION, NEXT)
        left = look(path)
        assert left.finished == state.finished
        assert left.rows == state.rows
    law("SIGKILL in an upgrade", path, MANY, injected=kills, before=state.finished, program=ahead)
    assert version(path) == NEXT
