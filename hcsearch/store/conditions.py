"""The query language: conditions are parsed by a grammar and become SQL with bound parameters.

query = [either]                    either = all ("or" all)*
    all = one (["and"] one)*            one = "not" one | "(" either ")" | condition
    condition = NAME | NAME op VALUE    op = one of = != < <= > >=

NAME is a column or its label on pages, such as `degrees of freedom`, in capitals or not; keywords may be written in
capitals, too. Spaces may stand around an op; a value contains none. Paired brackets inside a value belong to it.

A name alone requires that a yes/no column is 1. A value never becomes part of the SQL text. NULL satisfies neither a
condition nor its negation. `array=` takes any array specification and `circuit=` a circuit in any position, order or
direction: both select congruent designs. `fits=` takes an envelope, such as 3U or 340x640x130 in mm, into which
the folded array must go with its sides parallel to it.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import Any

from sqlalchemy import ColumnClause, ColumnElement, FromClause, and_, column, literal, not_, or_, table, text, true

from hcsearch.basics.errors import ArrayError, NotationError, QueryError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, grid_named, parse_array
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.scenes.envelopes import box_placements, envelope_sides
from hcsearch.store.columns import VIEWS, column_names
from hcsearch.store.quantity import Quantity
from hcsearch.store.views import SCENIC, select_view_in

MAX_CONDITIONS = 500
"""Conditions in one query; databases allow about twice as many."""
MAX_NESTING_DEPTH = 15
"""Nesting depth of brackets and `not`: each level takes up to five of the 100 stack places of SQLite's parser."""
EXAMPLE_CONDITIONS = "write conditions as in 'grid=hex n=12 (untwisted or dof<=6) not status=locked'"

_CONDITION = re.compile(r"([A-Za-z_][A-Za-z_0-9]*)(?:(<=|>=|!=|=|<|>)(.*)|(?=[()]|$))", re.DOTALL)
_SPACED_SIGN = re.compile(r"(?<!\s)\s*(<=|>=|!=|=|<|>)\s*")
_WORDS = ("and", "or", "not")
FITS = "fits"
"""The condition on the three columns of the stowed box; no column has this name."""
STOWED_SIDES = ("stowed_length", "stowed_width", "stowed_height")
_FIT_TOLERANCE_MM = 1e-6
"""By how much a box may be larger than an envelope into which it fits exactly: the rounding of the columns."""


@dataclass(frozen=True)
class Condition:
    """One condition; `sign` and `value` are None for a name alone."""

    name: str
    sign: str | None = None
    value: str | None = None

    @property
    def text(self) -> str:
        """The condition as it was written."""
        return f"{self.name}{self.sign or ''}{self.value or ''}"


@dataclass(frozen=True)
class Not:
    """The negation of a condition."""

    part: ConditionTree


@dataclass(frozen=True)
class AllOf:
    """A conjunction; true without parts."""

    parts: tuple[ConditionTree, ...]


@dataclass(frozen=True)
class AnyOf:
    """A disjunction."""

    parts: tuple[ConditionTree, ...]


ConditionTree = Condition | Not | AllOf | AnyOf


def parse_conditions(query: str, view: str = "designs") -> ConditionTree:
    """Parse a query on a view; QueryError for a syntax error, too many conditions or too many levels."""
    tokens = list(_tokens(with_column_names(query, view)))
    number = sum(isinstance(token, Condition) for token in tokens)
    if number > MAX_CONDITIONS:
        raise QueryError(f"the query has {number} conditions: give {MAX_CONDITIONS} at most")
    reader = _Reader(tokens)
    tree = reader.either(0) if tokens else AllOf(())
    if reader.next is not None:
        raise QueryError(f"a bracket closes where none is open: {EXAMPLE_CONDITIONS}")
    return tree


