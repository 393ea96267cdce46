"""Runs of the pipeline: shards of a search through the stages, on several cores, with or without a database."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, StageError
from hcsearch.basics.simulation_summaries import SimulationAccuracy, TrialAccuracy, accuracy_of_trials, undecided_counts
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
from hcsearch.search.pipeline.shards import SMALL_CIRCUIT_COUNT, ShardJob, ShardOutput
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.search.stages.order import STAGES, check_keep, stage_keeping, stage_numbers, stages_until
from hcsearch.search.stages.stage import Stage
from hcsearch.system.terminal import duration_text
from hcsearch.system.work_steps import (
    Announcement,
    Progress,
    StageProgress,
    hearing_work,
    no_announcement,
    no_progress,
    part_of_progress,
)

SMALL_JUDGED_COUNT = 3_000  # circuits, in runs that search for motions
QUICK_CORE_SECONDS = 100.0  # core seconds below which threads suffice, since new processes first load kernels
LONG_RUN_SECONDS = 30.0  # seconds above which a run announces its duration
_GROUPS = 25
_MAX_WAITING = 200_000  # designs, of about 500 bytes
_FIRST = stage_keeping("all").name
_SHARD_SIZE = 10_000  # circuits, where a search cannot say how many it has
_LISTED, _RELISTED, _JUDGED = 0.04, 0.05, 0.5  # shares of a run with verdicts; the last where undecided ones follow

RunBatch = tuple[str, DesignBatch, tuple[StageResult, ...]]


@dataclass(frozen=True)
class Plan:
    """The parameters of a run.

    until : the last stage. keep : which designs to keep. scene : of verdicts. crew : the workers. budget : efforts of
    the search for the motion of a folding; None for the default.
    """

    search: Search
    until: str
    keep: str = "all"
    scene: Scene = SCENES["default"]
    crew: WorkerPool = field(default_factory=WorkerPool)
    budget: int | None = None

    def __post_init__(self) -> None:
        check_keep(self.keep, self.until)
        if self.budget is not None and not self.scene_stages:
            raise StageError("--budget applies to the stage motion, which does not run: leave out --until or --budget")
        if self.scene_stages:
            check_scene_of_run(self.scene, self.search.grid.name, self.search.n)
        _ = self.search.prefixes  # too large a search is refused before a database is touched

    @property
    def scene_stages(self) -> tuple[Stage, ...]:
        """The stages that depend on the scene, which take a thousand times longer than all others."""
        return tuple(stage for stage in stages_until(self.until) if stage.depends_on_scene)

    @property
    def judge(self) -> Judge:
        """The task that judges pieces by these stages."""
        return Judge(self.scene, self.scene_stages, self.budget)

    @property
    def listing_stages(self) -> tuple[Stage, ...]:
        """The stages that do not depend on the scene."""
        return tuple(stage for stage in stages_until(self.until) if not stage.depends_on_scene)

    @property
    def is_small(self) -> bool:
        """Whether listing takes only seconds, less than the start of other processes or a probe."""
        expected = self.search.expected
        circuits = len(self.search.prefixes) * _SHARD_SIZE if expected is None else expected
        return circuits < (SMALL_JUDGED_COUNT if self.scene_stages else SMALL_CIRCUIT_COUNT)

    @property
    def listing_crew(self) -> WorkerPool:
        """The workers that list circuits: this process alone for a small search."""
        return WorkerPool() if self.is_small and self.crew.scheduler is None else self.crew

    @property
    def panel(self) -> str:
        """Size of the panels in millimetres, as a text."""
        return panel_text(panel_of(self.scene, self.search.grid.name))

    @property
    def listing_key(self) -> WorkKey:
        """The key of finished batches of circuits of this plan."""
        return WorkKey(self.search.grid.name, self.search.n, self.search.target, self.keep)

    @property
    def judging_key(self) -> WorkKey:
        """The key of finished verdicts of this plan."""
        return replace(self.listing_key, scene=self.scene.name)


@dataclass(frozen=True)
class Funnel:
    """Number of circuits that pass each stage; None where a stage has not run or its input was not listed.

    Parameters
    ----------
    fixed_circuits
        Number of circuits, congruent ones counted separately.
    arrays
        Number of arrays.
    circuits
        Number of circuits up to congruence.
    two_stack
        Number that fold into two stacks.
    untwisted
        Number with a folding without twist.
    movable
        Number with a proved path from packed to flat, or deployed by springs.
    deploys
        Number deployed by springs.
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
    """The outcome of a run. Times are summed over processes; `arrays` of the funnel counts the arrays of kept designs.

    undecided : foldings that are undecided in the scene; None where no stage judged them. not_decided : number of
    foldings that no simulation decides, by its ending. accuracy : of the deployments; None where none was simulated.
    """

    funnel: Funnel
    stage_times: dict[str, float]
    batches_done: int
    batches_reused: int
    undecided: int | None = None
    not_decided: Mapping[str, int] = field(default_factory=dict)
    accuracy: SimulationAccuracy | None = None


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
        """Describe the results up to a stage, for progress."""
        return f"{stage.name}, {self.passed.get(_FIRST, 0):,} circuits"

    def funnel(self, plan: Plan, stages: Sequence[Stage], arrays: int) -> Funnel:
        """Return the numbers of circuits that pass stages, which have run."""
        lists = plan.search.lists
        # a search that lists only circuits that pass a stage has no counts for the stages before
        known = stages[list(STAGES.values()).index(stage_keeping(lists)) :]
        counts = {stage.funnel_column: self.passed.get(stage.name, 0) for stage in known if stage.funnel_column}
        return Funnel(fixed_circuits=self.n_fixed if lists == "all" else None, arrays=arrays, **counts)


