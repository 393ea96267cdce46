"""Several processes on one database; each begins its work when all are ready."""

import multiprocessing
import os
import signal

import pytest
from store_samples import RESULTS, VERSIONS, WORK, begin, circuits, contents, record, sample

from hcsearch.store import design_rows, finished_batches, open_database, record_batches, select, select_sql
from hcsearch.store.database import open_readonly

PROCESSES = 2
context = multiprocessing.get_context("spawn")  # as for a user: nothing shared but the database


def create(place, ready, number):
    ready.wait(30)
    with open_database(place, create=True) as database:
        begin(database)


def record_own(place, ready, number):
    with open_database(place, create=True) as database:
        run = begin(database)
        ready.wait(30)
        for k in range(20):
            batch = sample(circuits(1 + 10 * (2 * k + number), 10))
            record_batches(database, run, WORK, [(f"{number}.{k}", batch, RESULTS)])


def record_same(place, ready, number):
    with open_database(place, create=True) as database:
        run = begin(database)
        ready.wait(30)
        for k in range(20):
            record_batches(database, run, WORK, [(str(k), sample(circuits(1 + 9 * k, 9)), RESULTS)])


def record_and_hang(place, ready, number):
    with open_database(place, create=True) as database:
        record(database, circuits(1, 30))
        with database.writing() as connection:
            design_rows.insert_designs(connection, database.location, sample(circuits(31, 3000)))
            ready.wait(30)
            signal.pause()


def run_together(target, place, processes=PROCESSES):
    ready = context.Barrier(processes)
    workers = [context.Process(target=target, args=(place, ready, k)) for k in range(processes)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(60)
    assert [worker.exitcode for worker in workers] == [0] * processes


@pytest.mark.parametrize("attempt", range(2))
def test_creating_the_same_database(place, attempt):
    run_together(create, place, 3)
    with open_readonly(place) as database:
        assert select(database, view="runs", columns="id").rows == ((1,), (2,), (3,))


def test_recording_different_batches(place):
    run_together(record_own, place)
    with open_readonly(place) as database:
        rows = contents(database)
        assert len(rows) == len({row["circuit"] for row in rows}) == 10 * 20 * PROCESSES
        assert [row[0] for row in select(database, columns="id").rows] == list(range(1, len(rows) + 1))
        assert len(finished_batches(database, WORK, VERSIONS)) == 20 * PROCESSES
        assert all(len(row["foldings"]) == row["n_foldings"] for row in rows)


def test_recording_the_same_batches(place, tmp_path):
    run_together(record_same, place)
    with open_database(str(tmp_path / "alone.sqlite"), create=True) as alone, open_readonly(place) as database:
        for k in range(20):
            record(alone, circuits(1 + 9 * k, 9), prefix=str(k))
        assert contents(database) == contents(alone)
        assert finished_batches(database, WORK, VERSIONS) == finished_batches(alone, WORK, VERSIONS)


def test_killed_writer_loses_only_the_batch_at_hand(place):
    ready = context.Barrier(2)
    worker = context.Process(target=record_and_hang, args=(place, ready, 0))
    worker.start()
    ready.wait(30)
    os.kill(worker.pid, signal.SIGKILL)
    worker.join(30)
    with open_readonly(place) as database:
        assert len(select(database).rows) == 30
        assert select_sql(database, "SELECT count(*) FROM folding").rows == ((40,),)
    with open_database(place, create=False) as database:
        record(database, circuits(31, 30), prefix="q")
        assert len(select(database).rows) == 60
        if database.path is not None:
            with database.reading() as connection:
                assert connection.exec_driver_sql("PRAGMA integrity_check").scalar() == "ok"
