"""Results as text (table, csv, json, markdown) or Parquet, and as files that are written whole or not at all.

Parquet has integers of 64 bits, reals of 64 bits, text, bytes; NULL stays NULL.
"""

from __future__ import annotations

import csv
import io
import json
import math
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, TYPE_CHECKING, Any

from hcsearch.basics.errors import QueryError, printable
from hcsearch.system.outputs import replacing_file
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    import pyarrow

    from hcsearch.store.rows import ResultRow, Rows


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
        writer.writerows([plain_value(value) for value in row] for row in chunk)
        yield text.take()
    yield text.take()


def _json(rows: Rows) -> Iterator[str]:
    """Write one object a line, so that the text can be read both as a whole and by line tools."""
    check_names(rows, "json")
    before = "["
    for chunk in rows.chunks:
        lines = [
            json.dumps(dict(zip(rows.columns, map(plain_value, row), strict=True)), ensure_ascii=False) for row in chunk
        ]
        yield before + ",\n ".join(lines)
        before = ",\n "
    yield "[]\n" if before == "[" else "]\n"


def check_names(rows: Rows, style: str) -> None:
    """Refuse columns of the same name, for a style that cannot keep them apart."""
    if len(set(rows.columns)) < len(rows.columns):
        raise QueryError(f"two columns have the same name, which {style} cannot hold: rename one with AS")


def plain_value(value: Any) -> Any:
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
    text = short_number(value, 6) if isinstance(value, float) else str(plain_value(value))
    # A cell is one line that no terminal acts on, and a bar would end it in markdown.
    text = printable(" ".join(text.splitlines()))
    return text.replace("|", "\\|") if style == "pipe" else text


_GROUP = 1 << 15
"""Rows of a row group: enough to compress well, few enough to hold in memory."""

_KINDS = {"integer": "int64", "boolean": "int64", "real": "float64", "text": "string"}
# Of the values of a column whose kind is not known; any other mixture becomes text.
_TYPES: dict[frozenset[type], str] = {
    frozenset(): "null",
    frozenset({int}): "int64",
    frozenset({float}): "float64",
    frozenset({int, float}): "float64",
    frozenset({bytes}): "binary",
}


def save_rows(rows: Rows, style: str, path: Path) -> None:
    """Write a result to a file, in the place of an older one; text is UTF-8.

    OutputError: the file cannot be written, or is a database. QueryError: the style cannot hold the result.
    """
    with replacing_file(path) as part:
        if style == "parquet":
            _write_parquet(rows, part)
        else:
            with part.open("w", encoding="utf-8", newline="") as file:
                file.writelines(format_rows(rows, style))


def _write_parquet(rows: Rows, path: Path) -> None:
    """Write a result as row groups, in little memory; yes/no columns are 0 and 1, as they are stored.

    QueryError: pyarrow is not there, or two columns have the same name.
    """
    try:
        import pyarrow  # noqa: PLC0415 - an extra
        import pyarrow.parquet  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise QueryError("the format parquet needs pyarrow: pip install 'hcsearch[parquet]'") from error
    check_names(rows, "parquet")
    with _typed(rows, path.parent) as (types, chunks):
        schema = pyarrow.schema(
            [(name, getattr(pyarrow, kind)()) for name, kind in zip(rows.columns, types, strict=True)]
        )
        with pyarrow.parquet.ParquetWriter(path, schema) as writer:
            for group in _groups(chunks):
                columns = [
                    _column(values, kind) for values, kind in zip(zip(*group, strict=True), schema.types, strict=True)
                ]
                writer.write_batch(pyarrow.record_batch(columns, schema=schema))


def _column(values: Sequence[Any], kind: pyarrow.DataType) -> pyarrow.Array:
    import pyarrow  # noqa: PLC0415 - an extra

    if kind == pyarrow.float64():
        values = [None if value is None else float(value) for value in values]
    elif kind == pyarrow.string():
        values = [None if value is None else str(plain_value(value)) for value in values]
    return pyarrow.array(values, kind)


def _groups(chunks: Iterator[Sequence[ResultRow]]) -> Iterator[list[ResultRow]]:
    rows = chain.from_iterable(chunks)
    while group := list(islice(rows, _GROUP)):
        yield group


@contextmanager
def _typed(rows: Rows, folder: Path) -> Iterator[tuple[list[str], Iterator[Sequence[ResultRow]]]]:
    """Give the types of the columns before the first row, from all rows where they are not known beforehand."""
    if None not in rows.kinds:
        yield [_KINDS[kind] for kind in rows.kinds if kind is not None], rows.chunks
        return
    # A file has one type a column, and its type may depend on the last row; so the rows wait on the disk.
    with TemporaryFile(dir=folder) as spool:
        types_of: list[set[type]] = [set() for _ in rows.columns]
        for chunk in rows.chunks:
            for types, values in zip(types_of, zip(*chunk, strict=True), strict=True):
                types.update(map(_type, values))
            pickle.dump(chunk, spool)
        spool.seek(0)
        yield [_TYPES.get(frozenset(types - {type(None)}), "string") for types in types_of], _spooled(spool)


def _type(value: Any) -> type:
    """Type of a value; a whole number too long for 64 bits, which only servers have, counts as text."""
    return str if type(value) is int and not -(2**63) <= value < 2**63 else type(value)


def _spooled(spool: IO[bytes]) -> Iterator[Sequence[ResultRow]]:
    while True:
        try:
            yield pickle.load(spool)
        except EOFError:
            return
