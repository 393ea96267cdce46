"""Recording runs and finished batches. One batch is one transaction: it is in the database whole, or not at all."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, distinct, func, select, update

from hcsearch.basics.errors import DatabaseError
from hcsearch.designs.records import DesignBatch, StageResult, WorkKey
from hcsearch.store.columns import Kind
from hcsearch.store.database import Database
from hcsearch.store.designs import insert_designs
from hcsearch.store.rows import check_values, next_id
from hcsearch.store.schema import FUNNEL, batch, design, run
from hcsearch.store.upsert import insert_rows

_KINDS: dict[str, Kind] = {"prefix": "text", "passed": "integer", "n_fixed": "integer", "seconds": "real"}


def start_run(
    database: Database,
    *,
    work: WorkKey,
    until: str,
    panel: str | None,
    arguments: Mapping[str, object],
    versions: Mapping[str, object],
) -> int:
    """Record that an enumerate call begins, and return the id of the run.

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

    funnel : counts by the names in `schema.FUNNEL`, None or left out where a stage has not run; stage_times : seconds.
    """
    if unknown := set(funnel) - set(FUNNEL):
        raise KeyError(f"no funnel column {sorted(unknown)}; there are {FUNNEL}")
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
    """Return, by search prefix, the results of the batches that have every asked stage at exactly these versions.

    versions : stage -> its current version; the results of a batch come in this order.
    """
    wanted = select(batch).where(_of(work), batch.c.stage.in_(versions))
    by_prefix: dict[str, dict[str, StageResult]] = {}
    with database.reading() as connection:
        for row in connection.execute(wanted):
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
    """Store batches in one transaction: designs and foldings, and that these stages are done for the search prefix.

    They are on disk for certain from the next durable transaction on, such as that of the end of the run.

    The same batch twice adds nothing. A design that was there before gets the columns of the stages that ran; the
    columns of other stages stay.
    """
    with database.writing(durable=False) as connection:  # a batch takes milliseconds to find again
        for prefix, designs, results in batches:
            insert_designs(connection, database.location, designs)
            insert_results(connection, run_id, work, prefix, results)


def count_arrays(database: Database, work: WorkKey, *, designs: int = 0) -> int:
    """Count the distinct arrays of the stored designs that this work keeps, also those that other work stored.

    designs : how many designs the finished batches of this work gave. DatabaseError when fewer are stored: SQLite does
    not notice all damage to a file.
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
    """Store that stages are done for a piece of work, in a transaction of the caller."""
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
