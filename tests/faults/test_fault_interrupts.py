"""Ctrl-C: one line, exit code 130, and the same command goes on."""

import signal
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

import hcsearch
from hcsearch.system.interrupts import INTERRUPT_MESSAGE
from tests.faults.fault_tools import INTERRUPTED, MANY, MOST, Running, assert_one_line, look, progress, seeded, wait_for


def interrupt(path, job, more, delay=0.0, *, times=1):
    """Start a job and interrupt it, as a terminal does, once it has finished some batches; what was finished then."""
    begun = progress(path)
    with Running(*job.into(path)) as running:
        wait_for(running, path, more, begun)
        time.sleep(delay)
        seen = progress(path)[1]
        for _ in range(times - 1):
            running.signal(signal.SIGINT)
            time.sleep(0.01)
        code, _, err = running.end(signal.SIGINT, whole_group=True)
    state = look(path, rows=False)
    assert len(state.finished) >= seen
    return code, err.removeprefix("\n"), state.finished  # an empty line ends that of a terminal's ^C


def is_over(path):
    """Whether the last run has finished."""
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute("SELECT finished FROM runs ORDER BY id DESC LIMIT 1").fetchone()[0] is not None


@pytest.mark.parametrize("times", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_ctrl_c_in_the_middle_is_one_line_and_goes_on(tmp_path, law, times):
    path = tmp_path / "designs.sqlite"
    code, err, finished = interrupt(path, MANY, 1, times=times)
    assert code == INTERRUPTED
    assert_one_line(err)
    law("SIGINT", path, MANY, injected=1, before=finished)


@pytest.mark.slow
def test_ctrl_c_again_and_again_loses_nothing(tmp_path, law):
    path = tmp_path / "designs.sqlite"
    chance = seeded("interrupts")
    finished = frozenset()
    injected = 0
    for _ in range(8):
        more, delay = chance.choice([0, 1, 3]), chance.uniform(0, 0.02)
        code, err, now = interrupt(path, MOST, more, delay, times=injected % 2 + 1)
        assert now >= finished
        if code == -signal.SIGINT:  # it came while Python ended, after all was done, and had taken its handler away
            assert (err, is_over(path)) == ("", True)
            continue
        assert code in (0, INTERRUPTED)
        if code:
            assert_one_line(err)
        injected += code != 0
        finished = now
    law("SIGINT", path, MOST, injected=injected, before=finished)


STARTING = 0.3  # seconds: about as long as it takes to load the command line on an idle machine


@pytest.mark.parametrize("times", [12, pytest.param(100, marks=pytest.mark.slow)])
def test_ctrl_c_at_the_start_is_no_traceback(tmp_path, tally, times):
    """What Python does before it comes to the first line of this program is its own."""
    path = tmp_path / "designs.sqlite"
    chance = seeded(f"{times} interrupts at the start")
    for _ in range(times):
        with Running("query", "--db", path, anew=True) as running:
            time.sleep(chance.uniform(0, STARTING))
            code, out, err = running.end(signal.SIGINT)
        assert out == ""
        if code == INTERRUPTED:
            assert err.removeprefix("\n") in ("", f"{INTERRUPT_MESSAGE}\n")
        elif code == 2:
            assert "there is no hcsearch database" in err
        else:
            assert code in (1, -signal.SIGINT), err
            # no frame of this package; its path alone may stand there, as a key of Python's search for modules
            assert f'File "{Path(hcsearch.__file__).parent}' not in err
        tally("SIGINT", 1, 0, 0)