def run_dry(
    plan: Plan,
    progress: Progress = no_progress,
    announce: Announcement = no_announcement,
    listed: Callable[[Funnel], None] = lambda _: None,
) -> RunSummary:
    """Run the stages without a database.

    announce, listed : as in `run_into`. Memory grows with the number of distinct arrays, which are counted, and of
    candidates for a motion.
    """
    totals = _Totals()
    arrays = _DistinctArrays()
    prefixes, last = plan.search.prefixes, plan.listing_stages[-1]
    job = ShardJob(
        plan.search, plan.listing_stages, plan.keep, with_rows=False, with_candidates=bool(plan.scene_stages)
    )
    candidates: dict[str, StagedDesigns] = {}
    show = _listing_progress(plan, progress)
    show(0, len(prefixes), last.name)
    for done, (prefix, output) in enumerate(plan.listing_crew.map_ordered(job, prefixes), 1):
        totals.add(output.results, fresh=True)
        assert output.arrays is not None
        arrays.add(output.arrays)
        if output.candidates is not None:
            candidates[prefix] = output.candidates
        show(done, len(prefixes), totals.note(last))
    listed(totals.funnel(plan, plan.listing_stages, arrays.count))
    pending = [piece for prefix in candidates for piece in candidate_pieces(prefix, candidates[prefix])]
    undecided_count = 0
    reasons: dict[object, str] = {}
    trials: list[TrialAccuracy] = []
    for verdict in _judged(plan, pending, part_of_progress(progress, _LISTED, 1.0), announce):
        totals.add(verdict.results, fresh=True)
        undecided_count += verdict.verdicts.folding_status.count("undecided")
        reasons |= {(verdict.key, folding): reason for folding, reason in verdict.verdicts.undecided_reasons().items()}
        trials += verdict.verdicts.accuracies()
    funnel, done = totals.funnel(plan, stages_until(plan.until), arrays.count), len(prefixes) + len(pending)
    undecided = undecided_count if plan.scene_stages else None
    return RunSummary(funnel, totals.seconds, done, 0, undecided, undecided_counts(reasons), accuracy_of_trials(trials))


def _listing_progress(plan: Plan, show: Progress) -> Progress:
    """Return the progress of the stages that do not depend on the scene: the whole run, or its beginning."""
    return part_of_progress(show, 0.0, _LISTED, unit="batch") if plan.scene_stages else show


def _judged(
    plan: Plan, pieces_to_judge: list[CandidatePiece], show: Progress, announce: Announcement
) -> Iterator[JudgedPiece]:
    """Yield the verdicts on pieces, in order, by threads or processes; long work is announced."""
    if not pieces_to_judge:
        return
    foldings = sum(len(piece.candidates.folded) for piece in pieces_to_judge)
    seconds = judging_seconds(foldings, plan.search.n)
    jobs, cluster = plan.crew.jobs, plan.crew.scheduler is not None
    use_threads = seconds < QUICK_CORE_SECONDS and not cluster
    if seconds / jobs > LONG_RUN_SECONDS:
        workers = "on the cluster" if cluster else f"with --jobs {jobs}"
        announce(
            f"{foldings:,} foldings to judge in the scene {plan.scene.name}: "
            f"about {duration_text(seconds / jobs)} {workers}"
        )
    crew = WorkerPool() if use_threads else plan.crew
    yield from _judged_by(crew, plan.judge, pieces_to_judge, foldings, show, jobs if use_threads else 1)


