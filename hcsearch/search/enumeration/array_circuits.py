"""Enumeration of the circuits of one array, one per class under its symmetries, without dead ends.

The frontier states of a sweep form a layered graph whose paths are the circuits. Its last layers are stored as tails,
the edge sets that complete a state; the first ones are traversed, and each path is joined with the tails of the state
that it reaches. Circuits are numbered in this order, and the search can start at any number.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import ByValue
from hcsearch.basics.errors import SizeError, expect_kind
from hcsearch.designs.grid import Array, Grid, LatticePoint
from hcsearch.designs.grid.turning import step_tables
from hcsearch.designs.records import CircuitBatch
from hcsearch.kernels.circuits import frontier
from hcsearch.kernels.circuits.words import canonicalise
from hcsearch.search.enumeration.sweep import Sweep, plan_sweep

MAX_FRONTIER_STATES = 30_000_000  # states of all layers, to list circuits: 0.7 GB
MAX_LAYER_ENTRIES = 40_000_000  # entries of one layer, to count: 6 GB; 16 x 16 squares stay below, 17 x 18 do not
_MAX_TAILS = 1 << 16
_SHARD_SIZE = 1 << 15


@dataclass(frozen=True)
class ArraySearch:
    """All circuits of one array, in shards named by prefixes: the number of each shard's first circuit.

    For an array without circuits the search is empty.

    Parameters
    ----------
    array
        The searched array.

    Raises
    ------
    SizeError
        For an array that is too wide to list.
    """

    array: Array

    def __post_init__(self) -> None:
        expect_kind("the array of a search", self.array, Array, "an Array, such as parse_array('hex', '3-4-3')")

    @property
    def grid(self) -> Grid:
        """The array's grid."""
        return self.array.grid

    @property
    def n(self) -> int:
        """Number of panels."""
        return self.array.n

    @property
    def lists(self) -> str:
        """Which circuits are listed, as `--keep` names them: `all`."""
        return "all"

    @cached_property
    def target(self) -> str:
        """The notation of the searched array, in its canonical position."""
        return self.array.canonical().notation

    @cached_property
    def group_order(self) -> int:
        """Order of the array's symmetry group."""
        return self.array.symmetry

    @cached_property
    def n_circuits(self) -> int:
        """The number of circuits, congruent ones counted separately, saturated at 2^61."""
        return 0 if self._dag is None else self._dag.total

    @property
    def expected(self) -> float:
        """Estimated number of listed circuits: most have no symmetry."""
        return self.n_circuits / self.group_order

    @cached_property
    def prefixes(self) -> list[str]:
        """The keys of the shards: the number of each shard's first circuit, as a text."""
        if self.n_circuits >= 10**12:
            raise SizeError(
                f"the array has {'over ' if self.n_circuits >= frontier.SATURATED_COUNT else ''}{self.n_circuits} "
                "circuits, "
                "too many to store: use `hcsearch count`, or take some of them with `enumerate_circuits` in Python"
            )
        return [str(first) for first in range(0, self.n_circuits, _SHARD_SIZE)]

    def circuits(self, prefix: str, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield the canonical circuits of a shard lazily, in batches of at most `batch_size`."""
        first = int(prefix)
        return self._between(first, min(first + _SHARD_SIZE, self.n_circuits), batch_size)

    def batches(self, batch_size: int = 1 << 16) -> Iterator[CircuitBatch]:
        """Yield all canonical circuits lazily, in batches of at most `batch_size`."""
        return self._between(0, self.n_circuits, batch_size)

    def _between(self, first: int, last: int, batch_size: int) -> Iterator[CircuitBatch]:
        if self._dag is None:
            return
        steps = step_tables(self.grid)
        for masks, symmetry in self._dag.masks(first, last, batch_size):
            words = np.empty((len(masks), self.n), np.int8)
            frontier.trace_masks(masks, self._dag.edges, steps.back, words)
            canonical, order = np.empty_like(words), np.empty(len(words), np.int16)
            canonicalise(words, steps, self.grid.step_classes, canonical, order)
            yield CircuitBatch(self.grid.name, canonical, symmetry)

    def masks(self, batch_size: int = 1 << 16) -> Iterator[tuple[NDArray[np.uint64], NDArray[np.int16]]]:
        """Yield one circuit of each class as bits of edges, from bit 63 of the first word, and its symmetry order."""
        if self._dag is not None:
            yield from self._dag.masks(0, self._dag.total, batch_size)

    @cached_property
    def _dag(self) -> _Dag | None:
        return _build_dag(self.array)


@dataclass(frozen=True, eq=False)
class _Dag(ByValue):
    """The layered graph of frontier states, and the tails below one of its layers.

    offsets : number of the first state of each layer. child, counts : as in `kernels.circuits.frontier`, with all
        layers concatenated.
    edges : shape (n_edges, 3), cells and step of each edge, in the sweep's order.
    permutations : shape (order of the group - 1, n_edges), actions of the array's symmetries on the edges.
    start, tails, tail_images : the tails of layer `layer`.
    """

    offsets: NDArray[np.int64]
    child: NDArray[np.int32]
    counts: NDArray[np.int64]
    edges: NDArray[np.int64]
    permutations: NDArray[np.int32]
    layer: int
    start: NDArray[np.int64]
    tails: NDArray[np.uint64]
    tail_images: NDArray[np.uint64]

    @property
    def total(self) -> int:
        return int(self.counts[0])

    def masks(self, first: int, last: int, batch_size: int) -> Iterator[tuple[NDArray[np.uint64], NDArray[np.int16]]]:
        """Yield the least edge set and the symmetry of each class among circuits number first .. last - 1."""
        rank = np.array([first, last])
        masks = np.empty((batch_size, self.tails.shape[1]), np.uint64)
        symmetry = np.empty(batch_size, np.int16)
        while rank[0] < rank[1]:
            written = frontier.list_masks(
                self.layer,
                self.offsets,
                self.child,
                self.counts,
                self.permutations,
                self.start,
                self.tails,
                self.tail_images,
                rank,
                masks,
                symmetry,
            )
            if written:
                yield masks[:written].copy(), symmetry[:written].copy()


def array_sweep(array: Array) -> Sweep | None:
    """Plan a sweep over the array's grid graph; None below three cells or for a cell with under two neighbours."""
    edges = [(u, v) for u, v, _ in array.edges()]
    degree = np.bincount(np.array(edges, np.int64).ravel(), minlength=array.n)
    if array.n < 3 or degree.min() < 2:
        return None
    return plan_sweep(array.n, edges, sweep_ranks(array.grid, array.points))


def sweep_ranks(grid: Grid, points: tuple[LatticePoint, ...]) -> list[list[int]]:
    """Return ranks of points along sweeps by rows and diagonals, for every isometry of the tiling's point group."""
    ranks = []
    for isometry in grid.tiling.point_group:
        moved = [isometry(p) for p in points]
        rows = [(grid.lattice_row(point), point[0]) for point in moved]
        diagonals = [(x + y, x) for x, y in moved]
        levels = [(y, x) for x, y in moved]
        for keys in (rows, diagonals, levels) if grid.kinds > 2 else (rows, diagonals):
            order = sorted(range(len(points)), key=keys.__getitem__)
            rank = [0] * len(points)
            for place, i in enumerate(order):
                rank[i] = place
            ranks.append(rank)
    return ranks


def _build_dag(array: Array) -> _Dag | None:
    sweep = array_sweep(array)
    if sweep is None:
        return None
    layers = _children(sweep)
    if layers is None:
        return None
    n_edges = len(layers)
    counts = [np.zeros(1, np.int64)]
    for child in reversed(layers):
        counts.append(np.empty(len(child), np.int64))
        frontier.count_completions(child, counts[-2], counts[-1])
    counts.reverse()
    if counts[0][0] == 0:
        return None
    offsets = np.cumsum([0] + [len(child) for child in layers])
    child = np.concatenate(layers)
    joined = np.concatenate(counts[:-1])
    # circuits may close at any edge of the last cell, so tails start before those edges
    last_cell = int(np.flatnonzero(sweep.steps[:, frontier.SWEEP_ENTERED])[0])
    sizes = [min(int(c.clip(max=_MAX_TAILS + 1).sum()), _MAX_TAILS + 1) for c in counts[: last_cell + 1]]
    layer = next((k for k, size in enumerate(sizes) if size <= _MAX_TAILS), last_cell)
    n_tails = int(counts[layer].sum())
    words = (n_edges + 63) // 64
    start = np.empty(len(counts[layer]) + 1, np.int64)
    tails = np.zeros((n_tails, words), np.uint64)
    frontier.list_completions(layer, offsets, child, joined, start, tails)
    permutations = _edge_permutations(array, sweep)
    images = np.zeros((n_tails, len(permutations), words), np.uint64)
    frontier.permute_masks(tails, permutations, images)
    graph_edges = np.array(array.edges())
    return _Dag(offsets, child, joined, graph_edges[list(sweep.order)], permutations, layer, start, tails, images)


def _children(sweep: Sweep) -> list[NDArray[np.int32]] | None:
    """Return the children of every layer's states; None when no state survives. SizeError beyond MAX_STATES."""
    layers = []
    total = 0
    for child, _ in frontier_layers(sweep):
        total += len(child)
        if total > MAX_FRONTIER_STATES:
            raise SizeError(
                f"the array is too wide to list (more than {MAX_FRONTIER_STATES} frontier states): "
                "use `hcsearch count` for it"
            )
        layers.append(child)
    return layers if len(layers) == len(sweep.order) else None


def frontier_layers(sweep: Sweep, *, odd: bool = False) -> Iterator[tuple[NDArray[np.int32], int]]:
    """Decide edges in order; yield each layer's children and the number of states after it, until no state is left.

    odd : whether cycles have an odd number of marked edges, else an even one.
    Raises SizeError beyond MAX_LAYER states.
    """
    lo, hi = np.zeros(1, np.uint64), np.zeros(1, np.uint64)
    for step, (full_lo, full_hi) in zip(sweep.steps, sweep.full, strict=True):
        room = 2 * len(lo)
        table = np.full(1 << max(4, (2 * room - 1).bit_length()), -1, np.int32)
        next_lo, next_hi = np.empty(room, np.uint64), np.empty(room, np.uint64)
        child = np.empty((len(lo), 2), np.int32)
        goal = full_lo | frontier.PARITY_BIT if odd else full_lo
        size = frontier.advance_states(step, goal, full_hi, lo, hi, table, next_lo, next_hi, child)
        yield child, size
        if size == 0:
            return
        if size > MAX_LAYER_ENTRIES:
            raise SizeError(
                f"the array is too wide: over {MAX_LAYER_ENTRIES // 10**6} million frontier states at once; "
                "take a narrower one"
            )
        lo, hi = next_lo[:size].copy(), next_hi[:size].copy()


def _edge_permutations(array: Array, sweep: Sweep) -> NDArray[np.int32]:
    """Return the permutation of the edges, in the sweep's order, by each symmetry of the array but the identity."""
    listed = array.edges()
    points = array.points
    place = {array.grid.edge(points[listed[e][0]], points[listed[e][1]]): k for k, e in enumerate(sweep.order)}
    permutations = []
    for isometry, (dx, dy) in array.symmetries()[1:]:
        row = np.empty(len(place), np.int32)
        for (x, y), k in place.items():
            mx, my = isometry((x, y))
            row[k] = place[mx + 2 * dx, my + 2 * dy]
        permutations.append(row)
    return np.array(permutations, np.int32).reshape(-1, len(place))
