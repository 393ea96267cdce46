"""Storing scenes and verdicts on designs in them, in atomic transactions."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from sqlalchemy import Connection, Table, and_, case, delete, func, select

from hcsearch.basics.errors import DatabaseError, SceneError
from hcsearch.basics.vocabulary import STATUSES, finite_or_none, millimetres
from hcsearch.designs.records import (
    Evidence,
    FlightNumbers,
    MotionBatch,
    StageResult,
    Trial,
    Undecided,
    VerdictBatch,
    WorkKey,
    play_of_batch,
)
from hcsearch.store.columns import FLIGHT_QUANTITIES, flight_value, stored_quantities
from hcsearch.store.database import Database
from hcsearch.store.design_rows import INSERT_CHUNK_ROWS, ids_of_circuits, insert_rows
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.rows import parts_of_ids
from hcsearch.store.runs import insert_results
from hcsearch.store.schema import deployment, design, flight, folding, motion, outcome, scene, verdict

VerdictColumns = dict[str, list[Any]]


def record_scene(database: Database, name: str, values: str) -> None:
    """Store a scene, so that queries and deployments may name it; SceneError if a different one has its name."""
    with database.writing() as connection:
        stored = connection.execute(select(scene.c.scene_values).where(scene.c.name == name)).scalar()
        if stored is None:
            connection.execute(scene.insert().values(name=name, scene_values=values))
        elif stored != values:
            raise SceneError(
                f"database {database.location} has another scene {name!r}, with verdicts of its own: give this one "
                "another name, or name another database"
            )


@retry_if_changed
def find_scene(database: Database, name: str) -> str | None:
    """Return the values of a stored scene as a TOML file; None for an unknown name."""
    with database.reading() as connection:
        values: str | None = connection.execute(select(scene.c.scene_values).where(scene.c.name == name)).scalar()
    return values


@retry_if_changed
def scene_names(database: Database) -> list[str]:
    """Return the names of the scenes that were run on a database."""
    with database.reading() as connection:
        return list(connection.execute(select(scene.c.name).order_by(scene.c.name)).scalars())


def record_verdicts(
    database: Database, run_id: int, work: WorkKey, key: str, verdicts: VerdictBatch, results: Sequence[StageResult]
) -> None:
    """Store verdicts in the scene of this work, and the results of its stages for a batch, in one transaction."""
    with database.writing() as connection:
        if verdicts.circuit:
            _insert(connection, database, work.scene, verdicts)
        insert_results(connection, run_id, work, key, results)


def record_settled(
    database: Database, run_id: int, work: WorkKey, key: str, verdicts: VerdictBatch, results: Sequence[StageResult]
) -> tuple[StageResult, ...]:
    """Store new verdicts on foldings of designs judged before, in one transaction; return the increase of counts.

    results : of the stages that judged them. The returned counts are the numbers of designs that pass only now.
    """
    with database.writing() as connection:
        ids = _ids(connection, database, verdicts.circuit)
        earlier = _statuses(connection, ids, work.scene)
        designs = [ids[row] for row in verdicts.folding_row.tolist()]
        for design_id, crease in zip(designs, verdicts.folding_crease.tolist(), strict=True):
            of_folding = deployment.c.design_id == design_id, deployment.c.crease == crease
            connection.execute(delete(deployment).where(deployment.c.base == work.scene, *of_folding))
        _insert_foldings(connection, work.scene, designs, verdicts)
        best = _chosen_foldings(connection, ids, work.scene)
        columns: VerdictColumns = {"scene": [work.scene] * len(ids), "design_id": ids}
        columns |= {"best_crease": [best[k][0] for k in ids], "status": [best[k][1] for k in ids]}
        insert_rows(connection, outcome, columns, ("best_crease", "status"))
        later = _statuses(connection, ids, work.scene)
        added = tuple(_added(result, earlier, later, single=bool(work.target)) for result in results)
        insert_results(connection, run_id, work, key, added)
    return added


def _chosen_foldings(connection: Connection, ids: Sequence[int], scene: str) -> dict[int, tuple[int, str]]:
    """Return crease and status of the best folding of each design by the stored verdicts in a scene.

    The order is that of `stages.statuses.best_foldings`: status, needed margin, degrees of freedom, crease.
    """
    joined = verdict.join(
        folding, and_(folding.c.design_id == verdict.c.design_id, folding.c.crease == verdict.c.crease)
    )
    columns = verdict.c.design_id, verdict.c.crease, verdict.c.status, verdict.c.needed_margin, folding.c.dof
    statement = select(*columns).select_from(joined).where(verdict.c.scene == scene)
    best: dict[int, tuple[int, str]] = {}
    best_rank: dict[int, tuple[float, ...]] = {}
    for part in parts_of_ids(ids):
        for number, crease, status, margin, dof in connection.execute(statement.where(verdict.c.design_id.in_(part))):
            rank = (STATUSES.index(status), *(math.inf if v is None else float(v) for v in (margin, dof)), crease)
            if number not in best or rank < best_rank[number]:
                best[number], best_rank[number] = (crease, status), rank
    return best


_PASSING = {"motion": ("deploys", "movable"), "deployment": ("deploys",), "flight": ("deploys", "movable")}
"""By stage: the statuses of designs that pass it in a scene."""


def _added(
    result: StageResult,
    earlier: dict[int, tuple[str, int, int]],
    later: dict[int, tuple[str, int, int]],
    *,
    single: bool,
) -> StageResult:
    """Return counts of the designs that pass a stage only after a change; single : count circuits of one array."""
    passing = _PASSING[result.stage]
    now_passing = [now for k, now in later.items() if now[0] in passing and earlier[k][0] not in passing]
    return replace(
        result, passed=len(now_passing), n_fixed=sum(orbit if single else fixed for _, fixed, orbit in now_passing)
    )


def _statuses(connection: Connection, ids: Sequence[int], name: str) -> dict[int, tuple[str, int, int]]:
    """Return status in a scene, number of fixed copies and orbit size of some designs, by id."""
    columns = outcome.c.design_id, outcome.c.status, design.c.n_fixed, design.c.array_symmetry, design.c.symmetry
    joined = select(*columns).join(design, design.c.id == outcome.c.design_id).where(outcome.c.scene == name)
    rows = [
        row for part in parts_of_ids(ids) for row in connection.execute(joined.where(outcome.c.design_id.in_(part)))
    ]
    return {row[0]: (row[1], row[2], row[3] // row[4]) for row in rows}


@retry_if_changed
def undecided(database: Database, work: WorkKey, budget: int | None = None) -> list[Undecided]:
    """Return the foldings of designs of a run that are undecided in its scene.

    budget : only foldings searched with a smaller budget. Efforts count as 0 if a path was found, so that the search is
    repeated and meets it again.
    """
    recorded_efforts = func.coalesce(motion.c.efforts, 0)
    efforts = case((motion.c.states > 0, 0), else_=recorded_efforts)
    joined = verdict.join(design, design.c.id == verdict.c.design_id).outerjoin(
        motion, and_(*(motion.c[name] == verdict.c[name] for name in ("design_id", "crease", "scene")))
    )
    conditions = [design.c.grid == work.grid, design.c.n == work.n, verdict.c.scene == work.scene]
    conditions.append(verdict.c.status == "undecided")
    if budget is not None:
        conditions.append(recorded_efforts < budget)
    if work.target:
        conditions.append(design.c.array == work.target)
    statement = select(design.c.id, design.c.circuit, verdict.c.crease, efforts).select_from(joined)
    with database.reading() as connection:
        rows = connection.execute(statement.where(*conditions).order_by(design.c.id, verdict.c.crease))
        return [Undecided(*row) for row in rows]


def _ids(connection: Connection, database: Database, circuits: Sequence[str]) -> list[int]:
    """Return the ids of stored designs; DatabaseError if one is missing."""
    id_of = ids_of_circuits(connection, circuits)
    if len(id_of) < len(circuits):
        raise DatabaseError(
            f"database {database.location} is damaged, it lacks {len(circuits) - len(id_of)} designs that were "
            "stored: restore a copy, or begin with another database"
        )
    return [id_of[circuit] for circuit in circuits]


def _insert(connection: Connection, database: Database, name: str, verdicts: VerdictBatch) -> None:
    ids = _ids(connection, database, verdicts.circuit)
    columns: VerdictColumns = {"scene": [name] * len(ids), "design_id": ids}
    columns |= {"best_crease": verdicts.best_crease, "status": verdicts.status}
    insert_rows(connection, outcome, columns, ("best_crease", "status"))
    for start in range(0, len(ids), INSERT_CHUNK_ROWS):
        part = ids[start : start + INSERT_CHUNK_ROWS]
        connection.execute(delete(deployment).where(deployment.c.base == name, deployment.c.design_id.in_(part)))
        for table in (motion, flight):
            connection.execute(delete(table).where(table.c.scene == name, table.c.design_id.in_(part)))
    _insert_foldings(connection, name, [ids[row] for row in verdicts.folding_row.tolist()], verdicts)


def _insert_foldings(connection: Connection, name: str, designs: list[int], verdicts: VerdictBatch) -> None:
    """Store the verdicts on foldings, their motions and deployments; designs : design id of each folding."""
    keys: VerdictColumns = {
        "design_id": designs,
        "crease": verdicts.folding_crease.tolist(),
        "scene": [name] * len(designs),
    }
    assert verdicts.motion is not None
    _insert_motions(connection, keys, verdicts.motion)
    deployments = verdicts.deployment
    margins, gaps = play_of_batch(verdicts.motion, deployments)
    none = np.full(len(designs), np.nan)
    results = {
        **verdicts.of_foldings,
        "min_clearance": none if deployments is None else deployments.clearance,
        "deploy_time": none if deployments is None else deployments.time,
        "needed_margin": margins,
        "least_gap": gaps,
    }
    judged = {
        one.name: [one.stored(value) for value in results[one.name].tolist()]
        for one in stored_quantities("verdict").values()
        if one.name in results
    }
    _upsert(connection, verdict, keys, {"status": verdicts.folding_status, **judged})
    if verdicts.flight is not None:
        _insert_flight(connection, keys, verdicts.flight)
    if deployments is not None and deployments.trials:
        _insert_trials(connection, keys, deployments.trials)


def _upsert(connection: Connection, table: Table, keys: VerdictColumns, values: VerdictColumns) -> None:
    insert_rows(connection, table, {**keys, **values}, list(values))


def _insert_motions(connection: Connection, keys: VerdictColumns, motions: MotionBatch) -> None:
    """Store the motions of the foldings that were planned."""
    planned = [i for i, reason in enumerate(motions.reason) if reason is not None]
    if not planned:
        return
    paths = [motions.paths[i] for i in planned]
    columns: VerdictColumns = {
        "flat_pairs": [motions.flat_pairs[i] for i in planned],
        "needed_margin": [millimetres(float(motions.margin[i])) for i in planned],
        "least_gap": [millimetres(float(motions.gap[i])) for i in planned],
        "slack": [finite_or_none(1e3 * float(motions.slack[i])) for i in planned],
        "states": [0 if path is None else len(path) for path in paths],
        "reason": [motions.reason[i] for i in planned],
        "as_crease": [motions.as_crease[i] if motions.as_crease else None for i in planned],
        **_evidence_columns([motions.evidence[i] if motions.evidence else None for i in planned]),
        "path": [None if path is None else zlib.compress(path.astype("<f8").tobytes()) for path in paths],
    }
    _upsert(connection, motion, {name: [values[i] for i in planned] for name, values in keys.items()}, columns)


def _insert_flight(connection: Connection, keys: VerdictColumns, numbers: Sequence[FlightNumbers | None]) -> None:
    """Store the figures of the stage `flight`; delete the stored ones of foldings without any."""
    for key in zip(*keys.values(), strict=True):
        same = (flight.c[name] == value for name, value in zip(keys, key, strict=True))
        connection.execute(delete(flight).where(*same))
    known = [(i, figures) for i, figures in enumerate(numbers) if figures is not None]
    if known:
        columns = {one.name: [flight_value(one, figures) for _, figures in known] for one in FLIGHT_QUANTITIES}
        _upsert(connection, flight, {name: [values[i] for i, _ in known] for name, values in keys.items()}, columns)


def _evidence_columns(evidence: Sequence[Evidence | None]) -> VerdictColumns:
    """Return the columns of `motion` on efforts, locks and margins of a search; lengths in millimetres."""
    locks = [None if record is None else record.lock for record in evidence]
    return {
        "efforts": [None if record is None else record.efforts for record in evidence],
        "lock_pairs": [None if lock is None else lock.way for lock in locks],
        "lock_end": [None if lock is None else lock.end for lock in locks],
        "lock_cubes": [None if lock is None else lock.cubes for lock in locks],
        "lock_faces": [None if lock is None else lock.faces for lock in locks],
        "critical_margin": [None if record is None else millimetres(record.critical) for record in evidence],
        "unmet_margin": [None if record is None else millimetres(record.unmet) for record in evidence],
        "lock_margin": [None if lock is None else millimetres(lock.margin) for lock in locks],
    }


def _insert_trials(connection: Connection, keys: VerdictColumns, trials: Sequence[Trial]) -> None:
    """Store deployments; their keys are the folding's and the scene that was simulated."""
    of_trials = {name: [values[trial.folding] for trial in trials] for name, values in keys.items()}
    of_trials["base"], of_trials["scene"] = of_trials["scene"], [trial.scene for trial in trials]
    values: VerdictColumns = {
        "scene_values": [trial.values for trial in trials],
        # an error, which is not rounded to a nanometre
        "closure_error": [finite_or_none(1e3 * trial.closure_error) for trial in trials],
    }
    others = [one for one in stored_quantities("deployment").values() if one.name not in {**of_trials, **values}]
    values |= {one.name: [one.stored(getattr(trial, one.name)) for trial in trials] for one in others}
    _upsert(connection, deployment, of_trials, values)
