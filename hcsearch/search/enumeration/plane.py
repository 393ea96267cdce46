"""The lattice points around a start point (home), numbered for kernels, and canonical batches of listed circuits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.designs.grid import Grid, LatticePoint
from hcsearch.designs.grid.turning import step_tables
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits.chains import UNREACHED_DISTANCE
from hcsearch.kernels.circuits.words import canonicalise


@dataclass(frozen=True, eq=False)
class LatticePlane(ByValue):
    """The cells of a grid within reach of home, a cell of kind 0, numbered from (x, y, kind).

    moves : increment of a place's number by each step.
    kinds : kind of the cell at each place. distance : steps from home to each place, UNREACHED_DISTANCE beyond reach.
    home : the number of home.
    width : lattice points in a row.
    """

    grid: Grid
    moves: NDArray[np.int64]
    kinds: NDArray[np.uint8]
    distance: NDArray[np.int16]
    home: int
    width: int

    @staticmethod
    def around_home(grid: Grid, reach: int) -> LatticePlane:
        """Return the places within `reach` steps of home, and a margin of one step beyond."""
        width = 2 * (reach + 1) + 1
        kinds = np.tile(np.arange(grid.kinds, dtype=np.uint8), width * width)
        distance = np.full(len(kinds), UNREACHED_DISTANCE, np.int16)
        home = (reach + 1) * (width + 1) * grid.kinds
        place = LatticePlane(grid, np.empty(0, np.int64), kinds, distance, home, width).place
        moves = []
        for (kind, _), vector in zip(grid.step_kinds, grid.steps, strict=True):
            x, y = grid.point((0, 0, kind))
            moves.append(place((x + vector[0], y + vector[1])) - place((x, y)))
        distance[home] = 0
        ring = [home]
        for step in range(1, reach + 1):
            outer = []
            for at in ring:
                for leaving in grid.leaving[kinds[at]]:
                    to = at + moves[leaving]
                    if distance[to] == UNREACHED_DISTANCE:
                        distance[to] = step
                        outer.append(to)
            ring = outer
        return LatticePlane(grid, np.array(moves), kinds, distance, home, width)

    def point(self, place: int) -> LatticePoint:
        """Return the lattice point of a place."""
        cell, kind = divmod(place - self.home, self.grid.kinds)
        radius = self.width // 2
        y, x = divmod(cell + radius * (self.width + 1), self.width)
        return self.grid.point((x - radius, y - radius, kind))

    def place(self, point: LatticePoint) -> int:
        """Return the number of the place at a lattice point."""
        x, y, kind = (*self.grid.cell(point), 0)[:3]
        return self.home + (y * self.width + x) * self.grid.kinds + kind


def canonical_batch(grid: Grid, words: NDArray[np.int8]) -> CircuitBatch:
    """Return the canonical circuits of words, one for each class under the symmetries of the tiling."""
    canonical, symmetry = np.empty_like(words), np.empty(len(words), np.int16)
    canonicalise(words, step_tables(grid), 1, canonical, symmetry)
    return split_by_axis(grid, CircuitBatch(grid.name, canonical, symmetry))


def split_by_axis(grid: Grid, batch: CircuitBatch) -> CircuitBatch:
    """Split classes on a grid without quarter turns: each circuit lying and standing, unless these are congruent."""
    if grid.step_classes == 1:
        return batch
    both = np.concatenate([batch.words, (batch.words + 1) % grid.directions]).astype(np.int8)
    words, symmetry = np.empty_like(both), np.empty(len(both), np.int16)
    canonicalise(both, step_tables(grid), grid.step_classes, words, symmetry)
    lying, standing = words[: len(batch)], words[len(batch) :]
    keep = np.concatenate([np.ones(len(batch), bool), (lying != standing).any(axis=1)])
    return CircuitBatch(grid.name, words[keep], symmetry[keep])