def with_column_names(query: str, view: str) -> str:
    """Return a query with labels of columns, and names in any case, replaced by names, and no space around signs.

    The longest label that fits is taken. Values are not replaced. `named` of grammar.js does the same on pages.
    """
    labels, names = _labels_of(view)
    tight = _SPACED_SIGN.sub(r"\1", query)
    # some letters beyond ASCII match one of a name without regard to case, as U+017F does `s`
    return labels.sub(lambda match: names.get(" ".join(match[0].lower().split()), match[0]), tight)


@cache
def _labels_of(view: str) -> tuple[re.Pattern[str], dict[str, str]]:
    """Return a pattern of all names and labels of the columns of a view, and the name by each in lower case."""
    names = {text.lower(): quantity.name for quantity in VIEWS[view] for text in (quantity.title, quantity.name)}
    longest_first = sorted(names, key=len, reverse=True)
    any_label = "|".join(re.escape(text).replace(r"\ ", r"\s+") for text in longest_first)
    return re.compile(rf"(?<![^\s(])(?:{any_label})(?=[<>=!\s()]|$)", re.IGNORECASE), names


def _tokens(query: str) -> Iterator[Condition | str]:
    """Split a query into conditions, brackets and keywords."""
    for word in query.split():
        remaining = word
        while remaining:
            if remaining[0] in "()":
                yield remaining[0]
                remaining = remaining[1:]
                continue
            match = _CONDITION.match(remaining)
            if match is None:
                raise QueryError(f"cannot read {remaining!r}: {EXAMPLE_CONDITIONS}")
            name, sign, operand = match.groups()
            value = None if sign is None else _before_bracket(operand)
            token = Condition(name, sign, value)
            yield name.lower() if sign is None and name.lower() in _WORDS else token
            remaining = remaining[len(token.text) :]


def _before_bracket(value: str) -> str:
    """Return a value up to the first bracket that closes one opened before the value."""
    depth = 0
    for k, mark in enumerate(value):
        depth += {"(": 1, ")": -1}.get(mark, 0)
        if depth < 0:
            return value[:k]
    return value


class _Reader:
    """A recursive-descent parser of tokens; `depth` is the number of enclosing brackets and `not`."""

    def __init__(self, tokens: list[Condition | str]) -> None:
        self._tokens = tokens[::-1]

    @property
    def next(self) -> Condition | str | None:
        """Return the next token; None at the end."""
        return self._tokens[-1] if self._tokens else None

    def _taken(self, *words: str) -> bool:
        """Consume the next token if it is one of some words; return whether it was."""
        matches = self.next in words
        if matches:
            self._tokens.pop()
        return matches

    def either(self, depth: int) -> ConditionTree:
        """Parse alternatives until the end or a closing bracket."""
        parts = [self._all(depth)]
        while self._taken("or"):
            parts.append(self._all(depth))
        return AnyOf(tuple(parts)) if len(parts) > 1 else parts[0]

    def _all(self, depth: int) -> ConditionTree:
        parts = [self._one(depth)]
        while self._taken("and") or self.next not in (None, ")", "or"):
            parts.append(self._one(depth))
        return AllOf(tuple(parts)) if len(parts) > 1 else parts[0]

    def _one(self, depth: int) -> ConditionTree:
        if depth > MAX_NESTING_DEPTH:
            raise QueryError(
                f"the query has brackets or `not` more than {MAX_NESTING_DEPTH} deep: leave out what is not needed"
            )
        if self._taken("not"):
            return Not(self._one(depth + 1))
        if self._taken("("):
            tree = self.either(depth + 1)
            if not self._taken(")"):
                raise QueryError(f"a bracket is not closed: {EXAMPLE_CONDITIONS}")
            return tree
        if isinstance(self.next, Condition):
            token = self._tokens.pop()
            assert isinstance(token, Condition)
            return token
        position = "at the end" if self.next is None else f"before {self.next!r}"
        raise QueryError(f"a condition is missing {position}: {EXAMPLE_CONDITIONS}")


