"""Results as text: table, csv, json or markdown. NULL is `-` in tables, empty in csv, null in json."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hcsearch.errors import QueryError

if TYPE_CHECKING:
    from hcsearch.store.queries import Result

FORMATS = ("table", "csv", "json", "markdown")


def format_result(result: Result, style: str) -> str:
    """Return a result as text that ends its last line; integers stay integers. QueryError for an unknown style."""
    writers: dict[str, Callable[[Result], str]] = {
        "table": lambda result: _tabulate(result, "simple"),
        "csv": _csv,
        "json": _json,
        "markdown": lambda result: _tabulate(result, "pipe"),
    }
    if style not in writers:
        raise QueryError(f"no format {style!r}: choose one of {', '.join(FORMATS)}")
    return writers[style](result)


class _Lines(io.StringIO):
    """Takes records that end in CR LF and ends them in LF. Only so does the csv module quote a CR within a value."""

    def write(self, record: str) -> int:
        return super().write(record.removesuffix("\r\n") + "\n")


def _csv(result: Result) -> str:
    text = _Lines(newline="")
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(result.columns)
    writer.writerows([_plain(value) for value in row] for row in result.rows)
    return text.getvalue()


def _json(result: Result) -> str:
    """Write one object a line, so that the text can be read both as a whole and by line tools."""
    if len(set(result.columns)) < len(result.columns):
        raise QueryError("two columns have the same name, which json cannot hold: rename one with AS")
    lines = [
        json.dumps(dict(zip(result.columns, map(_plain, row), strict=True)), ensure_ascii=False) for row in result.rows
    ]
    return "[" + ",\n ".join(lines) + "]\n"


def _plain(value: Any) -> Any:
    """Put what SQL knows and the formats do not into words: bytes, and numbers that are infinite."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _tabulate(result: Result, style: str) -> str:
    from tabulate import tabulate  # noqa: PLC0415 - only these two formats need it

    numeric = [all(_is_number(row[at]) for row in result.rows) for at in range(len(result.columns))]
    # Cells are text by now: tabulate would read 0123 as a number, and a column with NULLs as floats.
    text = tabulate(
        [[_cell(value, style) for value in row] for row in result.rows],
        headers=[_cell(name, style) for name in result.columns],
        tablefmt=style,
        disable_numparse=True,
        colalign=["right" if number else "left" for number in numeric] if result.rows else None,
    )
    return text + "\n"


def _is_number(value: Any) -> bool:
    return value is None or isinstance(value, int | float)


def _cell(value: Any, style: str) -> str:
    if value is None:
        return "-"
    text = f"{value:.6g}" if isinstance(value, float) else str(_plain(value))
    # A cell is one line, and a bar would end it in markdown.
    text = " ".join(text.splitlines())
    return text.replace("|", "\\|") if style == "pipe" else text
