"""Reading: rows and pages of a view by the query language, read-only SQL, and single designs with their foldings."""

from __future__ import annotations

import re
import shlex
import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from typing import Any

from sqlalchemy import ColumnElement, Connection, FromClause, Select, and_, case, func, literal_column, or_
from sqlalchemy import select as sql_select

from hcsearch.basics.errors import DatabaseError, HcsearchError, QueryError, SceneError, expect_kind, printable
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.panel_sizes import is_panel
from hcsearch.scenes import DEFAULT_SCENE_NAME, SCENES
from hcsearch.store.conditions import find_quantity, named_grids, parse_query, quantities_named, sort_terms, view_table
from hcsearch.store.database import Database
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.quantity import ColumnKind, Quantity
from hcsearch.store.rows import (
    FETCH_CHUNK_ROWS,
    Result,
    ResultRow,
    Rows,
    check_values,
    checked_rows,
    chunks_of,
    raising_query_errors,
)
from hcsearch.store.schema import design
from hcsearch.store.sqlite import PROGRESS_HANDLER_STEPS
from hcsearch.store.verdicts import scene_names
from hcsearch.store.views import SCENIC, sql_in_scene

# The columns that distinguish rows of a view: the last sort keys of every order, so that results are reproducible.
VIEW_KEYS = {
    "designs": ("id",),
    "foldings": ("design_id", "crease"),
    "motions": ("design_id", "crease", "scene"),
    "deployments": ("design_id", "crease", "base", "scene"),
    "runs": ("id",),
    "units": ("id",),
    "evaluations": ("subject", "setting", "springs"),
}

# On a server, rows stay there until they are fetched.
_CURSOR = {"yield_per": FETCH_CHUNK_ROWS}


@contextmanager
def stream(
    database: Database,
    query: str = "",
    *,
    columns: str | Sequence[str] = "",
    sort: str = "",
    limit: int | None = None,
    view: str = "designs",
    scene: str = DEFAULT_SCENE_NAME,
) -> Iterator[Rows]:
    """Stream the rows of a view that satisfy a query (see `conditions`), in little memory.

    scene : the one whose verdicts are shown. columns : names, a sequence or separated by commas; all where empty.
    sort : names separated by commas, `-` before a name for descending; NULL comes last either way.
    """
    view_table(view)  # raises for an unknown view before its columns are looked up
    quantities = quantities_named(view, columns)
    names = tuple(quantity.name for quantity in quantities)
    check_scene(database, scene, view)  # first, since views are cached by the name of the scene
    statement = _statement(view, scene, names, query, sort, limit)
    with database.reading() as connection:
        with raising_query_errors():
            cursor = connection.execute(statement, execution_options=_CURSOR)
        # A cursor left open amid its rows would keep the file in use.
        with closing(cursor):
            kinds = tuple(quantity.kind for quantity in quantities)
            yield Rows(names, kinds, _checked(database, names, kinds, chunks_of(cursor)))


def _checked(
    database: Database, names: Sequence[str], kinds: Sequence[ColumnKind | None], chunks: Iterator[Sequence[ResultRow]]
) -> Iterator[Sequence[ResultRow]]:
    for chunk in chunks:
        check_values(database.location, names, kinds, chunk)
        yield chunk


