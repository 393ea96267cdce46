"""Obvious twins of the kernels: slow, plain, and written without looking at them."""

import itertools
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import Array, Grid, LatticePoint

Corners = tuple[LatticePoint, ...]
"""A cell as its corners, the least first, in order around it: counterclockwise in coordinates."""
Drawn = frozenset[frozenset[Corners]]
"""A circuit as its pairs of neighbouring cells."""


def product(grid: Grid, a: LatticePoint, b: LatticePoint) -> int:
    """Twice the scalar product of two vectors on axes that meet at 60 or 90 degrees."""
    return 2 * (a[0] * b[0] + a[1] * b[1]) + (a[0] * b[1] + a[1] * b[0] if grid.axes == 6 else 0)


def area(corners: Sequence[LatticePoint]) -> int:
    """Twice the area of a polygon in units of the parallelogram of the axes, positive counterclockwise."""
    return sum(p[0] * q[1] - p[1] * q[0] for p, q in zip(corners, [*corners[1:], corners[0]], strict=True))


def mirrored(grid: Grid, point: LatticePoint, line: Sequence[LatticePoint]) -> LatticePoint:
    """Mirror image of a point in the line through two others; of a tiling's corners, one of its corners."""
    p, q = line
    side, away = (q[0] - p[0], q[1] - p[1]), (point[0] - p[0], point[1] - p[1])
    twice, square = 2 * product(grid, away, side), product(grid, side, side)
    assert twice * side[0] % square == twice * side[1] % square == 0
    return (p[0] + twice * side[0] // square - away[0], p[1] + twice * side[1] // square - away[1])


def drawn_cell(corners: Sequence[LatticePoint]) -> Corners:
    """A cell whose corners are given from anywhere in either order."""
    ring = list(corners) if area(corners) > 0 else list(reversed(corners))
    first = ring.index(min(ring))
    return tuple(ring[first:] + ring[:first])


@cache
def around(grid: Grid, cell: Corners) -> tuple[Corners, ...]:
    """The mirror images of a cell in its edges: edge i begins at corner i."""
    edges = zip(cell, cell[1:] + cell[:1], strict=True)
    return tuple(drawn_cell([mirrored(grid, corner, edge) for corner in cell]) for edge in edges)


def moved(cell: Corners, dx: int, dy: int) -> Corners:
    return tuple((x + dx, y + dy) for x, y in cell)


def distances(grid: Grid, start: Corners, reach: int) -> dict[Corners, int]:
    """The cells within some steps of one, and the steps to each."""
    steps, ring = {start: 0}, [start]
    for step in range(1, reach + 1):
        ring = list(dict.fromkeys(to for cell in ring for to in around(grid, cell) if to not in steps))
        steps |= dict.fromkeys(ring, step)
    return steps


@cache
def shapes(grid: Grid) -> tuple[Corners, ...]:
    """A cell of every shape that is no translate of another, the polygon first."""
    known: dict[Corners, Corners] = {}
    for cell in distances(grid, drawn_cell(grid.polygon), 12):
        known.setdefault(moved(cell, -cell[0][0], -cell[0][1]), cell)
    return tuple(known.values())


@cache
def isometries(grid: Grid) -> list[tuple[int, int, int, int]]:
    """The rotations and reflections (a, b, c, d) of the axes, but for quarter turns where panels are oblong."""
    turn, mirror = ((0, -1, 1, 1), (1, 1, 0, -1)) if grid.axes == 6 else ((0, -1, 1, 0), (1, 0, 0, -1))
    known, pending = set(), [(1, 0, 0, 1)]
    while pending:
        matrix = pending.pop()
        if matrix not in known:
            known.add(matrix)
            a, b, c, d = matrix
            pending += [(a * i + b * k, a * j + b * m, c * i + d * k, c * j + d * m) for i, j, k, m in (turn, mirror)]
    return [matrix for matrix in known if not grid.stretched or matrix[0]]


def mapped(matrix: tuple[int, int, int, int], cell: Corners) -> Corners:
    a, b, c, d = matrix
    return drawn_cell([(a * x + b * y, c * x + d * y) for x, y in cell])


def hamiltonian_circuits(array: Array) -> set[frozenset[frozenset[int]]]:
    """All Hamiltonian circuits of an array as edge sets, by backtracking from the first cell."""
    corners = [set(array.grid.lattice_corners(cell)) for cell in array.cells]
    neighbours: dict[int, set[int]] = {i: set() for i in range(array.n)}
    for u, v in itertools.combinations(range(array.n), 2):
        if len(corners[u] & corners[v]) == 2:
            neighbours[u].add(v)
            neighbours[v].add(u)
    circuits: set[frozenset[frozenset[int]]] = set()

    def walk(path: list[int]) -> None:
        if len(path) == array.n:
            if 0 in neighbours[path[-1]] and array.n > 2:
                closed = [*path, 0]
                circuits.add(frozenset(frozenset(pair) for pair in itertools.pairwise(closed)))
            return
        for to in neighbours[path[-1]] - set(path):
            walk([*path, to])

    walk([0])
    return circuits


def polygons(grid: Grid, n: int) -> set[Drawn]:
    """All circuits of n panels up to translation, by walks on cells that are reflected one from another."""
    circuits: set[Drawn] = set()

    def walk(path: list[Corners]) -> None:
        for to in around(grid, path[-1]):
            if len(path) == n and to == path[0] and n > 2:
                circuits.add(_to_origin([frozenset(pair) for pair in itertools.pairwise([*path, to])]))
            elif len(path) < n and to not in path and near.get(to, n) <= n - len(path):
                walk([*path, to])

    for start in shapes(grid):
        near = distances(grid, start, n // 2)
        walk([start])
    return circuits


def _to_origin(pairs: Sequence[frozenset[Corners]]) -> Drawn:
    x, y = min(cell[0] for pair in pairs for cell in pair)
    return frozenset(frozenset(moved(cell, -x, -y) for cell in pair) for pair in pairs)


def cells(circuit: Circuit) -> list[Corners]:
    """The cells of a circuit, drawn."""
    return [drawn_cell(circuit.grid.lattice_corners(cell)) for cell in circuit.cells]


def pairs(circuit: Circuit) -> Drawn:
    """A circuit as its pairs of neighbouring cells, moved to the origin."""
    drawn = cells(circuit)
    return _to_origin([frozenset(pair) for pair in zip(drawn, drawn[1:] + drawn[:1], strict=True)])


def congruent(grid: Grid, polygon: Drawn) -> set[Drawn]:
    """All images of a circuit under the symmetries of the tiling, moved to the origin."""
    return {
        _to_origin([frozenset(mapped(matrix, cell) for cell in pair) for pair in polygon])
        for matrix in isometries(grid)
    }


def creases(circuit: Circuit) -> list[tuple[LatticePoint, LatticePoint]]:
    """The ends of each crease: the corners that its panels share."""
    drawn = cells(circuit)
    shared = [tuple(sorted(set(a) & set(b))) for a, b in zip(drawn, drawn[1:] + drawn[:1], strict=True)]
    return [(p, q) for p, q in shared]


def _carried(circuit: Circuit, crease: int, way: int) -> tuple[LatticePoint, ...]:
    """The ends of a crease after reflections in the creases ahead of it (way 1) or behind it (-1), less than half."""
    edges, n = creases(circuit), circuit.n
    ends: tuple[LatticePoint, ...] = edges[crease]
    for t in range(1, n // 2):
        ends = tuple(mirrored(circuit.grid, end, edges[(crease + way * t) % n]) for end in ends)
    return ends


def folding_creases(circuit: Circuit) -> list[int]:
    """Creases in the first half whose two images coincide after the reflections of thesis section 3.2.1."""
    folding = []
    for j in range(circuit.n // 2 if circuit.n % 2 == 0 else 0):
        ahead, behind = _carried(circuit, j, 1), _carried(circuit, j, -1)
        assert set(ahead) != set(behind) or ahead == behind, "a half twist"
        if ahead == behind:
            folding.append(j)
    return folding


def creases_with_opposite_image(circuit: Circuit) -> Iterator[int]:
    """Creases j for which the forward image of crease j lies on crease j + n/2, as the theory says it must."""
    for j in folding_creases(circuit):
        if set(_carried(circuit, j, 1)) == set(creases(circuit)[j + circuit.n // 2]):
            yield j


def rotation(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation matrices of rotation vectors, (..., 3), by the exponential series of their cross product matrices."""
    x, y, z = np.moveaxis(np.asarray(vector, float), -1, 0)
    cross = np.stack([0 * x, -z, y, z, 0 * x, -x, -y, x, 0 * x], -1).reshape(*x.shape, 3, 3)
    total = term = np.broadcast_to(np.eye(3), cross.shape)
    for k in range(1, 60):
        term = term @ cross / k
        total = total + term
    return total


def around_the_loop(
    directions: NDArray[np.float64],
    points: NDArray[np.float64],
    loop: Sequence[tuple[int, int]],
    angles: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Products of the 4 x 4 matrices of the rotations about the hinges of a loop, at states (..., n)."""
    product = np.eye(4)
    for hinge, sign in loop:
        matrix = np.zeros((*angles.shape[:-1], 4, 4)) + np.eye(4)
        matrix[..., :3, :3] = rotation(sign * angles[..., hinge, None] * directions[hinge])
        matrix[..., :3, 3] = points[hinge] - matrix[..., :3, :3] @ points[hinge]
        product = product @ matrix
    return product


def cone_corners(columns: NDArray[np.float64]) -> set[tuple[float, ...]]:
    """Extreme rays of x >= 0 with sum x_i columns_i = 0, of sum 1, by trying all sets of hinges."""
    n = len(columns)
    rays: dict[frozenset[int], tuple[float, ...]] = {}
    for size in range(1, n + 1):
        for chosen in itertools.combinations(range(n), size):
            if any(known <= set(chosen) for known in rays):
                continue
            singular, vt = np.linalg.svd(columns[list(chosen)].T)[1:]
            if size - np.count_nonzero(singular > 1e-9) != 1:
                continue
            x = vt[-1] / vt[-1].sum() if abs(vt[-1].sum()) > 1e-9 else vt[-1]
            if x.min() > 1e-9:
                ray = np.zeros(n)
                ray[list(chosen)] = x
                rays[frozenset(chosen)] = tuple(ray.tolist())
    return set(rays.values())
