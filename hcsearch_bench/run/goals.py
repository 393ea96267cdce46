"""Goals of a bench: a number within limits, and whether a run of the bench meets it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """A goal, its limits, and the number that was measured; None where there is none. note : on the number."""

    goal: str
    measured: float | None
    at_least: float | None = None
    at_most: float | None = None
    note: str = ""

    @property
    def met(self) -> str:
        """`yes`, `no` or `not measured`."""
        if self.measured is None:
            return "not measured"
        enough = self.at_least is None or self.measured >= self.at_least
        return "yes" if enough and (self.at_most is None or self.measured <= self.at_most) else "no"
