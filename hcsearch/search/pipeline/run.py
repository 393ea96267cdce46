"""One run of the pipeline: shards of a search through the stages, on several cores, into a database or not."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.errors import DatabaseError, StageError
from hcsearch.designs.panel_sizes import panel_text
from hcsearch.designs.records import DesignBatch, StagedDesigns, StageResult, WorkKey
from hcsearch.kernels.circuits.words import insert_fingerprints
from hcsearch.scenes import SCENES, Scene, panel_of
from hcsearch.search.enumeration import Search
from hcsearch.search.pipeline.judging import (
    CandidatePiece,
    Judge,
    JudgedPiece,
    Settler,
    candidate_pieces,
    check_scene_of_run,
    judging_seconds,
    settling_tasks,
    unfinished_shards,
)
from hcsearch.search.pipeline.shards import ShardJob, ShardOutput
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.search.stages.order import STAGES, check_keep, stage_keeping, stage_numbers, stages_until
from hcsearch.search.stages.stage import Stage
from hcsearch.store import (
    Database,
    count_arrays,
    finish_run,
    finished_batches,
    open_readonly,
    record_batches,
    record_scene,
    record_settled,
    record_verdicts,
    start_run,
    undecided,
)
from hcsearch.system.terminal import duration_text

SMALL_CIRCUIT_COUNT, SMALL_JUDGED_COUNT = 5_000_000, 3_000  # circuits, of the latter where motions follow
QUICK_CORE_SECONDS = 100.0  # core seconds: two processes take some of them to load their kernels
LONG_RUN_SECONDS = 30.0  # seconds: a run that takes longer says so beforehand
_GROUPS = 25
_MAX_WAITING = 200_000  # designs, of about 500 bytes
_FIRST = stage_keeping("all").name
_SHARD_SIZE = 10_000  # circuits, where a search cannot say how many it has

RunBatch = tuple[str, DesignBatch, tuple[StageResult, ...]]


class RunProgress(Protocol):
    """Takes what is done, of how much, what has come out, and what is counted."""

    def __call__(self, done: int, total: int, note: str, unit: str = "batch") -> None:
        """Show it."""


AnnounceSentence = Callable[[str], None]


def _hidden(done: int, total: int, note: str, unit: str = "batch") -> None:
    """Show no progress."""


def _silent(sentence: str) -> None:
    """Say nothing."""


@dataclass(frozen=True)
class Plan:
    """What to run: a search, the last stage, which designs to keep, the scene that verdicts depend on, the crew.

    budget : efforts of the search for the motion of a folding, None for the usual ones.
    """

    search: Search
    until: str
    keep: str = "all"
    scene: Scene = SCENES["default"]
    crew: WorkerPool = field(default_factory=WorkerPool)
    budget: int | None = None

    def __post_init__(self) -> None:
        check_keep(self.keep, self.until)
        if self.budget is not None and not self.scenic:
            raise StageError("--budget is for motions, which no stage here searches for: leave out --until or --budget")
        if self.scenic:
            check_scene_of_run(self.scene, self.search.grid.name, self.search.n)
        _ = self.search.prefixes  # what is too large to list is refused before a database is touched

    @property
    def scenic(self) -> tuple[Stage, ...]:
        """The stages in a scene, which take a thousand times longer than all others."""
        return tuple(stage for stage in stages_until(self.until) if stage.in_a_scene)

    @property
    def judge(self) -> Judge:
        """Verdicts on a piece, by these stages."""
        return Judge(self.scene, self.scenic, self.budget)

    @property
    def listing(self) -> tuple[Stage, ...]:
        """The stages that depend on no scene."""
        return tuple(stage for stage in stages_until(self.until) if not stage.in_a_scene)

    @property
    def small(self) -> bool:
        """Whether listing takes seconds: other processes would take longer to start, and a probe to answer."""
        expected = self.search.expected
        circuits = len(self.search.prefixes) * _SHARD_SIZE if expected is None else expected
        return circuits < (SMALL_JUDGED_COUNT if self.scenic else SMALL_CIRCUIT_COUNT)

    @property
    def hands(self) -> WorkerPool:
        """The crew that lists: one process where that is done before others have started."""
        return WorkerPool() if self.small and self.crew.scheduler is None else self.crew

    @property
    def panel(self) -> str:
        """Size of the panels, in millimetres."""
        return panel_text(panel_of(self.scene, self.search.grid.name))

    @property
    def work(self) -> WorkKey:
        """The key of this plan's finished batches."""
        return WorkKey(self.search.grid.name, self.search.n, self.search.target, self.keep)

    @property
    def judging(self) -> WorkKey:
        """The key of its finished verdicts."""
        return replace(self.work, scene=self.scene.name)


