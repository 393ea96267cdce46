"""Storing the units of one element, in one transaction; the same units again add nothing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select

from hcsearch.store.database import Database
from hcsearch.store.rows import next_id
from hcsearch.store.schema import unit
from hcsearch.store.upsert import insert_rows

_KEY_COLUMNS = ("circuit", "crease", "alpha", "shape", "merged", "placements")


def record_units(database: Database, units: Sequence[Mapping[str, Any]]) -> int:
    """Store units, given as the columns of the view `units` by name, without ids; return how many are new.

    A unit is known by its element and where the copies lie: a search that is run again gives the same.
    """
    if not units:
        return 0
    names = [column.name for column in unit.columns if column.name not in ("id", "key")]
    keys = [" ".join(str(row[name]) for name in _KEY_COLUMNS) for row in units]
    with database.writing() as connection:
        known = set(connection.execute(select(unit.c.key).where(unit.c.key.in_(keys))).scalars())
        # a key that comes twice in one call is one unit
        fresh = {key: row for key, row in zip(keys, units, strict=True) if key not in known}
        if not fresh:
            return 0
        columns: dict[str, list[Any]] = {name: [row[name] for row in fresh.values()] for name in names}
        first = next_id(connection, database.location, unit.c.id, len(fresh))
        ids = list(range(first, first + len(fresh)))
        return insert_rows(connection, unit, {"id": ids, "key": list(fresh), **columns})
