"""Bulk inserts that meet rows which are there already; SQLite and PostgreSQL share the syntax, not the way of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, Table, select
from sqlalchemy.dialects import sqlite

from hcsearch.store.postgresql import stage_rows

if TYPE_CHECKING:
    from sqlalchemy.dialects import postgresql

Columns = Mapping[str, Sequence[Any]]

_ROWS = 50  # of one statement: more gain nothing, and old builds of SQLite take 999 values
_COUNTED = {"preserve_rowcount": True}  # which SQLAlchemy drops after an INSERT


def insert_rows(connection: Connection, table: Table, columns: Columns, changed: Sequence[str] = ()) -> int:
    """Insert rows one after the other, given as columns of equal length, by name; return how many are new or changed.

    changed : columns to set in a row whose primary key is there already. Where empty, a row is passed over when any
    of its unique columns is taken.
    """
    keys = [column.name for column in table.primary_key]
    if connection.dialect.name == "sqlite":
        statement = _meeting(sqlite.insert(table), keys, changed)
        compiled = statement.compile(dialect=connection.dialect, column_keys=list(columns))
        assert compiled.positiontup is not None
        return _insert_tuples(connection, str(compiled), [columns[name] for name in compiled.positiontup])
    from sqlalchemy.dialects import postgresql  # noqa: PLC0415 - databases in files need none of it

    staged = stage_rows(connection, table, _last_of_each(keys, columns) if changed else columns)
    rows_in_order = select(*staged.c).order_by(*(staged.c[key] for key in keys))
    into = postgresql.insert(table).from_select(list(columns), rows_in_order)
    return connection.execute(_meeting(into, keys, changed), execution_options=_COUNTED).rowcount


def _insert_tuples(connection: Connection, statement: str, columns: Sequence[Sequence[Any]]) -> int:
    """Run an SQLite insert of one row for all rows, many to a statement: each costs as much as several rows."""
    n_rows, width = len(columns[0]), len(columns)
    values = list(chain.from_iterable(zip(*columns, strict=True)))
    row = f"({', '.join('?' * width)})"
    changed = 0
    for size, first, last in ((_ROWS, 0, n_rows - n_rows % _ROWS), (1, n_rows - n_rows % _ROWS, n_rows)):
        step = size * width
        parameters = [tuple(values[at : at + step]) for at in range(first * width, last * width, step)]
        if parameters:
            text = statement.replace(row, ", ".join([row] * size))
            changed += connection.exec_driver_sql(text, parameters, execution_options=_COUNTED).rowcount
    return changed


def _meeting(
    statement: sqlite.Insert | postgresql.Insert, keys: Sequence[str], changed: Sequence[str]
) -> sqlite.Insert | postgresql.Insert:
    if not changed:
        return statement.on_conflict_do_nothing()
    return statement.on_conflict_do_update(
        index_elements=list(keys), set_={name: statement.excluded[name] for name in changed}
    )


def _last_of_each(keys: Sequence[str], columns: Columns) -> Columns:
    """Leave out rows whose key comes once more: PostgreSQL updates no row twice in one statement."""
    last = {key: row for row, key in enumerate(zip(*(columns[name] for name in keys), strict=True))}
    return {name: [values[row] for row in last.values()] for name, values in columns.items()}
