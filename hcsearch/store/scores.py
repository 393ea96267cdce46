"""Storing the scores of designs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import bindparam, delete

from hcsearch.scenes import DEFAULT
from hcsearch.store.database import Database
from hcsearch.store.schema import score
from hcsearch.store.upsert import insert_rows


def save_scores(database: Database, scores: Mapping[int, float | None], scene: str = DEFAULT) -> None:
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
