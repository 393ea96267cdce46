"""Results as text: table, csv, json or markdown. NULL is `-` in tables, empty in csv, null in json."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from hcsearch.basics.errors import QueryError, printable
from hcsearch.system.terminal import short

if TYPE_CHECKING:
    from hcsearch.store.rows import Rows

FORMATS = ("table", "csv", "json", "markdown", "parquet")


def format_rows(rows: Rows, style: str) -> Iterator[str]:
    """Give a result as text, piece by piece, the last line ended; integers stay integers.

    Tables are gathered first, for the widths of their columns. QueryError: a style that is unknown or no text.
    """
    writers: dict[str, Callable[[Rows], Iterator[str]]] = {
        "table": lambda rows: _tabulate(rows, "simple"),
        "csv": _csv,
        "json": _json,
        "markdown": lambda rows: _tabulate(rows, "pipe"),
    }
    if style == "parquet":
        raise QueryError("parquet is not text: name a file for it with --output FILE")
    if style not in writers:
        raise QueryError(f"no format {style!r}: choose one of {', '.join(FORMATS)}")
    return writers[style](rows)


class _Lines(io.StringIO):
    """Takes records that end in CR LF and ends them in LF. Only so does the csv module quote a CR within a value."""

    def write(self, record: str) -> int:
        return super().write(record.removesuffix("\r\n") + "\n")

    def take(self) -> str:
        """Return what has been written since the last time."""
        text = self.getvalue()
        self.seek(0)
        self.truncate()
        return text


def _csv(rows: Rows) -> Iterator[str]:
    text = _Lines(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(rows.columns)
    for chunk in rows.chunks:
        writer.writerows([plain(value) for value in row] for row in chunk)
        yield text.take()
    yield text.take()


def _json(rows: Rows) -> Iterator[str]:
    """Write one object a line, so that the text can be read both as a whole and by line tools."""
    check_names(rows, "json")
    before = "["
    for chunk in rows.chunks:
        lines = [json.dumps(dict(zip(rows.columns, map(plain, row), strict=True)), ensure_ascii=False) for row in chunk]
        yield before + ",\n ".join(lines)
        before = ",\n "
    yield "[]\n" if before == "[" else "]\n"


def check_names(rows: Rows, style: str) -> None:
    """Refuse columns of the same name, for a style that cannot keep them apart."""
    if len(set(rows.columns)) < len(rows.columns):
        raise QueryError(f"two columns have the same name, which {style} cannot hold: rename one with AS")


def plain(value: Any) -> Any:
    """Put what SQL knows and the formats do not into words: bytes, and numbers that are infinite."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _tabulate(rows: Rows, style: str) -> Iterator[str]:
    from tabulate import tabulate  # noqa: PLC0415 - only these two formats need it

    result = rows.gathered()
    numeric = [all(_is_number(row[at]) for row in result.rows) for at in range(len(result.columns))]
    # Cells are text by now: tabulate would read 0123 as a number, and a column with NULLs as floats.
    text = tabulate(
        [[_cell(value, style) for value in row] for row in result.rows],
        headers=[_cell(name, style) for name in result.columns],
        tablefmt=style,
        disable_numparse=True,
        colalign=["right" if number else "left" for number in numeric] if result.rows else None,
    )
    yield text + "\n"


def _is_number(value: Any) -> bool:
    return value is None or isinstance(value, int | float)


def _cell(value: Any, style: str) -> str:
    if value is None:
        return "-"
    text = short(value, 6) if isinstance(value, float) else str(plain(value))
    # A cell is one line that no terminal acts on, and a bar would end it in markdown.
    text = printable(" ".join(text.splitlines()))
    return text.replace("|", "\\|") if style == "pipe" else text
