"""Arrays: finite connected sets of cells, with a text notation and symmetries."""

from __future__ import annotations

import math
import operator
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

from hcsearch.basics.errors import ArrayError, NotationError, SizeError, expect_kind
from hcsearch.designs.grid.tessellation import LatticePoint
from hcsearch.designs.grid.tilings import Cell, Grid, LatticeIsometry, grid_named, grid_of
from hcsearch.shape.drawing import draw_array

if TYPE_CHECKING:
    import networkx as nx

MAX_CELLS = 20_000


@dataclass(frozen=True, repr=False)
class Array:
    """A connected set of cells, up to translation; make one with `from_cells`, `from_notation` or `parse_array`.

    Parameters
    ----------
    grid
        The grid of the cells.
    rows
        Each row as an integer, the bottom row first; bit x (triangles: bit 2x + u) is cell x of the row. The least x
        and the least y are 0. Where there are more kinds of cells, `Grid.row_of` gives row and bit.
    """

    grid: Grid
    rows: tuple[int, ...]

    @staticmethod
    def from_cells(grid: Grid | str, cells: Iterable[Cell]) -> Array:
        """Make the array of some cells of a grid, which is given by itself or by its name.

        Raises
        ------
        ArrayError
            For cells of another form, repeated or unconnected cells, or no cells.
        SizeError
            For too many cells.
        """
        grid = grid_of(grid)
        listed = [_cell(grid, cell) for cell in islice(cells, MAX_CELLS + 1)]
        if not listed:
            raise ArrayError("an array needs at least one cell")
        check_size(len(listed), "the array")
        twice = next((cell for cell, times in Counter(listed).items() if times > 1), None)
        if twice is not None:
            raise ArrayError(f"cell {' '.join(map(str, twice))} is given twice: list every cell once")
        parts = _parts(grid, listed)
        if parts > 1:
            raise ArrayError(f"the cells are not connected ({parts} pieces): join them by shared edges")
        return Array(grid, _rows(grid, listed))

    @staticmethod
    def from_notation(text: str) -> Array:
        """Read the notation that `notation` writes, such as `square:f.f.f.f`."""
        expect_kind("the notation of an array", text, str, "a text, such as 'hex:e.f.7'")
        name, colon, body = text.partition(":")
        grid = grid_named(name)
        if not colon or not re.fullmatch(r"[0-9a-f]+(\.[0-9a-f]+)*", body):
            raise NotationError(
                f"malformed array notation {text!r}: write the grid, a colon and rows in hexadecimal, as square:f.f"
            )
        rows = tuple(int(row, 16) for row in body.split("."))
        check_size(sum(map(int.bit_count, rows)), f"array {text!r}")
        return Array.from_cells(grid, _cells(grid, rows))

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """The cells, row by row from the bottom, left to right in each row."""
        return tuple(_cells(self.grid, self.rows))

    @cached_property
    def points(self) -> tuple[LatticePoint, ...]:
        """Lattice points of the cells, in the same order."""
        return tuple(map(self.grid.point, self.cells))

    @property
    def n(self) -> int:
        """Number of cells."""
        return sum(row.bit_count() for row in self.rows)

    @property
    def notation(self) -> str:
        """The grid and the rows in hexadecimal, the bottom row first; `from_notation` reads it."""
        return f"{self.grid.name}:" + ".".join(f"{row:x}" for row in self.rows)

    def __str__(self) -> str:
        return self.notation

    def __repr__(self) -> str:
        return f"Array.from_notation({self.notation!r})"

    def _repr_svg_(self) -> str:
        return draw_array(self.grid, self.cells, title=self.notation)

    @cached_property
    def _images(self) -> tuple[Array, ...]:
        """The images under the grid's point group, each moved back to the origin."""
        cell = self.grid.cell
        return tuple(
            Array(self.grid, _rows(self.grid, [cell(isometry(p)) for p in self.points]))
            for isometry in self.grid.point_group
        )

    def canonical(self) -> Array:
        """The canonical congruent array: the image with the fewest rows, and the least in order of several such."""
        return min(self._images, key=lambda image: (len(image.rows), image.rows))

    @property
    def symmetry(self) -> int:
        """Order of the array's symmetry group."""
        return sum(image.rows == self.rows for image in self._images)

    def symmetries(self) -> list[tuple[LatticeIsometry, LatticePoint]]:
        """The isometries that map the array onto itself, each with the translation that follows it."""
        corner = min(self.points)
        pairs = []
        for isometry, image in zip(self.grid.point_group, self._images, strict=True):
            if image.rows == self.rows:
                image_corner = min(map(isometry, self.points))
                pairs.append((isometry, (corner[0] - image_corner[0], corner[1] - image_corner[1])))
        return pairs

    def edges(self) -> list[tuple[int, int, int]]:
        """Pairs of neighbouring cells as (i, j, step from i to j) with i < j, by their indices in `cells`."""
        index = {point: i for i, point in enumerate(self.points)}
        edges = []
        for i, point in enumerate(self.points):
            for d, to in self.grid.neighbours(point):
                j = index.get(to, -1)
                if j > i:
                    edges.append((i, j, d))
        return edges

    def graph(self) -> nx.Graph:
        """The networkx graph of the array: its nodes are the cells, its edges the shared edges."""
        import networkx as nx  # noqa: PLC0415 - only who asks for the graph pays for the import

        graph = nx.Graph()
        graph.add_nodes_from(self.cells)
        graph.add_edges_from((self.cells[i], self.cells[j]) for i, j, _ in self.edges())
        return graph


