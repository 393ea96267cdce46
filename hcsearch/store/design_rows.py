"""Storing batches of designs with their foldings in a transaction of the caller; fastest for new designs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import Connection, Row, Select, Table, bindparam, delete, select, update
from sqlalchemy.dialects import sqlite

from hcsearch.designs.records import NO_NUMBER, Columns, DesignBatch
from hcsearch.store.postgresql import stage_rows
from hcsearch.store.rows import next_id
from hcsearch.store.schema import design, folding

if TYPE_CHECKING:
    from sqlalchemy.dialects import postgresql

ColumnValues = Mapping[str, Sequence[Any]]

_ROWS = 50  # in one statement: more gain nothing, and old builds of SQLite take 999 values
_COUNTED = {"preserve_rowcount": True}  # which SQLAlchemy drops after an INSERT


def insert_rows(connection: Connection, table: Table, columns: ColumnValues, changed: Sequence[str] = ()) -> int:
    """Upsert rows, given as named columns of equal length, in their order; return how many are new or changed.

    changed : columns to update in a row whose primary key exists. If empty, a row that violates a unique constraint
    is skipped.
    """
    keys = [column.name for column in table.primary_key]
    if connection.dialect.name == "sqlite":
        statement = _meeting(sqlite.insert(table), keys, changed)
        compiled = statement.compile(dialect=connection.dialect, column_keys=list(columns))
        assert compiled.positiontup is not None
        return _insert_tuples(connection, str(compiled), [columns[name] for name in compiled.positiontup])
    from sqlalchemy.dialects import postgresql  # noqa: PLC0415 - only for servers

    staged = stage_rows(connection, table, _last_of_each(keys, columns) if changed else columns)
    rows_in_order = select(*staged.c).order_by(*(staged.c[key] for key in keys))
    into = postgresql.insert(table).from_select(list(columns), rows_in_order)
    return connection.execute(_meeting(into, keys, changed), execution_options=_COUNTED).rowcount


def _insert_tuples(connection: Connection, statement: str, columns: Sequence[Sequence[Any]]) -> int:
    """Run an SQLite insert for all rows, many per statement, since a statement costs as much as several rows."""
    n_rows, width = len(columns[0]), len(columns)
    values = list(chain.from_iterable(zip(*columns, strict=True)))
    row = f"({', '.join('?' * width)})"
    changed = 0
    for size, start_row, end_row in ((_ROWS, 0, n_rows - n_rows % _ROWS), (1, n_rows - n_rows % _ROWS, n_rows)):
        step = size * width
        parameters = [
            tuple(values[offset : offset + step]) for offset in range(start_row * width, end_row * width, step)
        ]
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


def _last_of_each(keys: Sequence[str], columns: ColumnValues) -> ColumnValues:
    """Keep the last row of each key: PostgreSQL cannot update a row twice in one statement."""
    last_row = {key: row for row, key in enumerate(zip(*(columns[name] for name in keys), strict=True))}
    return {name: [values[row] for row in last_row.values()] for name, values in columns.items()}


ColumnLists = dict[str, list[Any]]

INSERT_CHUNK_ROWS = 1000  # values of one IN (...), well below what SQLite and PostgreSQL take


def insert_designs(connection: Connection, location: str, designs: DesignBatch) -> None:
    """Store a batch: insert new designs and update stored ones in the columns of the stages that ran.

    location : of the database, for messages. The caller holds the write lock, so ids can be assigned beforehand.
    """
    if not len(designs):
        return
    first_new_id = next_id(connection, location, design.c.id, len(designs))
    ids = list(range(first_new_id, first_new_id + len(designs)))
    columns = _lists(designs.designs, len(designs))
    if insert_rows(connection, design, {"id": ids, **columns}) < len(designs):
        ids = _meet(connection, designs, columns, first_new_id)
    if rows := _folding_columns(designs, ids):
        keys = ("design_id", "crease", "opposite")
        insert_rows(connection, folding, rows, [name for name in rows if name not in keys])


def _lists(columns: Columns, count: int) -> ColumnLists:
    """Return columns as lists of plain values, with None for missing numbers."""
    return {name: _list(values, count) for name, values in columns.items()}


def _list(values: Any, count: int) -> list[Any]:
    if isinstance(values, np.ndarray):
        listed = values.tolist()
        return [None if v == NO_NUMBER else v for v in listed] if (values == NO_NUMBER).any() else listed
    return values if isinstance(values, list) else [values] * count


def _folding_columns(designs: DesignBatch, ids: Sequence[int]) -> ColumnLists:
    """Return the rows of foldings; empty without any."""
    columns = _lists(designs.foldings, len(designs.foldings.get("row", ())))
    rows = columns.pop("row", None)
    if not rows:
        return {}
    columns["opposite"] = [crease + designs.designs["n"] // 2 for crease in columns["crease"]]
    return {"design_id": [ids[row] for row in rows], **columns}


def _meet(connection: Connection, designs: DesignBatch, columns: ColumnLists, first_new_id: int) -> list[int]:
    """Update the designs with ids below `first`, which were stored before; return the ids of the whole batch."""
    id_of = ids_of_circuits(connection, columns["circuit"])
    ids = [id_of[circuit] for circuit in columns["circuit"]]
    names = [name for name in columns if name not in ("grid", "n", "circuit")]
    changes = [
        {"key": key, **{name: columns[name][row] for name in names}}
        for row, key in enumerate(ids)
        if key < first_new_id
    ]
    if changes:
        # The remaining keys of the rows are the columns to set.
        connection.execute(update(design).where(design.c.id == bindparam("key")), changes)
        _drop_refuted(connection, designs, ids, first_new_id)
    return ids


def _drop_refuted(connection: Connection, designs: DesignBatch, ids: Sequence[int], first_new_id: int) -> None:
    """Delete foldings of stored designs that a newer version of the stage no longer lists."""
    n_foldings = designs.designs.get("n_foldings")
    if n_foldings is None or int(n_foldings.sum()) != len(designs.foldings["row"]):
        return  # a search for untwisted foldings only refutes none
    rows = _folding_columns(designs, ids)
    listed = set(zip(rows.get("design_id", ()), rows.get("crease", ()), strict=True))
    key, crease = folding.c.design_id, folding.c.crease
    stored = select_rows_in(
        connection, select(key, crease), key, [design_id for design_id in ids if design_id < first_new_id]
    )
    refuted = [{"key": row.design_id, "at": row.crease} for row in stored if (row.design_id, row.crease) not in listed]
    if refuted:
        connection.execute(delete(folding).where(key == bindparam("key"), crease == bindparam("at")), refuted)


def ids_of_circuits(connection: Connection, circuits: Sequence[str]) -> dict[str, int]:
    """Return the id of each circuit that is stored."""
    rows = select_rows_in(connection, select(design.c.circuit, design.c.id), design.c.circuit, circuits)
    return {row.circuit: row.id for row in rows}


def select_rows_in(
    connection: Connection, statement: Select[Any], column: Any, values: Sequence[Any]
) -> Iterator[Row[Any]]:
    """Return the rows of a statement in which a column has one of some values, queried in chunks of a thousand."""
    for start in range(0, len(values), INSERT_CHUNK_ROWS):
        yield from connection.execute(statement.where(column.in_(values[start : start + INSERT_CHUNK_ROWS]))).all()
