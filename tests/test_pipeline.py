"""Who works, in which order results come, and what a run says about itself before it begins."""

import itertools
import multiprocessing
import os
import signal
import threading
import time

import numpy as np
import pytest

from hcsearch.basics.errors import ClusterError, SizeError
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.search.enumeration import ArraySearch, FoldedSearch, PolygonSearch, search_all
from hcsearch.search.enumeration.frontier_counts import expected_circuits
from hcsearch.search.pipeline import (
    Plan,
    WorkerPool,
    check_disk_room,
    count_designs,
    counting_seconds,
    estimate_run,
    run_dry,
)
from hcsearch.search.pipeline.estimate import RunEstimate, duration_text
from hcsearch.search.pipeline.shards import ShardJob
from hcsearch.search.stages.order import stages_until
from tests import golden

HEX = GRIDS["hex"]


def die(item):
    os._exit(9)


def test_results_come_in_order_whoever_works():
    inputs = [str(i) for i in range(200)]
    expected = [(item, int(item)) for item in inputs]
    assert list(WorkerPool().map_ordered(int, inputs)) == expected
    assert list(WorkerPool(2).map_ordered(int, inputs)) == expected
    assert list(WorkerPool().map_ordered(int, inputs, threads=3)) == expected


def test_threads_of_one_process_work_beside_each_other():
    meet = threading.Barrier(3)
    assert [
        answer for _, answer in WorkerPool().map_ordered(lambda _: meet.wait(30) >= 0, ["item"] * 6, threads=3)
    ] == [True] * 6


def test_one_thread_begins_no_task_before_the_last_result_is_taken():
    begun = []
    answers = WorkerPool().map_ordered(begun.append, list("abc"))
    for taken in range(1, 4):
        next(answers)
        assert len(begun) == taken


def test_a_worker_that_dies_is_one_line():
    with pytest.raises(ClusterError, match="fewer --jobs"):
        list(WorkerPool(2).map_ordered(die, ["a", "b"]))


def test_what_a_worker_raises_comes_through():
    with pytest.raises(ValueError, match="invalid literal"):
        list(WorkerPool(2).map_ordered(int, ["1", "two"]))


def answer_at_length(item):
    """More than a pipe holds, so that a worker is in the midst of its answer most of the time."""
    return item * 1_000_000


def test_workers_in_the_midst_of_an_answer_are_ended_all_the_same():
    for taken in range(1, 9):
        answers = WorkerPool(2).map_ordered(answer_at_length, ["x"] * 1000)
        assert len(list(itertools.islice(answers, taken))) == taken
        answers.close()
        assert not multiprocessing.active_children()


def test_an_interrupt_that_wakes_no_wait_ends_it_all_the_same():
    ready = threading.Event()

    def task(_):
        time.sleep(0.5)  # the other thread waits
        # as if it had come just before that wait: it does not wake the thread that runs the handler
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGUSR1])
        signal.pthread_kill(threading.get_ident(), signal.SIGUSR1)
        return ready.wait(30)

    def interrupt(*_):
        raise KeyboardInterrupt

    handler = signal.signal(signal.SIGUSR1, interrupt)
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
    begin = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            next(WorkerPool().map_ordered(task, ["item"]))
        assert time.monotonic() - begin < 10
    finally:
        ready.set()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGUSR1])
        signal.signal(signal.SIGUSR1, handler)


@pytest.mark.parametrize(
    "address", ["", "host", "tcp://host", "http://host:1", "tcp://host:port", "a b:1", "tls://host:1"]
)
def test_an_address_that_cannot_be_one_is_refused(address):
    with pytest.raises(ClusterError, match="tcp://HOST:8786"):
        WorkerPool(scheduler=address)


def test_addresses_of_all_kinds_are_taken():
    for address in ("host:1", "tcp://host.name:8786", "tcp://[::1]:8786", "10.0.0.1:8786"):
        assert WorkerPool(scheduler=address).scheduler == address


def test_an_estimate_leaves_out_what_is_finished(monkeypatch):
    monkeypatch.setattr("hcsearch.search.pipeline.run.SMALL_CIRCUIT_COUNT", 0)
    plan = Plan(PolygonSearch(HEX, 16), "twist")
    shards = plan.search.prefixes
    whole, half = estimate_run(plan, stored=True), estimate_run(plan, stored=True, finished=set(shards[::2]))
    assert half.circuits == pytest.approx(whole.circuits / 2, rel=0.01)
    assert estimate_run(plan, stored=True, finished=set(shards)) is None


def test_processes_find_what_one_process_finds(monkeypatch):
    plans = [
        Plan(search, "twist", keep)
        for search, keep in (
            (PolygonSearch(HEX, 12), "all"),
            (FoldedSearch(HEX, 14, untwisted=True), "untwisted"),
            (ArraySearch(parse_array(GRIDS["square"], "6x6")), "two-stack"),
        )
    ]
    monkeypatch.setattr("hcsearch.search.pipeline.run.SMALL_CIRCUIT_COUNT", 0)
    monkeypatch.setattr("hcsearch.search.enumeration.folded._SHARD_PAIRS", 500)
    for plan in plans:
        alone = run_dry(plan)
        shared = run_dry(Plan(plan.search, plan.until, plan.keep, crew=WorkerPool(2)))
        assert shared.funnel == alone.funnel
        assert shared.batches_done == alone.batches_done


def test_a_job_travels_without_its_tables():
    search = PolygonSearch(HEX, 16)
    assert len(search.prefixes) > 1
    job = ShardJob(search, stages_until("twist"), "all", with_rows=True)
    assert "prefixes" not in job.__getstate__()["search"].__dict__


