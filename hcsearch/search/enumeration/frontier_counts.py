"""Exact counts of the circuits of an array without listing them, and the asymptotic growth of all circuits.

The number of classes is the mean, over the array's symmetries, of the number of circuits that each one fixes
(Burnside). These are counted on a smaller graph (docs/explanation/theory.md): for a reflection, the half array with an
additional vertex for the other half; for a rotation, the quotient graph, where a circuit must cross a cut from the
centre outwards an odd number of times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.errors import expect_kind
from hcsearch.designs.grid import Array, Grid, LatticeIsometry, LatticePoint
from hcsearch.kernels.circuits import frontier
from hcsearch.search.enumeration.array_circuits import array_sweep, frontier_layers, sweep_ranks
from hcsearch.search.enumeration.sweep import Sweep, plan_sweep
from hcsearch.system.work_steps import Progress


@dataclass(frozen=True)
class ArrayCount:
    """The result of `count_array`.

    Parameters
    ----------
    circuits
        The number of Hamiltonian circuits.
    classes
        Their number up to the symmetries of the array.
    symmetry
        The order of the symmetry group of the array.
    """

    circuits: int
    classes: int
    symmetry: int


def count_array(array: Array, progress: Progress | None = None) -> ArrayCount:
    """Count the circuits of an array without listing them, in exact integers of any size.

    Parameters
    ----------
    array
        The array; its cells are the vertices of the graph.
    progress
        Called after each edge with the numbers of edges done and in all, and the number of states as a text.

    Returns
    -------
    ArrayCount
        The number of circuits and of their classes.

    Raises
    ------
    SizeError
        When the frontier that sweeps over the array is wider than 24 cells.

    Examples
    --------
    >>> from hcsearch import count_array, parse_array
    >>> count_array(parse_array("square", "6x5"))
    ArrayCount(circuits=154, classes=44, symmetry=4)
    """
    expect_kind("the array to count on", array, Array, "an Array, such as parse_array('hex', '3-4-3')")
    circuits = count_cycles(array_sweep(array), progress=progress)
    symmetries = array.symmetries()
    if not circuits:
        return ArrayCount(0, 0, len(symmetries))
    fixed: dict[int, int] = {}  # circuits that the rotations of each order fix
    total = circuits
    for symmetry in symmetries[1:]:
        isometry, _ = symmetry
        if isometry.sign < 0:
            total += _count_mirrored(array, _images(array, symmetry), progress)
            continue
        order = array.grid.directions // math.gcd(isometry.offset, array.grid.directions)
        if order not in fixed:
            generator = next(g for g in symmetries if g[0].sign > 0 and g[0].offset == array.grid.directions // order)
            fixed[order] = _count_rotated(array, generator[0], _images(array, generator), progress)
        total += fixed[order]
    classes, rest = divmod(total, len(symmetries))
    assert rest == 0, "the fixed circuits do not add up to whole classes"
    return ArrayCount(circuits, classes, len(symmetries))


def count_cycles(sweep: Sweep | None, *, odd: bool = False, progress: Progress | None = None) -> int:
    """Count the Hamiltonian cycles of a planned graph.

    odd : whether to count cycles with an odd number of marked edges, else cycles with an even number.
    """
    if sweep is None:
        return 0
    counts = np.ones((1, 1), np.int64)
    total = 0
    for done, (child, size) in enumerate(frontier_layers(sweep, odd=odd), 1):
        next_counts = np.zeros((size, counts.shape[1]), np.int64)
        closed = np.zeros(counts.shape[1], np.int64)
        frontier.add_counts(child, counts, next_counts, closed)
        total += sum(int(limb) << 32 * place for place, limb in enumerate(closed))
        if frontier.carry_limbs(next_counts):
            next_counts = np.column_stack([next_counts, np.zeros(size, np.int64)])
            frontier.carry_limbs(next_counts)
        counts = next_counts
        if progress is not None:
            progress(done, len(sweep.order), f"{size:,} states")
    return total


def _images(array: Array, symmetry: tuple[LatticeIsometry, LatticePoint]) -> list[int]:
    """Return a symmetry as a permutation of the cells."""
    isometry, (dx, dy) = symmetry
    index = {point: i for i, point in enumerate(array.points)}
    return [index[x + dx, y + dy] for x, y in map(isometry, array.points)]


def _count_mirrored(array: Array, image: list[int], progress: Progress | None) -> int:
    """Count the circuits fixed by a reflection: cycles of one half and the axis, plus a vertex for the other half."""
    points = array.points
    axis = [i for i in range(array.n) if image[i] == i]
    if len(axis) > 2:
        return 0
    # the vectors from mirror images to their originals are parallel: their direction gives the side
    half = [i for i in range(array.n) if image[i] != i and points[i] > points[image[i]]]
    vertices = half + axis
    vertex_of = {i: k for k, i in enumerate(vertices)}
    apex = len(vertices)
    edges: list[tuple[int, int]] = []
    for u, v, _ in array.edges():
        if image[u] == v:
            inside = u if u in vertex_of else v
            edges.append((vertex_of[inside], apex))
        elif u in vertex_of and v in vertex_of and not (u in axis and v in axis):
            edges.append((vertex_of[u], vertex_of[v]))
    forced = frozenset(range(len(edges), len(edges) + len(axis)))
    edges.extend((vertex_of[i], apex) for i in axis)
    if not _all_meet_two(edges, apex + 1):
        return 0
    ranks = []
    for point_ranks in sweep_ranks(array.grid, tuple(points[i] for i in vertices)):
        ranks.append([*(2 * r for r in point_ranks), -1])
        ranks.append([*(2 * r for r in point_ranks), 2 * len(vertices)])
    return count_cycles(plan_sweep(apex + 1, edges, ranks, forced=forced), progress=progress)


def _count_rotated(array: Array, rotation: LatticeIsometry, image: list[int], progress: Progress | None) -> int:
    """Count the circuits fixed by a rotation by 2 pi / m: cycles of the quotient graph that wind once round the centre.

    A circuit winds 0 or 1 times, so the parity of its crossings of a cut from the centre outwards decides.
    """
    orbits = _orbits(image)
    m = max(map(len, orbits))
    if min(map(len, orbits)) < m:  # a cell at the centre would be a fixed point of the circuit, which is impossible
        return 0
    points = array.points
    firsts: list[int] = []  # the cell of each orbit in the sector between the cut and its image
    home: dict[int, tuple[int, int]] = {}  # cell -> (orbit, number of rotations from that cell)
    for k, orbit in enumerate(orbits):
        centre = (sum(points[i][0] for i in orbit), sum(points[i][1] for i in orbit))
        first = next(
            place
            for place, i in enumerate(orbit)
            if _in_sector((m * points[i][0] - centre[0], m * points[i][1] - centre[1]), rotation)
        )
        firsts.append(orbit[first])
        home.update({cell: (k, (place - first) % m) for place, cell in enumerate(orbit)})
    crossings = set()
    loops = False
    for u, v, _ in array.edges():
        (a, i), (b, j) = sorted((home[u], home[v]))
        if a != b:
            crossings.add((a, b, (j - i) % m))
        elif 2 * (j - i) % m:  # otherwise the edge runs through the centre, where a circuit cannot pass
            loops = True
    if len(orbits) == 1:
        return int(loops)
    edges = [(a, b) for a, b, _ in sorted(crossings)]
    marked = frozenset(k for k, (_, _, turns) in enumerate(sorted(crossings)) if turns)
    if not _all_meet_two(edges, len(orbits)):
        return 0
    ranks = sweep_ranks(array.grid, tuple(points[i] for i in firsts))
    return count_cycles(plan_sweep(len(orbits), edges, ranks, marked=marked), odd=True, progress=progress)


def _orbits(image: list[int]) -> list[list[int]]:
    """Return the orbits of the cells under a permutation, each in the order of its powers."""
    orbits = []
    remaining = set(range(len(image)))
    while remaining:
        orbit = [min(remaining)]
        while image[orbit[-1]] != orbit[0]:
            orbit.append(image[orbit[-1]])
        remaining -= set(orbit)
        orbits.append(orbit)
    return orbits


def _in_sector(vector: LatticePoint, rotation: LatticeIsometry) -> bool:
    """Whether a vector from the centre lies between the first lattice axis (included) and its image (excluded)."""
    x, y = vector
    rx, ry = rotation((1, 0))
    return ((y > 0 or (y == 0 and x > 0)) and x * ry - y * rx > 0) or (y == 0 and x > 0)


def _all_meet_two(edges: list[tuple[int, int]], n_vertices: int) -> bool:
    degree = np.bincount(np.array(edges, np.int64).ravel(), minlength=n_vertices)
    return bool(degree.min() >= 2)


def expected_circuits(grid: Grid, n: int) -> float:
    """Estimate the number of circuits of n panels up to symmetry, within a few per cent from n = 16 on.

    Where twelve panels meet in a corner, so that numbers rise and fall, it is within 20 per cent from n = 36 on.
    """
    circuits: float = grid.amplitude * grid.connective_constant**n / n**2.5
    return circuits / len(grid.point_group)