def _judged_by(
    crew: WorkerPool, task: Judge | Settler, inputs: Sequence[Any], foldings: int, show: Progress, threads: int = 1
) -> Iterator[JudgedPiece]:
    """Yield the results of a task, in order, and show the stage at work and how many of all foldings are done in it."""
    progress, done = StageProgress(show, [stage.name for stage in task.stages], foldings), 0
    with hearing_work(progress.hear):
        for _, verdict in crew.map_ordered(task, inputs, 1, threads, progress.show_state):
            yield verdict
            done += verdict.foldings
            progress.finish(done)


class _DistinctArrays:
    """Counter of distinct arrays by fingerprints, with 32 to 64 bytes per array."""

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
    """Return the shards of a plan that are finished in a database; empty where it cannot be read."""
    try:
        with store.open_readonly(location) as database:
            return set(store.finished_batches(database, plan.listing_key, stage_numbers(plan.listing_stages)))
    except DatabaseError:
        return set()


def run_into(
    plan: Plan,
    database: store.Database,
    progress: Progress = no_progress,
    announce: Announcement = no_announcement,
    listed: Callable[[Funnel], None] = lambda _: None,
) -> RunSummary:
    """Run the stages whose results are missing or outdated, one transaction per batch, and record the run.

    progress : called for batches, or, where stages depend on the scene, with the share of the whole run.
    announce : called with a sentence on long work. listed : called with the funnel of the stages that do not depend on
    the scene.
    """
    stages = stage_numbers(stages_until(plan.until))
    if plan.scene_stages:
        from hcsearch.scenes.scene_file import scene_file_text  # noqa: PLC0415 - loads kernels

        store.record_scene(database, plan.scene.name, scene_file_text({}, None, plan.scene))
    run_id = store.start_run(
        database,
        work=plan.listing_key,
        until=plan.until,
        panel=plan.panel,
        arguments={
            "grid": plan.listing_key.grid,
            "n": plan.listing_key.n,
            "array": plan.listing_key.target or None,
            "until": plan.until,
        }
        | {"keep": plan.keep, "scene": plan.scene.name, "budget": plan.budget, **asdict(plan.crew)},
        versions=_versions() | {f"stage {name}": str(number) for name, number in stages.items()},
    )
    return _Run(plan, database, run_id, progress, announce).run(listed)