@pytest.mark.parametrize("keep", ["all", "two-stack", "untwisted"])
@pytest.mark.parametrize(
    ("grid", "n"),
    [
        *(("hex", 12), ("hex", 16), ("square", 18), ("triangle", 26), ("rectangle", 14)),
        *(("rhombus", 20), ("kite", 18), ("right45", 28), ("right30", 30), ("obtuse", 36)),
    ],
)
def test_counting_agrees_with_the_funnel(grid, n, keep):
    search = search_all(GRIDS[grid], n, keep)
    funnel = run_dry(Plan(PolygonSearch(GRIDS[grid], n), "twist", "all")).funnel
    classes = {"all": funnel.circuits, "two-stack": funnel.two_stack, "untwisted": funnel.untwisted}[keep]
    assert count_designs(search, keep, WorkerPool()).classes == classes


def test_a_search_that_lists_only_what_passes_a_later_stage_has_no_numbers_of_those_before():
    search = FoldedSearch(HEX, 14, untwisted=True)
    known = count_designs(search, "untwisted", WorkerPool()).classes
    for until, untwisted in (("circuits", None), ("foldings", None), ("twist", known)):
        funnel = run_dry(Plan(search, until)).funnel
        assert (funnel.fixed_circuits, funnel.circuits, funnel.two_stack) == (None, None, None)
        assert funnel.untwisted == untwisted


def test_counting_on_an_array_lists_what_folds():
    counted = count_designs(ArraySearch(parse_array(HEX, "4-4-4")), "two-stack", WorkerPool())
    assert counted.classes == 2
    assert count_designs(ArraySearch(parse_array(HEX, "4-4-4")), "untwisted", WorkerPool()).classes == 0


def test_few_circuits_are_all_listed():
    assert search_all(HEX, 12, "untwisted").lists == "all"
    assert search_all(HEX, 18, "untwisted").lists == "untwisted"
    assert search_all(HEX, 18, "two-stack").lists == "two-stack"
    assert search_all(HEX, 18).lists == "all"


@pytest.mark.parametrize("grid", ["hex", "square", "triangle"])
def test_expected_numbers_of_circuits_are_good_to_five_per_cent(grid):
    published = {
        "hex": golden.values("A284869") | golden.values("free triangular-lattice SAPs"),
        "square": golden.values("A266549", step=2),
        "triangle": golden.values("A258206 honeycomb", step=2),
    }[grid]
    far = [n for n, count in published.items() if n >= 16 and count]
    errors = [abs(expected_circuits(GRIDS[grid], n) / published[n] - 1) for n in far[-5:]]
    assert max(errors) < 0.05


@pytest.mark.parametrize(
    ("grid", "sizes", "error"),
    [
        ("rhombus", (20, 21, 22), 0.05),
        ("kite", (18, 20, 21), 0.05),
        ("right45", (30, 32, 34), 0.05),
        ("right30", (32, 34, 36), 0.2),
        ("obtuse", (36, 38, 40), 0.2),
    ],
)
def test_expected_numbers_of_circuits_on_further_grids(grid, sizes, error):
    for n in sizes:
        listed = sum(map(len, PolygonSearch(GRIDS[grid], n).batches()))
        assert expected_circuits(GRIDS[grid], n) == pytest.approx(listed, rel=error)


def test_small_runs_are_not_estimated():
    assert estimate_run(Plan(PolygonSearch(HEX, 12), "twist"), stored=True) is None
    assert counting_seconds(FoldedSearch(HEX, 18, untwisted=True)) is None


def test_an_estimate_is_near_what_is_found(monkeypatch):
    monkeypatch.setattr("hcsearch.search.pipeline.run.SMALL_CIRCUIT_COUNT", 0)
    plan = Plan(FoldedSearch(HEX, 20, untwisted=True), "twist", "untwisted")
    expected = estimate_run(plan, stored=True)
    assert expected is not None
    assert expected.designs == pytest.approx(2_328_698, rel=0.5)
    assert expected.circuits == pytest.approx(expected.designs)
    assert expected.core_seconds > 0
    sentence = expected.sentence(WorkerPool(4))
    assert "with --jobs 4" in sentence
    assert "in the database" in sentence
    assert "core time on the cluster" in expected.sentence(WorkerPool(scheduler="tcp://host:8786"))


def test_a_database_that_finds_no_room_is_refused(tmp_path):
    huge = RunEstimate(1e15, 1e15, 1.0, 1e17, 1.0)
    with pytest.raises(SizeError, match="keep fewer with --keep"):
        check_disk_room(huge, str(tmp_path / "d.sqlite"))
    check_disk_room(huge, "postgresql://server/name")
    check_disk_room(RunEstimate(1.0, 1.0, 1.0, 100.0, 1.0), str(tmp_path / "no" / "such" / "d.sqlite"))


@pytest.mark.parametrize(
    ("seconds", "text"), [(12.34, "12 seconds"), (300, "5 minutes"), (9000, "2.5 hours"), (864000, "10 days")]
)
def test_durations_for_people(seconds, text):
    assert duration_text(seconds) == text


def test_units_hold_every_design_once(monkeypatch):
    monkeypatch.setattr("hcsearch.search.enumeration.folded._SHARD_PAIRS", 2000)
    search = FoldedSearch(HEX, 16, untwisted=True)
    words = np.concatenate([batch.words for prefix in search.prefixes for batch in search.circuits(prefix)])
    assert len(np.unique(words, axis=0)) == len(words) == 13_144
