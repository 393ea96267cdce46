"""Obvious twins of the kernels: slow, plain, and written without looking at them."""

import itertools
from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import Array, Grid, LatticePoint

Vector = tuple[Fraction, Fraction]


def hamiltonian_circuits(array: Array) -> set[frozenset[frozenset[int]]]:
    """All Hamiltonian circuits of an array as edge sets, by backtracking from the first cell."""
    neighbours: dict[int, set[int]] = {i: set() for i in range(array.n)}
    for u, v, _ in array.edges():
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


def polygons(grid: Grid, n: int) -> set[frozenset[frozenset[LatticePoint]]]:
    """All self-avoiding polygons of n steps up to translation, as sets of pairs of lattice points."""
    starts = [grid.point((0, 0, 0)), grid.point((0, 0, 1))] if grid.is_triangle else [(0, 0)]
    circuits: set[frozenset[frozenset[LatticePoint]]] = set()

    def walk(path: list[LatticePoint]) -> None:
        for _, to in grid.neighbours(path[-1]):
            if len(path) == n and to == path[0] and n > 2:
                circuits.add(_to_origin(grid, [*path, to]))
            elif len(path) < n and to not in path and _distance(grid, to, path[0]) <= n - len(path):
                walk([*path, to])

    for start in starts:
        walk([start])
    return circuits


def _distance(grid: Grid, a: LatticePoint, b: LatticePoint) -> float:
    """A lower bound of the number of steps between two points."""
    x, y = a[0] - b[0], a[1] - b[1]
    if grid.directions == 4:
        return abs(x) + abs(y)
    return max(abs(x), abs(y), abs(x + y)) / (2 if grid.is_triangle else 1)


def _to_origin(grid: Grid, path: list[LatticePoint]) -> frozenset[frozenset[LatticePoint]]:
    unit = 3 if grid.is_triangle else 1
    x0, y0 = min(p[0] // unit for p in path) * unit, min(p[1] // unit for p in path) * unit
    moved = [(x - x0, y - y0) for x, y in path]
    return frozenset(frozenset(pair) for pair in itertools.pairwise(moved))


def pairs(circuit: Circuit) -> frozenset[frozenset[LatticePoint]]:
    """A circuit as a set of pairs of lattice points, moved to the origin."""
    return _to_origin(circuit.grid, [*circuit.points, circuit.points[0]])


def congruent(grid: Grid, polygon: frozenset[frozenset[LatticePoint]]) -> set[frozenset[frozenset[LatticePoint]]]:
    """All images of a polygon under the point group, moved to the origin."""
    unit = 3 if grid.is_triangle else 1
    images = set()
    for isometry in grid.point_group:
        moved = [tuple(map(isometry, pair)) for pair in polygon]
        x0 = min(p[0] // unit for pair in moved for p in pair) * unit
        y0 = min(p[1] // unit for pair in moved for p in pair) * unit
        images.add(frozenset(frozenset((x - x0, y - y0) for x, y in pair) for pair in moved))
    return images


def _dot(grid: Grid, a: Vector, b: Vector) -> Fraction:
    """Scalar product in lattice coordinates: the axes meet at 60 degrees unless cells are squares."""
    skew = 0 if grid.directions == 4 else Fraction(1, 2)
    return a[0] * b[0] + a[1] * b[1] + skew * (a[0] * b[1] + a[1] * b[0])


def _reflect(grid: Grid, point: Vector, crease: tuple[LatticePoint, LatticePoint]) -> Vector:
    """Mirror image in the edge between two neighbouring cells."""
    p, q = crease
    normal = (Fraction(q[0] - p[0]), Fraction(q[1] - p[1]))
    middle = (Fraction(p[0] + q[0], 2), Fraction(p[1] + q[1], 2))
    away = (point[0] - middle[0], point[1] - middle[1])
    factor = 2 * _dot(grid, away, normal) / _dot(grid, normal, normal)
    return (point[0] - factor * normal[0], point[1] - factor * normal[1])


def _edge_vector(grid: Grid, crease: tuple[LatticePoint, LatticePoint]) -> tuple[Vector, Vector]:
    """The edge between two cells as two different points of it, in a fixed order."""
    p, q = crease
    x, y = Fraction(q[0] - p[0]), Fraction(q[1] - p[1])
    # perpendicular to (x, y): for axes at 60 degrees (-x - 2y, 2x + y), for squares (-y, x); any scale will do
    across = (-y, x) if grid.directions == 4 else (-(x + 2 * y), 2 * x + y)
    middle = (Fraction(p[0] + q[0], 2), Fraction(p[1] + q[1], 2))
    return middle, (middle[0] + across[0] / 10, middle[1] + across[1] / 10)


def folding_creases(circuit: Circuit) -> list[int]:
    """Creases in the first half whose two images coincide after the reflections of thesis section 3.2.1."""
    n, points = circuit.n, circuit.points
    creases = [(points[k], points[(k + 1) % n]) for k in range(n)]
    folding = []
    for j in range(n // 2 if n % 2 == 0 else 0):
        ahead = behind = _edge_vector(circuit.grid, creases[j])
        for t in range(1, n // 2):
            ahead = tuple(_reflect(circuit.grid, point, creases[(j + t) % n]) for point in ahead)  # type: ignore[assignment]
            behind = tuple(_reflect(circuit.grid, point, creases[(j - t) % n]) for point in behind)  # type: ignore[assignment]
        assert set(ahead) != set(behind) or ahead == behind, "a half twist"
        if ahead[0] == behind[0]:
            assert ahead == behind, "a half twist"
            folding.append(j)
    return folding


def creases_with_opposite_image(circuit: Circuit) -> Iterator[int]:
    """Creases j for which the forward image of crease j lies on crease j + n/2, as the theory says it must."""
    n, points = circuit.n, circuit.points
    for j in folding_creases(circuit):
        image = _edge_vector(circuit.grid, (points[j], points[(j + 1) % n]))[0]
        for t in range(1, n // 2):
            image = _reflect(circuit.grid, image, (points[(j + t) % n], points[(j + t + 1) % n]))
        p, q = points[(j + n // 2) % n], points[(j + n // 2 + 1) % n]
        if image == (Fraction(p[0] + q[0], 2), Fraction(p[1] + q[1], 2)):
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
