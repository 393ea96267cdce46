"""Counting designs without storing or even listing them, where half-chains make that possible."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from dataclasses import dataclass

from hcsearch.search.enumeration import FoldedSearch, Search
from hcsearch.search.pipeline.run import SMALL
from hcsearch.search.pipeline.shards import Travelling, run_shard, warm
from hcsearch.search.pipeline.workers import Crew
from hcsearch.search.stages.order import stage_keeping, stages_until

_SMALL_PAIRS = 2e9  # counted by one process in seconds
_PROBE_PAIRS = 100_000_000  # of one part of a key
_PROBE_SECONDS = 1.0


@dataclass(frozen=True)
class Counted:
    """Number of designs up to symmetry, and of circuits that these stand for: fixed ones, or those of the array."""

    classes: int
    circuits: int


@dataclass(frozen=True)
class _Task(Travelling):
    """Count the designs of one shard."""

    search: Search
    keep: str

    def __call__(self, shard: str) -> tuple[int, int]:
        search = warm(self.search)
        if isinstance(search, FoldedSearch):
            return search.count(shard)
        result = run_shard(search, shard, stages_until(stage_keeping(self.keep).name), "all")[1][-1]
        return result.passed, result.n_fixed


def count_designs(
    search: Search, keep: str, crew: Crew, progress: Callable[[int, int, str], None] | None = None
) -> Counted:
    """Count the designs that `--keep` names, exactly. Half-chains are joined without writing a circuit down."""
    if isinstance(search, FoldedSearch):
        shards = search.counting_shards
        if search.n_pairs < _SMALL_PAIRS and crew.scheduler is None:
            crew = Crew()
    else:
        shards = search.prefixes
        if search.expected is not None and search.expected < SMALL and crew.scheduler is None:
            crew = Crew()
    classes = circuits = 0
    for done, (_, (more, fixed)) in enumerate(crew.work(_Task(search, keep), shards), 1):
        classes += more
        circuits += fixed
        if progress is not None:
            progress(done, len(shards), f"{classes:,} designs")
    return Counted(classes, circuits)


def counting_seconds(search: Search) -> float | None:
    """About how many core seconds `count_designs` takes; None where that is a matter of seconds, or unknown."""
    if not isinstance(search, FoldedSearch) or search.n_pairs < _SMALL_PAIRS:
        return None
    pairs = search.pairs.tolist()
    search.count(str(search.pairs.argmin()))  # compiles
    chance = random.Random(0)
    tried = elapsed = 0.0
    while elapsed < _PROBE_SECONDS:
        key = chance.choices(range(len(pairs)), weights=pairs)[0]
        parts = max(1, pairs[key] // _PROBE_PAIRS)
        search.half_chains(key)  # listed once for all parts
        begun = time.perf_counter()
        search.count(f"{key}:{chance.randrange(parts)}/{parts}")
        elapsed += time.perf_counter() - begun
        tried += pairs[key] / parts
    return elapsed / tried * search.n_pairs
