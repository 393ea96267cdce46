"""The grammar of queries: conditions joined by `and`, `or`, `not` and brackets; white space alone means `and`.

    query = [either]                    either = all ("or" all)*
    all = one (["and"] one)*            one = "not" one | "(" either ")" | condition
    condition = NAME | NAME op VALUE    op = one of = != < <= > >=

A condition has no white space in it. Words may be written in capitals. Brackets that come in pairs inside a value
belong to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from hcsearch.basics.errors import QueryError

MOST_CONDITIONS = 500
"""In one query: databases allow about twice as many."""
DEEPEST = 15
"""Brackets and `not` inside each other: each takes up to five of the 100 places of SQLite's parser."""
EXAMPLE = "write conditions as in 'grid=hex n=12 (untwisted or dof<=6) not status=locked'"

_CONDITION = re.compile(r"([A-Za-z_][A-Za-z_0-9]*)(?:(<=|>=|!=|=|<|>)(.*)|(?=[()]|$))", re.DOTALL)
_WORDS = ("and", "or", "not")


@dataclass(frozen=True)
class Condition:
    """One condition; `sign` and `value` are None where it is only a name."""

    name: str
    sign: str | None = None
    value: str | None = None

    @property
    def text(self) -> str:
        """The condition as it was written."""
        return f"{self.name}{self.sign or ''}{self.value or ''}"


@dataclass(frozen=True)
class Not:
    """What must not hold."""

    of: Tree


@dataclass(frozen=True)
class AllOf:
    """Parts that must all hold; without parts it always does."""

    parts: tuple[Tree, ...]


@dataclass(frozen=True)
class AnyOf:
    """Parts of which one must hold."""

    parts: tuple[Tree, ...]


Tree = Condition | Not | AllOf | AnyOf


def parse(query: str) -> Tree:
    """Read a query; QueryError for one that has another form, too many conditions, or too many levels."""
    tokens = list(_tokens(query))
    number = sum(isinstance(token, Condition) for token in tokens)
    if number > MOST_CONDITIONS:
        raise QueryError(f"the query has {number} conditions: give {MOST_CONDITIONS} at most")
    reader = _Reader(tokens)
    tree = reader.either(0) if tokens else AllOf(())
    if reader.next is not None:
        raise QueryError(f"a bracket closes where none is open: {EXAMPLE}")
    return tree


def _tokens(query: str) -> Iterator[Condition | str]:
    """Conditions, brackets and small words."""
    for word in query.split():
        left = word
        while left:
            if left[0] in "()":
                yield left[0]
                left = left[1:]
                continue
            match = _CONDITION.match(left)
            if match is None:
                raise QueryError(f"cannot read {left!r}: {EXAMPLE}, without spaces inside a condition")
            name, sign, rest = match.groups()
            value = None if sign is None else _before_bracket(rest)
            token = Condition(name, sign, value)
            yield name.lower() if sign is None and name.lower() in _WORDS else token
            left = left[len(token.text) :]


def _before_bracket(value: str) -> str:
    """A value up to a bracket that closes what was opened before it."""
    depth = 0
    for k, mark in enumerate(value):
        depth += {"(": 1, ")": -1}.get(mark, 0)
        if depth < 0:
            return value[:k]
    return value


class _Reader:
    """Reads tokens from the left to the right; `depth` is the number of brackets and `not` around."""

    def __init__(self, tokens: list[Condition | str]) -> None:
        self._tokens = tokens[::-1]

    @property
    def next(self) -> Condition | str | None:
        """The next token; None at the end."""
        return self._tokens[-1] if self._tokens else None

    def _taken(self, *words: str) -> bool:
        """Whether the next token is one of some words, which is then taken."""
        taken = self.next in words
        if taken:
            self._tokens.pop()
        return taken

    def either(self, depth: int) -> Tree:
        """Read alternatives, until the end or a closing bracket."""
        parts = [self._all(depth)]
        while self._taken("or"):
            parts.append(self._all(depth))
        return AnyOf(tuple(parts)) if len(parts) > 1 else parts[0]

    def _all(self, depth: int) -> Tree:
        parts = [self._one(depth)]
        while self._taken("and") or self.next not in (None, ")", "or"):
            parts.append(self._one(depth))
        return AllOf(tuple(parts)) if len(parts) > 1 else parts[0]

    def _one(self, depth: int) -> Tree:
        if depth > DEEPEST:
            raise QueryError(f"the query has brackets or `not` more than {DEEPEST} deep: leave out what is not needed")
        if self._taken("not"):
            return Not(self._one(depth + 1))
        if self._taken("("):
            tree = self.either(depth + 1)
            if not self._taken(")"):
                raise QueryError(f"a bracket is not closed: {EXAMPLE}")
            return tree
        if isinstance(self.next, Condition):
            token = self._tokens.pop()
            assert isinstance(token, Condition)
            return token
        before = "at the end" if self.next is None else f"before {self.next!r}"
        raise QueryError(f"a condition is missing {before}: {EXAMPLE}")
