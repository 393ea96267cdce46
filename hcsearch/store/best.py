"""Which folding gave a design its status, as the stages recorded it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sqlalchemy import Connection, and_, func
from sqlalchemy import select as sql_select

from hcsearch.scenes import DEFAULT
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.rows import parts_of
from hcsearch.store.schema import design, folding, outcome, verdict
from hcsearch.vocabulary import STATUSES


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


def chosen_foldings(connection: Connection, ids: Sequence[int], scene: str) -> dict[int, tuple[int, str]]:
    """Crease and status of the best folding of each design by its verdicts in a scene, as they are stored now.

    The same order as that of `stages.statuses.best_foldings`: status, needed margin, degrees of freedom, crease.
    """
    own = verdict.join(folding, and_(folding.c.design_id == verdict.c.design_id, folding.c.crease == verdict.c.crease))
    columns = verdict.c.design_id, verdict.c.crease, verdict.c.status, verdict.c.needed_margin, folding.c.dof
    statement = sql_select(*columns).select_from(own).where(verdict.c.scene == scene)
    best: dict[int, tuple[int, str]] = {}
    least: dict[int, tuple[float, ...]] = {}
    for part in parts_of(ids):
        for number, crease, status, margin, dof in connection.execute(statement.where(verdict.c.design_id.in_(part))):
            place = (STATUSES.index(status), *(math.inf if v is None else float(v) for v in (margin, dof)), crease)
            if number not in best or place < least[number]:
                best[number], least[number] = (crease, status), place
    return best
