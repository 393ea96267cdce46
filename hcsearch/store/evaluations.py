"""Checks of spring sets, kept so that none is computed twice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select

from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.schema import evaluation
from hcsearch.store.upsert import insert_rows


@again
def find_evaluations(database: Database, subject: str) -> list[Mapping[str, Any]]:
    """All evaluations of a subject, as columns of the table by name."""
    with database.reading() as connection:
        return [
            dict(row)
            for row in connection.execute(select(evaluation).where(evaluation.c.subject == subject)).mappings()
        ]


def record_evaluations(database: Database, rows: Sequence[Mapping[str, Any]]) -> int:
    """Store evaluations in one transaction; return how many are new."""
    if not rows:
        return 0
    names = [column.name for column in evaluation.columns]
    with database.writing() as connection:
        return insert_rows(connection, evaluation, {name: [row[name] for row in rows] for name in names})
