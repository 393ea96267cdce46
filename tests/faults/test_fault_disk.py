"""A full disk, small and smaller: each failure is one line, and with more room the same command goes on."""

import subprocess
from pathlib import Path

import pytest

from tests.faults.fault_tools import MANY, MOST, PATIENCE, SMALL, assert_refused, command, look, run
from tests.faults.small_disk import limited, small_disk

FULL = Path("/dev/full")


def fill(path, lines):
    """Run command lines that each run out of room: the batches finished at last, and how many after each."""
    finished, growth = frozenset(), []
    for line in lines:
        done = subprocess.run(line, capture_output=True, text=True, timeout=PATIENCE, check=False)
        assert_refused(done.returncode, done.stderr)
        state = look(path, rows=False)
        assert state.finished >= finished
        finished = state.finished
        growth.append(len(finished))
    query = run("query", "--db", path, "--sql", "SELECT count(*) AS n FROM designs", "--format", "csv")
    assert (query.returncode, query.stdout, query.stderr) == (0, f"n\n{state.designs}\n", "")
    return finished, growth


# Before there are tables; within the first batch; after some; while the log is moved into the file.
LIMITS = {MANY: (20_000, 1_000_000, 4_500_000), MOST: (20_000, 500_000, 2_500_000, 6_000_000)}


@pytest.mark.parametrize("job", [MANY, pytest.param(MOST, marks=pytest.mark.slow)])
def test_full_disk_ends_in_one_line_and_room_lets_it_go_on(tmp_path, law, job):
    path = tmp_path / "designs.sqlite"
    lines = [limited(command(*job.into(path)), size) for size in LIMITS[job]]
    finished, growth = fill(path, lines)
    assert growth[0] == growth[1] == 0 < growth[-1]
    law("full disk", path, job, injected=len(lines), before=finished)


@pytest.mark.slow
def test_full_file_system_ends_in_one_line_and_room_lets_it_go_on(tmp_path, law):
    folder = tmp_path / "disk"
    folder.mkdir()
    path = folder / "designs.sqlite"
    line = command(*MOST.into(path))
    sizes = [2**k for k in range(14, 24, 2)]
    with small_disk(folder) as resize:
        finished, _ = fill(path, (resize(size, line) for size in sizes))
        resize(2**28, line)
        law("full disk", path, MOST, injected=len(sizes), before=finished)


@pytest.mark.parametrize("words", [["--format", "csv"], pytest.param(["--limit", "1"], marks=pytest.mark.slow)])
def test_query_into_a_full_device_is_one_line(reference, tally, words):
    path = reference(MANY).path
    with FULL.open("w") as full:
        done = run("query", "--db", path, *words, stdout=full)
    assert_refused(done.returncode, done.stderr)
    assert "make room" in done.stderr
    tally("full disk", 1, 0, 0)


@pytest.mark.slow
def test_summary_into_a_full_device_leaves_the_run_finished(tmp_path, law):
    path = tmp_path / "designs.sqlite"
    with FULL.open("w") as full:
        done = run(*SMALL.into(path), stdout=full)
    assert_refused(done.returncode, done.stderr)
    finished = look(path, rows=False).finished
    assert finished
    law("full disk", path, SMALL, injected=1, before=finished)