class _Run:
    """The state of a run into a database."""

    def __init__(
        self, plan: Plan, database: store.Database, run_id: int, show: Progress, announce: Announcement
    ) -> None:
        self.plan, self.database, self.run_id, self.show, self.announce = plan, database, run_id, show, announce
        self.totals = _Totals()
        self.prefixes = plan.search.prefixes
        self.candidates: dict[str, StagedDesigns] = {}
        self.done = self.reused = 0

    def run(self, listed: Callable[[Funnel], None]) -> RunSummary:
        plan, totals = self.plan, self.totals
        self._list()
        arrays = store.count_arrays(
            self.database, plan.listing_key, designs=totals.passed.get(stage_keeping(plan.keep).name, 0)
        )
        listed(totals.funnel(plan, plan.listing_stages, arrays))
        undecided_count, not_decided, accuracy = None, {}, None
        if plan.scene_stages:
            self._judge()
            undecided_count = len(store.undecided(self.database, plan.judging_key))
            not_decided = store.undecided_simulations(self.database, plan.judging_key)
            accuracy = store.simulation_accuracy(self.database, plan.judging_key)
        funnel = totals.funnel(plan, stages_until(plan.until), arrays)
        summary = RunSummary(funnel, totals.seconds, self.done, self.reused, undecided_count, not_decided, accuracy)
        store.finish_run(
            self.database, self.run_id, asdict(summary.funnel), summary.stage_times, self.done, self.reused
        )
        return summary

    def _list(self) -> None:
        """Run the stages that do not depend on the scene, shard by shard."""
        plan, totals, last = self.plan, self.totals, self.plan.listing_stages[-1]
        finished = store.finished_batches(self.database, plan.listing_key, stage_numbers(plan.listing_stages))
        for prefix in self.prefixes:
            if prefix in finished:
                totals.add(finished[prefix], fresh=False)
                self.reused += 1
        pending = [prefix for prefix in self.prefixes if prefix not in finished]
        job = ShardJob(
            plan.search, plan.listing_stages, plan.keep, with_rows=True, with_candidates=bool(plan.scene_stages)
        )
        show = _listing_progress(plan, self.show)
        show(self.reused, len(self.prefixes), totals.note(last))
        for batches in _grouped(self._listed(job, pending)):
            store.record_batches(self.database, self.run_id, plan.listing_key, batches)
            for _, _, results in batches:
                totals.add(results, fresh=True)
            self.done += len(batches)
            show(self.done + self.reused, len(self.prefixes), totals.note(last))

    def _listed(self, job: ShardJob, pending: list[str]) -> Iterator[tuple[str, ShardOutput]]:
        for prefix, output in self.plan.listing_crew.map_ordered(job, pending):
            if output.candidates is not None:
                self.candidates[prefix] = output.candidates
            yield prefix, output

    def _judge(self) -> None:
        """Run the stages that depend on the scene, piece by piece."""
        plan, totals = self.plan, self.totals
        finished = store.finished_batches(self.database, plan.judging_key, stage_numbers(plan.scene_stages))
        unfinished_prefixes = unfinished_shards(self.prefixes, list(finished))
        # shards listed by an earlier run are listed again, since the database does not record the contents of a shard
        relisting = ShardJob(plan.search, plan.listing_stages, plan.keep, with_rows=False, with_candidates=True)
        unlisted = [prefix for prefix in unfinished_prefixes if prefix not in self.candidates]
        show = part_of_progress(self.show, _LISTED, _RELISTED, unit="listed batch")
        for done, (prefix, output) in enumerate(plan.listing_crew.map_ordered(relisting, unlisted), 1):
            assert output.candidates is not None
            self.candidates[prefix] = output.candidates
            show(done, len(unlisted), "of an earlier run")
        all_pieces = [
            piece for prefix in unfinished_prefixes for piece in candidate_pieces(prefix, self.candidates[prefix])
        ]
        for key in finished:
            totals.add(finished[key], fresh=False)
        self.reused += len(finished)
        pending = [piece for piece in all_pieces if piece.key not in finished]
        end = 1.0 if plan.budget is None else _JUDGED if pending else _RELISTED
        for verdict in _judged(plan, pending, part_of_progress(self.show, _RELISTED, end), self.announce):
            store.record_verdicts(
                self.database, self.run_id, plan.judging_key, verdict.key, verdict.verdicts, verdict.results
            )
            totals.add(verdict.results, fresh=True)
            self.done += 1
        self._settle(part_of_progress(self.show, end, 1.0))

    def _settle(self, show: Progress) -> None:
        """Continue the search for undecided foldings with less effort than the budget, design by design."""
        plan, totals = self.plan, self.totals
        if plan.budget is None:
            return
        pending = list(settling_tasks(store.undecided(self.database, plan.judging_key, plan.budget), plan.budget))
        if not pending:
            return
        foldings = sum(len(task.foldings) for task in pending)
        settler = Settler(plan.scene, plan.scene_stages, plan.budget)
        for verdict in _judged_by(plan.crew, settler, pending, foldings, show):
            work = self.run_id, plan.judging_key, verdict.key
            totals.add(store.record_settled(self.database, *work, verdict.verdicts, verdict.results), fresh=True)
            self.done += 1


def _grouped(outputs: Iterable[tuple[str, ShardOutput]]) -> Iterator[list[RunBatch]]:
    """Group batches to be recorded in one transaction.

    Designs come in random order with respect to the index of circuits, so each transaction rewrites most of a large
    index: groups grow in proportion to the designs recorded before, but wait for at most a second.
    """
    group: list[RunBatch] = []
    recorded = pending = 0
    start_time = time.monotonic()
    for prefix, output in outputs:
        assert output.rows is not None
        group.append((prefix, output.rows, output.results))
        pending += output.kept_count
        if pending >= min(recorded // _GROUPS, _MAX_WAITING) or time.monotonic() > start_time + 1.0:
            yield group
            recorded += pending
            group, pending, start_time = [], 0, time.monotonic()
    if group:
        yield group


def _versions() -> dict[str, str]:
    """Return the versions of this program and of the libraries that affect results."""
    return {"hcsearch": version("hcsearch"), "python": platform.python_version()} | {
        name: version(name) for name in ("numba", "numpy", "sqlalchemy")
    }
