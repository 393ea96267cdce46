"""Congruence classes of listed circuits: canonical words, and what rectangles add to squares."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.grid import Grid
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits.words import canonicalise


def canonical_batch(grid: Grid, words: NDArray[np.int8]) -> CircuitBatch:
    """The canonical circuits of some words, one of each class of squares, triangles or hexagons."""
    canonical, symmetry = np.empty_like(words), np.empty(len(words), np.int16)
    canonicalise(words, grid.directions, 1, canonical, symmetry)
    return split_by_axis(grid, CircuitBatch(grid.name, canonical, symmetry))


def split_by_axis(grid: Grid, batch: CircuitBatch) -> CircuitBatch:
    """The classes of a grid without quarter turns: each circuit lying and standing, unless those are congruent."""
    if len(grid.first_directions) == 1:
        return batch
    both = np.concatenate([batch.words, (batch.words + 1) % grid.directions]).astype(np.int8)
    words, symmetry = np.empty_like(both), np.empty(len(both), np.int16)
    canonicalise(both, grid.directions, len(grid.first_directions), words, symmetry)
    lying, standing = words[: len(batch)], words[len(batch) :]
    keep = np.concatenate([np.ones(len(batch), bool), (lying != standing).any(axis=1)])
    return CircuitBatch(grid.name, words[keep], symmetry[keep])
