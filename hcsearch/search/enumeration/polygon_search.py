"""Enumeration of the circuits of n panels on any array, one per congruence class: self-avoiding polygons of n steps.

They run on the lattice points around a start point (home), which are numbered for kernels.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.basics.errors import SizeError, expect_kind
from hcsearch.designs.grid import Grid, LatticePoint
from hcsearch.designs.grid.turning import step_tables
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits.chains import UNREACHED_DISTANCE
from hcsearch.kernels.circuits.polygons import walk_polygons
from hcsearch.kernels.circuits.words import canonicalise
from hcsearch.search.enumeration.frontier_counts import expected_circuits


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


MAX_SEARCH_PANELS = 120

_LETTERS = "0123456789abcdefghijklmnopqrstuvwxyz"
_SHARD_SIZE = 10_000
_MAX_SHARDS = 20_000
_MAX_LISTED = 1e11


@dataclass(frozen=True)
class PolygonSearch:
    """All circuits of n panels on a grid, in shards named by prefixes: the first letters of the canonical turn word.

    For odd n on a grid of two colours, or where there is no circuit, the search is empty.

    Parameters
    ----------
    grid, n
        The grid, and the number of panels.

    Raises
    ------
    SizeError
        For fewer than 3 and for more than 120 panels.
    """

    grid: Grid
    n: int

    def __post_init__(self) -> None:
        expect_kind("the grid of a search", self.grid, Grid, "a Grid, such as GRIDS['hex']")
        check_length(self.n)
        if self.n > MAX_SEARCH_PANELS:
            raise SizeError(_too_large(self.grid, self.n, "or `count --array` for one array"))

    @property
    def lists(self) -> str:
        """Which circuits are listed, as `--keep` names them: `all`."""
        return "all"

    @property
    def target(self) -> str:
        """Notation of the searched array: empty, as the search covers all arrays."""
        return ""

    @property
    def group_order(self) -> int:
        """Order of the point group of the grid."""
        return len(self.grid.point_group)

    @property
    def expected(self) -> float:
        """Estimated number of circuits, from their published asymptotic growth."""
        return 0.0 if self._empty else expected_circuits(self.grid, self.n)

    @cached_property
    def prefixes(self) -> list[str]:
        """The keys of the shards, in order, which together contain every circuit once.

        Raises SizeError when there are more than about 1e11 circuits, too many to list them all.
        """
        if self._empty:
            return []
        if self.expected > _MAX_LISTED:
            about = f"or take some of the {self.expected:.0e} circuits with `enumerate_circuits` in Python"
            raise SizeError(_too_large(self.grid, self.n, about))
        words: list[tuple[int, ...]] = [()]
        depth = 0
        # the largest shards hold several times the mean, so the aim is lower
        while len(words) < min(4 * self.expected / _SHARD_SIZE, _MAX_SHARDS) and depth < self.n - 3:
            words = [longer for word in words for walk in self._walks(word) for longer in walk.extensions()]
            depth += 1
        return ["".join(_LETTERS[letter] for letter in word) for word in words]

    def circuits(self, prefix: str, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield the canonical circuits whose turn word begins with a prefix lazily, in batches up to `batch_size`."""
        if self._empty:
            return
        for walk in self._walks(tuple(map(_LETTERS.index, prefix))):
            while not walk.done and not walk.impossible:
                words, symmetry = walk.more(batch_size)
                if len(words):
                    batch = CircuitBatch(self.grid.name, words, symmetry)
                    yield split_by_axis(self.grid, batch)

    def batches(self, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield all canonical circuits lazily, in batches of at most `batch_size`."""
        return self.circuits("", batch_size)

    @property
    def _empty(self) -> bool:
        """Whether no circuit can have this length because the cells can be coloured in two colours."""
        return self.n % 2 == 1 and self.grid.has_two_colours

    def _walks(self, prefix: tuple[int, ...]) -> Iterator[_Walk]:
        """Yield the walks below a prefix, one for each first step of canonical words with it."""
        starts = step_tables(self.grid).starts.tolist()
        for start in dict.fromkeys([starts[prefix[0]]] if prefix else starts):
            if start >= 0:
                yield _Walk(self._plane, self.n, start, prefix)

    @cached_property
    def _plane(self) -> LatticePlane:
        return LatticePlane.around_home(self.grid, self.n // 2 + 1)


class _Walk:
    """The resumable state of a depth-first search below a prefix of turn letters."""

    def __init__(self, plane: LatticePlane, n: int, start: int, prefix: tuple[int, ...]) -> None:
        self.plane, self.n, self.prefix = plane, n, prefix
        self.steps = step_tables(plane.grid)
        self.letters = np.zeros(n + 1, np.int8)
        self.heading = np.zeros(n, np.int64)
        self.place = np.zeros(n + 1, np.int64)
        self.period = np.zeros(n + 1, np.int64)
        self.visited = np.zeros(len(plane.distance), np.uint8)
        self.place[0] = plane.home
        self.heading[0] = start
        self.place[1] = plane.home + plane.moves[start]
        self.visited[self.place[:2]] = 1
        self.impossible = False
        for k, letter in enumerate(prefix, 1):
            self.impossible |= not self._step(k, letter)
        self.state = np.array([len(prefix) + 1, 1, 0])
        # remaining steps from which a test for a way home pays: an enclosed walk would go on for about 3e5 steps
        self._trap = round(math.log(3e5) / math.log(plane.grid.connective_constant))

    @property
    def done(self) -> bool:
        return bool(self.state[2])

    def _step(self, k: int, letter: int) -> bool:
        """Take step k with a turn; False if the word is no prenecklace or the walk meets itself or cannot return."""
        before = self.period[k - 1]
        if k > 1 and letter < self.letters[k - before]:
            return False
        turn = letter - self.steps.first_codes[self.heading[k - 1]]
        if not 0 <= turn < self.steps.following.shape[1]:
            return False
        heading = self.steps.following[self.heading[k - 1], turn]
        to = self.place[k] + self.plane.moves[heading]
        if self.plane.distance[to] > self.n - 1 - k or self.visited[to]:
            return False
        self.letters[k], self.heading[k], self.place[k + 1] = letter, heading, to
        self.period[k] = k if k == 1 or letter != self.letters[k - before] else before
        self.visited[to] = 1
        return True

    def extensions(self) -> Iterator[tuple[int, ...]]:
        """Yield the feasible prefixes that are one letter longer."""
        k = len(self.prefix) + 1
        for letter in range(len(self.steps.code_turns)):
            if self._step(k, letter):
                self.visited[self.place[k + 1]] = 0
                yield (*self.prefix, letter)

    def more(self, size: int) -> tuple[NDArray[np.int8], NDArray[np.int16]]:
        """Return the words of the next circuits, and the orders of their symmetry groups (in the full point group)."""
        words, symmetry = np.empty((size, self.n), np.int8), np.empty(size, np.int16)
        plane = self.plane
        written = walk_polygons(
            self.steps,
            plane.moves,
            plane.distance,
            self.n,
            len(self.prefix),
            self._trap,
            self.letters,
            self.heading,
            self.place,
            self.period,
            self.visited,
            self.state,
            words,
            symmetry,
        )
        return words[:written].copy(), symmetry[:written].copy()


def check_length(n: int) -> None:
    """Check a number of panels; SizeError, with the remedy, below 3."""
    expect_kind("n", n, Integral, "a whole number of panels")
    if n < 3:
        raise SizeError(f"a circuit has at least 3 panels: --n {n} is too small, use --n 3 or more")


def _too_large(grid: Grid, n: int, otherwise: str) -> str:
    longest = max(m for m in range(4, MAX_SEARCH_PANELS, 2) if expected_circuits(grid, m) <= _MAX_LISTED)
    return f"--n {n} is too large to list on this grid: use --n {longest} or less, {otherwise}"
