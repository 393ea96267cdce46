"""Damaged database files: refused in one line with nothing changed, or, where the damage is out of sight, right."""

import signal
import sqlite3
from contextlib import closing

import pytest

from tests.faults.fault_tools import (
    MANY,
    Running,
    assert_refused,
    batches,
    copy,
    digest,
    funnel,
    leaf,
    look,
    seeded,
    wait_for,
)

SECTOR = 512


def mostly_slow(first, *others):
    """One case for every day, and more of the same."""
    return [first, *(pytest.param(other, marks=pytest.mark.slow) for other in others)]


@pytest.fixture(scope="session")
def crashed(tmp_path_factory):
    """A database whose writer was killed after some batches, which are all still in its log; with its state."""
    path = tmp_path_factory.mktemp("crashed") / "designs.sqlite"
    with Running(*MANY.into(path)) as running:
        wait_for(running, path, 2)
        running.end(signal.SIGKILL)
    return path, look(path, rows=False)


@pytest.fixture(scope="session")
def settled(tmp_path_factory, crashed):
    """The same with the log moved into the file."""
    path = copy(crashed[0], tmp_path_factory.mktemp("settled") / "designs.sqlite")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return path, crashed[1]


def overwrite(path, at, content):
    with path.open("r+b") as file:
        file.seek(at)
        file.write(content)


def query_and_enumerate(path):
    """Both commands on a damaged file: (exit code, stdout, stderr) of each."""
    words = ("query", "--db", path, "-c", "circuit,array,min_twist", "--format", "csv")
    with Running(*words) as asking:
        asked = asking.end()
    with Running(*MANY.into(path)) as writing:
        return asked, writing.end()


def assert_both_refused(path):
    before = digest(path)
    for code, out, err in query_and_enumerate(path):
        assert_refused(code, err)
        assert out == ""
    assert digest(path) == before


BEGINNINGS = {
    "magic": lambda chance: (0, chance.randbytes(16)),
    "header": lambda chance: (0, chance.randbytes(100)),
    "schema": lambda chance: (100, chance.randbytes(3996)),
    "zeros": lambda chance: (0, bytes(1 << 16)),
}


@pytest.mark.parametrize("where", mostly_slow(*BEGINNINGS))
def test_destroyed_beginning_is_refused_with_nothing_changed(tmp_path, settled, tally, where):
    path = copy(settled[0], tmp_path / "designs.sqlite")
    overwrite(path, *BEGINNINGS[where](seeded(where)))
    assert_both_refused(path)
    tally("damaged file", 1, len(settled[1].finished), 0)


@pytest.mark.parametrize("part", mostly_slow(0.3, 0.0001, 0.999))
def test_truncated_file_is_refused_with_nothing_changed(tmp_path, settled, tally, part):
    path = copy(settled[0], tmp_path / "designs.sqlite")
    with path.open("r+b") as file:
        file.truncate(int(part * path.stat().st_size))
    assert_both_refused(path)
    tally("damaged file", 1, len(settled[1].finished), 0)


def assert_refused_or_right(path, state, reference):
    """Never a traceback, never a batch taken that was not finished, never a wrong count of circuits."""
    (code, _, err), (written, out, complaint) = query_and_enumerate(path)
    if code:
        assert_refused(code, err)
    if written:
        assert_refused(written, complaint)
        return
    assert complaint == ""
    n_done, n_taken = batches(out)
    assert n_taken <= len(state.finished)
    assert n_done + n_taken == len(reference(MANY).state.finished)
    counted = funnel(out)
    whole = funnel(reference(MANY).text)
    for label in ("fixed circuits", "non-isomorphic circuits", "two-stack", "untwisted"):
        assert counted[label] == whole[label]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_scrambled_sectors_are_refused_or_do_no_harm(tmp_path, settled, reference, tally, seed):
    path = copy(settled[0], tmp_path / "designs.sqlite")
    chance = seeded(f"sectors {seed}")
    for _ in range(chance.choice([1, 3, 10])):
        at = chance.randrange(8, path.stat().st_size // SECTOR) * SECTOR
        overwrite(path, at, chance.choice([bytes(SECTOR), chance.randbytes(SECTOR)]))
    assert_refused_or_right(path, settled[1], reference)
    tally("damaged file", 1, len(settled[1].finished), 0)


@pytest.mark.slow
@pytest.mark.parametrize("table", ["batch", "run", "hcsearch_version"])
def test_scrambled_records_of_the_work_done_are_refused_or_do_no_harm(tmp_path, settled, reference, tally, table):
    path = copy(settled[0], tmp_path / "designs.sqlite")
    at, size = leaf(path, table)
    overwrite(path, at + size // 2, seeded(table).randbytes(size // 2))
    assert_refused_or_right(path, settled[1], reference)
    tally("damaged file", 1, len(settled[1].finished), 0)


@pytest.mark.slow
@pytest.mark.parametrize("lost", [SECTOR, 4 * SECTOR])
def test_lost_entries_of_an_index_are_refused_or_do_no_harm(tmp_path, settled, reference, tally, lost):
    """Sectors of zeros can read as entries of nothing, and a count by that index misses what they stood for."""
    path = copy(settled[0], tmp_path / "designs.sqlite")
    at, size = leaf(path, "ix_design_grid_n")
    overwrite(path, at + size - lost, bytes(lost))
    code, out, err = query_and_enumerate(path)[1]
    if code:
        assert_refused(code, err)
    else:
        assert funnel(out) == funnel(reference(MANY).text)
    tally("damaged file", 1, len(settled[1].finished), 0)


@pytest.mark.parametrize("seed", mostly_slow(*range(8)))
def test_damaged_log_is_read_up_to_the_damage(tmp_path, crashed, reference, tally, seed):
    """What stands in a log behind damage is gone, as SQLite has it; so it must be worked out again."""
    path = copy(crashed[0], tmp_path / "designs.sqlite")
    log = path.with_name(f"{path.name}-wal")
    chance = seeded(f"log {seed}")
    at = 0 if seed == 1 else chance.randrange(log.stat().st_size)
    overwrite(log, at, chance.randbytes(chance.choice([1, SECTOR, 1 << 14])))
    left = look(path, rows=False).finished
    assert left <= crashed[1].finished
    (code, _, err), (written, out, complaint) = query_and_enumerate(path)
    assert (written, complaint) == (0, "")
    if code:
        assert_refused(code, err)  # nothing is left, not even the tables
    n_done, n_taken = batches(out)
    expected = reference(MANY).state
    assert (n_taken, n_done) == (len(left), len(expected.finished) - len(left))
    assert look(path).rows == expected.rows
    tally("damaged log", 1, len(left), 0)
