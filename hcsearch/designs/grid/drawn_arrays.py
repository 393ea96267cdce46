"""Arrays that users list by their cells, or draw as rows of X and `.`, in a file or in one line."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from hcsearch.basics.errors import ArrayError, HcsearchError, NotationError
from hcsearch.designs.grid.arrays import Array, cell_form, cells_at, cells_within, check_size, is_cell
from hcsearch.designs.grid.tilings import Cell, Grid
from hcsearch.system.reading import read_text_file

_CELL_SIGNS = "X#O1"
"""Signs for cells, one of them in each drawing; 0 is an empty place in drawings of 1."""
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_MAX_COORDINATE = 1e9
_COORDINATES = ("x", "y", "q", "r", "u", "k")
"""The names of coordinates on all grids."""


def is_drawing(text: str) -> bool:
    """Whether a specification is a drawing: signs for cells, `.`, blanks, and slashes or line ends between rows.

    A text of 0 and 1 only is a drawing if it has several rows.
    """
    marks, rows = _marks(text), re.split("[/\n]", text)
    return (bool(marks) and marks <= set("X#O")) or ("1" in marks and marks <= set("10") and len(rows) > 1)


def drawn_array(grid: Grid, text: str) -> Array:
    """The array drawn in a text, its rows from the top, on lines or between slashes: `XXX / X.X`."""
    return _drawn(grid, text.lstrip("\ufeff").splitlines())


def array_in_file(grid: Grid, path: str) -> Array:
    """The array in a text file: one cell a line, below a heading or not, or a drawing.

    Comments from # on are skipped, unless the whole file is a drawing of #. Empty lines are rows without cells in
    drawings, and skipped in lists. Errors name the file.
    """
    lines = read_text_file(path, "the cells in").splitlines()
    if _marks("".join(lines)) == {"#"} or any(map(_has_inner_hash, lines)):
        rows = [line for line in lines if line.lstrip()[:1] != "#" or _marks(line) <= set("X#O")]
    else:  # lines that hold a comment only are no rows
        rows = [line.split("#")[0].rstrip() for line in lines if line.lstrip()[:1] != "#"]
    listed = {number: told for number, line in enumerate(lines, 1) if (told := line.split("#")[0].rstrip())}
    if not any(map(str.strip, rows)):
        names, _ = cell_form(grid)
        example = ",".join("0" for _ in names)
        raise ArrayError(
            f"{path} holds no cells: write one a line, as {example}, or draw rows of X and . (# begins a comment)"
        )
    marks = _marks("".join(rows))
    of_digits = marks <= set("10") and all(len(line.split()) == 1 for line in listed.values())
    try:
        if marks <= set("X#O") or of_digits:
            return _drawn(grid, rows)
        refuse_strange_row(listed, "line")
        return Array.from_cells(grid, _listed_cells(grid, listed))
    except HcsearchError as error:
        raise type(error)(f"{path}: {error}") from None


def refuse_strange_row(rows: Mapping[int, str], kind: str) -> None:
    """Refuse rows where some are drawn and others have further signs: NotationError with the first such row.

    rows : by their numbers. kind : row or line. Rows of digits are drawn only where no row has several words, as listed
    cells do.
    """
    signs = "X#O" if any(re.search(r"\S[\s,;]+\S", row) for row in rows.values()) else "X#O10"
    strange = [number for number, row in rows.items() if not _marks(row) <= {*signs}]
    if strange and any(_marks(row) and number not in strange for number, row in rows.items()):
        raise NotationError(
            f"{kind} {strange[0]}: {rows[strange[0]].strip()!r:.60} is no row of a drawing: draw cells as X, or all as "
            "O, # or 1, and empty places as . or blanks"
        )


def _marks(text: str) -> set[str]:
    """The signs of cells in a drawing, without empty places and breaks of rows; a text of other signs has more."""
    return set(re.sub(r"[\s./\ufeff]", "", text).upper())


def _has_inner_hash(line: str) -> bool:
    """Whether a line is a row in which a # follows another sign, so that it begins no remark."""
    return _marks(line) <= set("X#O") and re.search(r"[^\s#]#", line) is not None


def _drawn(grid: Grid, lines: Sequence[str]) -> Array:
    """The array drawn on lines."""
    rows = [row for line in lines for row in _rows_of_line(grid, line, only=len(lines) == 1)]
    marks = _marks("".join(rows))
    if len(marks) > 1 and marks != set("10"):
        listed = " and ".join(sorted(marks))
        raise NotationError(f"the drawing has the signs {listed}: draw cells as X and empty places as .")
    rows = [re.sub("[" + _CELL_SIGNS + "]", "X", row.upper()) for row in rows]
    while rows and not rows[0].strip():
        del rows[0]
    cells = _drawn_cells(grid, _with_places(grid, rows))
    try:
        return Array.from_cells(grid, cells)
    except ArrayError as error:
        blank = any(" " in row.strip() or not row.strip() for row in rows)
        raise ArrayError(f"{error}{'; a blank in a drawing is an empty place' if blank else ''}") from None


def _rows_of_line(grid: Grid, line: str, *, only: bool) -> list[str]:
    """The rows on one line, without blanks at their ends; only : whether there is no other line."""
    rows = (line if only else line.rstrip().removesuffix("/")).split("/")
    spaced = all(row[:1].isspace() for row in rows[1:]) and all(row[-1:].isspace() for row in rows[:-1])
    blank = next((number for number, row in enumerate(rows, 1) if row[:1].isspace()), None)
    if "square" in grid.blocks and blank and len(rows) > 1 and not (spaced and blank > 1):
        raise NotationError(
            f"row {blank} of {line.strip()!r} begins with a blank: write ' / ' between all rows, and . for an empty "
            "place"
        )
    # blanks on both sides of each slash are no part of the rows
    return [row[spaced and number > 0 :].rstrip() for number, row in enumerate(rows)]


