"""Reading what is known of foldings in a scene: the best one of a design, the verdict on one, its path."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from sqlalchemy import Row, Select, and_, func
from sqlalchemy import select as sql_select

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import DatabaseError
from hcsearch.basics.vocabulary import Status, Way
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.scenes.looks import SceneVariant
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.rows import check_values, parts_of
from hcsearch.store.schema import deployment, design, motion, outcome, verdict

LARGEST_PATH = 8 << 20
"""Bytes of the states of a path, far beyond those of any motion: what was tampered with may expand to fill memory."""
_LARGEST_ANGLE = 2.0 * math.pi
"""Panels meet at pi, on either side; beyond a full turn there is no fold angle, whatever is rounded."""


@dataclass(frozen=True)
class StoredVerdict:
    """The verdict on a folding in a scene.

    path : how flat pairs are joined in the proved path; None without one. deployed : the look at the scene in which
    springs open it; None without one.
    """

    status: Status
    path: Way | None
    deployed: SceneVariant | None


@dataclass(frozen=True, eq=False)
class StoredPath(ByValue):
    """A path of a folding from packed to flat.

    design_id, crease : of the folding. way : how flat pairs are joined, recorded of proved paths only.
    states : (k, n_hinges), rad. needed_margin : least play for each face with which it is proved, mm; None without.
    """

    design_id: int
    crease: int
    way: Way | None
    states: Reals
    needed_margin: float | None


@again
def best_creases(database: Database, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME) -> dict[int, int]:
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


@again
def find_verdict(database: Database, number: int, crease: int, scene: str = DEFAULT_SCENE_NAME) -> StoredVerdict | None:
    """The verdict on the folding of a design in a scene; None where no stage has judged it there."""
    same = [
        and_(other.c.design_id == verdict.c.design_id, other.c.crease == verdict.c.crease)
        for other in (motion, deployment)
    ]
    statement = (
        sql_select(verdict.c.status, motion.c.flat_pairs, deployment.c.scene, deployment.c.pairs, deployment.c.springs)
        .outerjoin(motion, and_(same[0], motion.c.scene == verdict.c.scene))
        .outerjoin(deployment, and_(same[1], deployment.c.base == verdict.c.scene, deployment.c.status == "deploys"))
        .where(verdict.c.design_id == number, verdict.c.crease == crease, verdict.c.scene == scene)
        .order_by(deployment.c.scene)
    )
    with database.reading() as connection:
        row = connection.execute(statement).first()
    if row is None:
        return None
    deployed = None if row.scene is None else SceneVariant(row.pairs, row.springs, as_written=row.scene == scene)
    return StoredVerdict(cast("Status", row.status), cast("Way | None", row.flat_pairs), deployed)


def foldings_with_paths(
    database: Database, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME
) -> list[tuple[int, int]]:
    """Id and crease of the foldings of some designs whose path in a scene is stored, proved or not."""
    rows = _with_paths(database, sql_select(motion.c.design_id, motion.c.crease), ids, scene)
    return [(row.design_id, row.crease) for row in rows]


def find_paths(database: Database, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME) -> list[StoredPath]:
    """The stored paths of the foldings of some designs in a scene, by design and crease; DatabaseError for damage."""
    paths = []
    for row in _with_paths(database, sql_select(motion), ids, scene):
        states = _states(database, row.path, row.states)
        check_values(database.location, ("needed_margin",), ("real",), [(row.needed_margin,)])
        way = cast("Way | None", row.flat_pairs)
        paths.append(StoredPath(row.design_id, row.crease, way, states, row.needed_margin))
    return paths


@again
def _with_paths(database: Database, columns: Select[Any], ids: Sequence[int], scene: str) -> list[Row[Any]]:
    """Columns of the motions of some designs in a scene that have a path, by design and crease."""
    rows: list[Row[Any]] = []
    with database.reading() as connection:
        for part in parts_of(ids):
            wanted = motion.c.design_id.in_(part), motion.c.scene == scene, motion.c.path.is_not(None)
            rows += connection.execute(columns.where(*wanted).order_by(motion.c.design_id, motion.c.crease))
    return rows


def _states(database: Database, packed: object, count: int) -> Reals:
    """Fold angles of so many states."""
    try:
        unpacking = zlib.decompressobj()
        values = np.frombuffer(unpacking.decompress(cast(bytes, packed), LARGEST_PATH), "<f8")
        if not unpacking.eof:
            raise ValueError(f"it is cut short, or takes more than {LARGEST_PATH >> 20} MB")
        if count < 1 or not values.size or values.size % count:
            raise ValueError(f"{values.size} fold angles are not those of {count} states")
        if not (np.abs(values) <= _LARGEST_ANGLE).all():
            raise ValueError("not all of its numbers are fold angles")
    except (zlib.error, ValueError, TypeError) as error:
        raise DatabaseError(
            f"database {database.location} is damaged: a path cannot be read ({error}); restore a copy, or enumerate "
            "anew"
        ) from error
    states: Reals = values.reshape(count, -1).astype(float)
    return states
