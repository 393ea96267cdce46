"""Arrays that users list by their cells, or draw as rows of X and `.`, in a file or in one line."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hcsearch.basics.errors import ArrayError, HcsearchError, NotationError
from hcsearch.designs.grid.arrays import Array, cell_form, check_size, is_cell
from hcsearch.designs.grid.lattice_regions import SQUARES, blocks, within
from hcsearch.designs.grid.tilings import Cell, Grid
from hcsearch.system.reading import read_text_file

_DRAWN = re.compile(r"(?=.*[Xx])[Xx.\s/]+")
_NUMBER = re.compile("[+-]?[0-9]{1,9}")


def is_drawing(text: str) -> bool:
    """Whether a specification, or a line of a file, is a drawing: X, `.`, spaces and slashes, with an X."""
    return _DRAWN.fullmatch(text) is not None


def drawn_array(grid: Grid, text: str) -> Array:
    """The array drawn in one line, its rows from the top, between slashes: `XXX / X.X`."""
    spaced = text.count(" / ") == text.count("/")  # spaces on both sides of each slash are no part of the rows
    return Array.from_cells(grid, _drawn_cells(grid, text.split(" / " if spaced else "/")))


def array_in_file(grid: Grid, path: str) -> Array:
    """The array in a text file: one cell a line, below a heading or not, or a drawing.

    Empty lines and comments from # on are skipped. Errors name the file.
    """
    lines = {
        number: line.split("#")[0].rstrip()
        for number, line in enumerate(read_text_file(path, "the cells in").splitlines(), 1)
    }
    lines = {number: line for number, line in lines.items() if line}
    if not lines:
        names, _ = cell_form(grid)
        example = ",".join("0" for _ in names)
        raise ArrayError(f"{path} holds no cells: write one a line, as {example}, or draw rows of X and .")
    try:
        if all(_is_row(line) for line in lines.values()):
            rows = [row for line in lines.values() for row in line.split("/")]
            return Array.from_cells(grid, _drawn_cells(grid, rows))
        return Array.from_cells(grid, _listed_cells(grid, lines))
    except HcsearchError as error:
        raise type(error)(f"{path}: {error}") from None


def _is_row(line: str) -> bool:
    """Whether a line may be part of a drawing, such as one of empty places only."""
    return is_drawing(line + "X")


def _drawn_cells(grid: Grid, rows: Sequence[str]) -> list[Cell]:
    """The cells of a drawing, whose rows are given from the top; an X is one of `grid`'s shapes, as docs show them.

    On squares an X is a cell; on `right45` a square of four. On hexagons it is a hexagon, two places wide, so that rows
    are shifted by one place. On triangles places alternate between upright ones, with the first of the first row, and
    inverted ones.
    """
    if grid.name in SQUARES:
        rows = ["".join(row.split()) for row in rows]  # spaces only make squares look square
    places = [(column, k) for k, row in enumerate(rows) for column, mark in enumerate(row.expandtabs()) if mark in "Xx"]
    if not places:
        raise NotationError("the drawing has no cell: draw cells as X and empty places as .")
    check_size(len(places) * max(1, grid.kinds // 2), "the drawing")
    if grid.name in SQUARES:
        return blocks(grid, [(column, -row) for column, row in places])
    steps = [(column + row, row) for column, row in places]  # 2 x, and 1 more for an inverted triangle, in each row -y
    if grid.name in ("triangle", "obtuse"):
        return [
            cell
            for step, row in steps
            for cell in within(grid, [_triangle_at(step // 2, -row, inverted=step % 2 == 1)])
        ]
    odd = next((row for step, row in steps if (step - steps[0][0]) % 2), None)
    if odd is not None:
        raise NotationError(
            f"row {odd + 1} of the drawing does not lie as rows of hexagons do: a hexagon is two places wide, and each "
            "row is shifted by one, as in .X.X./X.X.X"
        )
    return blocks(grid, [((step - steps[0][0]) // 2, -row) for step, row in steps])


def _triangle_at(x: int, y: int, *, inverted: bool) -> list[tuple[float, float]]:
    """The corners of a triangle of a lattice, counterclockwise."""
    if inverted:
        return [(x + 1, y), (x + 1, y + 1), (x, y + 1)]
    return [(x, y), (x + 1, y), (x, y + 1)]


def _listed_cells(grid: Grid, lines: dict[int, str]) -> list[Cell]:
    """The cells that lines list by their coordinates, in the order of the heading where there is one."""
    names, kinds = cell_form(grid)
    words = {number: re.sub("[,;]", " ", line).split() for number, line in lines.items()}
    first = next(iter(words))
    heading = [word.strip("\"'").lower() for word in words[first]]
    order = list(names)
    if sorted(heading) == sorted(names):
        order = heading
        del words[first]
    elif not any(map(_NUMBER.fullmatch, heading)):
        raise ArrayError(f"line {first}: {lines[first].strip()!r} is no heading of cells: write {','.join(names)}")
    cells: list[Cell] = []
    for number, texts in words.items():
        numbers = [int(text) for text in texts if _NUMBER.fullmatch(text)]
        cell = tuple(numbers) if len(numbers) == len(texts) == len(names) else ()
        cell = tuple(dict(zip(order, cell, strict=True))[name] for name in names) if cell else ()
        if not is_cell(grid, cell):
            form = ",".join(order) + kinds.replace(",", " with", 1)
            raise ArrayError(f"line {number}: {lines[number].strip()!r} is no cell: write {form}")
        cells.append(cell)
    return cells
