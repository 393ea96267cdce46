"""SIGKILL at moments drawn by chance: at the start, between and within batches, at the end."""

import os
import signal
import time
from contextlib import suppress

import pytest

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import open_readonly, select_sql
from tests.faults.fault_tools import (
    DEPLOYED,
    INTERRUPTED,
    LONG,
    MANY,
    MOST,
    Running,
    assert_refused,
    look,
    members,
    progress,
    seeded,
    wait_for,
)

START = 0.4  # seconds: loading takes about as long, then a new file is made
WRITING = 0.008  # seconds: a batch takes about as long
END = 0.05  # seconds: a run with nothing to do takes about as long after it has begun


def kill_once(job, path, chance, batches_left, kills_left):
    """Start the job and kill it somewhere: whether it was alive until then, and the finished batches seen before."""
    begun = progress(path)
    at_start = chance.random() < 0.2
    # As many batches as bring the job near its end with the last kills.
    more = round(chance.uniform(0, 2.2 * batches_left / kills_left))
    with Running(*job.into(path)) as running:
        if at_start:
            time.sleep(chance.uniform(0, START))
        else:
            wait_for(running, path, min(more, batches_left), begun)
            time.sleep(chance.uniform(0, WRITING if batches_left else END))
        seen = progress(path)[1]
        code, _, err = running.end(signal.SIGKILL)
        assert code in (0, -signal.SIGKILL)
        assert err == ""
        return code != 0, seen


def count_as_a_user(path):
    """Designs that a query counts; 0 while there is no database yet."""
    with suppress(DatabaseError), open_readonly(str(path)) as database:
        return select_sql(database, "SELECT count(*) FROM designs").rows[0][0]
    with pytest.raises(DatabaseError, match="make one with `hcsearch enumerate`"):
        open_readonly(str(path))
    return 0


def kill_and_finish(job, path, reference, law, kills):
    chance = seeded(f"{kills} kills")
    all_batches = len(reference(job).state.finished)
    killed = 0
    finished = frozenset()
    while killed < kills:
        alive, seen = kill_once(job, path, chance, all_batches - len(finished), kills - killed)
        state = look(path, rows=False)
        assert state.finished >= finished
        assert len(state.finished) >= seen
        assert count_as_a_user(path) == state.designs
        killed += alive
        finished = state.finished
    law("SIGKILL", path, job, injected=killed, before=finished)


def test_five_kills_lose_no_finished_batch(tmp_path, reference, law):
    kill_and_finish(MANY, tmp_path / "designs.sqlite", reference, law, 5)


@pytest.mark.slow
def test_twenty_five_kills_of_one_run_lose_no_finished_batch(tmp_path, reference, law):
    kill_and_finish(MOST, tmp_path / "designs.sqlite", reference, law, 25)


@pytest.mark.slow
def test_kills_lose_no_finished_deployment(tmp_path, reference, law):
    kill_and_finish(DEPLOYED, tmp_path / "designs.sqlite", reference, law, 3)


def start_workers(running, path):
    """Wait until the work is shared and some of it is finished; the workers."""
    wait_for(running, path, 1)
    workers = [process for process in members(running.group) if process != running.group]
    assert len(workers) >= 2
    return workers


@pytest.mark.parametrize(
    "number",
    [signal.SIGKILL, *(pytest.param(number, marks=pytest.mark.slow) for number in (signal.SIGTERM, signal.SIGINT))],
)
def test_no_worker_outlives_its_command(tmp_path, tally, number):
    path = tmp_path / "designs.sqlite"
    with Running(*LONG.into(path)) as running:
        start_workers(running, path)
        seen = progress(path)[1]
        code, _, err = running.end(number)
    assert code == (INTERRUPTED if number == signal.SIGINT else -number)
    assert "Traceback" not in err
    finished = look(path, rows=False).finished
    assert len(finished) >= seen
    tally(number.name, 1, len(finished), 0)


@pytest.mark.slow
def test_worker_that_is_killed_ends_the_command_in_one_line(tmp_path, tally):
    path = tmp_path / "designs.sqlite"
    with Running(*LONG.into(path)) as running:
        worker = max(start_workers(running, path))
        seen = progress(path)[1]
        os.kill(worker, signal.SIGKILL)
        code, _, err = running.end()
    assert_refused(code, err.splitlines(keepends=True)[-1])  # an estimate of the time may stand before it
    assert "Traceback" not in err
    finished = look(path, rows=False).finished
    assert len(finished) >= seen
    tally("SIGKILL of a worker", 1, len(finished), 0)
