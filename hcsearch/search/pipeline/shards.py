"""The work on one shard, a part of a search that is stored as a whole: the stages that depend on no scene."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.equality import ByValue
from hcsearch.designs.records import DesignBatch, StagedDesigns, StageResult
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES
from hcsearch.search.enumeration import Search
from hcsearch.search.pipeline.rows import array_fingerprints, design_rows
from hcsearch.search.stages.circuits import listed
from hcsearch.search.stages.stage import Stage, run_stages


class Travelling:
    """A task that goes to other processes."""

    search: Search

    def __getstate__(self) -> dict[str, object]:
        """Without the tables of the search: they may be large, and the other process computes them again."""
        return self.__dict__ | {"search": replace(self.search)}


@dataclass(frozen=True)
class ShardJob(Travelling):
    """The work on every shard of a run.

    stages : those to run; keep : which designs to keep.
    rows : whether the rows for the store are wanted, or only the fingerprints of the arrays. candidates : whether the
    designs are wanted whose motion is to be looked for.
    """

    search: Search
    stages: tuple[Stage, ...]
    keep: str
    rows: bool
    candidates: bool = False

    def __call__(self, prefix: str) -> Output:
        """Work on one shard."""
        search = warm(self.search)
        designs, results = run_shard(search, prefix, self.stages, self.keep)
        rows = design_rows(search, designs) if self.rows else None
        arrays = None if self.rows else array_fingerprints(search, designs.circuits)
        candidates = candidates_of(designs) if self.candidates else None
        return Output(results, len(designs), rows, arrays, candidates)


@lru_cache(maxsize=2)
def warm(search: Search) -> Search:
    """The first search given that equals this one: its tables are computed already."""
    return search


@dataclass(frozen=True, eq=False)
class Output(ByValue):
    """What a shard gives back: the stages' results, how many designs are kept, and either rows or fingerprints.

    candidates : for motions and deployments; None where none are wanted.
    """

    results: tuple[StageResult, ...]
    kept: int
    rows: DesignBatch | None
    arrays: NDArray[np.uint64] | None
    candidates: StagedDesigns | None


def run_shard(
    search: Search, prefix: str, stages: tuple[Stage, ...], keep: str
) -> tuple[StagedDesigns, tuple[StageResult, ...]]:
    """Run stages on one shard of a search; designs that are not to be kept are dropped on the way."""
    begun = time.perf_counter()
    return run_stages(listed(search, prefix), stages, SCENES[DEFAULT_SCENE_NAME], keep, begun)


def candidates_of(designs: StagedDesigns) -> StagedDesigns:
    """The designs whose motion is to be looked for: those with an untwisted folding, and these foldings alone."""
    assert designs.twists is not None
    plain = designs.twists == 0
    return designs.take(designs.with_folding(plain), plain)
