"""Bulk inserts, and inserts that meet rows which are there already; SQLite and PostgreSQL share the syntax."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, Table
from sqlalchemy.dialects import postgresql, sqlite

Insert = sqlite.Insert | postgresql.Insert


def insert_rows(connection: Connection, statement: Insert, columns: Mapping[str, Sequence[Any]]) -> None:
    """Insert rows given as columns of equal length, by name."""
    compiled = statement.compile(dialect=connection.dialect, column_keys=list(columns))
    order = compiled.positiontup
    if order is None:
        rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
        connection.execute(statement, rows)
    else:
        # The same statement with plain tuples: twice as fast as dictionaries through `execute`.
        connection.exec_driver_sql(str(compiled), list(zip(*(columns[name] for name in order), strict=True)))


def insert_missing(connection: Connection, table: Table) -> Insert:
    """Return an insert that passes over rows whose unique columns are taken."""
    return _insert(connection, table).on_conflict_do_nothing()


def insert_or_update(connection: Connection, table: Table, columns: Sequence[str]) -> Insert:
    """Return an insert that, where the primary key is taken, sets these columns (none: leaves the row alone)."""
    statement = _insert(connection, table)
    if not columns:
        return statement.on_conflict_do_nothing()
    changed = {name: statement.excluded[name] for name in columns}
    return statement.on_conflict_do_update(index_elements=[column.name for column in table.primary_key], set_=changed)


def _insert(connection: Connection, table: Table) -> Insert:
    return sqlite.insert(table) if connection.dialect.name == "sqlite" else postgresql.insert(table)
