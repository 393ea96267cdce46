"""A column of the database: one value from which its table, views, upserts, labels and units follow."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from hcsearch.basics.vocabulary import millimetres

ColumnKind = Literal["integer", "boolean", "real", "text"]
BetterDirection = Literal["higher", "lower", ""]

LISTED = "IN ({words})"
"""The check that a column holds one of its words."""


class Quantity(NamedTuple):
    """One column of a view; `unit` is empty for pure numbers and text, booleans are 0 or 1.

    words : the admissible values of a text; empty where any text may stand.
    better : whether higher or lower values make the better design; empty where neither does.
    half : for a ranking criterion, the value that is worth 1/2, in its unit; None for other quantities.
    weight : of the criterion in a rank, unless given there.
    label : short name on pages; if empty, the column name with spaces for underscores.
    table : the table that stores it; if empty, the table of the view.
    sql : its expression in the view, in a scene `:scene`; if empty, the stored column. A quantity with an expression
        and without a table is not stored.
    required : whether the table refuses NULL. check : what the table requires of the stored value, after its name.
    """

    name: str
    kind: ColumnKind
    unit: str
    meaning: str
    words: tuple[str, ...] = ()
    better: BetterDirection = ""
    half: float | None = None
    label: str = ""
    weight: float = 1.0
    table: str = ""
    sql: str = ""
    required: bool = False
    check: str = ""

    @property
    def title(self) -> str:
        """The name for pages and tables."""
        return self.label or self.name.replace("_", " ")

    @property
    def better_first(self) -> str:
        """The sort specification that puts the better end first; the smaller values where neither is better."""
        return f"-{self.name}" if self.better == "higher" else self.name

    @property
    def note(self) -> str:
        """Meaning, unit and better direction in one line."""
        direction = f"{self.better} is better" if self.better else ""
        return ", ".join(part for part in (self.meaning, self.unit, direction) if part)

    @property
    def condition(self) -> str:
        """The SQL condition that the table requires; empty without one."""
        return self.check and f"{self.name} {self.check.format(words=', '.join(map(repr, self.words)))}"

    def stored(self, value: Any) -> int | float | str | None:
        """Return a value in SI units in the unit of the column; None where it is not known or not finite."""
        if isinstance(value, float):
            return None if not math.isfinite(value) else millimetres(value) if self.unit == "mm" else value
        return ", ".join(value) if isinstance(value, tuple) else value


def in_table(table: str, *quantities: Quantity) -> tuple[Quantity, ...]:
    """Return quantities that are stored in a table other than their view's."""
    return tuple(quantity._replace(table=table) for quantity in quantities)


def not_null(*quantities: Quantity) -> tuple[Quantity, ...]:
    """Return quantities that are known of every row."""
    return tuple(quantity._replace(required=True) for quantity in quantities)
