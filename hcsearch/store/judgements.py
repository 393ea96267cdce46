"""Reading results on foldings in a scene: the best folding of a design, verdicts and paths."""

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
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.rows import check_values, parts_of_ids
from hcsearch.store.schema import deployment, design, motion, outcome, verdict

MAX_PATH_BYTES = 8 << 20
"""Largest size of a decompressed path in bytes, far above any motion's; guards against tampered data."""
_LARGEST_ANGLE = 2.0 * math.pi
"""Largest fold angle in a path, rad: panels meet at +-pi, so a full turn bounds every rounded angle."""


@dataclass(frozen=True)
class StoredVerdict:
    """The verdict on a folding in a scene.

    path_flat_pairs : joining of flat pairs in the proved path; None without one.
    deployed_variant : variant of the scene in which springs open the folding; None without one.
    """

    status: Status
    path_flat_pairs: Way | None
    deployed_variant: SceneVariant | None


@dataclass(frozen=True, eq=False)
class StoredPath(ByValue):
    """A path of a folding from the packed to the flat state.

    design_id, crease : of the folding. way : joining of flat pairs, recorded of proved paths only.
    states : (k, n_hinges), rad. needed_margin : least play on each face at which it is proved, mm; None without proof.
    """

    design_id: int
    crease: int
    way: Way | None
    states: Reals
    needed_margin: float | None


@retry_if_changed
def best_creases(database: Database, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME) -> dict[int, int]:
    """Return the crease of the best folding of each design that has one in a scene, as in the view `designs`.

    `stages.statuses.best_foldings` chooses it once, when verdicts are recorded.
    """
    creases: dict[int, int] = {}
    best = func.coalesce(outcome.c.best_crease, design.c.best_crease)
    joined = design.outerjoin(outcome, and_(outcome.c.design_id == design.c.id, outcome.c.scene == scene))
    with database.reading() as connection:
        for part in parts_of_ids(ids):
            statement = sql_select(design.c.id, best).select_from(joined)
            statement = statement.where(design.c.id.in_(part), best.is_not(None))
            creases.update((row[0], row[1]) for row in connection.execute(statement))
    return creases


@retry_if_changed
def find_verdict(database: Database, number: int, crease: int, scene: str = DEFAULT_SCENE_NAME) -> StoredVerdict | None:
    """Return the verdict on a folding of a design in a scene; None before any stage has judged it there."""
    same_folding = [
        and_(table.c.design_id == verdict.c.design_id, table.c.crease == verdict.c.crease)
        for table in (motion, deployment)
    ]
    statement = (
        sql_select(verdict.c.status, motion.c.flat_pairs, deployment.c.scene, deployment.c.pairs, deployment.c.springs)
        .outerjoin(motion, and_(same_folding[0], motion.c.scene == verdict.c.scene))
        .outerjoin(
            deployment, and_(same_folding[1], deployment.c.base == verdict.c.scene, deployment.c.status == "deploys")
        )
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
    """Return design id and crease of the foldings of some designs with a stored path in a scene, proved or not."""
    rows = _with_paths(database, sql_select(motion.c.design_id, motion.c.crease), ids, scene)
    return [(row.design_id, row.crease) for row in rows]


def find_paths(database: Database, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME) -> list[StoredPath]:
    """Return the stored paths of some designs in a scene, ordered by design and crease; DatabaseError for damage."""
    paths = []
    for row in _with_paths(database, sql_select(motion), ids, scene):
        states = _states(database, row.path, row.states)
        check_values(database.location, ("needed_margin",), ("real",), [(row.needed_margin,)])
        way = cast("Way | None", row.flat_pairs)
        paths.append(StoredPath(row.design_id, row.crease, way, states, row.needed_margin))
    return paths


@retry_if_changed
def _with_paths(database: Database, columns: Select[Any], ids: Sequence[int], scene: str) -> list[Row[Any]]:
    """Select columns of the motions with a path of some designs in a scene, ordered by design and crease."""
    rows: list[Row[Any]] = []
    with database.reading() as connection:
        for part in parts_of_ids(ids):
            conditions = motion.c.design_id.in_(part), motion.c.scene == scene, motion.c.path.is_not(None)
            rows += connection.execute(columns.where(*conditions).order_by(motion.c.design_id, motion.c.crease))
    return rows


def _states(database: Database, packed: object, count: int) -> Reals:
    """Unpack the fold angles of `count` states; DatabaseError for damaged data."""
    try:
        unpacking = zlib.decompressobj()
        values = np.frombuffer(unpacking.decompress(cast(bytes, packed), MAX_PATH_BYTES), "<f8")
        if not unpacking.eof:
            raise ValueError(f"it is cut short, or takes more than {MAX_PATH_BYTES >> 20} MB")
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