_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@cache  # one object per view: SQLAlchemy would join two of the same name
def view_table(view: str, scene: str = DEFAULT_SCENE_NAME) -> FromClause:
    """Return a view in a scene as a selectable; QueryError for an unknown view."""
    if view not in VIEWS:
        raise QueryError(f"no view {view!r}{nearest_names_hint(view, list(VIEWS))}: choose one of {', '.join(VIEWS)}")
    columns: list[ColumnClause[Any]] = [column(quantity.name) for quantity in VIEWS[view]]
    if scene == DEFAULT_SCENE_NAME or view not in SCENIC:
        return table(view, *columns)
    # a colon would begin the name of a parameter
    return text(select_view_in(view, scene).replace(":", r"\:")).columns(*columns).subquery(view)


def find_quantity(view: str, name: str) -> Quantity:
    """Return a column of a view; QueryError with the nearest names for an unknown one."""
    names = [quantity.name for quantity in VIEWS[view]]
    if name not in names:
        raise QueryError(
            f"no column {name!r} in {view}{nearest_names_hint(name, names)}: choose from {', '.join(names)}"
        )
    return VIEWS[view][names.index(name)]


def quantities_named(view: str, columns: str | Sequence[str]) -> list[Quantity]:
    """Return the named columns of a view, all of them without names; names are a sequence or separated by commas."""
    return [find_quantity(view, name) for name in _split_names(columns) or column_names(view)]


def parse_query(query: str, view: str = "designs", scene: str = DEFAULT_SCENE_NAME) -> ColumnElement[bool]:
    """Return the SQL condition of a query; the empty query holds for every row.

    QueryError: a syntax error, an unknown column, a value that is no number where a
    number is needed. HcsearchError: an array or a circuit that cannot be read.
    """
    return condition_of(view_table(view, scene), view, parse_conditions(query, view))


def condition_of(source: FromClause, view: str, tree: ConditionTree) -> ColumnElement[bool]:
    """Return the SQL condition of a parsed query. source : of `view_table`."""
    return and_(true(), _condition(source, view, tree, tuple(GRIDS)))


def _condition(source: FromClause, view: str, tree: ConditionTree, grids: Sequence[str]) -> ColumnElement[bool]:
    """Return the SQL condition of a part of a query; grids : the grids of the arrays that it names."""
    match tree:
        case AllOf(parts):
            grids = _grids_of(parts, grids)
            return and_(true(), *(_condition(source, view, part, grids) for part in parts))
        case AnyOf(parts):
            return or_(*(_condition(source, view, part, grids) for part in parts))
        case Not(part):
            return not_(_condition(source, view, part, grids))
        case Condition():
            return _compared(source, view, tree, grids)


def named_grids(query: str) -> list[str]:
    """Return the grids that the conditions of a query on the grid leave possible."""
    tree = parse_conditions(query)
    return list(_grids_of(tree.parts if isinstance(tree, AllOf) else (tree,), tuple(GRIDS)))


def _grids_of(parts: Sequence[ConditionTree], grids: Sequence[str]) -> Sequence[str]:
    named_values = [part.value for part in parts if isinstance(part, Condition) and _names_grid(part)]
    return [grid for grid in grids if grid in named_values] if named_values else grids


def _names_grid(condition: Condition) -> bool:
    return condition.name == "grid" and condition.sign == "="


def _compared(source: FromClause, view: str, condition: Condition, grids: Sequence[str]) -> ColumnElement[bool]:
    name, sign, value = condition.name, condition.sign, condition.value
    if name.lower() == FITS and set(STOWED_SIDES) <= set(column_names(view)):
        return _fitted(source, condition)
    quantity = find_quantity(view, name)
    source_column = source.c[name]
    if sign is None or value is None:
        if quantity.kind != "boolean":
            raise QueryError(f"{name} is not a yes/no column: compare it, as in {name}=VALUE")
        return source_column == literal(1)
    read = _value(quantity, condition.text, sign, value)
    if sign in ("=", "!=") and name in ("array", "circuit"):
        congruent = _arrays(value, grids) if name == "array" else [Circuit.from_notation(value).canonical().notation]
        return source_column.in_(congruent) if sign == "=" else source_column.not_in(congruent)
    compared: ColumnElement[bool] = _OPERATORS[sign](source_column, literal(read))
    return compared


