"""The nine grids on the eight edge tessellations, each defined by the corners of one panel, in exact integers.

A panel of an edge tessellation is the mirror image of its neighbours in the edges that they share, all over the plane.
Eight polygons tile the plane so (Kirby and Umble, Mathematics Magazine 84, 2011); squares are rectangles with more
symmetries. Cells, neighbours, corners, symmetries and notations follow from the polygon by reflections.

A cell has a kind, its shape up to translation, and a lattice point (X, Y), the mean of its corners. A **step** leads
from a cell of one kind across one of its edges; steps are numbered by their directions, counterclockwise, then by kind.
Directions count counterclockwise in units of 2 pi / `directions`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from hcsearch.basics.errors import NotationError
from hcsearch.designs.grid.tessellation import (
    LatticePoint,
    Matrix,
    Polygon,
    Tessellation,
    angle_of,
    axis_matrices,
    mapped,
    middle_of,
    reflected,
    square_of,
    tessellation_of,
)

Cell = tuple[int, ...]
Block = Literal["square", "triangle", "hexagon"]


@dataclass(frozen=True)
class LatticeIsometry:
    """A symmetry of a tiling that fixes the origin and maps direction i to sign * i + offset.

    matrix : (a, b, c, d), by which the point (X, Y) is mapped to (a X + b Y, c X + d Y). steps : images of the steps.
    """

    sign: int
    offset: int
    matrix: Matrix
    steps: tuple[int, ...]

    def __call__(self, point: LatticePoint) -> LatticePoint:
        """The image of a lattice point."""
        return mapped(self.matrix, point)


@dataclass(frozen=True, repr=False)
class Grid:
    """One of the nine grids, such as `hex` or `kite`: all that the program knows of it.

    Parameters
    ----------
    name
        The name that commands take.
    polygon
        Corners of a panel in whole numbers, counterclockwise; users give the length of its first edge.
    axes
        6 where the coordinates' axes enclose 60 degrees, 4 where they enclose 90.
    noun
        A panel in a title, such as `hexagon`.
    blocks
        The regular polygons that cells are or fill, by which users give arrays; squares may be rectangles.
    connective_constant, amplitude
        mu and B: there are about B mu^n n^(-5/2) circuits of n panels up to translation, n even where the cells have
        two colours.
    stretched
        Whether panels have a length and another width, so that quarter turns are no symmetries.
    given_edge
        The edge whose length users give, where edges differ; empty where they do not, and where a width is given, too.
    exact_noun, shape
        A panel in a sentence, and by its angles; equal to `noun` unless given.
    """

    name: str
    polygon: Polygon
    axes: int
    noun: str
    blocks: tuple[Block, ...]
    connective_constant: float
    amplitude: float
    stretched: bool = False
    given_edge: str = ""
    exact_noun: str = ""
    shape: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "exact_noun", self.exact_noun or self.noun)
        object.__setattr__(self, "shape", self.shape or self.exact_noun)

    def __repr__(self) -> str:
        return f"GRIDS[{self.name!r}]"

    @property
    def tiling(self) -> Grid:
        """The grid with all symmetries of its lattice of cells: `square` for rectangles."""
        return GRIDS["square"] if self.stretched else self

    @property
    def is_rectangular(self) -> bool:
        """Whether panels are squares or rectangles, whose lengths and widths are free."""
        return self.axes == self.edges_per_cell == 4

    @property
    def step_classes(self) -> int:
        """Number of classes of steps under rotations that are one class on the tiling: 2 on rectangles, else 1."""
        return 2 if self.stretched else 1

    @cached_property
    def _tessellation(self) -> Tessellation:
        return tessellation_of(self.polygon, self.axes)

    @cached_property
    def kinds(self) -> int:
        """Number of cells per translation: 1 for squares and hexagons, 12 for 30-60-90 triangles."""
        return len(self._tessellation.kinds)

    @cached_property
    def steps(self) -> tuple[LatticePoint, ...]:
        """The lattice vector of each step."""
        return tuple(step.vector for step in self._tessellation.steps)

    @cached_property
    def step_kinds(self) -> tuple[tuple[int, int], ...]:
        """The kinds of the cells that each step leaves and enters."""
        return tuple((step.kind, step.target) for step in self._tessellation.steps)

    @cached_property
    def _angles(self) -> list[int]:
        return sorted({step.angle for step in self._tessellation.steps})

    @property
    def directions(self) -> int:
        """Number of directions in a full turn: 4, 6, 8 or 12."""
        return len(self._angles)

    @cached_property
    def step_directions(self) -> tuple[int, ...]:
        """The direction of each step; steps themselves on triangles, squares, rectangles and hexagons."""
        return tuple(self._angles.index(step.angle) for step in self._tessellation.steps)

    @property
    def has_directed_steps(self) -> bool:
        """Whether there is one step in each direction, which is its number: on triangles, squares and hexagons."""
        return len(self.steps) == self.directions

    @cached_property
    def leaving(self) -> tuple[tuple[int, ...], ...]:
        """The steps that leave a cell of each kind, counterclockwise, the least first."""
        return tuple(
            tuple(step for step, (kind, _) in enumerate(self.step_kinds) if kind == wanted)
            for wanted in range(self.kinds)
        )

    @cached_property
    def backwards(self) -> tuple[int, ...]:
        """The step back over the same edge, for each step."""
        number = {(*self.step_kinds[step], vector): step for step, vector in enumerate(self.steps)}
        return tuple(
            number[target, kind, (-x, -y)] for (kind, target), (x, y) in zip(self.step_kinds, self.steps, strict=True)
        )

    @property
    def edges_per_cell(self) -> int:
        """Number of edges of a panel."""
        return len(self.polygon)

    @cached_property
    def has_two_colours(self) -> bool:
        """Whether cells can be coloured so that neighbours differ, and no circuit has an odd number of panels.

        That is so where an even number of panels meets in every corner.
        """
        sides = zip(self.polygon, self.polygon[1:] + self.polygon[:1], strict=True)
        ways = [angle_of((b[0] - a[0], b[1] - a[1]), self.axes) for a, b in sides]
        return all(
            180 % ((before - after + 180) % 360) == 0 for before, after in zip(ways[-1:] + ways, ways, strict=False)
        )

    @cached_property
    def point_group(self) -> tuple[LatticeIsometry, ...]:
        """The tiling's rotations and reflections, the identity first; 8 for right angles, 4 for rectangles, else 12."""
        turns, mirrors = axis_matrices(self.axes)
        found = []
        for sign, matrices in ((1, turns), (-1, mirrors)):
            for matrix in matrices:
                steps = self._step_images(matrix)
                offset = (self.step_directions[steps[0]] - sign * self.step_directions[0]) % self.directions
                if not (self.stretched and offset % 2):
                    found.append(LatticeIsometry(sign, offset, matrix, steps))
        return tuple(sorted(found, key=lambda isometry: (-isometry.sign, isometry.offset)))

    def _step_images(self, matrix: Matrix) -> tuple[int, ...]:
        kinds = [self._kind(mapped(matrix, place)) for place in self._tessellation.places]
        number = {
            (kind, vector): step
            for step, ((kind, _), vector) in enumerate(zip(self.step_kinds, self.steps, strict=True))
        }
        return tuple(
            number[kinds[kind], mapped(matrix, vector)]
            for (kind, _), vector in zip(self.step_kinds, self.steps, strict=True)
        )

    @cached_property
    def _residues(self) -> dict[LatticePoint, int]:
        return {self._on_lattice(place): kind for kind, place in enumerate(self._tessellation.places)}

    def _on_lattice(self, point: LatticePoint) -> LatticePoint:
        """The lattice coordinates of a point times their common denominator, without whole translations."""
        (a, b), (c, d) = self._tessellation.lattice
        x, y = point
        det = a * d - b * c
        return ((x * d - y * c) % det, (y * a - x * b) % det)

    def _kind(self, point: LatticePoint) -> int:
        return self._residues[self._on_lattice(point)]

    def kind_of(self, cell: Cell) -> int:
        """The kind of a cell."""
        return cell[2] if self.kinds > 1 else 0

    def point(self, cell: Cell) -> LatticePoint:
        """The lattice point of a cell, in exact integers."""
        if self.kinds == 1:
            return (cell[0], cell[1])
        (a, b), (c, d) = self._tessellation.lattice
        x, y = cell[:2]
        px, py = self._tessellation.places[cell[2]]
        return (px + x * a + y * c, py + x * b + y * d)

    def lattice_row(self, point: LatticePoint) -> int:
        """The row of the lattice of translations in which a point lies: for squares and hexagons its Y."""
        a, b, det = self._row_numbers
        return (point[1] * a - point[0] * b) // det

    @cached_property
    def _row_numbers(self) -> tuple[int, int, int]:
        (a, b), (c, d) = self._tessellation.lattice
        return a, b, a * d - b * c

    def cell(self, point: LatticePoint) -> Cell:
        """The cell at a lattice point: (x, y), and its kind where there are several."""
        if self.kinds == 1:
            return point
        kind = self._kind(point)
        (a, b), (c, d) = self._tessellation.lattice
        px, py = self._tessellation.places[kind]
        x, y, det = point[0] - px, point[1] - py, a * d - b * c
        cell = ((x * d - y * c) // det, (y * a - x * b) // det)
        return (*cell, kind)

    @property
    def columns_per_cell(self) -> int:
        """Number of bits of a row of `Array.rows` per x: 2 where the number of kinds is even, else 1."""
        return 2 - self.kinds % 2

    @property
    def rows_per_cell(self) -> int:
        """Number of rows of `Array.rows` per y."""
        return self.kinds // self.columns_per_cell

    def row_of(self, cell: Cell) -> tuple[int, int]:
        """Row and column of the bit of a cell in `Array.rows`."""
        x, y, kind = (*cell, 0)[:3]
        row, column = divmod(kind, self.columns_per_cell)
        return (self.rows_per_cell * y + row, self.columns_per_cell * x + column)

    def cell_of_bit(self, row: int, column: int) -> Cell:
        """The cell of a bit of `Array.rows`."""
        (y, upper), (x, right) = divmod(row, self.rows_per_cell), divmod(column, self.columns_per_cell)
        return (x, y, upper * self.columns_per_cell + right) if self.kinds > 1 else (x, y)

    @cached_property
    def row_moves(self) -> list[list[tuple[int, int, int, int]]]:
        """Moves in `Array.rows` by the image of each step under each element of the point group.

        The first numbers are increments of column and row; the others are the column and row where the step starts,
        counted within its lattice point.
        """
        moves = []
        for (kind, _), (x, y) in zip(self.step_kinds, self.steps, strict=True):
            px, py = self._tessellation.places[kind]
            row, column = self.row_of(self.cell((px, py)))
            to_row, to_column = self.row_of(self.cell((px + x, py + y)))
            here = (column % self.columns_per_cell, row % self.rows_per_cell)
            moves.append((to_column - column, to_row - row, *here))
        return [[moves[step] for step in isometry.steps] for isometry in self.point_group]

    def neighbours(self, point: LatticePoint) -> Iterator[tuple[int, LatticePoint]]:
        """The cells that share an edge with the cell at a lattice point, as steps and lattice points."""
        for step in self.leaving[self._kind(point)]:
            yield step, (point[0] + self.steps[step][0], point[1] + self.steps[step][1])

    @staticmethod
    def edge(a: LatticePoint, b: LatticePoint) -> LatticePoint:
        """Exact coordinates of the edge between two neighbouring cells: twice its point midway between them."""
        return (a[0] + b[0], a[1] + b[1])

    def position(self, point: tuple[float, float]) -> tuple[float, float]:
        """Cartesian coordinates of a lattice point, for panels whose first edge is 1."""
        scale = self._tessellation.scale
        return self._corner_position((scale * point[0], scale * point[1]))

    def corners(self, cell: Cell) -> list[tuple[float, float]]:
        """The corners of a panel, counterclockwise; the edge to neighbour i begins at corner i. The first edge is 1."""
        return list(map(self._corner_position, self.lattice_corners(cell)))

    def lattice_corners(self, cell: Cell) -> list[LatticePoint]:
        """The corners of a cell in exact integers, in the order of `corners`; cells that meet in a corner share it.

        Lattice points are multiplied by 2 for squares and by 3 for hexagons, whose corners lie between them.
        """
        kind = self.kind_of(cell)
        scale, (px, py), (x, y) = self._tessellation.scale, self._tessellation.places[kind], self.point(cell)
        shift = (scale * (x - px), scale * (y - py))
        return [(a + shift[0], b + shift[1]) for a, b in self._tessellation.kinds[kind]]

    def _corner_position(self, corner: tuple[float, float]) -> tuple[float, float]:
        """Cartesian coordinates of a corner: a constant times whole numbers, so that mirror images are exact."""
        x, y = corner
        square = self._first_edge_square
        side = math.isqrt(square)
        if self.axes == 4:
            return (x / side, y / side) if side * side == square else (x / math.sqrt(square), y / math.sqrt(square))
        if side * side == square:
            return ((2 * x + y) / (2 * side), math.sqrt(3) / (2 * side) * y)
        side = math.isqrt(square // 3)
        return (math.sqrt(3) / (6 * side) * (2 * x + y), y / (2 * side))

    @cached_property
    def _first_edge_square(self) -> int:
        (a, b), (c, d) = self.polygon[:2]
        return square_of((c - a, d - b), self.axes)

    def mesh(self, cells: Iterable[Cell]) -> tuple[list[tuple[float, float]], list[tuple[int, ...]]]:
        """The mesh of panels whose first edge is 1: vertices, and the vertex numbers of each panel, counterclockwise.

        Vertices are numbered by their first occurrence in the cells.
        """
        numbers: dict[LatticePoint, int] = {}
        faces = [
            tuple(numbers.setdefault(corner, len(numbers)) for corner in self.lattice_corners(cell)) for cell in cells
        ]
        return list(map(self._corner_position, numbers)), faces

    @cached_property
    def labels(self) -> tuple[int, ...]:
        """The step across each edge of the polygon, which is the cell of kind 0, in the order of its corners."""
        middle = middle_of(self.polygon)
        angles = []
        for edge in range(self.edges_per_cell):
            x, y = middle_of(reflected(self.polygon, edge, self.axes))
            angles.append(angle_of((x - middle[0], y - middle[1]), self.axes))
        return tuple(
            next(step for step in self.leaving[0] if self._tessellation.steps[step].angle == angle) for angle in angles
        )

    def carried(self, step: int, edge: int) -> int:
        """The step across the mirror image of an edge of a cell: its step `edge`, reflected in the edge of `step`."""
        towards = 2 * self.step_directions[step] + self.directions // 2 - self.step_directions[edge]
        return self.step_towards(self.step_kinds[step][1], towards % self.directions)

    def step_towards(self, kind: int, direction: int) -> int:
        """The step in a direction from a cell of some kind that has an edge facing it."""
        return next(step for step in self.leaving[kind] if self.step_directions[step] == direction)

    @property
    def corner_scale(self) -> int:
        """Units of `lattice_corners` per unit of lattice points: 2 for squares, 3 for hexagons, else 1."""
        return self._tessellation.scale

    def edge_corners(self, cell: Cell, step: int) -> tuple[LatticePoint, LatticePoint]:
        """The ends of the edge that a step crosses, counterclockwise about the cell, as `lattice_corners`."""
        corners, place = self.lattice_corners(cell), self.leaving[self.step_kinds[step][0]].index(step)
        return corners[place], corners[(place + 1) % len(corners)]


_SQUARE = (((1, -1), (1, 1), (-1, 1), (-1, -1)), 4)
_HEXAGON = (((2, -1), (1, 1), (-1, 2), (-2, 1), (-1, -1), (1, -2)), 6)
_TRIANGLES_AND_HEXAGONS: tuple[Block, ...] = ("triangle", "hexagon")

# mu and B: Jensen and Guttmann, J. Phys. A 32 (1999) 4867 (square lattice); Jensen, J. Phys.: Conf. Ser. 42 (2006) 163
# (honeycomb; mu proved by Duminil-Copin and Smirnov) and J. Stat. Mech. (2004) P10008 (triangular). On 3.12.12,
# 1/mu^2 + 1/mu^3 is 1/mu of the honeycomb (Jensen and Guttmann, J. Phys. A 31, 1998, 8137). The other numbers of the
# last five grids are fitted to listings.
GRIDS: dict[str, Grid] = {
    grid.name: grid
    for grid in (
        Grid(
            *("triangle", ((3, 0), (0, 3), (0, 0)), 6, "triangle", ("triangle",), math.sqrt(2 + math.sqrt(2)), 1.272),
            exact_noun="equilateral triangle",
        ),
        Grid("square", *_SQUARE, "square", ("square",), 2.638159, 0.562, shape="rectangle"),
        Grid("rectangle", *_SQUARE, "rectangle", ("square",), 2.638159, 0.562, stretched=True),
        Grid("hex", *_HEXAGON, "hexagon", ("hexagon",), 4.150797, 0.264, exact_noun="regular hexagon"),
        Grid(
            *("rhombus", ((0, 0), (2, 0), (2, 2), (0, 2)), 6, "rhombus", ("hexagon",), 2.560577, 0.87),
            shape="60-120 rhombus",
        ),
        Grid(
            *("kite", ((0, 0), (12, 0), (8, 8), (0, 12)), 6, "kite", _TRIANGLES_AND_HEXAGONS, 2.56, 1.83),
            given_edge="longer side",
            shape="60-90-120-90 kite",
        ),
        Grid(
            *("right45", ((6, 0), (3, 3), (0, 0)), 4, "isosceles right triangle", ("square",), 1.808830, 2.66),
            given_edge="leg",
        ),
        Grid(
            *("right30", ((6, 6), (0, 0), (9, 0)), 6, "30-60-90 triangle", _TRIANGLES_AND_HEXAGONS, 1.8, 6.4),
            given_edge="hypotenuse",
        ),
        Grid(
            *("obtuse", ((9, 0), (3, 3), (0, 0)), 6, "30-30-120 triangle", ("triangle",), 1.711041, 2.3),
            given_edge="leg",
        ),
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
