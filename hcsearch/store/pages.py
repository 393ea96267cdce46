"""Pages of what a query selects, from anywhere among millions of rows, and bounded counts, both within a time limit."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, func, literal_column, or_
from sqlalchemy import select as sql_select

from hcsearch.basics.errors import DatabaseError, QueryError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.conditions import find_quantity, parse_query, quantities_named, view_table
from hcsearch.store.database import Database
from hcsearch.store.failures import again
from hcsearch.store.queries import IDENTITY, check_scene, order_of
from hcsearch.store.rows import Result, checked_rows, refusing
from hcsearch.store.sqlite import STEPS

SECONDS = 10.0
"""How long a statement may take."""


class SlowQueryError(QueryError):
    """A query that takes more time than it has."""


_STOPPED = "57014"  # SQLSTATE of a server that ends a statement at its time limit


@again
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
    seconds: float = SECONDS,
) -> Result:
    """Return `count` rows of a view after the first `skip` of those that `select` returns.

    Two statements: the first passes over the rows before in the columns of query and order alone, of which SQLite
    reads no others and makes no other joins; the second reads the page. SlowQueryError: one takes more than `seconds`.
    """
    view_table(view)
    quantities = quantities_named(view, columns)
    check_scene(database, scene, view)
    source, identity = view_table(view, scene), IDENTITY[view]
    key = [source.c[name] for name in identity]
    found = sql_select(*key).where(parse_query(query, view, scene)).order_by(*order_of(source, view, sort))
    names = tuple(quantity.name for quantity in quantities)
    kinds = [find_quantity(view, name).kind for name in identity] + [quantity.kind for quantity in quantities]
    with _limited(database, seconds) as connection:
        with refusing():
            keys = [tuple(row) for row in connection.execute(found.offset(min(skip, 2**62)).limit(count))]
        if not keys:
            return Result(names, ())
        wanted = or_(*(and_(*(own == value for own, value in zip(key, row, strict=True))) for row in keys))
        statement = sql_select(*key, *(source.c[name] for name in names)).where(wanted)
        rows = checked_rows(connection, database.location, statement, kinds)
    at = {row[: len(key)]: row[len(key) :] for row in rows}
    return Result(names, tuple(at[row] for row in keys if row in at))


@again
def count_rows(
    database: Database,
    query: str = "",
    *,
    most: int,
    view: str = "designs",
    scene: str = DEFAULT_SCENE_NAME,
    seconds: float = SECONDS,
) -> int:
    """Return the number of rows of a view that satisfy a query; `most` where there are as many or more."""
    source = view_table(view, scene)
    one: ColumnElement[int] = literal_column("1")
    rows = sql_select(one).select_from(source).where(parse_query(query, view, scene)).limit(most)
    with _limited(database, seconds) as connection, refusing():
        return int(connection.execute(sql_select(func.count()).select_from(rows.subquery())).scalar_one())


@contextmanager
def _limited(database: Database, seconds: float) -> Iterator[Connection]:
    """A connection for reading, whose statements end after some seconds; SlowQueryError where they do."""
    end = time.monotonic() + seconds
    too_long = SlowQueryError(
        f"the query takes more than {seconds:.3g} s: narrow it, as with grid= and n=, or give it more time"
    )
    try:
        with database.reading() as connection:
            driver: Any = connection.connection.dbapi_connection
            if not isinstance(driver, sqlite3.Connection):
                connection.exec_driver_sql(f"SET LOCAL statement_timeout = {round(1000 * seconds)}")
                yield connection
                return
            driver.set_progress_handler(lambda: time.monotonic() > end, STEPS)
            try:
                yield connection
            finally:
                driver.set_progress_handler(lambda: 0, STEPS)  # as `sqlite.connect` sets it
    except KeyboardInterrupt:
        if time.monotonic() > end:  # SQLite was interrupted by the handler here
            raise too_long from None
        raise
    except DatabaseError as error:
        driver = getattr(error.__cause__, "orig", None)
        if getattr(driver, "sqlstate", None) == _STOPPED:
            raise too_long from None
        raise
