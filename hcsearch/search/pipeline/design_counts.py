"""Counts of designs, without listing them where possible."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass

from hcsearch.search.enumeration import FoldedSearch, Search
from hcsearch.search.pipeline.shards import SMALL_CIRCUIT_COUNT, TransferableTask, cached_search, run_shard
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.search.stages.order import stage_keeping, stages_until
from hcsearch.system.work_steps import Progress

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
