"""Checks of spring sets, kept so that none is computed twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Integer, Text, select

from hcsearch.store.columns import Kind
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.rows import check_values
from hcsearch.store.schema import evaluation
from hcsearch.store.upsert import insert_rows

_KINDS: list[Kind] = [
    "text" if isinstance(column.type, Text) else "integer" if isinstance(column.type, Integer) else "real"
    for column in evaluation.columns
]


@again
def find_evaluations(database: Database, subject: str) -> list[Mapping[str, Any]]:
    """All evaluations of a subject, as columns of the table by name; DatabaseError for values that they cannot hold."""
    with database.reading() as connection:
        rows = connection.execute(select(evaluation).where(evaluation.c.subject == subject)).all()
    check_values(database.location, evaluation.columns.keys(), _KINDS, rows)
    return [dict(row._mapping) for row in rows]


def record_evaluations(database: Database, rows: Sequence[Mapping[str, Any]]) -> int:
    """Store evaluations in one transaction; return how many are new."""
    if not rows:
        return 0
    names = [column.name for column in evaluation.columns]
    with database.writing() as connection:
        return insert_rows(connection, evaluation, {name: [row[name] for row in rows] for name in names})
