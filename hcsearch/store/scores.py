"""Storing the scores of designs."""

from __future__ import annotations

from collections.abc import Mapping

from sqlalchemy import bindparam, update

from hcsearch.store.database import Database
from hcsearch.store.schema import design


def save_scores(database: Database, scores: Mapping[int, float | None]) -> None:
    """Set the scores of designs by id, None for no score, in one transaction; scores of other designs stay."""
    score = bindparam("value", type_=design.c.score.type)
    changed = (
        update(design)
        .where(design.c.id == bindparam("key"), design.c.score.is_distinct_from(score))  # the same again writes nothing
        .values(score=score)
    )
    with database.writing() as connection:
        if scores:
            connection.execute(changed, [{"key": key, "value": value} for key, value in scores.items()])