@dataclass(frozen=True)
class Funnel:
    """How many circuits pass each stage; None where a stage has not run, or where its circuits were not listed.

    movable : with a proved path from packed to flat, or deploying. deploys : by springs alone.
    """

    fixed_circuits: int | None
    arrays: int
    circuits: int | None = None
    two_stack: int | None = None
    untwisted: int | None = None
    movable: int | None = None
    deploys: int | None = None


@dataclass(frozen=True)
class RunSummary:
    """What a run did. Times are those of the kernels, summed over processes; `arrays` counts those of kept designs.

    undecided : foldings that are undecided in the scene; None where no stage judged them.
    """

    funnel: Funnel
    stage_times: dict[str, float]
    batches_done: int
    batches_reused: int
    undecided: int | None = None


@dataclass
class _Totals:
    """Sums over the batches of a run."""

    passed: dict[str, int] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    n_fixed: int = 0

    def add(self, results: tuple[StageResult, ...] | list[StageResult], *, fresh: bool) -> None:
        for result in results:
            self.n_fixed += result.n_fixed if result.stage == _FIRST else 0
            self.passed[result.stage] = self.passed.get(result.stage, 0) + result.passed
            self.seconds[result.stage] = self.seconds.get(result.stage, 0.0) + (result.seconds if fresh else 0.0)

    def note(self, stage: Stage) -> str:
        """What has come out of the stages that end with one."""
        if stage.they:
            return f"{stage.name}, {self.passed.get(stage.name, 0):,} designs {stage.they}"
        return f"{stage.name}, {self.passed.get(_FIRST, 0):,} circuits"

    def funnel(self, plan: Plan, arrays: int) -> Funnel:
        stages, lists = stages_until(plan.until), plan.search.lists
        # a search that lists only what passes a stage does not meet what passes those before
        known = stages[list(STAGES.values()).index(stage_keeping(lists)) :]
        counts = {stage.counts: self.passed.get(stage.name, 0) for stage in known if stage.counts}
        return Funnel(fixed_circuits=self.n_fixed if lists == "all" else None, arrays=arrays, **counts)


def run_dry(plan: Plan, progress: RunProgress | None = None, announce: AnnounceSentence = _silent) -> RunSummary:
    """Run the stages without a database.

    Memory grows with the number of arrays, to count different ones, and with that of candidates for a motion.
    """
    totals = _Totals()
    arrays = _DistinctArrays()
    prefixes, last = plan.search.prefixes, plan.listing[-1]
    job = ShardJob(plan.search, plan.listing, plan.keep, rows=False, candidates=bool(plan.scenic))
    candidates: dict[str, StagedDesigns] = {}
    show = progress or _hidden
    show(0, len(prefixes), last.name)
    for done, (prefix, output) in enumerate(plan.hands.work(job, prefixes), 1):
        totals.add(output.results, fresh=True)
        assert output.arrays is not None
        arrays.add(output.arrays)
        if output.candidates is not None:
            candidates[prefix] = output.candidates
        show(done, len(prefixes), totals.note(last))
    todo = [piece for prefix in candidates for piece in candidate_pieces(prefix, candidates[prefix])]
    left = 0
    for verdict in _judged(plan, todo, totals, show, announce):
        totals.add(verdict.results, fresh=True)
        left += verdict.verdicts.folding_status.count("undecided")
    funnel, done = totals.funnel(plan, arrays.count), len(prefixes) + len(todo)
    return RunSummary(funnel, totals.seconds, done, 0, left if plan.scenic else None)


