"""The lattice points around a start point (home), numbered for kernels, and canonical batches of listed circuits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.designs.grid import Grid, LatticePoint
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits.chains import UNREACHED_DISTANCE
from hcsearch.kernels.circuits.words import canonicalise


@dataclass(frozen=True, eq=False)
class LatticePlane(ByValue):
    """Lattice points within reach of home.

    moves : increment of a place's number by a step in each direction.
    distance : steps from home to each place, UNREACHED_DISTANCE beyond reach.
    home : the number of home, a triangle that points up where the tiling has two kinds.
    width : places in a row.
    """

    grid: Grid
    moves: NDArray[np.int64]
    distance: NDArray[np.int16]
    home: int
    width: int

    @staticmethod
    def around_home(grid: Grid, reach: int) -> LatticePlane:
        """Return the places within `reach` steps of home, and a margin of one step beyond."""
        radius = (reach + 1) * max(abs(v) for step in grid.steps for v in step)
        width = 2 * radius + 1
        distance = np.full(width * width, UNREACHED_DISTANCE, np.int16)
        start = (1, 1) if grid.is_triangle else (0, 0)
        home = radius * width + radius
        distance[home] = 0
        ring = [start]
        for step in range(1, reach + 1):
            outer = []
            for point in ring:
                for _, to in grid.neighbours(point):
                    at = home + (to[0] - start[0]) + (to[1] - start[1]) * width
                    if distance[at] == UNREACHED_DISTANCE:
                        distance[at] = step
                        outer.append(to)
            ring = outer
        return LatticePlane(grid, np.array([x + y * width for x, y in grid.steps]), distance, home, width)

    def point(self, place: int) -> LatticePoint:
        """Return the lattice point of a place, relative to home."""
        y, x = divmod(place, self.width)
        return (x - self.width // 2, y - self.width // 2)

    def place(self, point: LatticePoint) -> int:
        """Return the number of the place at a point relative to home."""
        return self.home + point[0] + point[1] * self.width


def canonical_batch(grid: Grid, words: NDArray[np.int8]) -> CircuitBatch:
    """Return the canonical circuits of words, one per class of squares, triangles or hexagons."""
    canonical, symmetry = np.empty_like(words), np.empty(len(words), np.int16)
    canonicalise(words, grid.directions, 1, canonical, symmetry)
    return split_by_axis(grid, CircuitBatch(grid.name, canonical, symmetry))


def split_by_axis(grid: Grid, batch: CircuitBatch) -> CircuitBatch:
    """Split classes on a grid without quarter turns: each circuit lying and standing, unless these are congruent."""
    if len(grid.first_directions) == 1:
        return batch
    both = np.concatenate([batch.words, (batch.words + 1) % grid.directions]).astype(np.int8)
    words, symmetry = np.empty_like(both), np.empty(len(both), np.int16)
    canonicalise(both, grid.directions, len(grid.first_directions), words, symmetry)
    lying, standing = words[: len(batch)], words[len(batch) :]
    keep = np.concatenate([np.ones(len(batch), bool), (lying != standing).any(axis=1)])
    return CircuitBatch(grid.name, words[keep], symmetry[keep])
