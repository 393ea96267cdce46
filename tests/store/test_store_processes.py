"""Several processes on one file; each begins its work when all are ready."""

import multiprocessing
import os
import signal

import pytest
from store_samples import RESULTS, VERSIONS, WORK, begin, circuits, contents, record, sample

from hcsearch.store import design_rows, finished_batches, open_database, record_batches, select, select_sql
from hcsearch.store.database import open_readonly

PROCESSES = 2
context = multiprocessing.get_context("spawn")  # as for a user: nothing shared but the file


def create(path, ready, number):
    ready.wait(30)
    with open_database(path, create=True) as database:
        begin(database)


def record_own(path, ready, number):
    with open_database(path, create=True) as database:
        run = begin(database)
        ready.wait(30)
        for k in range(20):
            batch = sample(circuits(1 + 10 * (2 * k + number), 10))
            record_batches(database, run, WORK, [(f"{number}.{k}", batch, RESULTS)])


def record_same(path, ready, number):
    with open_database(path, create=True) as database:
        run = begin(database)
        ready.wait(30)
        for k in range(20):
            record_batches(database, run, WORK, [(str(k), sample(circuits(1 + 9 * k, 9)), RESULTS)])


def record_and_hang(path, ready, number):
    with open_database(path, create=True) as database:
        record(database, circuits(1, 30))
        with database.writing() as connection:
            design_rows.insert_designs(connection, database.location, sample(circuits(31, 3000)))
            ready.wait(30)
            signal.pause()


def run_together(target, path, processes=PROCESSES):
    ready = context.Barrier(processes)
    workers = [context.Process(target=target, args=(str(path), ready, k)) for k in range(processes)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert [worker.exitcode for worker in workers] == [0] * processes


@pytest.mark.parametrize("attempt", range(2))
def test_creating_the_same_file(path, attempt):
    run_together(create, path, 3)
    with open_readonly(str(path)) as database:
        assert len(select(database, view="runs").rows) == 3


def test_recording_different_batches(path):
    run_together(record_own, path)
    with open_readonly(str(path)) as database:
        rows = contents(database)
        assert len(rows) == len({row["circuit"] for row in rows}) == 10 * 20 * PROCESSES
        assert len(finished_batches(database, WORK, VERSIONS)) == 20 * PROCESSES
        assert all(len(row["foldings"]) == row["n_foldings"] for row in rows)


def test_recording_the_same_batches(path, tmp_path):
    run_together(record_same, path)
    with open_database(str(tmp_path / "alone.sqlite"), create=True) as alone, open_readonly(str(path)) as database:
        for k in range(20):
            record(alone, circuits(1 + 9 * k, 9), prefix=str(k))
        assert contents(database) == contents(alone)
        assert finished_batches(database, WORK, VERSIONS) == finished_batches(alone, WORK, VERSIONS)


def test_killed_writer_loses_only_the_batch_at_hand(path):
    ready = context.Barrier(2)
    worker = context.Process(target=record_and_hang, args=(str(path), ready, 0))
    worker.start()
    ready.wait(30)
    os.kill(worker.pid, signal.SIGKILL)
    worker.join(30)
    with open_readonly(str(path)) as database:
        assert len(select(database).rows) == 30
        assert select_sql(database, "SELECT count(*) FROM folding").rows == ((40,),)
    with open_database(str(path), create=False) as database:
        record(database, circuits(31, 30), prefix="q")
        assert len(select(database).rows) == 60
        with database.reading() as connection:
            assert connection.exec_driver_sql("PRAGMA integrity_check").scalar() == "ok"