def _judged(
    plan: Plan, todo: list[CandidatePiece], totals: _Totals, show: RunProgress, announce: AnnounceSentence
) -> Iterator[JudgedPiece]:
    """Verdicts on pieces, in order, by as many threads or processes as pay; says beforehand when it takes long."""
    if not todo:
        return
    foldings = sum(len(piece.candidates.folded) for piece in todo)
    seconds = judging_seconds(foldings, plan.search.n)
    jobs, cluster = plan.crew.jobs, plan.crew.scheduler is not None
    small = seconds < QUICK_CORE_SECONDS and not cluster
    if seconds / jobs > LONG_RUN_SECONDS:
        who = "on the cluster" if cluster else f"with --jobs {jobs}"
        announce(
            f"{foldings:,} foldings to judge in the scene {plan.scene.name}: "
            f"about {duration_text(seconds / jobs)} {who}"
        )
    hands = WorkerPool() if small else plan.crew
    done, last = 0, plan.scenic[-1]
    show(done, foldings, totals.note(last), "folding")
    for _, verdict in hands.work(plan.judge, todo, parcel=1, threads=jobs if small else 1):
        yield verdict
        done += verdict.foldings
        show(done, foldings, totals.note(last), "folding")


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


def finished_shards(plan: Plan, location: str) -> set[str]:
    """Shards of a plan that are finished in a database; none where it cannot be read, which opening it will explain."""
    try:
        with open_readonly(location) as database:
            return set(finished_batches(database, plan.work, stage_numbers(plan.listing)))
    except DatabaseError:
        return set()


def run_into(
    plan: Plan, database: Database, progress: RunProgress | None = None, announce: AnnounceSentence = _silent
) -> RunSummary:
    """Run the stages where results are missing or older, one transaction a batch, and record the run.

    announce : takes a sentence on what follows, where that takes long.
    """
    stages = stage_numbers(stages_until(plan.until))
    if plan.scenic:
        from hcsearch.scenes.scene_file import scene_file_text  # noqa: PLC0415 - loads kernels

        record_scene(database, plan.scene.name, scene_file_text({}, None, plan.scene))
    run_id = start_run(
        database,
        work=plan.work,
        until=plan.until,
        panel=plan.panel,
        arguments={"grid": plan.work.grid, "n": plan.work.n, "array": plan.work.target or None, "until": plan.until}
        | {"keep": plan.keep, "scene": plan.scene.name, "budget": plan.budget, **asdict(plan.crew)},
        versions=_versions() | {f"stage {name}": str(number) for name, number in stages.items()},
    )
    return _Run(plan, database, run_id, progress or _hidden, announce).run()


