"""CSV tables with named columns, as instruments and spreadsheets write them."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.system.reading import MAX_INPUT_BYTES, read_text_file

MIN_MEASURED_VALUE, MAX_MEASURED_VALUE = 1e-30, 1e30
"""Range of magnitudes of measured numbers: the squares of others overflow or underflow."""


@dataclass(frozen=True)
class CsvColumns:
    """A CSV table as text.

    names : the columns' names, "" where a column has none. rows : the number of each line in the file, and its cells;
    blank lines are left out.
    """

    path: str
    names: tuple[str, ...]
    rows: tuple[tuple[int, list[str]], ...]

    def texts(self, name: str) -> list[str]:
        """Return the cells of a column as text, "" where a line is too short."""
        k = self.names.index(name)
        return [row[k].strip() if k < len(row) else "" for _, row in self.rows]

    def numbers(self, name: str) -> Reals:
        """Return the numbers of a column, NaN in cells that hold no measured number."""
        return np.array([float(text) if is_measured(text) else math.nan for text in self.texts(name)])

    def cell_error(self, row: int, name: str, remedy: str) -> HcsearchError:
        """Return the error for a cell without a measured number; remedy : advice where the value was not measured."""
        number, cells = self.rows[row]
        k = self.names.index(name)
        count = max(j for j, known in enumerate(self.names, 1) if known)
        if len(cells) < count:
            return HcsearchError(
                f"line {number} of {self.path} has {len(cells)} values for {count} columns: complete it, or {remedy}"
            )
        text = cells[k].strip()
        if is_number(text):
            remedy = f"write 0 or a number of size {MIN_MEASURED_VALUE:g} to {MAX_MEASURED_VALUE:g}"
        elif is_number(text.replace(",", ".")):
            remedy = "write decimals by points"
        return HcsearchError(f"line {number} of {self.path} has {text!r} for {name}: {remedy}")


def read_columns(path: str, example: str, *, what: str = "", max_bytes: int = MAX_INPUT_BYTES) -> CsvColumns:
    """Read a CSV file whose first line names its columns.

    example : a column name for messages. what : expected content for messages. max_bytes : limit of the size. Empty
    cells after the last column are dropped. Errors: HcsearchError for a first line of numbers, for columns that are not
    separated by commas, for lines above the column names, and for lines with more values than columns.
    """
    try:
        reader = csv.reader(io.StringIO(read_text_file(path, what, max_bytes=max_bytes), newline=""))
        lines = [(number, row) for number, row in enumerate(reader, 1) if any(map(str.strip, row))]
    except csv.Error as error:
        raise HcsearchError(f"{path} is no table: give a CSV file with a line of column names") from error
    if not lines:
        raise HcsearchError(f"{path} is empty: give a CSV file with a line of column names")
    first = [name.strip() for name in lines[0][1]]
    _refuse_title(path, lines)
    # a name of several words may be that of a single column; columns separated by spaces have such values, too
    spaced = all(len(row) == 1 and " " in row[0].strip() for _, row in lines[:2])
    if len(first) == 1 and (spaced or any(mark in first[0] for mark in ";\t|")):
        raise HcsearchError(f"the columns of {path} are not separated by commas: write them so, and decimals by points")
    if all(is_number(name) for name in first if name):
        raise HcsearchError(f"the first line of {path} names no columns: write one name for each, such as {example}")
    for number, row in lines[1:]:
        if len(row) > len(first):
            while len(row) > len(first) and not row[-1].strip():
                row.pop()
            if len(row) > len(first):
                raise HcsearchError(
                    f"line {number} of {path} has {len(row)} values for {len(first)} columns: name each column, and "
                    "write decimals by points"
                )
    return CsvColumns(path, tuple(first), tuple(lines[1:]))


def _refuse_title(path: str, lines: Sequence[tuple[int, list[str]]]) -> None:
    """Refuse title and comment lines above the column names."""
    filled = ([cell for cell in row if cell.strip()] for _, row in lines)
    k, names = next(((k, cells) for k, cells in enumerate(filled) if len(cells) > 1), (0, []))
    if k and not any(map(is_number, names)):
        heading = f"line {lines[0][0]}" if k == 1 else f"lines {lines[0][0]} to {lines[k - 1][0]}"
        raise HcsearchError(
            f"{heading} of {path} {'names' if k == 1 else 'name'} no columns, line {lines[k][0]} does: leave out what "
            "stands above it"
        )


def rename_columns(columns: CsvColumns, known: Mapping[str, str], example: str) -> CsvColumns:
    """Return the table with recognised column names in their standard spelling; HcsearchError for a name twice.

    known : standard names by their `canonical_name` form.
    """
    names = tuple(known.get(canonical_name(name), name) for name in columns.names)
    refuse_repeated_names(columns.path, names, known.values(), example)
    return CsvColumns(columns.path, names, columns.rows)


def refuse_repeated_names(path: str, names: Sequence[str], wanted: Iterable[str], example: str) -> None:
    """Refuse columns of which two have one of the wanted names."""
    for name in wanted:
        if names.count(name) > 1:
            raise HcsearchError(
                f"the first line of {path} names no columns: {name} occurs {names.count(name)} times; "
                f"write one name for each, such as {example}"
            )


def canonical_name(name: str) -> str:
    """Return a column name in lower case with underscores: `angle_deg` for `Angle (deg)`."""
    return re.sub(r"[\W_]+", "_", name.replace("°", "deg").casefold()).strip("_")


def is_number(text: str) -> bool:
    """Whether a cell holds a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def is_measured(text: str) -> bool:
    """Whether a cell holds zero or a number of measurable magnitude."""
    return is_number(text) and (float(text) == 0.0 or MIN_MEASURED_VALUE <= abs(float(text)) <= MAX_MEASURED_VALUE)