def _fitted(source: FromClause, condition: Condition) -> ColumnElement[bool]:
    """Return the condition that the stowed box goes into an envelope, or with `!=` that it does not."""
    if condition.sign not in ("=", "!=") or not condition.value:
        raise QueryError(f"{condition.text!r} names no envelope by = or !=: write fits=3U, or fits=340x640x130 in mm")
    sides = [source.c[name] for name in STOWED_SIDES]
    laid = (
        and_(*(side <= literal(room + _FIT_TOLERANCE_MM) for side, room in zip(sides, rooms, strict=True)))
        for rooms in box_placements(envelope_sides(condition.value))
    )
    fitted = or_(*laid)
    return fitted if condition.sign == "=" else not_(fitted)


def _arrays(spec: str, grids: Sequence[str]) -> list[str]:
    """Return the canonical notations of an array on all grids on which it exists; HcsearchError if there is none."""
    notations, errors = [], []
    for name in grids:
        try:
            notations.append(parse_array(grid_named(name), spec).canonical().notation)
        except (NotationError, ArrayError) as error:
            errors.append(error)
    if len(errors) == 1 and not notations:
        raise errors[0]
    if errors and not notations:
        raise QueryError(
            f"no grid has an array {spec!r}: write 6x5, 3-4-3, p5x4, t5, h3, s1, @file or an array's notation; with "
            "its grid, as in grid=hex, the query says what is wrong"
        )
    return notations


def _value(quantity: Quantity, text: str, sign: str, value: str) -> str | int | float:
    if not value or value[0] in "=<>!":
        intended_sign = {"==": "=", "<>": "!="}.get(sign + value[:1])
        if intended_sign is not None and value[1:]:
            raise QueryError(f"{text!r} is no comparison: write {quantity.name}{intended_sign}{value[1:]}")
        raise QueryError(f"no value in {text!r}: the comparisons are = != < <= > >=, each followed by a value")
    if quantity.kind == "text":
        if quantity.words and sign in ("=", "!=") and value not in quantity.words:
            words = ", ".join(quantity.words)
            raise QueryError(
                f"{quantity.name} is never {value!r}{nearest_names_hint(value, quantity.words)}: it is one of {words}"
            )
        # Undecodable bytes of a command line become lone surrogates, which no database stores.
        return value.encode(errors="replace").decode()
    if not _NUMBER.fullmatch(value):
        needed = "1 or 0" if quantity.kind == "boolean" else "a number"
        if _NUMBER.fullmatch(value.rstrip(",;")):
            raise QueryError(f"{text!r} ends in {value[-1]!r}: separate conditions by spaces")
        raise QueryError(f"{quantity.name} is compared with {needed}, not with {value!r}")
    try:
        integer = int(value)
    except ValueError:  # a fraction, or more digits than Python reads
        return float(value)
    return integer if abs(integer) < 2**63 else float(value)


def sort_terms(view: str, sort: str) -> list[tuple[str, bool]]:
    """Parse a sort specification such as `-score,n` into (column, descending) pairs."""
    terms = [(term.removeprefix("-"), term.startswith("-")) for term in _split_names(sort)]
    for name, _ in terms:
        find_quantity(view, name)
    return terms


def _split_names(names: str | Sequence[str]) -> list[str]:
    """Split names at commas; return a sequence of names unchanged."""
    parts = names.split(",") if isinstance(names, str) else names
    return [part.strip() for part in parts if part.strip()]


def nearest_names_hint(name: str, names: Sequence[str]) -> str:
    """Return the part of an error message that suggests the nearest names; empty if none is near."""
    close = get_close_matches(name[:100], names, n=2)  # longer names resemble none, and comparing them takes long
    return f" (did you mean {' or '.join(close)}?)" if close else ""
