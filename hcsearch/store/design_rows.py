"""Storing batches of designs with their foldings in a transaction of the caller; fastest for new designs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, Row, Select, Table, bindparam, delete, select, update
from sqlalchemy.dialects import sqlite

from hcsearch.designs.records import NO_NUMBER, DesignBatch, MobilityBatch
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
    columns = _design_columns(designs)
    if insert_rows(connection, design, {"id": ids, **columns}) < len(designs):
        ids = _meet(connection, designs, columns, first_new_id)
    if designs.folding_row is not None and len(designs.folding_row):
        rows = _folding_columns(designs, ids)
        insert_rows(connection, folding, rows, _stage_columns(rows))


def _design_columns(designs: DesignBatch) -> ColumnLists:
    columns: ColumnLists = {
        "grid": [designs.grid] * len(designs),
        "n": [designs.n] * len(designs),
        "circuit": designs.circuit,
        "array": designs.array,
        "array_symmetry": designs.array_symmetry.tolist(),
        "symmetry": designs.symmetry.tolist(),
        "n_fixed": designs.n_fixed.tolist(),
    }
    for name in ("n_foldings", "n_untwisted"):
        if (values := getattr(designs, name)) is not None:
            columns[name] = values.tolist()
    if designs.min_twist is not None:
        columns["min_twist"] = [None if twist < 0 else twist for twist in designs.min_twist.tolist()]
    if designs.best_crease is not None and designs.status is not None:
        columns["best_crease"] = [None if crease < 0 else crease for crease in designs.best_crease.tolist()]
        columns["status"] = list(designs.status)
    return columns


def _folding_columns(designs: DesignBatch, ids: Sequence[int]) -> ColumnLists:
    assert designs.folding_row is not None
    assert designs.folding_crease is not None
    creases = designs.folding_crease.tolist()
    columns: ColumnLists = {
        "design_id": [ids[row] for row in designs.folding_row.tolist()],
        "crease": creases,
        "opposite": [crease + designs.n // 2 for crease in creases],
    }
    if designs.folding_twist is not None:
        columns["twist"] = designs.folding_twist.tolist()
        if designs.mobility is not None:
            assert designs.folding_status is not None
            columns |= _mobility_columns(designs.mobility) | {"status": list(designs.folding_status)}
    return columns


def _mobility_columns(mobility: MobilityBatch) -> ColumnLists:
    columns: ColumnLists = {"kutzbach": [mobility.kutzbach] * len(mobility.dof)}
    for name in ("dof", "dof_folded", "dof_flat", "merged_panels", "kutzbach_merged", "dof_merged"):
        columns[name] = [None if value == NO_NUMBER else value for value in getattr(mobility, name).tolist()]
    return columns


def _stage_columns(columns: ColumnLists) -> list[str]:
    """Return the names of the folding columns that stages fill, which are all but the key."""
    return [name for name in columns if name not in ("design_id", "crease", "opposite")]


def _meet(connection: Connection, designs: DesignBatch, columns: ColumnLists, first_new_id: int) -> list[int]:
    """Update the designs with ids below `first`, which were stored before; return the ids of the whole batch."""
    id_of = ids_of_circuits(connection, designs.circuit)
    ids = [id_of[circuit] for circuit in designs.circuit]
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
    if designs.n_foldings is None or designs.folding_row is None or designs.folding_crease is None:
        return
    if int(designs.n_foldings.sum()) != len(designs.folding_row):
        return  # a search for untwisted foldings only refutes none
    rows = _folding_columns(designs, ids)
    listed = set(zip(rows["design_id"], rows["crease"], strict=True))
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
