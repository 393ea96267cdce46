"""Writing results as text (table, csv, json, markdown) or Parquet; files are written atomically.

Types in Parquet are 64-bit integers, 64-bit reals, text and bytes; NULL stays NULL.
"""

from __future__ import annotations

import csv
import io
import json
import math
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
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
    """Yield a result as pieces of text that end in a newline; integers stay integers.

    Tables are gathered first to find the widths of columns. QueryError: an unknown style, or one that is no text.
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
    """A file for the csv module that turns CR LF into LF; with CR LF as line end the module quotes CR in values."""

    def write(self, record: str) -> int:
        return super().write(record.removesuffix("\r\n") + "\n")

    def take(self) -> str:
        """Return the text written since the last call."""
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
    """Yield a JSON array with one object per line, for JSON readers and line tools alike."""
    check_names(rows, "json")
    separator = "["
    for chunk in rows.chunks:
        lines = [
            json.dumps(dict(zip(rows.columns, map(plain_value, row), strict=True)), ensure_ascii=False) for row in chunk
        ]
        yield separator + ",\n ".join(lines)
        separator = ",\n "
    yield "[]\n" if separator == "[" else "]\n"


def check_names(rows: Rows, style: str) -> None:
    """Raise QueryError for duplicate column names if the style cannot distinguish them."""
    if len(set(rows.columns)) < len(rows.columns):
        raise QueryError(f"two columns have the same name, which {style} cannot hold: rename one with AS")


def plain_value(value: Any) -> Any:
    """Return bytes and infinite numbers, which the formats lack, as text; other values unchanged."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _tabulate(rows: Rows, style: str) -> Iterator[str]:
    from tabulate import tabulate  # noqa: PLC0415 - only these two formats need it

    result = rows.gathered()
    numeric = [all(_is_number(row[column]) for row in result.rows) for column in range(len(result.columns))]
    # Cells are text here: tabulate would read 0123 as a number, and a column with NULLs as floats.
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
    # A cell is one line without control characters; a bar would end it in Markdown.
    text = printable(" ".join(text.splitlines()))
    return text.replace("|", "\\|") if style == "pipe" else text


_GROUP = 1 << 15
"""Rows of a Parquet row group: enough to compress well, few enough to hold in memory."""

_KINDS = {"integer": "int64", "boolean": "int64", "real": "float64", "text": "string"}
# For the types of values in a column of unknown kind; any other mixture becomes text.
_TYPES: dict[frozenset[type], str] = {
    frozenset(): "null",
    frozenset({int}): "int64",
    frozenset({float}): "float64",
    frozenset({int, float}): "float64",
    frozenset({bytes}): "binary",
}


def save_rows(rows: Rows, style: str, path: Path) -> None:
    """Write a result to a file, replacing an older one; text is UTF-8.

    OutputError: the file cannot be written, or is a database. QueryError: the style cannot hold the result.
    """
    with replacing_file(path) as part:
        if style == "parquet":
            write_parquet_rows(rows, part)
        else:
            with part.open("w", encoding="utf-8", newline="") as file:
                file.writelines(format_rows(rows, style))


def check_parquet() -> None:
    """Raise QueryError if pyarrow is not installed."""
    try:
        import pyarrow.parquet  # noqa: F401, PLC0415 - an extra
    except ImportError as error:
        raise QueryError("the format parquet needs pyarrow: pip install 'hcsearch[parquet]'") from error


def write_parquet_rows(
    rows: Rows,
    path: Path,
    column_notes: Mapping[str, Mapping[str, str]] | None = None,
    notes: Mapping[str, str] | None = None,
) -> None:
    """Write a result to Parquet in row groups, in little memory; yes/no columns are 0 and 1, as stored.

    column_notes : metadata of columns, by name. notes : metadata of the file.
    QueryError: pyarrow is not installed, or two columns have the same name.
    """
    check_parquet()
    import pyarrow.parquet  # noqa: PLC0415 - an extra

    check_names(rows, "parquet")
    with _typed(rows, path.parent) as (types, chunks):
        fields = [
            pyarrow.field(name, getattr(pyarrow, kind)(), metadata=(column_notes or {}).get(name))
            for name, kind in zip(rows.columns, types, strict=True)
        ]
        schema = pyarrow.schema(fields, metadata=notes)
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
    """Yield the column types and the rows; unknown types are found in a first pass over all rows."""
    if None not in rows.kinds:
        yield [_KINDS[kind] for kind in rows.kinds if kind is not None], rows.chunks
        return
    # A file has one type per column, which may depend on the last row; so rows are spooled to disk.
    with TemporaryFile(dir=folder) as spool:
        types_of: list[set[type]] = [set() for _ in rows.columns]
        for chunk in rows.chunks:
            for types, values in zip(types_of, zip(*chunk, strict=True), strict=True):
                types.update(map(_type, values))
            pickle.dump(chunk, spool)
        spool.seek(0)
        yield [_TYPES.get(frozenset(types - {type(None)}), "string") for types in types_of], _spooled(spool)


def _type(value: Any) -> type:
    """Return the type of a value; an integer beyond 64 bits, which only servers have, counts as text."""
    return str if type(value) is int and not -(2**63) <= value < 2**63 else type(value)


def _spooled(spool: IO[bytes]) -> Iterator[Sequence[ResultRow]]:
    while True:
        try:
            yield pickle.load(spool)
        except EOFError:
            return
