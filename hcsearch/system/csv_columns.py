"""CSV files as instruments and spreadsheets write them: columns by the names of the first line."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.system.reading import MAX_INPUT_BYTES, read_text_file

MIN_MEASURED_VALUE, MAX_MEASURED_VALUE = 1e-30, 1e30
"""Sizes of numbers that are taken for measured: squares of others overflow or are nothing."""


@dataclass(frozen=True)
class CsvColumns:
    """A table as text.

    names : of the columns, as `canonical_name` writes them, "" where a column has none. rows : the number of each line
    in the file, and its cells; blank lines are left out.
    """

    path: str
    names: tuple[str, ...]
    rows: tuple[tuple[int, list[str]], ...]

    def texts(self, name: str) -> list[str]:
        """The cells of a column; "" where a line ends before it."""
        k = self.names.index(name)
        return [row[k].strip() if k < len(row) else "" for _, row in self.rows]

    def numbers(self, name: str) -> Reals:
        """The numbers of a column, NaN in cells that hold no measured number."""
        return np.array([float(text) if is_measured(text) else math.nan for text in self.texts(name)])

    def fault(self, row: int, name: str, remedy: str) -> HcsearchError:
        """The message on a cell without a measured number; remedy : what to do where nothing was measured."""
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


def read_columns(path: str, example: str, *, what: str = "", most: int = MAX_INPUT_BYTES) -> CsvColumns:
    """Read a CSV file whose first line names its columns.

    example : of a name, for messages. what : what the file should hold. most : its size in bytes. Empty cells after the
    last column are left out. Errors: HcsearchError for a first line of numbers, for columns that are not separated by
    commas, for lines above the names of columns, and for lines with more values than there are columns.
    """
    try:
        reader = csv.reader(io.StringIO(read_text_file(path, what, most=most), newline=""))
        lines = [(number, row) for number, row in enumerate(reader, 1) if any(map(str.strip, row))]
    except csv.Error as error:
        raise HcsearchError(f"{path} is no table: give a CSV file with a line of column names") from error
    if not lines:
        raise HcsearchError(f"{path} is empty: give a CSV file with a line of column names")
    first = [name.strip() for name in lines[0][1]]
    _refuse_title(path, lines)
    # a name of several words is no list of names, unless values stand there in the same way
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
    """Refuse titles and comments above the names of columns."""
    filled = ([cell for cell in row if cell.strip()] for _, row in lines)
    k, names = next(((k, cells) for k, cells in enumerate(filled) if len(cells) > 1), (0, []))
    if k and not any(map(is_number, names)):
        before = f"line {lines[0][0]}" if k == 1 else f"lines {lines[0][0]} to {lines[k - 1][0]}"
        raise HcsearchError(
            f"{before} of {path} {'names' if k == 1 else 'name'} no columns, line {lines[k][0]} does: leave out what "
            "stands above it"
        )


def rename_columns(columns: CsvColumns, known: Mapping[str, str], example: str) -> CsvColumns:
    """The columns, with names that are known as they are written here; HcsearchError where two have one name.

    known : names by what `canonical_name` makes of them.
    """
    names = tuple(known.get(canonical_name(name), name) for name in columns.names)
    for name in set(known.values()):
        if names.count(name) > 1:
            raise HcsearchError(
                f"the first line of {columns.path} names no columns: {name} stands there {names.count(name)} times; "
                f"write one name for each, such as {example}"
            )
    return CsvColumns(columns.path, names, columns.rows)


def canonical_name(name: str) -> str:
    """A name without case, brackets and spaces: angle_deg of `Angle (deg)`."""
    return re.sub(r"[\W_]+", "_", name.replace("°", "deg").casefold()).strip("_")


def is_number(text: str) -> bool:
    """Whether a cell holds a finite number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def is_measured(text: str) -> bool:
    """Whether a cell holds a number of a size that can be measured."""
    return is_number(text) and (float(text) == 0.0 or MIN_MEASURED_VALUE <= abs(float(text)) <= MAX_MEASURED_VALUE)