def _with_places(grid: Grid, rows: Sequence[str]) -> list[str]:
    """The rows with one sign for each place.

    Tabs part the places where no two signs are between them. On squares blanks part the places where every second
    place is blank in all rows, as cells would touch nowhere along the rows otherwise.
    """
    fields = [row.split("\t") for row in rows]
    if any("\t" in row for row in rows) and all(len(field.strip()) < 2 for row in fields for field in row):
        return ["".join(field.strip() or " " for field in row) for row in fields]
    rows = [row.expandtabs() for row in rows]
    if "square" not in grid.blocks:
        return list(rows)
    margin = min((len(row) - len(row.lstrip()) for row in rows if row), default=0)
    return [row[margin::2] for row in rows] if not any(row[margin + 1 :: 2].strip() for row in rows) else list(rows)


def _drawn_cells(grid: Grid, rows: Sequence[str]) -> list[Cell]:
    """The cells of a drawing, whose rows are given from the top; an X is one of `grid`'s shapes, as docs show them.

    On squares an X is a cell, or the square that the cells of a lattice point fill. On hexagons it is a hexagon, two
    places wide, so that rows are shifted by one place. On triangles places alternate between upright and inverted ones,
    and the first place of the first row is upright.
    """
    places = [(column, k) for k, row in enumerate(rows) for column, mark in enumerate(row) if mark == "X"]
    if not places:
        raise NotationError("the drawing has no cell: draw cells as X and empty places as .")
    check_size(len(places) * max(1, grid.kinds // 2), "the drawing")
    if "square" in grid.blocks:
        return cells_at(grid, [(column, -row) for column, row in places])
    steps = [(column + row, row) for column, row in places]  # 2 x, and 1 more for an inverted triangle, in each row -y
    if "hexagon" not in grid.blocks:
        return [
            cell
            for step, row in steps
            for cell in cells_within(grid, [_triangle_at(step // 2, -row, inverted=step % 2 == 1)])
        ]
    odd = next((row for step, row in steps if (step - steps[0][0]) % 2), None)
    if odd is not None:
        raise NotationError(
            f"row {odd + 1} of the drawing does not lie as rows of hexagons do: a hexagon is two places wide, and each "
            "row is shifted by one, as in .X.X./X.X.X"
        )
    return cells_at(grid, [((step - steps[0][0]) // 2, -row) for step, row in steps])


def _triangle_at(x: int, y: int, *, inverted: bool) -> list[tuple[float, float]]:
    """The corners of a triangle of a lattice, counterclockwise."""
    if inverted:
        return [(x + 1, y), (x + 1, y + 1), (x, y + 1)]
    return [(x, y), (x + 1, y), (x, y + 1)]


def _listed_cells(grid: Grid, lines: dict[int, str]) -> list[Cell]:
    """The cells that lines list by their coordinates, in the order of the heading where there is one.

    A column before the coordinates is an index, if the heading has one, or if it counts the lines.
    """
    names, kinds = cell_form(grid)
    words = {number: re.sub("[][(),;]", " ", line).split() for number, line in lines.items()}
    first = next(iter(words))
    first_line = re.sub("unnamed: [0-9]", "index", " ".join(words[first]).lower())  # as pandas reads an index back
    heading = [word.strip("\"'") for word in first_line.split()]
    order, before, indexed = heading[-len(names) :], heading[: -len(names)], False
    if sorted(order) == sorted(names) and len(before) < 2 and not {*before} & {*_COORDINATES}:
        indexed = bool(before) or lines[first][0] in ",; \t"
        del words[first]
    elif any(_whole(word) is not None for word in heading):
        order = list(names)
    else:
        raise ArrayError(
            f"line {first}: {lines[first].strip()!r} is no heading of cells: write {','.join(names)}, or draw rows of "
            "X and ."
        )
    rows = {number: [_whole(text) for text in texts] for number, texts in words.items()}
    starts = [row[0] if len(row) == len(names) + 1 else None for row in rows.values()]
    if indexed or (len(rows) > 1 and starts in (list(range(len(rows))), list(range(1, len(rows) + 1)))):
        rows = {number: row[1:] if len(row) > len(names) else row for number, row in rows.items()}
    cells: list[Cell] = []
    for number, row in rows.items():
        numbers = tuple(number for number in row if number is not None)
        cell = numbers if len(numbers) == len(row) == len(names) else ()
        cell = tuple(dict(zip(order, cell, strict=True))[name] for name in names) if cell else ()
        if not is_cell(grid, cell):
            form = ",".join(order) + kinds.replace(",", " with", 1)
            drawing = ", or draw rows of 1 and 0 without blanks" if len(row) > 1 and {*row} <= {0, 1} else ""
            raise ArrayError(f"line {number}: {lines[number].strip()!r} is no cell: write {form}{drawing}")
        cells.append(cell)
    return cells


def _whole(text: str) -> int | None:
    """The whole number of a text, such as 1, "1" or 1.0e+00; None for others."""
    text = text.strip("\"'")
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    return int(value) if abs(value) < _MAX_COORDINATE and value.is_integer() else None
