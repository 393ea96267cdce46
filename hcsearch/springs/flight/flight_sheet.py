"""The flight sheet of a folding: each rule of a standard with its clause, the figure, and whether it passes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from hcsearch.designs.records import FlightNumbers
from hcsearch.springs.flight.margin_figures import FigureKind
from hcsearch.springs.flight.travel import Travel
from hcsearch.store.columns import FLIGHT_QUANTITIES, flight_value

SENSITIVITY_CHANGE = 0.2
"""Share by which values of a scene are changed for sensitivities."""
SheetVerdict = Literal["pass", "fail", "not known"]
FigureSide = Literal["exact", "from below", "from above"]
"""The direction in which a figure is a bound."""


@dataclass(frozen=True)
class SheetRow:
    """A rule, and the figure that is compared with it.

    rule : what is asked for. clause : of the standard. figure, required : in the same unit; no figure where it is not
    known. at_least : whether the figure must be at least the required one, else at most. note : where the figure is
    least. kind, side : how the figure is known, and in which direction it is a bound. other : what was computed on the
    other side of the true figure, such as the least margin at states beside a bound between them; None without it.
    """

    rule: str
    clause: str
    figure: float | None
    required: float
    unit: str = ""
    at_least: bool = True
    note: str = ""
    kind: FigureKind = "proved"
    side: FigureSide = "exact"
    other: float | None = None

    @property
    def verdict(self) -> SheetVerdict:
        """Whether the rule passes; not known without a figure, and where only what is sampled passes."""
        if self.figure is None:
            return "not known"
        if self._passes(self.figure):
            return "not known" if self.kind == "sampled" else "pass"
        return "not known" if self.other is not None and self._passes(self.other) else "fail"

    @property
    def known(self) -> str:
        """How the figure is known, in words."""
        return "-" if self.figure is None else ", ".join([self.kind, *([self.side] if self.side != "exact" else [])])

    def _passes(self, figure: float) -> bool:
        return figure == self.required or (figure > self.required) == self.at_least

    @property
    def margin(self) -> float | None:
        """By how much the rule is passed, as a share of what is required; negative where it fails."""
        if self.figure is None or not self.required:
            return None
        return self.figure / self.required - 1.0 if self.at_least else 1.0 - self.figure / self.required


class Demand(NamedTuple):
    """What parts must bear: its name, its value with a unit, the clause, and how it is known."""

    what: str
    value: str
    clause: str
    known: str


@dataclass(frozen=True)
class Sensitivity:
    """How a figure changes with one value of the scene.

    value : its name. figure : that changes, in a unit. low, high : the figure where the value is smaller and greater by
    `SENSITIVITY_CHANGE`. spread : the change between both over the figure itself.
    """

    value: str
    figure: str
    low: float
    high: float
    unit: str = ""
    spread: float = 0.0


@dataclass(frozen=True)
class FlightSheet:
    """A folding or a pattern in a scene, compared with the rules of a standard.

    Parameters
    ----------
    title
        Its name.
    scene
        The name of the scene.
    source
        What moves it, in a sentence.
    standard
        Title and issue.
    rows
        The rules.
    demands
        What parts must bear.
    numbers
        All figures.
    sensitivities
        The most important first.
    omitted
        Sentences on what was left out.
    springs
        Hinge and law of springs with which the motorisation passes along the same motion, where those of the scene do
        not pass.
    advice
        A sentence on springs that do not pass; empty where they do.
    dampers
        Damping and hinges of the dampers that the scene gives.
    margins
        Places along the travel, 0 packed, 1 flat, and the torque margin there; for a drawing.
    travel
        The states of the motion, for drawings.
    kind
        What it is.
    """

    title: str
    scene: str
    source: str
    standard: str
    rows: tuple[SheetRow, ...]
    demands: tuple[Demand, ...]
    numbers: FlightNumbers
    sensitivities: tuple[Sensitivity, ...] = ()
    omitted: tuple[str, ...] = ()
    springs: tuple[tuple[str, str], ...] = ()
    advice: str = ""
    dampers: tuple[tuple[float, tuple[str, ...]], ...] = ()
    margins: tuple[tuple[float, float], ...] = field(default=(), repr=False)
    travel: Travel | None = field(default=None, repr=False, compare=False)
    kind: Literal["folding", "pattern"] = "folding"

    @property
    def verdict(self) -> SheetVerdict:
        """`fail` where a rule fails, `not known` where a figure is missing, else `pass`."""
        verdicts = {row.verdict for row in self.rows}
        return "fail" if "fail" in verdicts else "not known" if "not known" in verdicts else "pass"

    def figures(self) -> dict[str, int | float | str | None]:
        """Return all figures by the names of columns, in their units."""
        return {quantity.name: flight_value(quantity, self.numbers) for quantity in FLIGHT_QUANTITIES}

    def facts(self) -> dict[str, Any]:
        """Return the sheet as plain data."""
        rules = [{**vars(row), "verdict": row.verdict, "margin": row.margin} for row in self.rows]
        return {
            self.kind: self.title,
            "scene": self.scene,
            "motion": self.source,
            "standard": self.standard,
            "verdict": self.verdict,
            "rules": rules,
            "demands": [demand._asdict() for demand in self.demands],
            "figures": self.figures(),
            "sensitivities": [vars(row) for row in self.sensitivities],
            "advice": self.advice,
            "springs_that_pass": dict(self.springs),
            "dampers": [{"damping_N_m_s_rad": damping, "hinges": list(names)} for damping, names in self.dampers],
            "left_out": list(self.omitted),
        }
