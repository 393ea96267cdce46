"""The four grids on three tilings: directions, cells and symmetries in exact integers.

Every cell has a lattice point (X, Y): hexagons their axial coordinates, squares their column and row, triangles
(3x + 1 + u, 3y + 1 + u), three times the centroid. Directions count counterclockwise in units of 2 pi / `directions`;
`steps[d]` is the move from a cell to its neighbour across the edge facing d. A triangle pointing up has neighbours
in the even directions, one pointing down in the odd ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from hcsearch.basics.errors import NotationError

Cell = tuple[int, ...]
LatticePoint = tuple[int, int]


@dataclass(frozen=True)
class LatticeIsometry:
    """A symmetry of a tiling that fixes the origin and maps direction i to sign * i + offset.

    matrix : (a, b, c, d), by which the point (X, Y) is mapped to (a X + b Y, c X + d Y).
    """

    sign: int
    offset: int
    matrix: tuple[int, int, int, int]

    def __call__(self, point: LatticePoint) -> LatticePoint:
        """The image of a lattice point."""
        a, b, c, d = self.matrix
        x, y = point
        return (a * x + b * y, c * x + d * y)


@dataclass(frozen=True, repr=False)
class Grid:
    """One of the four grids: `triangle`, `square`, `rectangle`, `hex`.

    directions : the number of directions in a full turn, 6 or 4. steps : the lattice vector of a step in each of them.
    turns : the turns that a circuit can make at a panel, in units of 2 pi / directions, the sharpest left turn first.
    first_directions : one direction of each class under the grid's rotations; a canonical circuit begins with one.
    """

    name: str
    directions: int
    steps: tuple[LatticePoint, ...]
    turns: tuple[int, ...]
    first_directions: tuple[int, ...] = (0,)

    def __repr__(self) -> str:
        return f"GRIDS[{self.name!r}]"

    @property
    def is_triangle(self) -> bool:
        """Whether cells are triangles, with a third coordinate u: 0 points up, 1 points down."""
        return self.turns == (1, -1)

    @property
    def tiling(self) -> Grid:
        """The grid with all symmetries of its lattice of cells: `square` for rectangles."""
        return self if len(self.first_directions) == 1 else GRIDS["square"]

    @cached_property
    def point_group(self) -> tuple[LatticeIsometry, ...]:
        """The tiling's rotations and reflections (8 square, 4 rectangle, 12 hex and triangle), the identity first."""
        offsets = range(0, self.directions, len(self.first_directions))
        return tuple(self._isometry(sign, offset) for sign in (1, -1) for offset in offsets)

    def _isometry(self, sign: int, offset: int) -> LatticeIsometry:
        (ax, ay), (bx, by) = self.steps[:2]
        (px, py), (qx, qy) = self.steps[offset % self.directions], self.steps[(sign + offset) % self.directions]
        det = ax * by - bx * ay
        matrix = (px * by - qx * ay, qx * ax - px * bx, py * by - qy * ay, qy * ax - py * bx)
        return LatticeIsometry(sign, offset, tuple(v // det for v in matrix))  # type: ignore[arg-type]

    def point(self, cell: Cell) -> LatticePoint:
        """The lattice point of a cell, in exact integers."""
        if self.is_triangle:
            x, y, u = cell
            return (3 * x + 1 + u, 3 * y + 1 + u)
        x, y = cell
        return (x, y)

    def cell(self, point: LatticePoint) -> Cell:
        """The cell at a lattice point."""
        x, y = point
        if self.is_triangle:
            u = x % 3 - 1
            return ((x - 1 - u) // 3, (y - 1 - u) // 3, u)
        return (x, y)

    @property
    def row_moves(self) -> list[list[tuple[int, int, int]]]:
        """Increments of bit column and row by a step, for each element of the point group and each direction.

        Columns are those of `Array.rows`; the third number is the column, modulo the columns of a cell, from which a
        step in the direction starts.
        """
        if self.is_triangle:
            moves = [(1 if d % 2 == 0 else -1, {1: 1, 4: -1}.get(d, 0), d % 2) for d in range(6)]
            moves[2], moves[5] = (-1, 0, 0), (1, 0, 1)
        else:
            moves = [(x, y, 0) for x, y in self.steps]
        return [
            [moves[(g.sign * d + g.offset) % self.directions] for d in range(self.directions)] for g in self.point_group
        ]

    def neighbours(self, point: LatticePoint) -> Iterator[tuple[int, LatticePoint]]:
        """The cells that share an edge with the cell at a lattice point, as directions and lattice points."""
        parity = (point[0] % 3 - 1, 2) if self.is_triangle else (0, 1)
        for d in range(parity[0], self.directions, parity[1]):
            yield d, (point[0] + self.steps[d][0], point[1] + self.steps[d][1])

    @staticmethod
    def edge(a: LatticePoint, b: LatticePoint) -> LatticePoint:
        """Exact coordinates of the edge between two neighbouring cells: twice its midpoint."""
        return (a[0] + b[0], a[1] + b[1])

    def position(self, point: tuple[float, float]) -> tuple[float, float]:
        """Cartesian coordinates of a lattice point, for panels of side 1."""
        x, y = point
        if self.directions == 4:
            return (x, y)
        scale = 1 / 3 if self.is_triangle else math.sqrt(3)
        return (scale * (x + y / 2), scale * y * math.sqrt(3) / 2)

    def corners(self, cell: Cell) -> list[tuple[float, float]]:
        """The corners of a panel of side 1, counterclockwise; the edge to neighbour i begins at corner i."""
        return list(map(self._corner_position, self.lattice_corners(cell)))

    def lattice_corners(self, cell: Cell) -> list[LatticePoint]:
        """The corners of a cell in exact integers, in the order of `corners`; cells that meet in a corner share it.

        Lattice points are multiplied by 2 for squares and by 3 for hexagons, whose corners lie between them; for
        triangles they are in thirds already.
        """
        x, y = self.point(cell)
        faces = [d for d, _ in self.neighbours((x, y))]
        sides = [(self.steps[before], self.steps[d]) for before, d in zip((faces[-1], *faces), faces, strict=False)]
        fine = 1 if self.is_triangle else self.directions // 2
        return [(fine * x + ax + bx, fine * y + ay + by) for (ax, ay), (bx, by) in sides]

    def _corner_position(self, corner: LatticePoint) -> tuple[float, float]:
        """Cartesian coordinates of a corner: a constant times whole numbers, so that mirror images are exact."""
        x, y = corner
        if self.directions == 4:
            return (x / 2, y / 2)
        if self.is_triangle:
            return ((2 * x + y) / 6, math.sqrt(3) / 6 * y)
        return (math.sqrt(3) / 6 * (2 * x + y), y / 2)

    def mesh(self, cells: Iterable[Cell]) -> tuple[list[tuple[float, float]], list[tuple[int, ...]]]:
        """The mesh of panels of side 1: vertices, and the vertex numbers of each panel, counterclockwise.

        Vertices are numbered by their first occurrence in the cells.
        """
        numbers: dict[LatticePoint, int] = {}
        faces = [
            tuple(numbers.setdefault(corner, len(numbers)) for corner in self.lattice_corners(cell)) for cell in cells
        ]
        return list(map(self._corner_position, numbers)), faces

    def corners_from_centre(self, faces: Sequence[int]) -> list[tuple[float, float]]:
        """The corners of a panel of side 1 about its centre, for a panel with neighbours in these directions."""
        radius = {3: 1 / math.sqrt(3), 4: math.sqrt(0.5), 6: 1.0}[len(faces)]
        turn = 2 * math.pi / self.directions
        first = math.pi / 6 if self.is_triangle else 0.0
        half = math.pi / len(faces)
        return [(radius * math.cos(first + turn * d - half), radius * math.sin(first + turn * d - half)) for d in faces]


_AXIAL: tuple[LatticePoint, ...] = ((1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1))
_TRIANGLE: tuple[LatticePoint, ...] = ((1, 1), (-1, 2), (-2, 1), (-1, -1), (1, -2), (2, -1))
_SQUARE: tuple[LatticePoint, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1))

GRIDS: dict[str, Grid] = {
    grid.name: grid
    for grid in (
        Grid("triangle", 6, _TRIANGLE, (1, -1)),
        Grid("square", 4, _SQUARE, (1, 0, -1)),
        Grid("rectangle", 4, _SQUARE, (1, 0, -1), first_directions=(0, 1)),
        Grid("hex", 6, _AXIAL, (2, 1, 0, -1, -2)),
    )
}


def grid_named(name: str) -> Grid:
    """Find a grid by its name; NotationError, which lists the names, for another one."""
    try:
        return GRIDS[name]
    except KeyError:
        raise NotationError(f"unknown grid {name!r}: use one of {', '.join(GRIDS)}") from None


def grid_of(grid: Grid | str) -> Grid:
    """Return a grid that is given by itself or by its name."""
    return grid if isinstance(grid, Grid) else grid_named(str(grid))