@contextmanager
def stream_sql(
    database: Database, sql: str, kinds: Sequence[ColumnKind] = (), scene: str = DEFAULT_SCENE_NAME
) -> Iterator[Rows]:
    """Stream the rows of one read-only SQL statement; the database is from `open_readonly`.

    kinds : of its columns, if the statement is of this program and other values are errors. scene : shown by the
    views `designs` and `foldings`.
    QueryError: a statement that would change something, several statements, or a mistake in the SQL.
    """
    if not database.readonly:
        raise QueryError("SQL is run on read-only databases: open this one with open_readonly")
    if scene != DEFAULT_SCENE_NAME:
        check_scene(database, scene)
        sql = sql_in_scene(sql, scene)
    with database.reading() as connection:
        with raising_query_errors(trusted=bool(kinds)):
            # The text goes to the driver unchanged, without parameters, so `:` and `%` have no meaning. On a server it
            # becomes the query of a cursor, which can only be one SELECT: COPY could write files there.
            cursor = connection.exec_driver_sql(sql, execution_options={**_CURSOR, "no_parameters": True})
            if not cursor.returns_rows:
                raise QueryError("the SQL returns no rows, and the database is read-only: write a SELECT")
            names = tuple(cursor.keys())
        with closing(cursor):
            column_kinds = tuple(kinds) or (None,) * len(names)
            yield Rows(
                names, column_kinds, _checked(database, names, column_kinds, chunks_of(cursor, trusted=bool(kinds)))
            )


@retry_if_changed
def select(
    database: Database,
    query: str = "",
    *,
    columns: str | Sequence[str] = "",
    sort: str = "",
    limit: int | None = None,
    view: str = "designs",
    scene: str = DEFAULT_SCENE_NAME,
) -> Result:
    """Return the rows of a view that satisfy a query as plain values; `read` returns a pandas table instead.

    Parameters
    ----------
    database
        An open database.
    query, columns, sort, limit, view
        As in `read`.
    scene
        The name of a scene.

    Returns
    -------
    Result
        Columns and rows.
    """
    expect_kind("the database to read", database, Database, "an open one, such as open_readonly('designs.sqlite')")
    with stream(database, query, columns=columns, sort=sort, limit=limit, view=view, scene=scene) as rows:
        return rows.gathered()


@retry_if_changed
def select_sql(database: Database, sql: str, kinds: Sequence[ColumnKind] = ()) -> Result:
    """Return the rows of one read-only SQL statement as plain values; `read(sql=...)` returns a pandas table.

    Parameters
    ----------
    database
        A database from `open_readonly`.
    sql
        One SELECT.
    kinds
        The kinds of the columns, if rows with other values are errors.

    Returns
    -------
    Result
        Columns and rows.
    """
    expect_kind("the database to read", database, Database, "an open one, such as open_readonly('designs.sqlite')")
    with stream_sql(database, sql, kinds) as rows:
        return rows.gathered()


def check_scene(database: Database, scene: str, view: str = "designs") -> None:
    """Raise SceneError for a scene that was never run on a database; `default` is allowed if none was run."""
    if scene == DEFAULT_SCENE_NAME and view not in SCENIC:
        return
    stored_names = scene_names(database)
    if scene in stored_names or (scene == DEFAULT_SCENE_NAME and not stored_names):
        return
    names = ", ".join(map(shlex.quote, stored_names)) or "none yet"
    base, _, size = scene.rpartition(", ")
    exists = scene in SCENES or (is_panel(size) and (base or DEFAULT_SCENE_NAME) in (*SCENES, *stored_names))
    scene_option = (
        "" if scene == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(scene)}" if exists else " --scene FILE.toml"
    )
    remedy = f"{'' if exists else 'for a scene of your own '}run `hcsearch enumerate{scene_option}`"
    alternative = "name one of these with --scene, or " if stored_names else ""
    raise SceneError(
        f"no verdicts of the scene {scene!r} in {database.location}, its scenes are: {names}; "
        f"{alternative}{remedy} with the grid and --n or --array first"
    )


@retry_if_changed
def grids_in(database: Database, query: str = "") -> list[str]:
    """Return the grids that the conditions of a query allow and a database has designs on.

    If the database has no design on any of them, all grids that the conditions allow.
    """
    allowed_grids = named_grids(query)
    with database.reading() as connection:
        probes = {grid: sql_select(design.c.id).where(design.c.grid == grid).limit(1) for grid in allowed_grids}
        stored = [grid for grid, statement in probes.items() if connection.execute(statement).first() is not None]
    return stored or allowed_grids


