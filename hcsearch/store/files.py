"""Results as files, of text or Parquet by pyarrow: a file is written whole under its name, or not at all.

Parquet has integers of 64 bits, reals of 64 bits, text, bytes; NULL stays NULL.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, TYPE_CHECKING, Any

from hcsearch.basics.errors import QueryError
from hcsearch.store.formats import check_names, format_rows, plain
from hcsearch.store.rows import Row, Rows
from hcsearch.system.outputs import replacing

if TYPE_CHECKING:
    import pyarrow

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
    with replacing(path) as part:
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
        values = [None if value is None else str(plain(value)) for value in values]
    return pyarrow.array(values, kind)


def _groups(chunks: Iterator[Sequence[Row]]) -> Iterator[list[Row]]:
    rows = chain.from_iterable(chunks)
    while group := list(islice(rows, _GROUP)):
        yield group


@contextmanager
def _typed(rows: Rows, folder: Path) -> Iterator[tuple[list[str], Iterator[Sequence[Row]]]]:
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


def _spooled(spool: IO[bytes]) -> Iterator[Sequence[Row]]:
    while True:
        try:
            yield pickle.load(spool)
        except EOFError:
            return
