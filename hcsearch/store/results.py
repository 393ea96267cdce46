"""Results of ranking, tuning and the search for units: scores of designs, evaluations of spring sets, units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Integer, Text, bindparam, delete, select

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import Kind
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.rows import check_values, next_id
from hcsearch.store.schema import evaluation, score, unit
from hcsearch.store.upsert import insert_rows

_EVALUATION_KINDS: list[Kind] = [
    "text" if isinstance(column.type, Text) else "integer" if isinstance(column.type, Integer) else "real"
    for column in evaluation.columns
]
_UNIT_KEY = ("circuit", "crease", "alpha", "shape", "merged", "placements")


def save_scores(database: Database, scores: Mapping[int, float | None], scene: str = DEFAULT_SCENE_NAME) -> None:
    """Set the scores of designs in a scene by id, None for no score, in one transaction; those of others stay."""
    known = {design: value for design, value in scores.items() if value is not None}
    none = [{"key": design} for design, value in scores.items() if value is None]
    with database.writing() as connection:
        if known:
            columns: dict[str, list[Any]] = {
                "scene": [scene] * len(known),
                "design_id": list(known),
                "score": list(known.values()),
            }
            insert_rows(connection, score, columns, ("score",))
        if none:
            gone = delete(score).where(score.c.scene == scene, score.c.design_id == bindparam("key"))
            connection.execute(gone, none)


@again
def find_evaluations(database: Database, subject: str) -> list[Mapping[str, Any]]:
    """Return all evaluations of a subject, as columns of the table by name; DatabaseError for damaged values."""
    with database.reading() as connection:
        rows = connection.execute(select(evaluation).where(evaluation.c.subject == subject)).all()
    check_values(database.location, evaluation.columns.keys(), _EVALUATION_KINDS, rows)
    return [dict(row._mapping) for row in rows]


def record_evaluations(database: Database, rows: Sequence[Mapping[str, Any]]) -> int:
    """Store evaluations in one transaction; return how many are new."""
    if not rows:
        return 0
    names = [column.name for column in evaluation.columns]
    with database.writing() as connection:
        return insert_rows(connection, evaluation, {name: [row[name] for row in rows] for name in names})


def record_units(database: Database, units: Sequence[Mapping[str, Any]]) -> int:
    """Store the units of one element in one transaction; return how many are new.

    units : as the columns of the view `units` by name, without ids.
    A unit is known by its element and where the copies lie: a search that is run again gives the same.
    """
    if not units:
        return 0
    names = [column.name for column in unit.columns if column.name not in ("id", "key")]
    keys = [" ".join(str(row[name]) for name in _UNIT_KEY) for row in units]
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
