"""Runs of rising work: each row takes longer than the one before, until one would take too long."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Protocol, TypeVar

from hcsearch.errors import HcsearchError
from hcsearch_bench.run.machine import MISSING

OURS = "hcsearch"
PATIENCE, QUICK_PATIENCE = 8.0, 2.0
"""Seconds that a run may be expected to take, from the one before it."""


class UnableError(HcsearchError):
    """An engine is not there, cannot be given a system, or does not get to the end."""


class _Measured(Protocol):
    """A row of a table of work."""

    @property
    def seconds(self) -> float | None: ...
    @property
    def note(self) -> str: ...


Row = TypeVar("Row", bound=_Measured)


def rising(
    settings: Sequence[float],
    patience: float,
    blank: Callable[[float], Row],
    measure: Callable[[float], Row],
    *,
    by_tolerance: bool,
) -> Iterator[Row]:
    """Rows of rising work, until one would take too long; one with the reason where the engine is unable.

    blank : a row without numbers; measure : one with them, or UnableError.
    """
    took, before = 0.0, None
    for setting in settings:
        more = 2.0 if by_tolerance or before is None else before / setting
        if took * more > patience:
            yield noted(blank(setting), f"not tried: more than {patience:g} s")
            continue
        try:
            row = measure(setting)
        except UnableError as error:
            row = noted(blank(setting), str(error))
        yield row
        if row.note == MISSING:
            return
        if row.seconds is not None:
            took, before = row.seconds, setting


def noted(row: Row, note: str) -> Row:
    """The row with a note."""
    changed: Any = replace(row, note=note)  # type: ignore[type-var]
    found: Row = changed
    return found


def level_of(error: float, levels: Sequence[tuple[str, float]], scale: float = 1.0) -> str:
    """The first level that an error is within; `wrong` beyond them all. scale : what the limits are multiplied by."""
    return next((name for name, limit in levels if error <= limit * scale), "wrong")


def seconds_of(row: _Measured) -> float:
    """The seconds of a row that has been measured."""
    assert row.seconds is not None
    return row.seconds
