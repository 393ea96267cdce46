"""Specifications of arrays that users type: rectangles, parallelograms, triangles, hexagons, stars, rows and files."""

from __future__ import annotations

import re

from hcsearch.basics.errors import NotationError, expect_kind
from hcsearch.designs.grid.arrays import Array, cells_at, cells_within, check_size
from hcsearch.designs.grid.drawn_arrays import array_in_file, drawn_array, is_drawing, refuse_strange_row
from hcsearch.designs.grid.tessellation import LatticePoint
from hcsearch.designs.grid.tilings import Cell, Grid, grid_of


def parse_array(grid: Grid | str, spec: str) -> Array:
    """Read an array specification on a grid, which is given by itself or by its name.

    `6x5` has 6 columns and 5 rows of squares or rectangles; `3-4-3` lists rows of hexagons from the top; `p5x4` is a
    parallelogram, `t5` a triangle of side 5, `h3` a hexagon of side 3 and `s1` a star with points of side 1, of
    triangles or hexagons; `XXX / X.X` is drawn, its rows from the top, between slashes or on lines; `@file` names a
    file with one cell a line, or with a drawing. On grids whose panels are parts of squares, triangles or hexagons,
    these are cut into panels (docs/reference/grids.md has pictures): squares `6x5` of isosceles right triangles in two,
    with their legs as sides. An array's own notation is read, too.

    Parameters
    ----------
    grid
        The grid, or its name.
    spec
        The specification.

    Returns
    -------
    Array
        The array.

    Raises
    ------
    NotationError
        For a text that is none of these.
    SizeError
        For an array that is too large.
    ArrayError
        For cells that are no array.
    InputFileError
        For a file that cannot be read.

    Examples
    --------
    >>> from hcsearch import parse_array
    >>> parse_array("hex", "3-4-3").n
    10
    """
    grid = grid_of(grid)
    expect_kind("the specification of an array", spec, str, "a text, such as '3-4-3' or '6x5'")
    if spec.startswith("@"):
        return array_in_file(grid, spec[1:])
    if is_drawing(spec):
        return drawn_array(grid, spec)
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
            least = sum(sizes) if "-" in spec else sizes[0] * sizes[-1] * (3 if spec[0] in "hs" else 1) // 2
            min_cells = least * max(1, grid.kinds // 2)
            check_size(min_cells, f"array {spec!r}")
            cells = make(grid, sizes)
            if cells is None:
                raise NotationError(f"the {grid.name} grid has no array {spec!r}: {_help(grid)}")
            return Array.from_cells(grid, cells)
    refuse_strange_row(dict(enumerate(re.split("[/\n]", spec), 1)), "row")
    raise NotationError(f"malformed array {spec!r}: {_help(grid)}")


def _help(grid: Grid) -> str:
    """The specifications that a grid has, as a sentence part."""
    words = ["6x5 (columns x rows)"] if "square" in grid.blocks else []
    words += ["3-4-3 (rows of hexagons from the top)"] if "hexagon" in grid.blocks else []
    if "square" not in grid.blocks:
        words.append("t5, h3 (triangle, hexagon by its side)")
    if "triangle" in grid.blocks or _meet_in_stars(grid):
        words.append("s1 (star)")
    return f"use {', '.join([*words, 'p5x4', '@file'])}, a drawing (XXX / X.X) or an array's notation"


def _rectangle(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    if "square" not in grid.blocks:
        return None
    if grid.is_rectangular:
        return _parallelogram(grid, sizes)
    x, y = (0.5 * size for size in sizes)  # squares on the legs, which lie on the diagonals of the lattice
    return cells_within(grid, [[(0, 0), (x, x), (x - y, x + y), (-y, y)]])


def _parallelogram(grid: Grid, sizes: list[int]) -> list[Cell]:
    columns, rows = sizes
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(0, 0), (columns, 0), (columns, rows), (0, rows)]])
    return cells_at(grid, [(x, y) for y in range(rows) for x in range(columns)])


def _triangle(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    side = sizes[0]
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(0, 0), (side, 0), (0, side)]])
    if "hexagon" in grid.blocks:
        return cells_at(grid, [(x, y) for y in range(side) for x in range(side - y)])
    return None


def _hexagon(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    side = sizes[0]
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(side, 0), (0, side), (-side, side), (-side, 0), (0, -side), (side, -side)]])
    if "hexagon" in grid.blocks:
        span = range(1 - side, side)
        return cells_at(grid, [(q, r) for r in span for q in span if abs(q + r) < side])
    return None


def _star(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    side = sizes[0]
    if "triangle" in grid.blocks:
        up, down = (
            [(-side, -side), (2 * side, -side), (-side, 2 * side)],
            [(side, side), (-2 * side, side), (side, -2 * side)],
        )
        return cells_within(grid, [up, down])
    if _meet_in_stars(grid) and side == 1:  # the six panels around a corner
        near = cells_at(grid, [(x, y) for y in (-1, 0) for x in (-1, 0)])
        return [cell for cell in near if (0, 0) in grid.lattice_corners(cell)]
    return None


def _meet_in_stars(grid: Grid) -> bool:
    """Whether hexagons are cut into panels that are no parts of triangles: at some corners six of these meet."""
    return grid.blocks == ("hexagon",) and grid.kinds > 1


def _hexagon_rows(grid: Grid, sizes: list[int]) -> list[Cell] | None:
    if "hexagon" not in grid.blocks:
        return None
    places: list[LatticePoint] = []
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
        places.extend((q + x, -y) for x in range(length))
    return cells_at(grid, places)


_SHAPES = (
    ("[0-9]+x[0-9]+", _rectangle),
    ("p[0-9]+x[0-9]+", _parallelogram),
    ("t[0-9]+", _triangle),
    ("h[0-9]+", _hexagon),
    ("s[0-9]+", _star),
    ("[0-9]+(-[0-9]+)+", _hexagon_rows),
)
