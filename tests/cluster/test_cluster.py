"""The same work on a Dask cluster: the same rows with the same ids, whoever dies meanwhile."""

import os
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from shutil import ignore_patterns

import pytest

import hcsearch
from hcsearch.basics.errors import ClusterError
from hcsearch.search.pipeline import WorkerPool
from hcsearch.store import open_readonly, select_sql
from tests.cluster.conftest import until
from tests.commands import without_progress
from tests.postgresql import PASSWORD, running_server

pytestmark = pytest.mark.extra

DESIGNS = "SELECT * FROM designs ORDER BY id"
FOLDINGS = "SELECT * FROM foldings ORDER BY design_id, crease"


def start(folder, *words):
    command = [sys.executable, "-m", "hcsearch", "enumerate", "--grid", "rectangle", "--until", "mobility", *words]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def run(folder, *words):
    """Output of a run that succeeds and says nothing else."""
    process = start(folder, *words)
    output, errors = process.communicate(timeout=300)
    assert (process.returncode, without_progress(errors)) == (0, "")
    return output


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """What one process on its own finds."""
    folder = tmp_path_factory.mktemp("alone")
    run(folder, "--n", "20", "--jobs", "1", "--db", "alone.sqlite")
    return content(folder / "alone.sqlite")


def content(location):
    with open_readonly(str(location)) as database:
        return select_sql(database, DESIGNS).rows, select_sql(database, FOLDINGS).rows


def batches(path):
    """Batches of a database file that are finished by now."""
    if not path.exists():
        return 0
    link = sqlite3.connect(path)
    try:
        return link.execute("SELECT count(DISTINCT prefix) FROM batch").fetchone()[0]
    except sqlite3.OperationalError:
        return 0
    finally:
        link.close()


def test_a_worker_killed_in_the_middle_changes_nothing(tmp_path, cluster, alone):
    process = start(tmp_path, "--n", "20", "--scheduler", cluster.address, "--db", "cluster.sqlite")
    until(lambda: batches(tmp_path / "cluster.sqlite") >= 2)
    victim = until(cluster.working)[0]
    os.kill(victim, signal.SIGKILL)
    assert batches(tmp_path / "cluster.sqlite") < 12, "the run was over before the worker died"
    _, errors = process.communicate(timeout=300)
    assert (process.returncode, without_progress(errors)) == (0, "")
    assert content(tmp_path / "cluster.sqlite") == alone
    assert "12 taken from before" in run(tmp_path, "--n", "20", "--jobs", "1", "--db", "cluster.sqlite")


def test_a_lost_scheduler_is_one_line_and_finished_batches_stay(tmp_path, cluster, alone):
    process = start(tmp_path, "--n", "20", "--scheduler", cluster.address, "--db", "d.sqlite")
    finished = until(lambda: batches(tmp_path / "d.sqlite"))
    os.killpg(cluster.scheduler.pid, signal.SIGKILL)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 2
    line = without_progress(errors)
    assert line.count("\n") == 1
    assert "finished batches are kept" in line
    kept = batches(tmp_path / "d.sqlite")
    assert finished <= kept < 12
    assert f"{kept} taken from before" in run(tmp_path, "--n", "20", "--jobs", "1", "--db", "d.sqlite")
    assert content(tmp_path / "d.sqlite") == alone


def test_results_that_are_ready_when_the_scheduler_dies_are_not_waited_for(cluster):
    work = WorkerPool(scheduler=cluster.address).map_ordered(int, [str(item) for item in range(8)])
    assert next(work) == ("0", 0)
    os.killpg(cluster.scheduler.pid, signal.SIGKILL)
    with pytest.raises(ClusterError, match="lost its scheduler"):
        list(work)


def test_sqlite_postgresql_and_a_cluster_into_postgresql_hold_the_same(tmp_path, cluster, alone):
    with running_server() as server:
        name = server.create_database()
        own, shared = server.url(server.create_database()), server.url(name)
        process = start(tmp_path, "--n", "20", "--scheduler", cluster.address, "--db", shared)
        has_begun = "SELECT 1 FROM pg_tables WHERE tablename = 'batch'"
        until(lambda: server.run(has_begun, name) and server.run("SELECT 1 FROM batch LIMIT 1", name))
        os.kill(cluster.working()[0], signal.SIGKILL)
        _, errors = process.communicate(timeout=300)
        assert (process.returncode, without_progress(errors)) == (0, "")
        assert PASSWORD not in run(tmp_path, "--n", "20", "--jobs", "1", "--db", own)
        assert len(alone[0]) == 20_769
        assert content(own) == alone
        assert content(shared) == alone


