"""Results of queries, streamed in chunks or gathered; values have the types of SQLite."""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from itertools import chain
from typing import Any

from sqlalchemy import Column, Connection, CursorResult, Select, func, select
from sqlalchemy.exc import DBAPIError

from hcsearch.basics.errors import DatabaseError, HcsearchError, QueryError
from hcsearch.store.columns import view_names
from hcsearch.store.failures import is_of_database, is_of_values, is_refusal
from hcsearch.store.quantity import ColumnKind

ResultRow = tuple[Any, ...]

_NONE = type(None)
_TYPES: dict[str, set[type]] = {
    "integer": {int, _NONE},
    "boolean": {int, _NONE},
    "real": {int, float, _NONE},
    "text": {str, _NONE},
}

IDS_PER_STATEMENT = 5000
"""Largest number of design ids in one statement."""
FETCH_CHUNK_ROWS = 1000
"""Rows fetched at once."""


@dataclass(frozen=True)
class Result:
    """Column names, and rows of plain values (None for NULL)."""

    columns: tuple[str, ...]
    rows: tuple[ResultRow, ...]

    def records(self) -> list[dict[str, Any]]:
        """Return each row as a dict from column name to value."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]

    def stream(self) -> Rows:
        """Return the same result as a stream of one chunk."""
        return Rows(self.columns, (None,) * len(self.columns), iter([self.rows]))


@dataclass(frozen=True)
class Rows:
    """A streamed result; its chunks can be read once, while the query is open.

    kinds : of the columns; None if unknown before the values are read.
    """

    columns: tuple[str, ...]
    kinds: tuple[ColumnKind | None, ...]
    chunks: Iterator[Sequence[ResultRow]]

    def gathered(self) -> Result:
        """Return all rows as one result."""
        return Result(self.columns, tuple(chain.from_iterable(self.chunks)))


def parts_of_ids(ids: Sequence[int]) -> Iterator[list[int]]:
    """Split design ids into parts, one for each statement."""
    for start in range(0, len(ids), IDS_PER_STATEMENT):
        yield list(ids[start : start + IDS_PER_STATEMENT])


def chunks_of(cursor: CursorResult[Any], *, trusted: bool = True) -> Iterator[Sequence[ResultRow]]:
    """Fetch the rows of a cursor in chunks, with the errors of `raising_query_errors`."""
    while True:
        with raising_query_errors(trusted=trusted):
            fetched = cursor.fetchmany(FETCH_CHUNK_ROWS)
        if not fetched:
            return
        if cursor.dialect.name == "sqlite":
            yield [tuple(row) for row in fetched]
        else:
            yield [tuple(map(_plain, row)) for row in fetched]


def checked_rows(
    connection: Connection, location: str, statement: Select[Any], kinds: Sequence[ColumnKind | None]
) -> list[ResultRow]:
    """Return the rows of a SELECT of this program; errors as in `raising_query_errors` and `check_values`."""
    with raising_query_errors():
        cursor = connection.execute(statement)
    names = tuple(cursor.keys())
    rows = [row for chunk in chunks_of(cursor) for row in chunk]
    check_values(location, names, kinds, rows)
    return rows


def check_values(
    location: str, names: Sequence[str], kinds: Sequence[ColumnKind | None], rows: Iterable[Sequence[Any]]
) -> None:
    """Raise DatabaseError for values that do not fit their columns, infinities included; SQLite does not check them.

    kinds : of the named columns; None where any value is allowed. The error names the first such column.
    """
    for name, kind, values in zip(names, kinds, zip(*rows, strict=True), strict=False):
        if kind is not None and not _are(kind, values):
            raise DatabaseError(
                f"database {location} is damaged, column {name} holds what is no {kind} value: restore a copy, or "
                "mend it with `sqlite3 FILE`"
            )


def next_id(connection: Connection, location: str, column: Column[int], count: int = 1) -> int:
    """Return the first of `count` new row ids, in a writing transaction; DatabaseError if they are exhausted.

    Ids come from no sequence, which would lose numbers in failed transactions.
    """
    largest = connection.execute(select(func.max(column))).scalar() or 0
    check_values(location, [column.name], ["integer"], [(largest,)])
    if largest + count >= 2**63:
        raise DatabaseError(
            f"database {location} is damaged, column {column.name} of {column.table.name} holds the largest number: "
            "restore a copy, or mend it with `sqlite3 FILE`"
        )
    return largest + 1


def _are(kind: ColumnKind, values: Sequence[Any]) -> bool:
    """Return whether all values are NULL or of a kind."""
    if not set(map(type, values)) <= _TYPES[kind]:
        return False
    return kind != "real" or all(map(math.isfinite, filter(None, values)))


def _plain(value: Any) -> Any:
    """Convert a value of a server to the type that SQLite returns."""
    if value is None or type(value) in (int, str, float, bytes):
        return value
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, Decimal):  # sums are integers, averages are not
        return int(value) if value.is_finite() and value.as_tuple().exponent == 0 else float(value)
    return str(value)


@contextmanager
def raising_query_errors(*, trusted: bool = True) -> Iterator[None]:
    """Turn errors of a statement into QueryError; errors of the database itself, damaged or locked, pass.

    trusted : whether it is a statement of this program. One of a user may convert bytes to text, or overflow a sum.
    """
    try:
        yield
    except HcsearchError:
        raise
    except (DBAPIError, sqlite3.Error, sqlite3.Warning, ValueError) as error:
        cause = (error.orig if isinstance(error, DBAPIError) else None) or error
        detail = (str(cause) or type(cause).__name__).splitlines()[0]
        if is_refusal(cause):
            raise QueryError(f"the database is read-only here, run nothing but SELECT ({detail})") from error
        if is_of_database(cause) and (trusted or not is_of_values(cause)):
            raise
        views = ", ".join(view_names())
        raise QueryError(f"the SQL cannot be run ({detail}): write one SELECT; the views are {views}") from error