class _Run:
    """One run into a database, while it goes on."""

    def __init__(
        self, plan: Plan, database: Database, run_id: int, show: RunProgress, announce: AnnounceSentence
    ) -> None:
        self.plan, self.database, self.run_id, self.show, self.announce = plan, database, run_id, show, announce
        self.totals = _Totals()
        self.prefixes = plan.search.prefixes
        self.candidates: dict[str, StagedDesigns] = {}
        self.done = self.reused = 0

    def run(self) -> RunSummary:
        plan, totals = self.plan, self.totals
        self._list()
        if plan.scenic:
            self._judge()
        arrays = count_arrays(self.database, plan.work, designs=totals.passed.get(stage_keeping(plan.keep).name, 0))
        left = len(undecided(self.database, plan.judging)) if plan.scenic else None
        summary = RunSummary(totals.funnel(plan, arrays), totals.seconds, self.done, self.reused, left)
        finish_run(self.database, self.run_id, asdict(summary.funnel), summary.stage_times, self.done, self.reused)
        return summary

    def _list(self) -> None:
        """The stages that depend on no scene, shard by shard of the search."""
        plan, totals, last = self.plan, self.totals, self.plan.listing[-1]
        finished = finished_batches(self.database, plan.work, stage_numbers(plan.listing))
        for prefix in self.prefixes:
            if prefix in finished:
                totals.add(finished[prefix], fresh=False)
                self.reused += 1
        todo = [prefix for prefix in self.prefixes if prefix not in finished]
        job = ShardJob(plan.search, plan.listing, plan.keep, rows=True, candidates=bool(plan.scenic))
        self.show(self.reused, len(self.prefixes), totals.note(last))
        for batches in _grouped(self._listed(job, todo)):
            record_batches(self.database, self.run_id, plan.work, batches)
            for _, _, fresh in batches:
                totals.add(fresh, fresh=True)
            self.done += len(batches)
            self.show(self.done + self.reused, len(self.prefixes), totals.note(last))

    def _listed(self, job: ShardJob, todo: list[str]) -> Iterator[tuple[str, ShardOutput]]:
        for prefix, output in self.plan.hands.work(job, todo):
            if output.candidates is not None:
                self.candidates[prefix] = output.candidates
            yield prefix, output

    def _judge(self) -> None:
        """The stages in a scene, piece by piece."""
        plan, totals = self.plan, self.totals
        finished = finished_batches(self.database, plan.judging, stage_numbers(plan.scenic))
        left = unfinished_shards(self.prefixes, list(finished))
        # shards that were listed by an earlier run are listed once more: the database does not know what is in a shard
        again = ShardJob(plan.search, plan.listing, plan.keep, rows=False, candidates=True)
        unknown = [prefix for prefix in left if prefix not in self.candidates]
        for done, (prefix, output) in enumerate(plan.hands.work(again, unknown), 1):
            assert output.candidates is not None
            self.candidates[prefix] = output.candidates
            self.show(done, len(unknown), "mobility, units that were listed before")
        wanted = [piece for prefix in left for piece in candidate_pieces(prefix, self.candidates[prefix])]
        for key in finished:
            totals.add(finished[key], fresh=False)
        self.reused += len(finished)
        todo = [piece for piece in wanted if piece.key not in finished]
        for verdict in _judged(plan, todo, totals, self.show, self.announce):
            record_verdicts(self.database, self.run_id, plan.judging, verdict.key, verdict.verdicts, verdict.results)
            totals.add(verdict.results, fresh=True)
            self.done += 1
        self._settle()

    def _settle(self) -> None:
        """What is undecided and was searched with less than the budget, design by design."""
        plan, totals = self.plan, self.totals
        if plan.budget is None:
            return
        todo = list(settling_tasks(undecided(self.database, plan.judging, plan.budget), plan.budget))
        foldings, done = sum(len(task.foldings) for task in todo), 0
        settler = Settler(plan.scene, plan.scenic, plan.budget)
        for _, verdict in plan.crew.work(settler, todo, parcel=1, threads=1):
            work = self.run_id, plan.judging, verdict.key
            totals.add(record_settled(self.database, *work, verdict.verdicts, verdict.results), fresh=True)
            done += verdict.foldings
            self.done += 1
            self.show(done, foldings, totals.note(plan.scenic[-1]), "folding")


def _grouped(outputs: Iterable[tuple[str, ShardOutput]]) -> Iterator[list[RunBatch]]:
    """Batches to be recorded together.

    Designs come in no order that an index of circuits could follow, so that each transaction writes nearly all of a
    large one: a group holds a share of what went before, but no more than a second's work waits.
    """
    group: list[RunBatch] = []
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
