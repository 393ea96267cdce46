"""A flight sheet as text: for a terminal, as Markdown, and as LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

from hcsearch.scenes.laws import rounded_law_text
from hcsearch.shape.labels import label_ranges
from hcsearch.springs.flight.flight_sheet import Demand, FlightSheet, Sensitivity, SheetRow
from hcsearch.system.terminal import short_number

RULE_HEADS = ("rule", "clause", "figure", "known", "required", "verdict", "margin", "note")
SENSITIVITY_HEADS = ("value of the scene", "figure", "20 % less", "20 % more")
_STYLES = {"text": ("simple", "{}"), "markdown": ("pipe", "## {}"), "latex": ("latex_booktabs", "\\subsection*{{{}}}")}
"""Tables as tabulate draws them, which escapes their texts, and headings."""
_LAW_DIGITS = 6
"""Significant digits of springs that pass: more than of other values, as some of these springs only just pass."""
SHEET_STYLES = tuple(_STYLES)
"""Text formats of a sheet; those for LaTeX need the package booktabs."""


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
    table, heading = _STYLES[style]
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
