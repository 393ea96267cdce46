"""Edge tessellations: the kinds of cells, the lattice and the steps that follow from one polygon by reflections.

Coordinates are whole numbers on two axes that enclose 60 or 90 degrees. All symmetries of the axes fix the origin, and
all are symmetries of a tiling, so that the origin is a centre of its greatest symmetry.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

LatticePoint = tuple[int, int]
Matrix = tuple[int, int, int, int]
Polygon = tuple[LatticePoint, ...]


class Step(NamedTuple):
    """A step across an edge: the angle of its direction in degrees, the kinds of cells, and the vector between them."""

    angle: int
    kind: int
    target: int
    vector: LatticePoint


class Tessellation(NamedTuple):
    """A tiling of the plane by mirror images of one polygon.

    scale : units of corners per unit of lattice points, in which cells and steps are placed.
    lattice : the two shortest translations, as lattice points. kinds : the corners of the cell of each kind at home,
        counterclockwise, the edge with the least direction first; kind 0 is the polygon itself.
    places : lattice points of these cells. steps : in the order of their angles, then of kinds.
    """

    scale: int
    lattice: tuple[LatticePoint, LatticePoint]
    kinds: tuple[Polygon, ...]
    places: tuple[LatticePoint, ...]
    steps: tuple[Step, ...]


def mapped(matrix: Matrix, point: LatticePoint) -> LatticePoint:
    """The image of a point under a matrix (a, b, c, d): (a X + b Y, c X + d Y)."""
    a, b, c, d = matrix
    x, y = point
    return (a * x + b * y, c * x + d * y)


@cache
def axis_matrices(axes: int) -> tuple[list[Matrix], list[Matrix]]:
    """Rotations by 0, 1, .. axes, and the reflection in the first axis followed by each of them."""
    (a, b, c, d), mirror = ((0, -1, 1, 1), (1, 1, 0, -1)) if axes == 6 else ((0, -1, 1, 0), (1, 0, 0, -1))
    turns: list[Matrix] = [(1, 0, 0, 1)]
    while len(turns) < axes:
        p, q, r, s = turns[-1]
        turns.append((a * p + b * r, a * q + b * s, c * p + d * r, c * q + d * s))
    p, q, r, s = mirror
    return turns, [(i * p + j * r, i * q + j * s, k * p + m * r, k * q + m * s) for i, j, k, m in turns]


def angle_of(vector: LatticePoint, axes: int) -> int:
    """The direction of a vector in degrees, counterclockwise from the first axis."""
    x, y = vector
    flat = (x + y / 2, y * math.sqrt(3) / 2) if axes == 6 else (x, y)
    return round(math.degrees(math.atan2(flat[1], flat[0]))) % 360


def square_of(vector: LatticePoint, axes: int) -> int:
    """The squared length of a vector."""
    x, y = vector
    return x * x + y * y + (x * y if axes == 6 else 0)


def tessellation_of(polygon: Polygon, axes: int) -> Tessellation:
    """Tessellate the plane by reflections of a polygon, given by its corners, counterclockwise.

    The cell of a kind is the translate nearest to the origin; ties go to the half-open cell between the translations.
    """
    cells = _reflections(polygon, axes)
    home = middle_of(polygon)
    shifts = [_minus(at, home) for at, cell in cells.items() if _shape(cell) == _shape(polygon) and at != home]
    shift = min(shifts, key=lambda v: (square_of(v, axes), angle_of(v, axes)))
    lattice = (shift, mapped(axis_matrices(axes)[0][1], shift))
    kinds: dict[frozenset[LatticePoint], Polygon] = {}
    for cell in cells.values():
        if _shape(cell) not in kinds:
            offset = _minus(_place(middle_of(cell), lattice, axes), middle_of(cell))
            kinds[_shape(cell)] = tuple(_plus(corner, offset) for corner in cell)
    ordered = [_ordered(kind, axes) for kind in _around(list(kinds.values()), axes)]
    scale = math.gcd(*home, *shift)
    places = [middle_of(kind) for kind in ordered]
    kind_of = {_shape(kind): number for number, kind in enumerate(ordered)}
    steps = []
    for number, kind in enumerate(ordered):
        for edge in range(len(kind)):
            image = reflected(kind, edge, axes)
            vector = _minus(middle_of(image), places[number])
            steps.append(Step(angle_of(vector, axes), number, kind_of[_shape(image)], _parted(vector, scale)))
    return Tessellation(
        scale,
        (_parted(lattice[0], scale), _parted(lattice[1], scale)),
        tuple(ordered),
        tuple(_parted(place, scale) for place in places),
        tuple(sorted(steps)),
    )


def reflected(polygon: Polygon, edge: int, axes: int) -> Polygon:
    """The mirror image of a polygon in one of its edges; corners correspond."""
    start = polygon[edge]
    side = _minus(polygon[(edge + 1) % len(polygon)], start)
    mirror = next(matrix for matrix in axis_matrices(axes)[1] if mapped(matrix, side) == side)
    return tuple(_plus(start, mapped(mirror, _minus(corner, start))) for corner in polygon)


def middle_of(polygon: Polygon) -> LatticePoint:
    """The mean of a polygon's corners, which must be whole."""
    return _parted((sum(x for x, _ in polygon), sum(y for _, y in polygon)), len(polygon))


