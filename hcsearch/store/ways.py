"""The verdict on a folding in a scene, and what it was drawn from: the deployment that deploys, the proved path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from sqlalchemy import and_
from sqlalchemy import select as sql_select

from hcsearch.scenes import DEFAULT
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.schema import deployment, motion, verdict
from hcsearch.vocabulary import Status, Way


@dataclass(frozen=True)
class StoredVerdict:
    """The verdict on a folding in a scene.

    path : how flat pairs are joined in the proved path; None without one. deployed : the name of the scene that
    deploys, which is this one, perhaps with other flat pairs and springs; None without one.
    """

    status: Status
    path: Way | None
    deployed: str | None


@again
def find_verdict(database: Database, number: int, crease: int, scene: str = DEFAULT) -> StoredVerdict | None:
    """The verdict on the folding of a design in a scene; None where no stage has judged it there."""
    same = [
        and_(other.c.design_id == verdict.c.design_id, other.c.crease == verdict.c.crease)
        for other in (motion, deployment)
    ]
    statement = (
        sql_select(verdict.c.status, motion.c.flat_pairs, deployment.c.scene)
        .outerjoin(motion, and_(same[0], motion.c.scene == verdict.c.scene))
        .outerjoin(deployment, and_(same[1], deployment.c.base == verdict.c.scene, deployment.c.status == "deploys"))
        .where(verdict.c.design_id == number, verdict.c.crease == crease, verdict.c.scene == scene)
        .order_by(deployment.c.scene)
    )
    with database.reading() as connection:
        row = connection.execute(statement).first()
    if row is None:
        return None
    return StoredVerdict(cast("Status", row[0]), cast("Way | None", row[1]), row[2])
