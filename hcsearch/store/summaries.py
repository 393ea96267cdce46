"""The content of reports: counts over all designs that a query selects, and rows of views on some of them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, and_, case, distinct, func
from sqlalchemy import select as sql_select

from hcsearch.basics.simulation_summaries import SimulationAccuracy, TrialAccuracy, accuracy_of_trials, undecided_counts
from hcsearch.basics.vocabulary import Status
from hcsearch.designs.records import WorkKey
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.columns import VIEWS, column_names
from hcsearch.store.conditions import find_quantity, parse_query, view_table
from hcsearch.store.database import Database
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.quantity import ColumnKind
from hcsearch.store.queries import check_scene, limited_reading, order_of, sort_key
from hcsearch.store.rows import Result, checked_rows, parts_of_ids
from hcsearch.store.schema import deployment, design, verdict

_SCENE_COLUMN = {"motions": "scene", "deployments": "base"}
"""The column with the scene whose verdict a row serves, by view with rows of all scenes."""


@dataclass(frozen=True)
class Summary:
    """Counts over the designs that a query selects, in a scene.

    circuits, fixed, arrays : designs, circuits up to translation, arrays. two_stack, untwisted, movable, deploys,
    locked : numbers of such designs; None if known of none. array : the common array, None for several.
    sizes : grid and number of panels, each pair once. census : (foldings, least twist, designs); None where not known.
    planned, tried : whether motions and deployments of any of them are recorded. not_decided : number of their foldings
    that no simulation decides, by its ending. accuracy : of their deployments.
    """

    circuits: int
    fixed: int
    arrays: int
    two_stack: int | None
    untwisted: int | None
    movable: int | None
    deploys: int | None
    locked: int | None
    array: str | None
    sizes: tuple[tuple[str, int], ...]
    census: tuple[tuple[int | None, int | None, int], ...]
    planned: bool
    tried: bool
    not_decided: dict[str, int]
    accuracy: SimulationAccuracy


@retry_if_changed
def summarize(
    database: Database, query: str, scene: str = DEFAULT_SCENE_NAME, *, seconds: float | None = None
) -> Summary:
    """Return counts of the designs that a query selects, by status in a scene.

    seconds : time limit; SlowQueryError beyond it.
    """
    check_scene(database, scene)
    designs = view_table("designs", scene)
    condition = parse_query(query, "designs", scene)
    grid, n, foldings, twist = (designs.c[name] for name in ("grid", "n", "n_foldings", "min_twist"))
    of_each = sql_select(foldings, twist, func.count().label("designs")).where(condition).group_by(foldings, twist)
    counts = _counts(designs.c).where(condition)
    kinds: list[ColumnKind] = [*("integer",) * 8, "text"]
    ids = sql_select(designs.c.id).where(condition)
    with _reading(database, seconds) as connection:
        rows = partial(checked_rows, connection, database.location)
        (row,) = rows(counts, kinds)
        fields: dict[str, Any] = dict(zip(counts.selected_columns.keys(), row, strict=True))
        return Summary(
            **fields,
            sizes=tuple(rows(sql_select(grid, n).distinct().where(condition).order_by(grid, n), ("text", "integer"))),
            census=tuple(rows(of_each, ("integer",) * 3)),
            planned=_has_rows(connection, "motions", scene, ids),
            tried=_has_rows(connection, "deployments", scene, ids),
            not_decided=simulations_of(connection, ids, scene),
            accuracy=accuracy_of_deployments(connection, ids, scene),
        )


@retry_if_changed
def simulations_not_decided(database: Database, query: str, scene: str = DEFAULT_SCENE_NAME) -> dict[str, int]:
    """Return `not_decided` of a summary of the designs that a query selects."""
    check_scene(database, scene)
    ids = sql_select(view_table("designs", scene).c.id).where(parse_query(query, "designs", scene))
    with database.reading() as connection:
        return simulations_of(connection, ids, scene)


def _reading(database: Database, seconds: float | None) -> AbstractContextManager[Connection]:
    return database.reading() if seconds is None else limited_reading(database, seconds)


@retry_if_changed
def count_values(
    database: Database,
    query: str,
    name: str,
    most: int,
    scene: str = DEFAULT_SCENE_NAME,
    *,
    seconds: float | None = None,
) -> list[tuple[Any, int]] | None:
    """Return the known values of a column in the designs that a query selects, and how many designs have each.

    In the order of `sort`. None where there are more than `most` values. seconds : as in `summarize`.
    """
    check_scene(database, scene)
    designs, quantity = view_table("designs", scene), find_quantity("designs", name)
    own = designs.c[name]
    statement = (
        sql_select(own, func.count()).where(parse_query(query, "designs", scene), own.is_not(None)).group_by(own)
    )
    with _reading(database, seconds) as connection:
        kinds: list[ColumnKind] = [quantity.kind, "integer"]
        rows = checked_rows(
            connection, database.location, statement.order_by(sort_key(designs, quantity)).limit(most + 1), kinds
        )
    return None if len(rows) > most else [(value, count) for value, count in rows]


def _counts(designs: Any) -> Select[Any]:
    """Return the SELECT of the first nine fields of a summary, under their names."""

    def having(*statuses: Status) -> ColumnElement[Any]:
        return func.sum(case((designs.status.in_(statuses), 1), else_=0))

    arrays = func.count(distinct(designs.array))
    return sql_select(
        func.count().label("circuits"),
        func.coalesce(func.sum(designs.n_fixed), 0).label("fixed"),
        arrays.label("arrays"),
        func.sum(designs.two_stack).label("two_stack"),
        func.sum(designs.untwisted).label("untwisted"),
        having("deploys", "movable").label("movable"),
        having("deploys").label("deploys"),
        having("locked").label("locked"),
        case((arrays == 1, func.min(designs.array))).label("array"),
    )


def _has_rows(connection: Connection, view: str, scene: str, ids: Select[Any]) -> bool:
    """Return whether a view has a row on one of some designs that serves a scene."""
    columns = view_table(view).c
    rows = sql_select(columns.design_id).where(columns[_SCENE_COLUMN[view]] == scene, columns.design_id.in_(ids))
    return connection.execute(rows.limit(1)).first() is not None


@retry_if_changed
def rows_of_designs(
    database: Database, view: str, ids: Sequence[int], scene: str = DEFAULT_SCENE_NAME
) -> list[dict[str, Any]]:
    """Return the rows of `foldings`, `motions` or `deployments` of some designs for a scene, as dicts."""
    check_scene(database, scene)
    source = view_table(view, scene)
    kinds = [quantity.kind for quantity in VIEWS[view]]
    statement = sql_select(source).order_by(*order_of(source, view, ""))
    if view in _SCENE_COLUMN:
        statement = statement.where(source.c[_SCENE_COLUMN[view]] == scene)
    rows: list[tuple[Any, ...]] = []
    with database.reading() as connection:
        for part in parts_of_ids(ids):
            of_part = statement.where(source.c.design_id.in_(part))
            rows += checked_rows(connection, database.location, of_part, kinds)
    return Result(column_names(view), tuple(rows)).records()


@retry_if_changed
def undecided_simulations(database: Database, work: WorkKey) -> dict[str, int]:
    """Return the number of foldings of a run that no simulation decides in its scene, by the ending of the first one.

    Foldings that some springs deploy are left out.
    """
    with database.reading() as connection:
        return simulations_of(connection, ids_of_run(work), work.scene)


def ids_of_run(work: WorkKey) -> Select[Any]:
    """Return the SELECT of the ids of the designs of a run."""
    conditions = [design.c.grid == work.grid, design.c.n == work.n]
    if work.target:
        conditions.append(design.c.array == work.target)
    return sql_select(design.c.id).where(*conditions)


def simulations_of(connection: Connection, ids: Select[Any], name: str) -> dict[str, int]:
    """Return the same as `undecided_simulations` for the designs with some ids, in a named scene."""
    same = and_(verdict.c.design_id == deployment.c.design_id, verdict.c.crease == deployment.c.crease)
    rows = connection.execute(
        sql_select(deployment.c.design_id, deployment.c.crease, deployment.c.reason)
        .select_from(deployment.join(verdict, and_(same, verdict.c.scene == deployment.c.base)))
        .where(deployment.c.base == name, deployment.c.status == "undecided", verdict.c.status != "deploys")
        .where(deployment.c.design_id.in_(ids))
        .order_by(deployment.c.design_id, deployment.c.crease, deployment.c.scene == name)
    )
    # of several trials the one in the scene as written counts, which comes last
    return undecided_counts({(design_id, crease): reason for design_id, crease, reason in rows})


@retry_if_changed
def simulation_accuracy(database: Database, work: WorkKey) -> SimulationAccuracy:
    """Return the accuracy of the deployments of the designs of a run in its scene."""
    with database.reading() as connection:
        return accuracy_of_deployments(connection, ids_of_run(work), work.scene)


def accuracy_of_deployments(connection: Connection, ids: Select[Any], name: str) -> SimulationAccuracy:
    """Return the accuracy of the deployments of the designs with some ids, in a named scene.

    Deployments that were taken over from congruent foldings, and those from before these columns, are left out.
    """
    rows = connection.execute(
        sql_select(deployment.c.time_saved, deployment.c.status, deployment.c.deploy_time, deployment.c.error_time)
        .where(deployment.c.base == name, deployment.c.as_crease.is_(None), deployment.c.time_saved.is_not(None))
        .where(deployment.c.design_id.in_(ids))
    )
    return accuracy_of_trials(TrialAccuracy(*row) for row in rows)
