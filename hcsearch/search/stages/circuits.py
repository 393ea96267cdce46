"""Stage `circuits`: Hamiltonian circuits, one per congruence class, as listed by a search."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.records import CircuitBatch, StagedDesigns
from hcsearch.scenes import Scene
from hcsearch.search.enumeration import Search
from hcsearch.search.stages.stage import Stage


def list_shard_circuits(search: Search, prefix: str) -> StagedDesigns:
    """Return all circuits of one shard of a search."""
    batches = list(search.circuits(prefix))
    circuits = CircuitBatch(search.grid.name, np.empty((0, search.n), np.int8), np.empty(0, np.int16))
    if batches:
        words = np.concatenate([batch.words for batch in batches])
        circuits = CircuitBatch(search.grid.name, words, np.concatenate([batch.symmetry for batch in batches]))
    return StagedDesigns(circuits, search.group_order // circuits.symmetry.astype(np.int64))


def _run(designs: StagedDesigns, _scene: Scene) -> StagedDesigns:
    """Return the circuits unchanged."""
    return designs


def _passed(designs: StagedDesigns, _scene: Scene) -> NDArray[np.bool_]:
    return np.ones(len(designs), bool)


STAGE = Stage("circuits", 1, _run, _passed, keep="all", funnel_column="circuits")