def _reflections(polygon: Polygon, axes: int) -> dict[LatticePoint, Polygon]:
    """Cells by their middles, up to three times the longest edge from the polygon: beyond the shortest translation."""
    sides = [_minus(p, q) for p, q in zip(polygon, polygon[1:] + polygon[:1], strict=True)]
    reach = 9 * max(square_of(side, axes) for side in sides)
    home = middle_of(polygon)
    cells, pending = {home: polygon}, [polygon]
    while pending:
        cell = pending.pop()
        for edge in range(len(cell)):
            image = reflected(cell, edge, axes)
            at = middle_of(image)
            if at not in cells and square_of(_minus(at, home), axes) <= reach:
                cells[at] = image
                pending.append(image)
    return cells


def _place(middle: LatticePoint, lattice: tuple[LatticePoint, LatticePoint], axes: int) -> LatticePoint:
    """The translate of a midpoint nearest to the origin; ties go to the half-open cell between the translations."""
    (a, b), (c, d) = lattice
    det = a * d - b * c
    x, y = middle
    u, v = (x * d - y * c) // det, (y * a - x * b) // det
    within = (x - u * a - v * c, y - u * b - v * d)
    near = [(within[0] - i * a - j * c, within[1] - i * b - j * d) for i in (0, 1) for j in (0, 1)]
    least = min(square_of(point, axes) for point in near)
    nearest = [point for point in near if square_of(point, axes) == least]
    return nearest[0] if len(nearest) == 1 else within


def _around(kinds: list[Polygon], axes: int) -> list[Polygon]:
    """Kinds counterclockwise about the mean of their middles, from the first one on."""
    middles = [middle_of(kind) for kind in kinds]
    total = (sum(x for x, _ in middles), sum(y for _, y in middles))
    arms = [(len(kinds) * x - total[0], len(kinds) * y - total[1]) for x, y in middles]
    first = angle_of(arms[0], axes)
    order = sorted(range(len(kinds)), key=lambda k: (angle_of(arms[k], axes) - first) % 360)
    return [kinds[k] for k in order]


def _ordered(polygon: Polygon, axes: int) -> Polygon:
    """Corners counterclockwise, from the start of the edge whose outward normal has the least angle."""
    middle, count = middle_of(polygon), len(polygon)
    ring = sorted(polygon, key=lambda corner: angle_of(_minus(corner, middle), axes))
    normals = [angle_of(_minus(middle_of(reflected(tuple(ring), edge, axes)), middle), axes) for edge in range(count)]
    first = min(range(count), key=normals.__getitem__)
    return tuple(ring[first:] + ring[:first])


def _shape(polygon: Polygon) -> frozenset[LatticePoint]:
    """The corners of a polygon relative to their mean, equal for translates."""
    middle = middle_of(polygon)
    return frozenset(_minus(corner, middle) for corner in polygon)


def _parted(vector: LatticePoint, scale: int) -> LatticePoint:
    assert vector[0] % scale == vector[1] % scale == 0, f"{vector} is no multiple of {scale}"
    return (vector[0] // scale, vector[1] // scale)


def _plus(p: LatticePoint, q: LatticePoint) -> LatticePoint:
    return (p[0] + q[0], p[1] + q[1])


def _minus(p: LatticePoint, q: LatticePoint) -> LatticePoint:
    return (p[0] - q[0], p[1] - q[1])