def check_size(n: int, what: str) -> None:
    """Raise SizeError for more cells than arrays may have."""
    if n > MAX_CELLS:
        raise SizeError(f"{what} is larger than {MAX_CELLS} cells: take a smaller one")


def _cell(grid: Grid, cell: Iterable[int]) -> Cell:
    """Check a cell and convert it to a tuple of integers; ArrayError if it is no cell of the grid."""
    try:
        numbers = tuple(map(operator.index, cell))
    except TypeError:
        numbers = ()
    if not is_cell(grid, numbers):
        names, kinds = cell_form(grid)
        raise ArrayError(
            f"{cell!r} is no cell of the {grid.name} grid: give ({', '.join(names)}){kinds} in whole numbers"
        )
    return numbers


def is_cell(grid: Grid, numbers: tuple[int, ...]) -> bool:
    """Whether whole numbers are a cell of a grid: (x, y), and the kind where there are several."""
    return len(numbers) == 2 + (grid.kinds > 1) and all(0 <= kind < grid.kinds for kind in numbers[2:])


def cell_form(grid: Grid) -> tuple[tuple[str, ...], str]:
    """The names of a cell's coordinates, and the range of the kind."""
    if grid.kinds == 1:
        return (("q", "r") if grid.axes == 6 else ("x", "y")), ""
    if grid.kinds == 2:
        return ("x", "y", "u"), ", u 0 (up) or 1 (down)"
    return ("x", "y", "k"), f", k from 0 to {grid.kinds - 1}"


def cells_at(grid: Grid, places: Sequence[LatticePoint]) -> list[Cell]:
    """All cells at some lattice points."""
    return [(*place, kind) if grid.kinds > 1 else place for place in places for kind in range(grid.kinds)]


def cells_within(grid: Grid, regions: Sequence[Sequence[tuple[float, float]]]) -> list[Cell]:
    """The cells in any of some convex regions with corners at lattice points or halves of these, counterclockwise."""
    origin, (ax, ay), (bx, by) = (grid.point((x, y, 0)) for x, y in ((0, 0), (1, 0), (0, 1)))
    scale = grid.corner_scale
    basis = (scale * (ax - origin[0]), scale * (ay - origin[1]), scale * (bx - origin[0]), scale * (by - origin[1]))
    found: dict[Cell, None] = {}
    for region in regions:
        corners = [(basis[0] * x + basis[2] * y, basis[1] * x + basis[3] * y) for x, y in region]
        sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
        (left, right), (low, high) = (
            (math.floor(min(values)) - 1, math.ceil(max(values)) + 1) for values in zip(*region, strict=True)
        )
        for cell in cells_at(grid, [(x, y) for y in range(low, high) for x in range(left, right)]):
            if all(
                (qx - px) * (y - py) - (qy - py) * (x - px) >= 0
                for x, y in grid.lattice_corners(cell)
                for (px, py), (qx, qy) in sides
            ):
                found[cell] = None
    return list(found)


def _parts(grid: Grid, cells: Iterable[Cell]) -> int:
    """Number of connected components of some cells."""
    remaining = set(map(grid.point, cells))
    parts = 0
    while remaining:
        parts += 1
        pending = [remaining.pop()]
        while pending:
            for _, to in grid.neighbours(pending.pop()):
                if to in remaining:
                    remaining.remove(to)
                    pending.append(to)
    return parts


def _rows(grid: Grid, cells: Iterable[Cell]) -> tuple[int, ...]:
    """Encode cells, moved to touch x = 0 and y = 0, as integers, one for each row."""
    listed = list(cells)
    x0, y0 = min(c[0] for c in listed), min(c[1] for c in listed)
    bits = [grid.row_of((cell[0] - x0, cell[1] - y0, *cell[2:])) for cell in listed]
    rows = [0] * (max(row for row, _ in bits) + 1)
    for row, column in bits:
        rows[row] |= 1 << column
    return tuple(rows)


def _cells(grid: Grid, rows: Iterable[int]) -> list[Cell]:
    """Decode rows into cells, row by row."""
    cells: list[Cell] = []
    for number, bits in enumerate(rows):
        row = bits
        while row:  # visit set bits only: a row may be thousands wide, and hold one cell
            lowest = row & -row
            cells.append(grid.cell_of_bit(number, lowest.bit_length() - 1))
            row ^= lowest
    return cells
