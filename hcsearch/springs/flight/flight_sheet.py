"""The flight sheet of a folding: each rule of a standard with its clause, the figure, and whether it passes.

Its texts are for a terminal, as Markdown, and as LaTeX.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from hcsearch.designs.records import FlightNumbers, FlightValue
from hcsearch.scenes.laws import rounded_law_text
from hcsearch.shape.labels import label_ranges
from hcsearch.springs.flight.margin_figures import FigureKind
from hcsearch.springs.flight.travel import Travel
from hcsearch.store.columns import FLIGHT_QUANTITIES, flight_value
from hcsearch.system.terminal import short_number

SENSITIVITY_CHANGE = 0.2
"""Share by which values of a scene are changed for sensitivities."""
MIN_SENSITIVITY = 1e-6
"""Change of a figure, over the figure, below which it does not depend on a value."""
RULE_HEADS = ("rule", "clause", "figure", "known", "required", "verdict", "margin", "note")
SENSITIVITY_HEADS = ("value of the scene", "figure", "20 % less", "20 % more")
SHEET_STYLES = {
    "text": ("simple", "{}"),
    "markdown": ("pipe", "## {}"),
    "latex": ("latex_booktabs", "\\subsection*{{{}}}"),
}
"""Text formats of a sheet: tables as tabulate draws them, which escapes their texts, and headings. LaTeX needs the
package booktabs."""
_LAW_DIGITS = 6
"""Significant digits of springs that pass: more than of other values, as some springs only just pass."""
SheetVerdict = Literal["pass", "fail", "not known"]
FigureSide = Literal["exact", "from below", "from above"]
"""The direction in which a figure is a bound."""


@dataclass(frozen=True)
class SheetRow:
    """A rule, and the figure that is compared with it.

    rule : its name. clause : of the standard. figure, required : in the same unit; no figure where it is not known.
    at_least : whether the figure must be at least the required one, else at most. note : where the figure is least.
    kind, side : how the figure is known, and in which direction it is a bound. other : what was computed on the other
    side of the true figure, such as the least margin at states beside a bound between them; None without it.
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
        """Whether the rule passes; not known without a figure, or where only a sampled figure passes."""
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

    value : its name. figure : the figure that changes, with its unit. low, high : the figure where the value is smaller
    and greater by `SENSITIVITY_CHANGE`. spread : the change between both over the figure itself.
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
        Hinge and law of springs with which the motorisation passes along the same motion, where the springs of the
        scene do not pass.
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
    kind: str = "folding"

    @property
    def verdict(self) -> SheetVerdict:
        """`fail` where a rule fails, `not known` where a figure is missing, else `pass`."""
        verdicts = {row.verdict for row in self.rows}
        return "fail" if "fail" in verdicts else "not known" if "not known" in verdicts else "pass"

    def figures(self) -> dict[str, FlightValue]:
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


def rule_cells(row: SheetRow) -> tuple[str, ...]:
    """Return a rule as texts, in the order of `RULE_HEADS`."""
    sense = "at least" if row.at_least else "at most"
    required = f"{sense} {_number(row.required, row.unit)}"
    margin = "-" if row.margin is None else f"{short_number(100.0 * row.margin, 3)} %"
    return row.rule, row.clause, _number(row.figure, row.unit), row.known, required, row.verdict, margin, row.note


def demand_cells(demand: Demand) -> tuple[str, ...]:
    """Return what parts must bear as texts, in the order of `RULE_HEADS`."""
    return demand.what, demand.clause, demand.value, demand.known, "-", "-", "-", ""


def sensitivity_cells(row: Sensitivity) -> tuple[str, ...]:
    """Return a sensitivity as texts, in the order of `SENSITIVITY_HEADS`."""
    return row.value, row.figure, _number(row.low, row.unit), _number(row.high, row.unit)


def spring_cells(sheet: FlightSheet) -> tuple[tuple[str, str], ...]:
    """Return hinge and law of the springs that pass as texts, numbers rounded to six digits."""
    return tuple((hinge, rounded_law_text(law, _LAW_DIGITS)) for hinge, law in sheet.springs)


def head_cells(sheet: FlightSheet) -> tuple[tuple[str, str], ...]:
    """Return the facts above the table of rules, each with its name."""
    facts = {sheet.kind: sheet.title, "scene": sheet.scene, "motion": sheet.source, "rules": sheet.standard}
    if sheet.dampers:
        facts["dampers"] = "; ".join(map(_damper_text, sheet.dampers))
    return (*facts.items(), ("verdict", sheet.verdict))


def sheet_text(sheet: FlightSheet, style: str) -> str:
    """Return a sheet as text in a style of `SHEET_STYLES`."""
    table, heading = SHEET_STYLES[style]
    parts = [_table(head_cells(sheet), ("sheet", ""), table)]
    if sheet.advice:
        parts.append(f"{sheet.advice[0].upper()}{sheet.advice[1:]}.")
    if sheet.springs:
        parts.append(_table(spring_cells(sheet), ("hinge", "spring that passes"), table))
    parts.append(_table([*map(rule_cells, sheet.rows), *map(demand_cells, sheet.demands)], RULE_HEADS, table))
    if sheet.sensitivities:
        parts.append(heading.format("Sensitivities"))
        parts.append(_table([sensitivity_cells(row) for row in sheet.sensitivities], SENSITIVITY_HEADS, table))
    if sheet.omitted:
        parts.append(heading.format("Left out"))
        parts.append(_table([(sentence,) for sentence in sheet.omitted], ("what",), table))
    return "\n\n".join(parts) + "\n"


def _damper_text(dampers: tuple[float, tuple[str, ...]]) -> str:
    damping, hinges = dampers
    return f"{short_number(damping, 4)} N m s/rad at {'hinges' if len(hinges) > 1 else 'hinge'} {label_ranges(hinges)}"


def _number(value: float | None, unit: str = "") -> str:
    return "-" if value is None else f"{short_number(value, 4)} {unit}".rstrip()


def _table(rows: Sequence[Sequence[str]], heads: Sequence[str], style: str) -> str:
    from tabulate import tabulate  # noqa: PLC0415 - only these formats need it

    escaped = [[cell.replace("|", "\\|") for cell in row] for row in rows] if style == "pipe" else rows
    return tabulate(escaped, headers=heads, tablefmt=style, disable_numparse=True)
