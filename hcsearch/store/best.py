"""Which folding gave a design its status, as the stages recorded it."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import and_, func
from sqlalchemy import select as sql_select

from hcsearch.scenes import DEFAULT
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.rows import parts_of
from hcsearch.store.schema import design, outcome


@again
def best_creases(database: Database, ids: Sequence[int], scene: str = DEFAULT) -> dict[int, int]:
    """The crease of the best folding of each design in a scene, as in the view `designs`; designs without one left out.

    The best folding is chosen by `stages.statuses.best_foldings`, once, when verdicts are recorded.
    """
    creases: dict[int, int] = {}
    best = func.coalesce(outcome.c.best_crease, design.c.best_crease)
    joined = design.outerjoin(outcome, and_(outcome.c.design_id == design.c.id, outcome.c.scene == scene))
    with database.reading() as connection:
        for part in parts_of(ids):
            statement = sql_select(design.c.id, best).select_from(joined)
            statement = statement.where(design.c.id.in_(part), best.is_not(None))
            creases.update((row[0], row[1]) for row in connection.execute(statement))
    return creases
