"""Recording runs and batches atomically, and results of ranking, tuning and the search for units."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, bindparam, delete, distinct, func, select, update

from hcsearch.basics.errors import DatabaseError
from hcsearch.designs.records import DesignBatch, StageResult, WorkKey
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import FUNNEL_COLUMNS, stored_quantities
from hcsearch.store.database import Database
from hcsearch.store.design_rows import insert_designs, insert_rows
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.quantity import ColumnKind
from hcsearch.store.rows import check_values, next_id
from hcsearch.store.schema import batch, design, evaluation, run, score, unit

_KINDS: dict[str, ColumnKind] = {"prefix": "text", "passed": "integer", "n_fixed": "integer", "seconds": "real"}


def start_run(
    database: Database,
    *,
    work: WorkKey,
    until: str,
    panel: str | None,
    arguments: Mapping[str, object],
    versions: Mapping[str, object],
) -> int:
    """Record the start of an enumeration, and return the id of the run.

    panel : length x width x thickness in millimetres, as `50x40x6`; arguments, versions : anything JSON can hold.
    """
    values = {
        "started": _now(),
        **{name: getattr(work, name) for name in ("grid", "n", "target", "keep")},
        "until": until,
        "panel": panel,
        "arguments": json.dumps(arguments, sort_keys=True),
        "versions": json.dumps(versions, sort_keys=True),
    }
    with database.writing() as connection:
        run_id = next_id(connection, database.location, run.c.id)
        connection.execute(run.insert().values(id=run_id, **values))
    return run_id


def finish_run(
    database: Database,
    run_id: int,
    funnel: Mapping[str, int | None],
    stage_times: Mapping[str, float],
    batches_done: int,
    batches_reused: int,
) -> None:
    """Record the outcome of a run.

    funnel : counts by the names in `FUNNEL_COLUMNS`, None or missing for a stage that has not run; stage_times : s.
    """
    if unknown := set(funnel) - set(FUNNEL_COLUMNS):
        raise KeyError(f"no funnel column {sorted(unknown)}; there are {FUNNEL_COLUMNS}")
    values = {
        "finished": _now(),
        **{name: None if count is None else int(count) for name, count in funnel.items()},
        "stage_times": json.dumps({stage: float(seconds) for stage, seconds in stage_times.items()}),
        "batches_done": batches_done,
        "batches_reused": batches_reused,
    }
    with database.writing() as connection:
        connection.execute(update(run).where(run.c.id == run_id).values(values))


def finished_batches(database: Database, work: WorkKey, versions: Mapping[str, int]) -> dict[str, list[StageResult]]:
    """Return, by search prefix, the results of the batches in which all stages are done at the given versions.

    versions : current version of each stage; the results of a batch are in this order.
    """
    statement = select(batch).where(_of(work), batch.c.stage.in_(versions))
    by_prefix: dict[str, dict[str, StageResult]] = {}
    with database.reading() as connection:
        for row in connection.execute(statement):
            if row.version == versions[row.stage]:
                check_values(database.location, row._fields, [_KINDS.get(name) for name in row._fields], [row])
                result = StageResult(row.stage, row.version, row.passed, row.n_fixed, row.seconds)
                by_prefix.setdefault(row.prefix, {})[row.stage] = result
    return {
        prefix: [results[stage] for stage in versions]
        for prefix, results in by_prefix.items()
        if len(results) == len(versions)
    }


def record_batches(
    database: Database, run_id: int, work: WorkKey, batches: Iterable[tuple[str, DesignBatch, Sequence[StageResult]]]
) -> None:
    """Store batches in one transaction: designs, foldings and the stages done for each search prefix.

    The next durable transaction, such as that at the end of the run, guarantees that they are on disk.

    Storing a batch again adds nothing. A design stored before gets the columns of the stages that ran; the columns
    of other stages stay.
    """
    with database.writing(durable=False) as connection:  # a batch takes only milliseconds to compute again
        for prefix, designs, results in batches:
            insert_designs(connection, database.location, designs)
            insert_results(connection, run_id, work, prefix, results)


def count_arrays(database: Database, work: WorkKey, *, designs: int = 0) -> int:
    """Count the distinct arrays of the stored designs that this work keeps, including designs stored by other work.

    designs : number of designs of the finished batches of this work. DatabaseError if fewer are stored, since SQLite
    does not detect all damage to a file.
    """
    counts = select(func.count(distinct(design.c.array)), func.count())
    counts = counts.where(design.c.grid == work.grid, design.c.n == work.n)
    if work.target:
        counts = counts.where(design.c.array == work.target)
    if work.keep != "all":
        counts = counts.where({"two-stack": design.c.n_foldings, "untwisted": design.c.n_untwisted}[work.keep] > 0)
    with database.reading() as connection:
        arrays, stored = connection.execute(counts).one()
    if stored < designs:
        raise DatabaseError(
            f"database {database.location} is damaged, it holds {stored} of {designs} designs: restore a copy, or "
            "salvage its rows with `sqlite3 FILE .recover`"
        )
    return int(arrays)


def _of(work: WorkKey) -> ColumnElement[bool]:
    return and_(*(batch.c[name] == getattr(work, name) for name in ("grid", "n", "target", "keep", "scene")))


def insert_results(
    connection: Connection, run_id: int, work: WorkKey, prefix: str, results: Sequence[StageResult]
) -> None:
    """Record the results of stages for a batch of work, in a transaction of the caller."""
    if not results:
        return
    key = {name: getattr(work, name) for name in ("grid", "n", "target", "keep", "scene")} | {"prefix": prefix}
    columns: dict[str, list[Any]] = {name: [value] * len(results) for name, value in key.items()}
    columns["stage"] = [result.stage for result in results]
    values: dict[str, list[Any]] = {
        "version": [result.version for result in results],
        "passed": [int(result.passed) for result in results],
        "n_fixed": [int(result.n_fixed) for result in results],
        "seconds": [float(result.seconds) for result in results],
        "run_id": [run_id] * len(results),
    }
    insert_rows(connection, batch, columns | values, tuple(values))


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


_EVALUATION_KINDS = {one.name: one.kind for one in stored_quantities("evaluation").values()}
_UNIT_KEY = ("circuit", "crease", "alpha", "shape", "merged", "placements")


def save_scores(database: Database, scores: Mapping[int, float | None], scene: str = DEFAULT_SCENE_NAME) -> None:
    """Set the scores of designs in a scene by id, None for no score, in one transaction; other scores stay."""
    present = {design: value for design, value in scores.items() if value is not None}
    removed = [{"key": design} for design, value in scores.items() if value is None]
    with database.writing() as connection:
        if present:
            columns: dict[str, list[Any]] = {
                "scene": [scene] * len(present),
                "design_id": list(present),
                "score": list(present.values()),
            }
            insert_rows(connection, score, columns, ("score",))
        if removed:
            gone = delete(score).where(score.c.scene == scene, score.c.design_id == bindparam("key"))
            connection.execute(gone, removed)


@retry_if_changed
def find_evaluations(database: Database, subject: str) -> list[Mapping[str, Any]]:
    """Return all evaluations of a subject as named columns of the table; DatabaseError for damaged values."""
    with database.reading() as connection:
        rows = connection.execute(select(evaluation).where(evaluation.c.subject == subject)).all()
    names = [column.name for column in evaluation.columns]
    check_values(database.location, names, [_EVALUATION_KINDS.get(name, "real") for name in names], rows)
    return [dict(row._mapping) for row in rows]


def record_evaluations(database: Database, rows: Sequence[Mapping[str, Any]]) -> int:
    """Store evaluations in one transaction; return the number of new ones."""
    if not rows:
        return 0
    names = [column.name for column in evaluation.columns]
    with database.writing() as connection:
        return insert_rows(connection, evaluation, {name: [row[name] for row in rows] for name in names})


def record_units(database: Database, units: Sequence[Mapping[str, Any]]) -> int:
    """Store the units of one element in one transaction; return the number of new ones.

    units : as the columns of the view `units` by name, without ids.
    Its element and the placement of the copies identify a unit, so a repeated search adds none.
    """
    if not units:
        return 0
    names = [column.name for column in unit.columns if column.name not in ("id", "key")]
    keys = [" ".join(str(row[name]) for name in _UNIT_KEY) for row in units]
    with database.writing() as connection:
        stored_keys = set(connection.execute(select(unit.c.key).where(unit.c.key.in_(keys))).scalars())
        # a key that occurs twice in one call is one unit
        fresh = {key: row for key, row in zip(keys, units, strict=True) if key not in stored_keys}
        if not fresh:
            return 0
        columns: dict[str, list[Any]] = {name: [row[name] for row in fresh.values()] for name in names}
        first_id = next_id(connection, database.location, unit.c.id, len(fresh))
        ids = list(range(first_id, first_id + len(fresh)))
        return insert_rows(connection, unit, {"id": ids, "key": list(fresh), **columns})
