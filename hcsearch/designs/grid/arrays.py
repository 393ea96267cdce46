"""Arrays: finite connected sets of cells, with a text notation, the specifications that users type, and symmetries."""

from __future__ import annotations

import operator
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

from hcsearch.basics.errors import ArrayError, NotationError, SizeError, expect_kind
from hcsearch.designs.grid.tilings import Cell, Grid, LatticeIsometry, LatticePoint, grid_named, grid_of
from hcsearch.shape.drawing import draw_array
from hcsearch.system.reading import read_text_file

if TYPE_CHECKING:
    import networkx as nx

MAX_CELLS = 20_000


@dataclass(frozen=True, repr=False)
class Array:
    """A connected set of cells, up to translation; make one with `from_cells`, `from_notation` or `parse_array`.

    rows : each row as an integer, the bottom row first; bit x (triangles: bit 2x + u) is cell x of the row. The least
    x and the least y are 0.
    """

    grid: Grid
    rows: tuple[int, ...]

    @staticmethod
    def from_cells(grid: Grid | str, cells: Iterable[Cell]) -> Array:
        """Make the array of some cells of a grid, which is given by itself or by its name.

        Errors: ArrayError for cells of another form, repeated or not connected, or none; SizeError for too many.
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
        """The canonical array of all congruent ones: the image of fewest rows, and of those the least in order."""
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
        """Pairs of neighbouring cells as (i, j, direction from i to j) with i < j, by their indices in `cells`."""
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
    if len(numbers) != 2 + grid.is_triangle or (grid.is_triangle and numbers[2] not in (0, 1)):
        form = "(x, y, u), u 0 (up) or 1 (down)" if grid.is_triangle else "(q, r)" if grid.name == "hex" else "(x, y)"
        raise ArrayError(f"{cell!r} is no cell of the {grid.name} grid: give {form} in whole numbers")
    return numbers


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
    rows = [0] * (max(c[1] for c in listed) - y0 + 1)
    for cell in listed:
        x, y = cell[0] - x0, cell[1] - y0
        rows[y] |= 1 << (2 * x + cell[2] if grid.is_triangle else x)
    return tuple(rows)


def _cells(grid: Grid, rows: Iterable[int]) -> list[Cell]:
    """Decode rows into cells, row by row."""
    cells: list[Cell] = []
    for y, bits in enumerate(rows):
        row = bits
        while row:  # visit set bits only: a row may be thousands wide, and hold one cell
            lowest = row & -row
            bit = lowest.bit_length() - 1
            cells.append((bit // 2, y, bit % 2) if grid.is_triangle else (bit, y))
            row ^= lowest
    return cells


def parse_array(grid: Grid | str, spec: str) -> Array:
    """Read an array specification on a grid, which is given by itself or by its name.

    `6x5` has 6 columns and 5 rows (squares, rectangles); `3-4-3` lists rows of hexagons from the top; `p5x4` is a
    parallelogram; `t5` a triangle of side 5 and `h3` a hexagon of side 3 (triangles, hexagons); `@file` names a file
    with one cell a line. An array's own notation is read, too.

    Errors: NotationError for a text that is none of these, SizeError for an array that is too large, ArrayError for
    cells that are no array, InputFileError for a file that cannot be read.

    >>> from hcsearch import parse_array
    >>> parse_array("hex", "3-4-3").n
    10
    """
    grid = grid_of(grid)
    expect_kind("the specification of an array", spec, str, "a text, such as '3-4-3' or '6x5'")
    if spec.startswith("@"):
        return Array.from_cells(grid, _read_cells(grid, spec[1:]))
    if ":" in spec:
        array = Array.from_notation(spec)
        if array.grid != grid:
            raise NotationError(f"array {spec!r} is not on the grid {grid.name}: name the grid {array.grid.name}")
        return array
    for pattern, make in _SHAPES:
        match = re.fullmatch(pattern, spec)
        if match:
            # nine digits suffice to show that a size is too large
            sizes = [int(group[:9]) for group in re.findall("[0-9]+", spec)]
            if min(sizes) < 1:
                raise NotationError(f"array {spec!r} has a size below 1: give sizes of 1 or more")
            min_cells = sum(sizes) if "-" in spec else sizes[0] * sizes[-1] * (3 if spec[0] == "h" else 1) // 2
            check_size(min_cells, f"array {spec!r}")
            cells = make(grid, sizes)
            if cells is None:
                raise NotationError(f"the {grid.name} grid has no array {spec!r}: {_HELP[grid.name]}")
            return Array.from_cells(grid, cells)
    raise NotationError(f"malformed array {spec!r}: {_HELP[grid.name]}")


_COMMON = "use p5x4, @file or an array's notation"
_HELP = {
    "triangle": f"use t5, h3 (triangle, hexagon by its side) or {_COMMON[4:]}",
    "square": f"use 6x5 (columns x rows) or {_COMMON[4:]}",
    "rectangle": f"use 6x5 (columns x rows) or {_COMMON[4:]}",
    "hex": f"use 3-4-3 (rows from the top), t5, h3 or {_COMMON[4:]}",
}


def _rectangle(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    if grid.directions != 4:
        return None
    return _parallelogram(grid, sizes)


def _parallelogram(grid: Grid, sizes: list[int]) -> list[Cell]:
    columns, rows = sizes
    kinds: list[tuple[int, ...]] = [(0,), (1,)] if grid.is_triangle else [()]
    return [(x, y, *u) for y in range(rows) for x in range(columns) for u in kinds]


def _triangle(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    side = sizes[0]
    if grid.directions == 4:
        return None
    if grid.is_triangle:
        return [(x, y, u) for y in range(side) for x in range(side - y) for u in (0, 1) if x + y + u < side]
    return [(x, y) for y in range(side) for x in range(side - y)]


def _hexagon(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    side = sizes[0]
    if grid.directions == 4:
        return None
    if grid.is_triangle:  # the 6 side^2 triangles around a lattice vertex: all corners within distance `side` of it
        span = range(-side, side)
        return [
            (x, y, u)
            for y in span
            for x in span
            for u in (0, 1)
            if all(abs(p + q) <= side for p, q in ((x + 1, y), (x, y + 1), (x + u, y + u)))
        ]
    span = range(1 - side, side)
    return [(q, r) for r in span for q in span if abs(q + r) < side]


def _hexagon_rows(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    if grid.name != "hex":
        return None
    cells: list[Cell] = []
    q = 0  # going down a row keeps q half a cell to the left, q + 1 half a cell to the right
    left_next = True
    for y, (length, above) in enumerate(zip(sizes, [sizes[0], *sizes], strict=False)):
        if y:
            if abs(length - above) > 1:
                raise NotationError(
                    f"row {y + 1} of {'-'.join(map(str, sizes))} differs by more than one from the row above: "
                    "give such an array by its cells, --array @file"
                )
            right = length < above or (length == above and not left_next)
            if length == above:
                left_next = not left_next
            q += right
        cells.extend((q + x, -y) for x in range(length))
    return cells


_SHAPES = (
    ("[0-9]+x[0-9]+", _rectangle),
    ("p[0-9]+x[0-9]+", _parallelogram),
    ("t[0-9]+", _triangle),
    ("h[0-9]+", _hexagon),
    ("[0-9]+(-[0-9]+)+", _hexagon_rows),
)


def _read_cells(grid: Grid, path: str) -> list[Cell]:
    """Read the cells of a text file, one in each line; empty lines and comments from # on are skipped."""
    lines = read_text_file(path, "the cells in").splitlines()
    coordinate_count = 3 if grid.is_triangle else 2
    cells: list[Cell] = []
    for number, line in enumerate(lines, 1):
        text = line.split("#")[0].replace(",", " ").split()
        if not text:
            continue
        numbers = [int(word) for word in text if re.fullmatch("[+-]?[0-9]{1,9}", word)]
        cell = tuple(numbers) if len(numbers) == len(text) else ()
        if len(cell) != coordinate_count or (coordinate_count == 3 and cell[2] not in (0, 1)):
            form = (
                "x y u with u 0 (up) or 1 (down)" if coordinate_count == 3 else ("q r" if grid.name == "hex" else "x y")
            )
            raise ArrayError(f"{path}, line {number}: {line.strip()!r} is no cell: write {form}")
        cells.append(cell)
    return cells
