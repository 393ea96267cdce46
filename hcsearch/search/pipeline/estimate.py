"""Counts of designs, without listing them where possible, and estimates of a run's time and space."""

from __future__ import annotations

import random
import time
from collections.abc import Collection
from dataclasses import dataclass

from hcsearch import store
from hcsearch.basics.errors import SizeError
from hcsearch.search.enumeration import FoldedSearch, Search
from hcsearch.search.pipeline.judging import judging_seconds
from hcsearch.search.pipeline.run import Plan
from hcsearch.search.pipeline.shards import SMALL_CIRCUIT_COUNT, ShardJob, TransferableTask, cached_search, run_shard
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.search.stages.order import stage_keeping, stages_until
from hcsearch.system.terminal import bytes_text, duration_text, number_text
from hcsearch.system.work_steps import Progress

_PROBE = 8  # shards
_FOLDING_BYTES = 650  # per panel, mostly paths; measured with hexagons: 7.6 kB per folding of n = 12, 9.4 kB of n = 14
_ROW_SECONDS = 1e-5  # measured: 100,000 designs a second go into a database


@dataclass(frozen=True)
class RunEstimate:
    """Estimated numbers of listed circuits and kept designs, core seconds of search, bytes and seconds of storage."""

    circuits: float
    designs: float
    core_seconds: float
    stored_bytes: float
    store_seconds: float

    def sentence(self, crew: WorkerPool) -> str:
        """Return the estimate as a sentence; one process writes while the others compute."""
        if crew.scheduler is not None:
            cores, store = duration_text(self.core_seconds), duration_text(self.store_seconds)
            time = f"{cores} of core time on the cluster, {store} to store"
        else:
            time = f"{duration_text(max(self.core_seconds / crew.jobs, self.store_seconds))} with --jobs {crew.jobs}"
        room = f", {bytes_text(self.stored_bytes)} in the database" if self.stored_bytes else ""
        return f"about {number_text(self.circuits)} circuits to list, {number_text(self.designs)} to keep: {time}{room}"


def estimate_run(plan: Plan, *, stored: bool, finished: Collection[str] = ()) -> RunEstimate | None:
    """Estimate the remaining work of a plan; None where it takes only seconds.

    finished : shards that are done already. A sample of the others, spread over the search, is processed as a probe,
    after one shard that is not timed, since it compiles kernels.
    """
    search = plan.search
    shards = [shard for shard in search.prefixes if shard not in finished]
    if plan.is_small or not shards:
        return None
    expected = None if search.expected is None else search.expected * len(shards) / len(search.prefixes)
    # motions are not probed: they take far longer than listing
    job = ShardJob(search, plan.listing_stages, plan.keep, with_rows=stored, with_candidates=bool(plan.scene_stages))
    job(shards[-1])
    sample = shards[:: -(-len(shards) // _PROBE)]
    start_time = time.perf_counter()
    outputs = [job(shard) for shard in sample]
    seconds = time.perf_counter() - start_time
    listed = sum(output.results[0].passed for output in outputs)
    kept_count = sum(output.kept_count for output in outputs)
    share = len(shards) / len(sample) if expected is None or not listed else expected / listed
    designs = kept_count * share
    core_seconds, stored_bytes = seconds * share, designs * (60 + 5 * search.n)
    if plan.scene_stages:
        foldings = share * sum(len(output.candidates.folded) for output in outputs if output.candidates is not None)
        core_seconds += judging_seconds(foldings, search.n)
        stored_bytes += foldings * _FOLDING_BYTES * search.n
    return RunEstimate(
        circuits=listed * share,
        designs=designs,
        core_seconds=core_seconds,
        stored_bytes=stored_bytes if stored else 0.0,
        store_seconds=designs * _ROW_SECONDS if stored else 0.0,
    )


def check_disk_room(expected: RunEstimate, location: str) -> None:
    """Check that a database's disk has room for the estimate, its present contents included; SizeError otherwise."""
    room = store.room_at(location)
    if room is not None and expected.stored_bytes > room:
        raise SizeError(
            f"about {number_text(expected.designs)} designs need {bytes_text(expected.stored_bytes)} and {location} "
            f"has room for {bytes_text(room)}: "
            "name a database elsewhere with --db, keep fewer with --keep or --n, or do without one: "
            "--dry-run, `hcsearch count`"
        )


_SMALL_PAIRS = 2e9  # pairs that one process counts in seconds
_PROBE_PAIRS = 100_000_000  # pairs of one part of a key
_PROBE_SECONDS = 1.0


@dataclass(frozen=True)
class DesignCount:
    """Number of designs up to symmetry, and of the circuits in their classes: fixed ones, or circuits of the array."""

    classes: int
    circuits: int


@dataclass(frozen=True)
class _Task(TransferableTask):
    """Count the designs of one shard."""

    search: Search
    keep: str

    def __call__(self, shard: str) -> tuple[int, int]:
        search = cached_search(self.search)
        if isinstance(search, FoldedSearch):
            return search.count(shard)
        result = run_shard(search, shard, stages_until(stage_keeping(self.keep).name), "all")[1][-1]
        return result.passed, result.n_fixed


def count_designs(search: Search, keep: str, crew: WorkerPool, progress: Progress | None = None) -> DesignCount:
    """Count the designs selected by `--keep`, exactly; half-chains are joined without listing circuits."""
    if isinstance(search, FoldedSearch):
        shards = search.counting_shards
        if search.n_pairs < _SMALL_PAIRS and crew.scheduler is None:
            crew = WorkerPool()
    else:
        shards = search.prefixes
        if search.expected is not None and search.expected < SMALL_CIRCUIT_COUNT and crew.scheduler is None:
            crew = WorkerPool()
    classes = circuits = 0
    for done, (_, (shard_classes, shard_circuits)) in enumerate(crew.map_ordered(_Task(search, keep), shards), 1):
        classes += shard_classes
        circuits += shard_circuits
        if progress is not None:
            progress(done, len(shards), f"{classes:,} designs")
    return DesignCount(classes, circuits)


def counting_seconds(search: Search) -> float | None:
    """Estimate the core seconds of `count_designs`; None where it takes only seconds, or is unknown."""
    if not isinstance(search, FoldedSearch) or search.n_pairs < _SMALL_PAIRS:
        return None
    pairs = search.pairs.tolist()
    search.count(str(search.pairs.argmin()))  # compiles
    generator = random.Random(0)
    probed_pairs = elapsed = 0.0
    while elapsed < _PROBE_SECONDS:
        key = generator.choices(range(len(pairs)), weights=pairs)[0]
        parts = max(1, pairs[key] // _PROBE_PAIRS)
        search.half_chains(key)  # listed once for all parts
        start_time = time.perf_counter()
        search.count(f"{key}:{generator.randrange(parts)}/{parts}")
        elapsed += time.perf_counter() - start_time
        probed_pairs += pairs[key] / parts
    return elapsed / probed_pairs * search.n_pairs