def test_counting_on_a_cluster(tmp_path, cluster):
    words = ["count", "--grid", "hex", "--n", "18", "--keep", "untwisted", "--scheduler", cluster.address]
    command = [sys.executable, "-m", "hcsearch", *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert without_progress(done.stderr) == ""
    assert "up to symmetry     218086" in done.stdout


@pytest.mark.parametrize(
    ("address", "remedy"),
    [("tcp://127.0.0.1:9", "start one with `dask scheduler`"), ("nowhere", "write it as tcp://HOST:8786")],
)
def test_no_scheduler_is_one_line_and_no_database(tmp_path, address, remedy):
    process = start(tmp_path, "--n", "6", "--scheduler", address, "--db", "d.sqlite")
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 2
    assert without_progress(errors).count("\n") == 1
    assert remedy in errors
    assert not (tmp_path / "d.sqlite").exists()


def test_a_scheduler_without_workers_is_one_line(tmp_path, lonely):
    process = start(tmp_path, "--n", "6", "--scheduler", lonely.address, "--db", "d.sqlite")
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 2
    assert without_progress(errors).count("\n") == 1
    assert f"start some with `dask worker {lonely.address}`" in errors


def test_workers_of_another_version_are_refused(tmp_path, cluster, monkeypatch):
    until(cluster.working)
    monkeypatch.setattr("hcsearch.search.pipeline.workers._VERSION", "0.0.0")
    with pytest.raises(ClusterError, match=r"install 0\.0\.0 there"):
        WorkerPool(scheduler=cluster.address).check_cluster()


def test_the_address_of_a_worker_is_one_line_within_seconds(tmp_path, cluster):
    from distributed import Client

    until(cluster.working)
    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=60)
        worker = next(iter(client.scheduler_info()["workers"]))
    begin = time.monotonic()
    process = start(tmp_path, "--n", "6", "--scheduler", worker, "--db", "d.sqlite")
    _, errors = process.communicate(timeout=60)
    assert time.monotonic() - begin < 15
    assert process.returncode == 2
    assert without_progress(errors).count("\n") == 1
    assert f"no Dask scheduler answers at {worker}" in errors


def test_a_stranger_at_the_address_is_one_line_within_seconds(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:  # who takes calls and says nothing
        begin = time.monotonic()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        process = start(tmp_path, "--n", "6", "--scheduler", address, "--db", "d.sqlite")
        _, errors = process.communicate(timeout=60)
    assert time.monotonic() - begin < 15
    assert (process.returncode, without_progress(errors).count("\n")) == (2, 1)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def stranger(tmp_path):
    """The sources of hcsearch with a change that nothing but a look into them shows, to run a worker on."""
    shutil.copytree(
        Path(hcsearch.__file__).parent, tmp_path / "other" / "hcsearch", ignore=ignore_patterns("__pycache__")
    )
    with (tmp_path / "other" / "hcsearch" / "designs" / "twisting.py").open("a", encoding="utf-8") as file:
        file.write("\n# another commit\n")
    return {"PYTHONPATH": str(tmp_path / "other")}


def test_a_worker_of_other_sources_is_refused_before_a_run(tmp_path, lonely, stranger):
    lonely.start_workers(1, **stranger)
    process = start(tmp_path, "--n", "6", "--scheduler", lonely.address, "--db", "d.sqlite")
    _, errors = process.communicate(timeout=120)
    assert (process.returncode, without_progress(errors).count("\n")) == (2, 1)
    assert f"has other sources of hcsearch {hcsearch.__version__}: install there what runs here" in errors
    assert not (tmp_path / "d.sqlite").exists()


def test_a_worker_of_other_sources_that_joins_gives_no_results(lonely, stranger):
    from distributed import Client

    lonely.start_workers(1)
    work = WorkerPool(scheduler=lonely.address).map_ordered(int, [str(item) for item in range(40)])
    assert next(work) == ("0", 0)
    lonely.start_workers(1, **stranger)
    with Client(lonely.address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
    os.killpg(lonely.worker.pid, signal.SIGKILL)
    with pytest.raises(ClusterError, match=r"has other sources of hcsearch .*: stop it"):
        list(work)