def _statement(view: str, scene: str, names: Sequence[str], query: str, sort: str, limit: int | None) -> Select[Any]:
    source = view_table(view, scene)
    statement = sql_select(*(source.c[name] for name in names)).where(parse_query(query, view, scene))
    statement = statement.order_by(*order_of(source, view, sort))
    if limit is not None:
        if limit < 0:
            raise QueryError(f"the limit {limit} is negative: give a number of rows, or leave it out")
        statement = statement.limit(min(limit, 2**63 - 1))
    return statement


def order_of(source: FromClause, view: str, sort: str) -> list[ColumnElement[Any]]:
    """Return the ORDER BY terms of a sort specification, made unique by the key columns.

    A column of words sorts in the order of its words, a status thus best first; other texts alphabetically.
    """
    terms = [(sort_key(source, find_quantity(view, name)), descending) for name, descending in sort_terms(view, sort)]
    order: list[ColumnElement[Any]] = [(key.desc() if down else key.asc()).nulls_last() for key, down in terms]
    return order + [source.c[name] for name in VIEW_KEYS[view]]


def sort_key(source: FromClause, quantity: Quantity) -> ColumnElement[Any]:
    """Return the sort key of a column: the place of a word among the words of the column, else the value itself."""
    own = source.c[quantity.name]
    return case({word: k for k, word in enumerate(quantity.words)}, value=own) if quantity.words else own


@retry_if_changed
def find_design(database: Database, text: str, scene: str = DEFAULT_SCENE_NAME) -> dict[str, Any]:
    """Return the row of `designs` for an id or a circuit notation, with its rows of the views of foldings.

    These are `foldings`, `motions` and `deployments`. scene : the one whose verdicts `designs` and `foldings` show.
    Control characters in texts are escaped for display, except in `scene_values`, which are TOML.
    """
    key, _ = find_circuit(database, text)
    queries = {"designs": f"id={key}"} | dict.fromkeys(("foldings", "motions", "deployments"), f"design_id={key}")
    rows = {view: _for_people(select(database, query, view=view, scene=scene)) for view, query in queries.items()}
    return rows.pop("designs")[0] | rows


@retry_if_changed
def find_circuit(database: Database, text: str) -> tuple[int, str]:
    """Return id and circuit of the design with an id or a circuit notation; QueryError if there is none."""
    by_id = re.fullmatch(r"[0-9]+", text) is not None
    condition = design.c.id == int(text[:20]) if by_id else design.c.circuit.in_(_spellings(text))
    if by_id and int(text[:20]) >= 2**63:
        raise _unknown(database, text)
    with database.reading() as connection:
        row = connection.execute(sql_select(design.c.id, design.c.circuit, design.c.n).where(condition)).first()
    if row is None:
        raise _unknown(database, text)
    check_values(database.location, ("id", "circuit", "n"), ("integer", "text", "integer"), [row])
    if len(row.circuit.rpartition(":")[2]) > row.n:
        raise DatabaseError(
            f"database {database.location} is damaged, the circuit of design {row.id} has more than its {row.n} "
            "panels: restore a copy, or enumerate anew"
        )
    return row.id, row.circuit


def _for_people(result: Result) -> list[dict[str, Any]]:
    def shown(name: str, value: Any) -> Any:
        return printable(value) if isinstance(value, str) and name != "scene_values" else value

    return [{name: shown(name, row[k]) for k, name in enumerate(result.columns)} for row in result.rows]


def _spellings(text: str) -> list[str]:
    """Return the notation of a circuit as written, and the canonical one if it can be parsed."""
    spellings = [text.encode(errors="replace").decode()]
    with suppress(HcsearchError):
        spellings.append(Circuit.from_notation(text).canonical().notation)
    return spellings


def _unknown(database: Database, text: str) -> QueryError:
    return QueryError(f"no design {text!r} in {database.location}: give an id or a circuit that `hcsearch query` lists")


STATEMENT_SECONDS = 10.0
"""Time limit of a statement, in seconds."""


