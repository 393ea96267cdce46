"""Array specifications, the short texts for arrays that users type (`6x5`, `3-4-3`, `p5x4`, `t5`, `h3`, `@file`)."""

from __future__ import annotations

import re

from hcsearch.basics.errors import ArrayError, NotationError, expect_kind
from hcsearch.designs.grid.arrays import Array, check_size
from hcsearch.designs.grid.tilings import Cell, Grid, grid_of
from hcsearch.system.reading import read_text_file


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
