"""One run of the pipeline: units of a search through the stages, on several cores, into a database or not."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from importlib.metadata import version

import numpy as np
from numpy.typing import NDArray

from hcsearch import deployment
from hcsearch.enumeration import Search
from hcsearch.errors import DatabaseError
from hcsearch.kernels.words import insert_fingerprints
from hcsearch.pipeline.designs import Job, Output
from hcsearch.pipeline.stages import KEEP_NEEDS, check_keep, stages_until
from hcsearch.pipeline.workers import Crew
from hcsearch.records import DesignBatch, StageResult, Work
from hcsearch.store import (
    Database,
    count_arrays,
    finish_run,
    finished_batches,
    open_readonly,
    record_batches,
    start_run,
)

SMALL, SMALL_DEPLOYED = 5_000_000, 3_000  # circuits
_GROUPS = 25
_MAX_WAITING = 200_000  # designs, of about 500 bytes
_UNIT_SIZE = 10_000  # circuits, where a search cannot say how many it has

Batch = tuple[str, DesignBatch, tuple[StageResult, ...]]
Progress = Callable[[int, int, str], None]  # batches done, all batches, what has been found


@dataclass(frozen=True)
class Plan:
    """What to run: a search, the last stage, which designs to keep, the panel (text, millimetres), who works."""

    search: Search
    until: str
    keep: str = "all"
    panel: str | None = None
    crew: Crew = field(default_factory=Crew)

    def __post_init__(self) -> None:
        check_keep(self.keep, self.until)
        _ = self.search.prefixes  # what is too large to list is refused before a database is touched

    @property
    def deploys(self) -> bool:
        """Whether deployments are checked, which takes a thousand times longer than all else."""
        return deployment.STAGE in stages_until(self.until)

    @property
    def small(self) -> bool:
        """Whether the run takes seconds: other processes would take longer to start, and a probe to answer."""
        expected = self.search.expected
        circuits = len(self.search.prefixes) * _UNIT_SIZE if expected is None else expected
        return circuits < (SMALL_DEPLOYED if self.deploys else SMALL)

    @property
    def hands(self) -> Crew:
        """Who works in fact: not several processes where one is done before the others have started."""
        return Crew() if self.small and self.crew.scheduler is None else self.crew

    @property
    def threads(self) -> int:
        """Threads of each process, where there are fewer processes at work than cores."""
        if self.crew.scheduler is not None:
            return 1
        return max(1, self.crew.jobs // min(self.hands.jobs, max(1, len(self.search.prefixes))))

    @property
    def work(self) -> Work:
        """The key of this plan's finished batches."""
        return Work(self.search.grid.name, self.search.n, self.search.target, self.keep)


@dataclass(frozen=True)
class Funnel:
    """How many are left after each stage; None where it has not run, or where only later ones are listed."""

    fixed_circuits: int | None
    circuits: int | None
    arrays: int
    two_stack: int | None
    untwisted: int | None
    deployable: int | None = None


@dataclass(frozen=True)
class Summary:
    """What a run did. Times are those of the kernels, summed over processes; `arrays` counts those of kept designs."""

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

    def funnel(self, plan: Plan, arrays: int) -> Funnel:
        stages = stages_until(plan.until)
        lists = plan.search.lists
        return Funnel(
            fixed_circuits=self.n_fixed if lists == "all" else None,
            circuits=self.passed.get("circuits", 0) if lists == "all" else None,
            arrays=arrays,
            two_stack=self.passed.get("foldings", 0) if "foldings" in stages and lists != "untwisted" else None,
            untwisted=self.passed.get("twist", 0) if "twist" in stages else None,
            deployable=self.passed.get("deployment", 0) if "deployment" in stages else None,
        )


def run_dry(plan: Plan, progress: Progress | None = None) -> Summary:
    """Run the stages without a database. Memory grows only with the number of arrays, to count different ones."""
    totals = _Totals()
    arrays = _DistinctArrays()
    prefixes = plan.search.prefixes
    job = Job(plan.search, stages_until(plan.until), plan.keep, rows=False, threads=plan.threads)
    for done, (_, output) in enumerate(plan.hands.work(job, prefixes), 1):
        totals.add(output.results, fresh=True)
        assert output.arrays is not None
        arrays.add(output.arrays)
        if progress is not None:
            progress(done, len(prefixes), totals.note)
    return Summary(totals.funnel(plan, arrays.count), totals.seconds, len(prefixes), 0)


class _DistinctArrays:
    """Counts different arrays by their fingerprints: 32 to 64 bytes an array."""

    def __init__(self) -> None:
        self.count = 0
        self._table = np.zeros((1 << 12, 2), np.uint64)

    def add(self, prints: NDArray[np.uint64]) -> None:
        if 2 * (self.count + len(prints)) > len(self._table):
            old = self._table
            self._table = np.zeros((1 << (4 * (self.count + len(prints))).bit_length(), 2), np.uint64)
            insert_fingerprints(old, self._table)
        self.count += insert_fingerprints(prints, self._table)


def finished_units(plan: Plan, location: str) -> set[str]:
    """Units of a plan that are finished in a database; none where it cannot be read, which opening it will explain."""
    try:
        with open_readonly(location) as database:
            return set(finished_batches(database, plan.work, stages_until(plan.until)))
    except DatabaseError:
        return set()


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
        | {"keep": plan.keep, "panel": plan.panel, **asdict(plan.crew)},
        versions=_versions() | {f"stage {name}": str(number) for name, number in stages.items()},
    )

    job = Job(plan.search, stages, plan.keep, rows=True, threads=plan.threads)
    done = len(reused)
    for batches in _grouped(plan.hands.work(job, todo)):
        record_batches(database, run_id, plan.work, batches)
        for _, _, fresh in batches:
            totals.add(fresh, fresh=True)
        done += len(batches)
        if progress is not None:
            progress(done, len(prefixes), totals.note)
    arrays = count_arrays(database, plan.work, designs=totals.passed.get(KEEP_NEEDS[plan.keep], 0))
    summary = Summary(totals.funnel(plan, arrays), totals.seconds, len(todo), len(reused))
    finish_run(database, run_id, asdict(summary.funnel), summary.stage_times, summary.batches_done, len(reused))
    return summary


def _grouped(outputs: Iterable[tuple[str, Output]]) -> Iterator[list[Batch]]:
    """Batches to be recorded together.

    Designs come in no order that an index of circuits could follow, so that each transaction writes nearly all of a
    large one: a group holds a share of what went before, but no more than a second's work waits.
    """
    group: list[Batch] = []
    before = waiting = 0
    begun = time.monotonic()
    for prefix, output in outputs:
        assert output.rows is not None
        group.append((prefix, output.rows, output.results))
        waiting += output.kept
        if waiting >= min(before // _GROUPS, _MAX_WAITING) or time.monotonic() > begun + 1.0:
            yield group
            before += waiting
            group, waiting, begun = [], 0, time.monotonic()
    if group:
        yield group


def _versions() -> dict[str, str]:
    """What made the results: this program and what it computes with."""
    return {"hcsearch": version("hcsearch"), "python": platform.python_version()} | {
        name: version(name) for name in ("numba", "numpy", "sqlalchemy")
    }
