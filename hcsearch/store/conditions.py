"""The query language: terms separated by white space, all of which must hold.

    query = term*            term = NAME | NAME op VALUE            op = in = != < <= > >=

NAME is a column of the view; alone, it asks that a yes/no column is 1. Values never become part of the SQL text.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Any

from sqlalchemy import ColumnClause, ColumnElement, FromClause, and_, column, literal, table, text, true

from hcsearch.errors import QueryError
from hcsearch.scenes import DEFAULT
from hcsearch.store.columns import VIEWS, Quantity
from hcsearch.store.views import SCENIC, select_in

_TERM = re.compile(r"([A-Za-z_]\w*)(?:(<=|>=|!=|=|<|>)(.*))?", re.ASCII | re.DOTALL)
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_EXAMPLE = "write conditions as in 'grid=hex n=12 untwisted dof<=6'"


@cache  # one object a view: SQLAlchemy would join two of the same name
def view_table(view: str, scene: str = DEFAULT) -> FromClause:
    """Return a view, in a scene, as something to select from; QueryError when there is none of that name."""
    if view not in VIEWS:
        raise QueryError(f"no view {view!r}{nearest(view, list(VIEWS))}: choose one of {', '.join(VIEWS)}")
    columns: list[ColumnClause[Any]] = [column(quantity.name) for quantity in VIEWS[view]]
    if scene == DEFAULT or view not in SCENIC:
        return table(view, *columns)
    # a colon would begin the name of a parameter
    return text(select_in(view, scene).replace(":", r"\:")).columns(*columns).subquery(view)


def find_quantity(view: str, name: str) -> Quantity:
    """Return a column of a view; QueryError with the nearest names when there is none."""
    names = [quantity.name for quantity in VIEWS[view]]
    if name not in names:
        raise QueryError(f"no column {name!r} in {view}{nearest(name, names)}: choose from {', '.join(names)}")
    return VIEWS[view][names.index(name)]


def parse_query(query: str, view: str = "designs", scene: str = DEFAULT) -> ColumnElement[bool]:
    """Return the condition that a query asks for; the empty query holds for every row.

    QueryError: a term that cannot be read, a column that is not there, a value that is no number where one is needed.
    """
    source = view_table(view, scene)
    return and_(true(), *(_term(source, view, text) for text in query.split()))


def _term(source: FromClause, view: str, text: str) -> ColumnElement[bool]:
    match = _TERM.fullmatch(text)
    if match is None:
        raise QueryError(f"cannot read {text!r}: {_EXAMPLE}, without spaces inside a condition")
    name, sign, value = match.groups()
    quantity = find_quantity(view, name)
    if sign is None:
        if quantity.kind != "boolean":
            raise QueryError(f"{name} is not a yes/no column: compare it, as in {name}=VALUE, without spaces")
        return source.c[name] == literal(1)
    condition: ColumnElement[bool] = _OPERATORS[sign](source.c[name], literal(_value(quantity, text, sign, value)))
    return condition


def _value(quantity: Quantity, text: str, sign: str, value: str) -> str | int | float:
    if not value or value[0] in "=<>!":
        raise QueryError(f"no value in {text!r}: the comparisons are = != < <= > >=, each followed by a value")
    if quantity.kind == "text":
        if quantity.words and sign in ("=", "!=") and value not in quantity.words:
            words = ", ".join(quantity.words)
            raise QueryError(
                f"{quantity.name} is never {value!r}{nearest(value, quantity.words)}: it is one of {words}"
            )
        # Undecodable bytes of a command line arrive as lone surrogates, which no database stores.
        return value.encode(errors="replace").decode()
    if not _NUMBER.fullmatch(value):
        needed = "1 or 0" if quantity.kind == "boolean" else "a number"
        raise QueryError(f"{quantity.name} is compared with {needed}, not with {value!r}")
    try:
        whole = int(value)
    except ValueError:  # a fraction, or more digits than Python reads
        return float(value)
    return whole if abs(whole) < 2**63 else float(whole)


def sort_terms(view: str, sort: str) -> list[tuple[str, bool]]:
    """Read a sort specification as `-score,n` into (column, descending) pairs."""
    terms = [(term.removeprefix("-"), term.startswith("-")) for term in split_names(sort)]
    for name, _ in terms:
        find_quantity(view, name)
    return terms


def split_names(names: str | Sequence[str]) -> list[str]:
    """Read names separated by commas, or take them as they are."""
    parts = names.split(",") if isinstance(names, str) else names
    return [part.strip() for part in parts if part.strip()]


def nearest(name: str, names: Sequence[str]) -> str:
    """Write which names are near to one that there is not, for a refusal; empty where none is."""
    close = get_close_matches(name, names, n=2)
    return f" (did you mean {' or '.join(close)}?)" if close else ""
