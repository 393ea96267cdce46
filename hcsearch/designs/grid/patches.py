"""Specifications of arrays that users type: rectangles, parallelograms, triangles, hexagons, stars, rows and files."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

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
    these are cut into panels (docs/reference/grids.md has pictures): isosceles right triangles halve the squares of
    `6x5`, whose sides are their legs. An array's own notation is read, too.

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
    for form in _FORMS:
        if re.fullmatch(form.pattern, spec):
            # nine digits suffice to show that a size is too large
            sizes = [int(group[:9]) for group in re.findall("[0-9]+", spec)]
            if min(sizes) < 1:
                raise NotationError(f"array {spec!r} has a size below 1: give sizes of 1 or more")
            least = sum(sizes) if "-" in spec else sizes[0] * sizes[-1] * (3 if spec[0] in "hs" else 1) // 2
            check_size(least * max(1, grid.kinds // 2), f"array {spec!r}")
            if not form.fits(grid) or not (cells := form.cells(grid, *sizes)):
                raise NotationError(f"the {grid.name} grid has no array {spec!r}: {_help(grid)}")
            return Array.from_cells(grid, cells)
    refuse_strange_row(dict(enumerate(re.split("[/\n]", spec), 1)), "row")
    raise NotationError(f"malformed array {spec!r}: {_help(grid)}")


def _help(grid: Grid) -> str:
    """The specifications that a grid has, as a sentence part."""
    words = [form.example for form in _FORMS if form.fits(grid)]
    return f"use {', '.join([*words, '@file'])}, a drawing (XXX / X.X) or an array's notation"


def _rectangle(grid: Grid, columns: int, rows: int) -> list[Cell]:
    if grid.is_rectangular:
        return _parallelogram(grid, columns, rows)
    x, y = 0.5 * columns, 0.5 * rows  # squares on the legs, which lie on the diagonals of the lattice
    return cells_within(grid, [[(0, 0), (x, x), (x - y, x + y), (-y, y)]])


def _parallelogram(grid: Grid, columns: int, rows: int) -> list[Cell]:
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(0, 0), (columns, 0), (columns, rows), (0, rows)]])
    return cells_at(grid, [(x, y) for y in range(rows) for x in range(columns)])


def _triangle(grid: Grid, side: int) -> list[Cell]:
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(0, 0), (side, 0), (0, side)]])
    return cells_at(grid, [(x, y) for y in range(side) for x in range(side - y)])


def _hexagon(grid: Grid, side: int) -> list[Cell]:
    if "triangle" in grid.blocks:
        return cells_within(grid, [[(side, 0), (0, side), (-side, side), (-side, 0), (0, -side), (side, -side)]])
    span = range(1 - side, side)
    return cells_at(grid, [(q, r) for r in span for q in span if abs(q + r) < side])


def _star(grid: Grid, side: int) -> list[Cell]:
    """A hexagon with triangles on its sides; without triangles the six panels around a corner, for side 1 alone."""
    if "triangle" in grid.blocks:
        up, down = (
            [(-side, -side), (2 * side, -side), (-side, 2 * side)],
            [(side, side), (-2 * side, side), (side, -2 * side)],
        )
        return cells_within(grid, [up, down])
    near = cells_at(grid, [(x, y) for y in (-1, 0) for x in (-1, 0)])
    return [cell for cell in near if (0, 0) in grid.lattice_corners(cell)] if side == 1 else []


def _hexagon_rows(grid: Grid, *lengths: int) -> list[Cell]:
    places: list[LatticePoint] = []
    q = 0  # going down a row keeps q half a cell to the left, q + 1 half a cell to the right
    left_next = True
    for y, (length, above) in enumerate(zip(lengths, [lengths[0], *lengths], strict=False)):
        if y:
            if abs(length - above) > 1:
                raise NotationError(
                    f"row {y + 1} of {'-'.join(map(str, lengths))} differs by more than one from the row above: "
                    "give such an array by its cells, --array @file"
                )
            right = length < above or (length == above and not left_next)
            if length == above:
                left_next = not left_next
            q += right
        places.extend((q + x, -y) for x in range(length))
    return cells_at(grid, places)


class _ArrayForm(NamedTuple):
    """A form of specifications: its pattern, the grids that it fits, the cells by sizes, and an example for help."""

    pattern: str
    fits: Callable[[Grid], bool]
    cells: Callable[..., list[Cell]]
    example: str


def _has_no_squares(grid: Grid) -> bool:
    return "square" not in grid.blocks


_FORMS = (
    _ArrayForm("[0-9]+x[0-9]+", lambda grid: "square" in grid.blocks, _rectangle, "6x5 (columns x rows)"),
    _ArrayForm(
        *("[0-9]+(-[0-9]+)+", lambda grid: "hexagon" in grid.blocks, _hexagon_rows),
        "3-4-3 (rows of hexagons from the top)",
    ),
    _ArrayForm("t[0-9]+", _has_no_squares, _triangle, "t5"),
    _ArrayForm("h[0-9]+", _has_no_squares, _hexagon, "h3 (triangle, hexagon by its side)"),
    _ArrayForm(
        "s[0-9]+",
        lambda grid: "triangle" in grid.blocks or ("hexagon" in grid.blocks and grid.kinds > 1),
        _star,
        "s1 (star)",
    ),
    _ArrayForm("p[0-9]+x[0-9]+", lambda _: True, _parallelogram, "p5x4"),
)
