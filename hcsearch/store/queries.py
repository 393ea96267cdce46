"""Reading: rows of a view by the query language, any read-only SQL, and one design with its foldings."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, CursorResult
from sqlalchemy import select as sql_select
from sqlalchemy.exc import DBAPIError

from hcsearch.errors import HcsearchError, QueryError
from hcsearch.store.columns import column_names, view_names
from hcsearch.store.conditions import find_quantity, parse_query, sort_terms, split_names, view_table
from hcsearch.store.database import Database
from hcsearch.store.failures import is_of_database, is_refusal

__all__ = ["Result", "find_design", "parse_query", "select", "select_sql"]

# What tells the rows of a view apart: the last resort of every order, so that results are the same each time.
_IDENTITY = {
    "designs": ("id",),
    "foldings": ("design_id", "crease"),
    "deployments": ("design_id", "crease", "scene"),
    "runs": ("id",),
}


@dataclass(frozen=True)
class Result:
    """Names of the columns, and rows of plain values (None for NULL)."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


def select(
    database: Database,
    query: str = "",
    *,
    columns: str | Sequence[str] = "",
    sort: str = "",
    limit: int | None = None,
    view: str = "designs",
) -> Result:
    """Return the rows of a view that satisfy a query (see `conditions`).

    columns : names, a sequence or separated by commas; all where empty.
    sort : names separated by commas, `-` before a name for descending; NULL comes last either way.
    """
    source = view_table(view)
    names = split_names(columns) or list(column_names(view))
    statement = sql_select(*(source.c[find_quantity(view, name).name] for name in names))
    statement = statement.where(parse_query(query, view))
    for name, descending in sort_terms(view, sort):
        key = source.c[name]
        statement = statement.order_by((key.desc() if descending else key.asc()).nulls_last())
    statement = statement.order_by(*(source.c[name] for name in _IDENTITY[view]))
    if limit is not None:
        if limit < 0:
            raise QueryError(f"the limit {limit} is negative: give a number of rows, or leave it out")
        statement = statement.limit(min(limit, 2**63 - 1))
    with database.reading() as connection, _refusing():
        return _result(connection.execute(statement))


def select_sql(database: Database, sql: str) -> Result:
    """Return the rows of one SQL statement that only reads; the database must come from `open_readonly`.

    QueryError: a statement that would change something, several statements, or a mistake in the SQL.
    """
    if not database.readonly:
        raise QueryError("SQL is run on read-only databases: open this one with open_readonly")
    with database.reading() as connection, _refusing():
        if connection.dialect.name != "sqlite":
            _begin_reading(connection, sql)
        # The text goes to the driver as it is: no parameters, so neither `:` nor `%` mean anything.
        cursor = connection.execution_options(no_parameters=True).exec_driver_sql(sql)
        if not cursor.returns_rows:
            raise QueryError("the SQL returns no rows, and the database is read-only: write a SELECT")
        return _result(cursor)


def _result(cursor: CursorResult[Any]) -> Result:
    return Result(tuple(cursor.keys()), tuple(tuple(row) for row in cursor))


def _begin_reading(connection: Connection, sql: str) -> None:
    """Make the transaction of a server read-only for good: it cannot be loosened after its first statement."""
    if ";" in sql.strip().rstrip(";"):
        raise QueryError("several statements, or a semicolon in a text: write one SELECT, the database is read-only")
    connection.exec_driver_sql("SET TRANSACTION READ ONLY")
    connection.exec_driver_sql("SELECT 1")


@contextmanager
def _refusing() -> Iterator[None]:
    """Turn a mistake in a statement into QueryError; a damaged or locked database is not the statement's fault."""
    try:
        yield
    except HcsearchError:
        raise
    except (DBAPIError, sqlite3.Error, sqlite3.Warning, ValueError) as error:
        cause = (error.orig if isinstance(error, DBAPIError) else None) or error
        detail = (str(cause) or type(cause).__name__).splitlines()[0]
        if is_refusal(cause):
            raise QueryError(f"the database is read-only here, run nothing but SELECT ({detail})") from error
        if is_of_database(cause):
            raise
        views = ", ".join(view_names())
        raise QueryError(f"the SQL cannot be run ({detail}): write one SELECT; the views are {views}") from error


def find_design(database: Database, text: str) -> dict[str, Any]:
    """Return the row of `designs` of an id or a circuit notation, with its rows of `foldings` under that key."""
    by_id = re.fullmatch(r"[0-9]+", text) is not None
    source = view_table("designs")
    wanted = source.c.id == int(text[:20]) if by_id else source.c.circuit == text.encode(errors="replace").decode()
    if by_id and int(text[:20]) >= 2**63:
        raise _unknown(database, text)
    with database.reading() as connection:
        found = connection.execute(sql_select(source).where(wanted)).mappings().first()
    if found is None:
        raise _unknown(database, text)
    foldings = select(database, f"design_id={found['id']}", view="foldings")
    return {**found, "foldings": [dict(zip(foldings.columns, row, strict=True)) for row in foldings.rows]}


def _unknown(database: Database, text: str) -> QueryError:
    return QueryError(f"no design {text!r} in {database.location}: give an id or a circuit that `hcsearch query` lists")
