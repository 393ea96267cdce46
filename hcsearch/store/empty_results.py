"""Why a query selects no rows: the ranges, in the database, of the columns that it compares."""

from __future__ import annotations

import math
from collections.abc import Iterator

from sqlalchemy import ColumnElement, FromClause, func, literal_column
from sqlalchemy import select as sql_select

from hcsearch.basics.vocabulary import listed
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.conditions import (
    FITS,
    STOWED_SIDES,
    AllOf,
    Condition,
    condition_of,
    find_quantity,
    parse_conditions,
    view_table,
)
from hcsearch.store.database import Database
from hcsearch.store.failures import retry_if_changed
from hcsearch.store.quantity import Quantity
from hcsearch.system.terminal import short_number

_MOST_WORDS = 9
"""Most values of a column of words that are listed."""
_ENDS = {">": "greatest", ">=": "greatest", "<": "least", "<=": "least"}


@retry_if_changed
def empty_result_reason(database: Database, query: str, view: str = "designs", scene: str = DEFAULT_SCENE_NAME) -> str:
    """Return the ranges of the columns that a query compares; empty where these do not explain anything.

    query : one that selects no row of the view. The range of a column is taken over the rows that satisfy all other
    conditions; if there are none, over all rows, for conditions that no row satisfies.
    """
    tree = parse_conditions(query, view)
    parts = tree.parts if isinstance(tree, AllOf) else (tree,)
    compared = [part for part in parts if isinstance(part, Condition)]
    reasons: list[str] = []
    for part in compared:
        others = tuple(other for other in parts if other is not part)
        reasons += _reasons(database, part, AllOf(others), view, scene)
    if not reasons:
        for part in compared:
            if _selects_none(database, view_table(view, scene), part, view):
                reasons += _reasons(database, part, AllOf(()), view, scene)
    return listed(reasons, "and") if reasons else ""


def _selects_none(database: Database, source: FromClause, condition: Condition | AllOf, view: str) -> bool:
    one: ColumnElement[int] = literal_column("1")
    statement = sql_select(one).where(condition_of(source, view, condition)).limit(1)
    with database.reading() as connection:
        return connection.execute(statement).first() is None


def _reasons(database: Database, condition: Condition, others: AllOf, view: str, scene: str) -> Iterator[str]:
    """Yield words on the values, in the column of a condition, of the rows that satisfy all other conditions."""
    source = view_table(view, scene)
    if condition.name.lower() == FITS:
        yield from _smallest_box(database, source, others, view)
    elif condition.sign is not None:
        quantity = find_quantity(view, condition.name)
        if quantity.kind in ("integer", "real"):
            yield from _range(database, source, quantity, condition.sign, others, view)
        elif quantity.kind == "text" and condition.sign == "=" and quantity.name not in ("array", "circuit"):
            yield from _words(database, source, quantity, others, view)


def _words(database: Database, source: FromClause, quantity: Quantity, others: AllOf, view: str) -> Iterator[str]:
    column = source.c[quantity.name]
    known = condition_of(source, view, others), column.is_not(None)
    statement = sql_select(column).where(*known).distinct().order_by(column).limit(_MOST_WORDS + 1)
    with database.reading() as connection:
        words = list(connection.execute(statement).scalars())
    if 0 < len(words) <= _MOST_WORDS:
        yield f"{quantity.name} is {listed(words, 'or')} here"


def _range(
    database: Database, source: FromClause, quantity: Quantity, sign: str, others: AllOf, view: str
) -> Iterator[str]:
    column = source.c[quantity.name]
    statement = sql_select(func.count(), func.min(column), func.max(column)).where(condition_of(source, view, others))
    with database.reading() as connection:
        count, least, greatest = connection.execute(statement).one()
    name, unit = quantity.name, f" {quantity.unit}" if quantity.unit else ""
    if not count:
        return
    if least is None:
        yield f"{name} is not known here"
    elif sign in _ENDS:
        end = greatest if _ENDS[sign] == "greatest" else least
        yield f"the {_ENDS[sign]} {name} here is {short_number(end)}{unit}"
    elif least == greatest:
        yield f"{name} is {short_number(least)}{unit} here"
    else:
        yield f"{name} is from {short_number(least)} to {short_number(greatest)}{unit} here"


def _smallest_box(database: Database, source: FromClause, others: AllOf, view: str) -> Iterator[str]:
    length, width, height = (source.c[name] for name in STOWED_SIDES)
    known = condition_of(source, view, others), length.is_not(None), width.is_not(None), height.is_not(None)
    statement = sql_select(length, width, height).where(*known).order_by(length * width * height).limit(1)
    with database.reading() as connection:
        box = connection.execute(statement).first()
    if box is not None:
        sides = "x".join(f"{math.ceil(100.0 * side) / 100.0:g}" for side in box)  # rounded up, so that it fits
        yield f"the smallest folded array here is {sides} mm, and sizes are in mm"
    elif not _selects_none(database, source, others, view):
        yield "the size of folded arrays is not known here"
