"""One run of the pipeline: units of a search through the stages, on several cores, into a database or not."""

from __future__ import annotations

import platform
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from itertools import islice
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hcsearch.enumeration import Search
from hcsearch.kernels.words import insert_fingerprints
from hcsearch.pipeline.designs import UnitResult, array_fingerprints, design_rows, run_unit
from hcsearch.pipeline.stages import check_keep, stages_until
from hcsearch.records import DesignBatch, StageResult, Work
from hcsearch.store import Database, count_arrays, finish_run, finished_batches, record_batch, start_run

Progress = Callable[[int, int, str], None]  # batches done, all batches, what has been found
T = TypeVar("T")


@dataclass(frozen=True)
class Plan:
    """What to run: a search, the last stage, which designs to keep, the panel (text, millimetres), threads."""

    search: Search
    until: str
    keep: str = "all"
    panel: str | None = None
    jobs: int = 1

    def __post_init__(self) -> None:
        check_keep(self.keep, self.until)
        _ = self.search.prefixes  # what is too large to list is refused before a database is touched

    @property
    def work(self) -> Work:
        """The key of this plan's finished batches."""
        return Work(self.search.grid.name, self.search.n, self.search.target, self.keep)


@dataclass(frozen=True)
class Funnel:
    """How many are left after each stage; None where it has not run."""

    fixed_circuits: int
    circuits: int
    arrays: int
    two_stack: int | None
    untwisted: int | None
    deployable: int | None = None


@dataclass(frozen=True)
class Summary:
    """What a run did. Times are those of the kernels, summed over threads; `arrays` counts those of kept designs."""

    funnel: Funnel
    stage_times: dict[str, float]
    batches_done: int
    batches_reused: int


@dataclass
class _Totals:
    """Sums over the batches of a run."""

    passed: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    n_fixed: int = 0

    def add(self, results: tuple[StageResult, ...] | list[StageResult], *, fresh: bool) -> None:
        for result in results:
            self.passed[result.stage] = self.passed.get(result.stage, 0) + result.passed
            self.seconds[result.stage] = self.seconds.get(result.stage, 0.0) + (result.seconds if fresh else 0.0)
        self.n_fixed += results[0].n_fixed

    @property
    def note(self) -> str:
        return f"{self.passed.get('circuits', 0):,} circuits"

    def funnel(self, stages: dict[str, int], arrays: int) -> Funnel:
        return Funnel(
            fixed_circuits=self.n_fixed,
            circuits=self.passed.get("circuits", 0),
            arrays=arrays,
            two_stack=self.passed.get("foldings", 0) if "foldings" in stages else None,
            untwisted=self.passed.get("twist", 0) if "twist" in stages else None,
        )


def run_dry(plan: Plan, progress: Progress | None = None) -> Summary:
    """Run the stages without a database. Memory grows only with the number of arrays, to count different ones."""
    stages = stages_until(plan.until)
    totals = _Totals()
    arrays = _DistinctArrays()
    prefixes = plan.search.prefixes

    def work(prefix: str) -> tuple[UnitResult, NDArray[np.uint64]]:
        unit = run_unit(plan.search, prefix, stages, plan.keep)
        return unit, array_fingerprints(plan.search, unit.circuits)

    for done, (_, (unit, prints)) in enumerate(_in_threads(work, prefixes, plan.jobs), 1):
        totals.add(unit.results, fresh=True)
        arrays.add(prints)
        if progress is not None:
            progress(done, len(prefixes), totals.note)
    return Summary(totals.funnel(stages, arrays.count), totals.seconds, len(prefixes), 0)


class _DistinctArrays:
    """Counts different arrays by their fingerprints: 32 to 64 bytes an array."""

    def __init__(self) -> None:
        self.count = 0
        self._table = np.zeros((1 << 12, 2), np.uint64)

    def add(self, prints: NDArray[np.uint64]) -> None:
        if 2 * (self.count + len(prints)) > len(self._table):
            old = self._table[self._table.any(axis=1)]
            self._table = np.zeros((1 << (4 * (self.count + len(prints))).bit_length(), 2), np.uint64)
            insert_fingerprints(old, self._table)
        self.count += insert_fingerprints(prints, self._table)


def run_into(plan: Plan, database: Database, progress: Progress | None = None) -> Summary:
    """Run the stages where results are missing or older, one transaction a batch, and record the run."""
    stages = stages_until(plan.until)
    totals = _Totals()
    prefixes = plan.search.prefixes
    finished = finished_batches(database, plan.work, stages)
    reused = [finished[prefix] for prefix in prefixes if prefix in finished]
    for results in reused:
        totals.add(results, fresh=False)
    todo = [prefix for prefix in prefixes if prefix not in finished]
    run_id = start_run(
        database,
        work=plan.work,
        until=plan.until,
        panel=plan.panel,
        arguments={"grid": plan.work.grid, "n": plan.work.n, "array": plan.work.target or None, "until": plan.until}
        | {"keep": plan.keep, "panel": plan.panel, "jobs": plan.jobs},
        versions=_versions() | {f"stage {name}": str(number) for name, number in stages.items()},
    )

    def work(prefix: str) -> tuple[UnitResult, DesignBatch]:
        unit = run_unit(plan.search, prefix, stages, plan.keep)
        return unit, design_rows(plan.search, unit)

    for done, (prefix, (unit, rows)) in enumerate(_in_threads(work, todo, plan.jobs), 1):
        record_batch(database, run_id, plan.work, prefix, rows, list(unit.results))
        totals.add(unit.results, fresh=True)
        if progress is not None:
            progress(len(reused) + done, len(prefixes), totals.note)
    summary = Summary(totals.funnel(stages, count_arrays(database, plan.work)), totals.seconds, len(todo), len(reused))
    finish_run(database, run_id, asdict(summary.funnel), summary.stage_times, summary.batches_done, len(reused))
    return summary


def _in_threads(work: Callable[[str], T], prefixes: list[str], jobs: int) -> Iterator[tuple[str, T]]:
    """Results in the order of the prefixes, so that a run stores the same whatever the number of threads.

    Kernels run without the interpreter lock; few results wait at a time.
    """
    with ThreadPoolExecutor(jobs) as pool:
        waiting: deque[tuple[str, Future[T]]] = deque()
        todo = iter(prefixes)
        try:
            while True:
                waiting.extend((prefix, pool.submit(work, prefix)) for prefix in islice(todo, jobs + 2 - len(waiting)))
                if not waiting:
                    return
                prefix, future = waiting.popleft()
                yield prefix, future.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _versions() -> dict[str, str]:
    """What made the results: this program and what it computes with."""
    return {"hcsearch": version("hcsearch"), "python": platform.python_version()} | {
        name: version(name) for name in ("numba", "numpy", "sqlalchemy")
    }