class SlowQueryError(QueryError):
    """A query exceeded its time limit."""


_STOPPED = "57014"  # SQLSTATE of a statement that a server ended at its time limit


@retry_if_changed
def select_page(
    database: Database,
    query: str = "",
    *,
    columns: str | Sequence[str] = "",
    sort: str = "",
    skip: int = 0,
    count: int = 50,
    view: str = "designs",
    scene: str = DEFAULT_SCENE_NAME,
    seconds: float = STATEMENT_SECONDS,
) -> Result:
    """Return `count` of the rows of a view that `select` returns, after the first `skip`.

    Two statements: the first skips the rows before the page and uses only the columns of query and order, so that
    SQLite omits other joins; the second reads the page. SlowQueryError: one takes more than `seconds`.
    """
    view_table(view)
    quantities = quantities_named(view, columns)
    check_scene(database, scene, view)
    source, identity = view_table(view, scene), VIEW_KEYS[view]
    key = [source.c[name] for name in identity]
    matching = sql_select(*key).where(parse_query(query, view, scene)).order_by(*order_of(source, view, sort))
    names = tuple(quantity.name for quantity in quantities)
    kinds = [find_quantity(view, name).kind for name in identity] + [quantity.kind for quantity in quantities]
    with limited_reading(database, seconds) as connection:
        with raising_query_errors():
            keys = [tuple(row) for row in connection.execute(matching.offset(min(skip, 2**62)).limit(count))]
        if not keys:
            return Result(names, ())
        on_page = or_(*(and_(*(column == value for column, value in zip(key, row, strict=True))) for row in keys))
        statement = sql_select(*key, *(source.c[name] for name in names)).where(on_page)
        rows = checked_rows(connection, database.location, statement, kinds)
    values_of = {row[: len(key)]: row[len(key) :] for row in rows}
    return Result(names, tuple(values_of[row] for row in keys if row in values_of))


@retry_if_changed
def count_rows(
    database: Database,
    query: str = "",
    *,
    most: int,
    view: str = "designs",
    scene: str = DEFAULT_SCENE_NAME,
    seconds: float = STATEMENT_SECONDS,
) -> int:
    """Return the number of rows of a view that satisfy a query, counted up to `most`."""
    source = view_table(view, scene)
    constant: ColumnElement[int] = literal_column("1")
    rows = sql_select(constant).select_from(source).where(parse_query(query, view, scene)).limit(most)
    with limited_reading(database, seconds) as connection, raising_query_errors():
        return int(connection.execute(sql_select(func.count()).select_from(rows.subquery())).scalar_one())


@contextmanager
def limited_reading(database: Database, seconds: float) -> Iterator[Connection]:
    """Yield a reading connection with a time limit for statements; SlowQueryError if one exceeds it."""
    end = time.monotonic() + seconds
    too_long = SlowQueryError(
        f"the query takes more than {seconds:.3g} s: narrow it, as with grid= and n=, or give it more time"
    )
    try:
        with database.reading() as connection:
            driver: Any = connection.connection.dbapi_connection
            if not isinstance(driver, sqlite3.Connection):
                milliseconds = max(1, round(1000 * seconds))  # 0 would be no limit
                connection.exec_driver_sql(f"SET LOCAL statement_timeout = {milliseconds}")
                yield connection
                return
            driver.set_progress_handler(lambda: time.monotonic() > end, PROGRESS_HANDLER_STEPS)
            try:
                yield connection
            finally:
                driver.set_progress_handler(
                    lambda: 0, PROGRESS_HANDLER_STEPS
                )  # restores the handler of `sqlite.connect`
    except KeyboardInterrupt:
        if time.monotonic() > end:  # the handler above interrupted SQLite
            raise too_long from None
        raise
    except DatabaseError as error:
        driver = getattr(error.__cause__, "orig", None)
        if getattr(driver, "sqlstate", None) == _STOPPED:
            raise too_long from None
        raise
