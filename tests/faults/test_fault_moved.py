"""A database that is removed, renamed or replaced while it is written to: one line, never an end that looks good."""

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import DatabaseError
from hcsearch.cli import hcsearch
from hcsearch.designs.records import WorkKey
from hcsearch.store import open_database, open_readonly, select, start_run
from tests.faults.fault_tools import LONG, MANY, Running, assert_one_line, assert_refused, wait_for


def replace(path):
    """Put another database under the name; it comes with a name of its own."""
    other = path.with_name("other.sqlite")
    open_database(str(other), create=True).close()
    other.rename(path)


FAULTS = {
    "removed": Path.unlink,
    "renamed": lambda path: path.rename(path.with_name("elsewhere.sqlite")),
    "folder removed": lambda path: shutil.rmtree(path.parent),
    "replaced": replace,
    "replaced by nothing": lambda path: (path.unlink(), path.touch()),
}


@pytest.fixture
def path(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    return folder / "designs.sqlite"


def begin(database):
    return start_run(database, work=WorkKey("hex", 6, "", "all"), until="twist", panel=None, arguments={}, versions={})


@pytest.mark.parametrize("fault", FAULTS)
def test_no_transaction_ends_well_without_its_file(path, fault):
    with open_database(str(path), create=True) as database:
        begin(database)
        FAULTS[fault](path)
        for attempt in (begin, lambda database: select(database, view="runs")):
            with pytest.raises(DatabaseError, match="removed, renamed or replaced") as caught:
                attempt(database)
            assert_one_line(f"hcsearch: {caught.value}\n")


def test_a_file_that_goes_within_a_transaction_is_noticed_at_its_end(path):
    def write(database):
        with database.writing():
            path.unlink()

    with (
        open_database(str(path), create=True) as database,
        pytest.raises(DatabaseError, match="removed, renamed or replaced"),
    ):
        write(database)


def test_a_renamed_file_that_is_put_back_has_lost_nothing(path):
    elsewhere = path.with_name("elsewhere.sqlite")
    with open_database(str(path), create=True) as database:
        begin(database)
        path.rename(elsewhere)
        with pytest.raises(DatabaseError, match="put it back with its -wal file"):
            begin(database)
    elsewhere.rename(path)
    with open_readonly(str(path)) as reader:
        assert len(select(reader, view="runs").rows) == 1


def end_after(fault, path):
    """Start a long run, and do this to its database once there is something in it."""
    with Running(*LONG.into(path)) as running:
        wait_for(running, path, 1)
        FAULTS[fault](path)
        left = path.read_bytes() if path.exists() else None
        code, out, err = running.end()
    line = err.splitlines(keepends=True)[-1]  # an estimate of the time stands before it
    assert_refused(code, line)
    assert "removed, renamed or replaced" in line
    assert [said.partition(" ")[0] for said in out.splitlines()] == ["searching"]
    assert (path.read_bytes() if path.exists() else None) == left


def test_a_run_whose_database_goes_ends_in_one_line(path, tally, monkeypatch):
    def opened(*places, **options):
        database = open_database(*places, **options)
        path.unlink()
        return database

    monkeypatch.setattr("hcsearch.store.open_database", opened)
    words = ["enumerate", "--grid", "hex", "--n", "6", "--until", "circuits", "--db", str(path)]
    done = CliRunner().invoke(hcsearch, words)
    assert isinstance(done.exception, DatabaseError)
    assert "removed, renamed or replaced" in str(done.exception)
    assert done.output == ""
    tally("database removed", 1, 0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("fault", list(FAULTS))
def test_a_run_after_such_a_fault_starts_anew(path, law, fault):
    end_after(fault, path)
    path.parent.mkdir(exist_ok=True)
    path.unlink(missing_ok=True)
    law(f"database {fault}", path, MANY, injected=1, before=frozenset())
