"""Fixtures of the fault tests."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from tests.commands import without_progress
from tests.faults.fault_tools import PROGRAM, State, batches, look, run
from tests.faults.summary import PROPERTY

NOTHING = State()


@dataclass(frozen=True)
class Reference:
    """What an undisturbed run into a fresh database left: its file, its state, and its summary."""

    path: Path
    state: State
    text: str


@pytest.fixture(scope="session")
def reference(tmp_path_factory):
    @cache
    def made(job):
        path = tmp_path_factory.mktemp("reference") / "designs.sqlite"
        done = run(*job.into(path))
        assert (done.returncode, without_progress(done.stderr)) == (0, "")
        return Reference(path, look(path), done.stdout)

    return made


@pytest.fixture
def tally(record_property):
    """Count faults of a kind for the table: how many, finished batches at the fault, rows lost."""

    def add(kind, injected, finished, lost):
        record_property(PROPERTY, [kind, injected, finished, lost])

    return add


@pytest.fixture
def law(reference, tally):
    """Check the law after faults of one kind, by the same commands again, and count for the table."""

    def check(kind, path, *jobs, injected, before, also=NOTHING, program=PROGRAM):
        """`before`: finished batches at the fault; `also`: what was there besides these jobs."""
        at_fault = look(path, rows=False)
        assert at_fault.finished >= before, f"lost: {before - at_fault.finished}"
        expected = sum((reference(job).state for job in jobs), also)
        for job in jobs:
            done = run(*job.into(path), program=program)
            assert (done.returncode, without_progress(done.stderr)) == (0, "")
            mine = reference(job).state.finished
            n_done, n_taken = batches(done.stdout)
            assert n_done + n_taken == len(mine)
            assert n_taken >= len(mine & at_fault.finished)
        after = look(path)
        lost = (expected.rows - after.rows).total() + len(before - after.finished)
        tally(kind, injected, len(at_fault.finished), lost)
        assert lost == 0
        assert after.finished == expected.finished
        assert after.rows == expected.rows

    return check
