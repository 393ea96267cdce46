"""The flight sheet of a folding: each rule of a standard with its clause, the figure, and whether it passes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from hcsearch.designs.records import FlightNumbers

SENSITIVITY_CHANGE = 0.2
"""Share by which values of a scene are changed for sensitivities."""
SheetVerdict = Literal["pass", "fail", "not known"]


@dataclass(frozen=True)
class SheetRow:
    """A rule, and the figure that is held against it.

    rule : what is asked for. clause : of the standard. figure, required : in the same unit; None where not known.
    at_least : whether the figure must be at least the required one, else at most. note : where the figure is least, and
    in which direction it is a bound.
    """

    rule: str
    clause: str
    figure: float | None
    required: float | None
    unit: str = ""
    at_least: bool = True
    note: str = ""

    @property
    def verdict(self) -> SheetVerdict:
        """Whether the rule passes; not known without a figure or without a requirement."""
        if self.figure is None or self.required is None:
            return "not known"
        return "pass" if (self.figure >= self.required) == self.at_least or self.figure == self.required else "fail"

    @property
    def margin(self) -> float | None:
        """By how much the rule is passed, as a share of what is required; negative where it fails."""
        if self.figure is None or self.required is None:
            return None
        if self.at_least:
            return None if self.required == 0.0 else self.figure / self.required - 1.0
        return None if self.figure == 0.0 else self.required / self.figure - 1.0


@dataclass(frozen=True)
class Sensitivity:
    """How a figure changes with one value of the scene.

    value : its name. figure : that changes, in a unit. low, high : the figure where the value is smaller and greater by
    `SENSITIVITY_CHANGE`; None where it is not known.
    """

    value: str
    figure: str
    low: float | None
    high: float | None
    unit: str = ""

    @property
    def spread(self) -> float:
        """The difference of both, by which rows are ordered; 0 where one is not known."""
        return 0.0 if self.low is None or self.high is None else abs(self.high - self.low)


@dataclass(frozen=True)
class FlightSheet:
    """A folding in a scene, held against the rules of a standard.

    title : the folding. scene : its name. source : what moves it, in a sentence. standard : title and issue. rows : the
    rules. numbers : all figures. sensitivities : the most important first. omitted : sentences on what was left out.
    """

    title: str
    scene: str
    source: str
    standard: str
    rows: tuple[SheetRow, ...]
    numbers: FlightNumbers
    sensitivities: tuple[Sensitivity, ...] = ()
    omitted: tuple[str, ...] = ()

    @property
    def verdict(self) -> SheetVerdict:
        """`fail` where a rule fails, `not known` where a figure is missing, else `pass`."""
        verdicts = {row.verdict for row in self.rows}
        return "fail" if "fail" in verdicts else "not known" if "not known" in verdicts else "pass"

    def facts(self) -> dict[str, Any]:
        """Return the sheet as plain data."""
        return {
            "folding": self.title,
            "scene": self.scene,
            "motion": self.source,
            "standard": self.standard,
            "verdict": self.verdict,
            "rules": [
                {
                    "rule": row.rule,
                    "clause": row.clause,
                    "figure": row.figure,
                    "required": row.required,
                    "unit": row.unit,
                    "verdict": row.verdict,
                    "margin": row.margin,
                    "note": row.note,
                }
                for row in self.rows
            ],
            "sensitivities": [vars(row) for row in self.sensitivities],
            "left_out": list(self.omitted),
        }
