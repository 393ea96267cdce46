"""Storing scenes, and verdicts on designs in them, in transactions that are whole or not at all."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from typing import Any

from sqlalchemy import Connection, delete, select

from hcsearch.errors import DatabaseError, SceneError
from hcsearch.play import millimetres
from hcsearch.records import DeploymentBatch, MotionBatch, StageResult, VerdictBatch, WorkKey, play_of
from hcsearch.store.database import Database
from hcsearch.store.designs import CHUNK, ids_of
from hcsearch.store.failures import again
from hcsearch.store.schema import deployment, motion, outcome, scene, verdict
from hcsearch.store.upsert import insert_rows
from hcsearch.store.writing import insert_results

Columns = dict[str, list[Any]]


def record_scene(database: Database, name: str, values: str) -> None:
    """Store a scene, so that queries and deployments may name it; SceneError where another one has its name."""
    with database.writing() as connection:
        stored = connection.execute(select(scene.c.scene_values).where(scene.c.name == name)).scalar()
        if stored is None:
            connection.execute(scene.insert().values(name=name, scene_values=values))
        elif stored != values:
            raise SceneError(
                f"database {database.location} has another scene {name!r}, with verdicts of its own: give this one "
                "another name, or name another database"
            )


@again
def find_scene(database: Database, name: str) -> str | None:
    """The values of a stored scene as a TOML file; None where there is none of the name."""
    with database.reading() as connection:
        values: str | None = connection.execute(select(scene.c.scene_values).where(scene.c.name == name)).scalar()
    return values


@again
def scene_names(database: Database) -> list[str]:
    """The names of the scenes that were run on a database."""
    with database.reading() as connection:
        return list(connection.execute(select(scene.c.name).order_by(scene.c.name)).scalars())


def record_verdicts(
    database: Database, run_id: int, work: WorkKey, key: str, verdicts: VerdictBatch, results: Sequence[StageResult]
) -> None:
    """Store verdicts in the scene of this work in one transaction, and that the stages are done for a piece of it."""
    with database.writing() as connection:
        if verdicts.circuit:
            _insert(connection, database, work.scene, verdicts)
        insert_results(connection, run_id, work, key, results)


def _insert(connection: Connection, database: Database, name: str, verdicts: VerdictBatch) -> None:
    known = ids_of(connection, verdicts.circuit)
    if len(known) < len(verdicts.circuit):
        raise DatabaseError(
            f"database {database.location} is damaged, it lacks {len(verdicts.circuit) - len(known)} designs that were "
            "stored: restore a copy, or begin with another database"
        )
    ids = [known[circuit] for circuit in verdicts.circuit]
    columns: Columns = {"scene": [name] * len(ids), "design_id": ids}
    columns |= {"best_crease": verdicts.best_crease, "status": verdicts.status}
    insert_rows(connection, outcome, columns, ("best_crease", "status"))
    creases = verdicts.folding_crease.tolist()
    designs = [ids[row] for row in verdicts.folding_row.tolist()]
    rows: Columns = {"scene": [name] * len(designs), "design_id": designs, "crease": creases}
    for start in range(0, len(ids), CHUNK):
        some = ids[start : start + CHUNK]
        connection.execute(delete(deployment).where(deployment.c.base == name, deployment.c.design_id.in_(some)))
        connection.execute(delete(motion).where(motion.c.scene == name, motion.c.design_id.in_(some)))
    _insert_motions(connection, rows, verdicts.motion)
    deployments = verdicts.deployment
    clearance, time = ([], []) if deployments is None else (deployments.clearance.tolist(), deployments.time.tolist())
    none = [None] * len(designs)
    margins, gaps = play_of(verdicts.motion, deployments)
    rows |= {
        "status": verdicts.folding_status,
        "min_clearance": [millimetres(gap) for gap in clearance] or none,
        "deploy_time": [_number(seconds) for seconds in time] or none,
        "needed_margin": [millimetres(margin) for margin in margins.tolist()],
        "least_gap": [millimetres(gap) for gap in gaps.tolist()],
    }
    own = ("status", "min_clearance", "deploy_time", "needed_margin", "least_gap")
    insert_rows(connection, verdict, rows, own)
    if deployments is not None and deployments.trials:
        trials = _trial_columns(deployments, rows, name)
        changed = [column for column in trials if column not in ("design_id", "crease", "base", "scene")]
        insert_rows(connection, deployment, trials, changed)


def _insert_motions(connection: Connection, foldings: Columns, motions: MotionBatch) -> None:
    """Store the motions of the foldings that were looked at; the others have none."""
    kept = [i for i, reason in enumerate(motions.reason) if reason is not None]
    if not kept:
        return
    columns: Columns = {name: [values[i] for i in kept] for name, values in foldings.items()}
    columns |= {
        "flat_pairs": [motions.flat_pairs[i] for i in kept],
        "needed_margin": [millimetres(float(motions.margin[i])) for i in kept],
        "least_gap": [millimetres(float(motions.gap[i])) for i in kept],
        "slack": [_number(1e3 * float(motions.slack[i])) for i in kept],
        "states": [0 if (path := motions.paths[i]) is None else len(path) for i in kept],
        "reason": [motions.reason[i] for i in kept],
        "as_crease": [motions.as_crease[i] if motions.as_crease else None for i in kept],
        "path": [
            None if (path := motions.paths[i]) is None else zlib.compress(path.astype("<f8").tobytes()) for i in kept
        ],
    }
    insert_rows(connection, motion, columns, [name for name in columns if name not in foldings])


def _trial_columns(deployments: DeploymentBatch, foldings: Columns, name: str) -> Columns:
    """The rows of `deployment`; lengths in millimetres, as its columns have them."""
    trials = deployments.trials
    columns: Columns = {key: [foldings[key][trial.folding] for trial in trials] for key in ("design_id", "crease")}
    columns |= {key: [getattr(t, key) for t in trials] for key in ("scene", "formulation", "status", "reason")}
    columns |= {key: [getattr(t, key) for t in trials] for key in ("first_contact", "deploy_time", "as_crease")}
    columns["base"] = [name] * len(trials)
    columns["scene_values"] = [trial.values for trial in trials]
    columns |= {
        key: [millimetres(getattr(t, key)) for t in trials] for key in ("clearance", "needed_margin", "least_gap")
    }
    # a simulation that diverged leaves numbers that overflowed
    columns["energy_error"] = [_finite(trial.energy_error) for trial in trials]
    columns["closure_error"] = [_finite(1e3 * trial.closure_error) for trial in trials]
    return columns


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
