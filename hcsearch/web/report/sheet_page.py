"""The page of a flight sheet, which prints on one sheet of paper."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from markupsafe import Markup

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.flight.flight_figures import root_of
from hcsearch.springs.flight.flight_sheet import RULE_HEADS, FlightSheet, demand_cells, rule_cells, spring_cells
from hcsearch.springs.flight.moving_room import swept_box
from hcsearch.springs.flight.travel import Travel
from hcsearch.store.columns import FLIGHT_QUANTITIES
from hcsearch.web.player.player_page import as_script
from hcsearch.web.report.plots import DrawnPlot
from hcsearch.web.report.sheet_drawings import margin_plot, stowed_drawing, swept_drawing, tornado
from hcsearch.web.report.templating import page_style, template_environment, written_value


@dataclass(frozen=True)
class SheetCells:
    """The texts of a sheet.

    rule_heads, rules : heads and cells of its rules, and of what parts must bear. figures : name, value and note of
    each known figure. springs : hinge and law of springs that pass.
    """

    rule_heads: tuple[str, ...]
    rules: tuple[tuple[str, ...], ...]
    figures: tuple[tuple[str, str, str], ...]
    springs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class SheetDrawings:
    """The drawings of a sheet."""

    plots: tuple[DrawnPlot, ...]


def sheet_cells(sheet: FlightSheet) -> SheetCells:
    """Return the texts of a sheet."""
    known = [(quantity, sheet.figures()[quantity.name]) for quantity in FLIGHT_QUANTITIES]
    figures = tuple(
        (quantity.title, f"{written_value(value)} {quantity.unit}".rstrip(), quantity.note)
        for quantity, value in known
        if value is not None
    )
    rules = *map(rule_cells, sheet.rows), *map(demand_cells, sheet.demands)
    return SheetCells(RULE_HEADS, rules, figures, spring_cells(sheet))


def sheet_drawings(sheet: FlightSheet) -> SheetDrawings:
    """Return the drawings of a sheet."""
    plots = [margin_plot(sheet)]
    for quantity in FLIGHT_QUANTITIES:
        rows = [row for row in sheet.sensitivities if row.figure == quantity.title]
        value = sheet.figures()[quantity.name]
        if rows and isinstance(value, float):
            note = "Bars go from values of the scene that are 20 % smaller to values that are 20 % greater."
            title = f"Sensitivities of {quantity.title}"
            plots.append(DrawnPlot(title, tornado(rows, value), (), note))
    if sheet.travel is not None:
        envelope = sheet.travel.setup.envelope
        note = f"From above, and from the side; dashed: {envelope}." if envelope else "From above, and from the side."
        plots.append(DrawnPlot("Packed", stowed_drawing(sheet.travel.linkage, envelope), (), note))
        if len(sheet.travel.states):
            plots.append(DrawnPlot("Swept volume", swept_drawing(sheet.travel), (), _swept_note(sheet.travel)))
    return SheetDrawings(tuple(plot for plot in plots if plot is not None))


def _swept_note(travel: Travel) -> str:
    """Return a sentence on the drawing of the swept volume, with the box that holds it where the motion is proved."""
    note = "From above and from two sides, with the root panel at rest."
    try:
        motion, slack = travel.course
    except HcsearchError:
        return note
    box = swept_box(travel.linkage, motion, float(np.max(slack, initial=0.0)), root_of(travel))
    sides = " x ".join(f"{1e3 * side:.4g}" for side in box.sides)
    return f"{note} A box of {sides} mm holds all panels at all times."


@dataclass(frozen=True)
class _Page:
    """The parts of a sheet that the frame of a page shows."""

    title: str
    meta: tuple[tuple[str, str], ...]


def render_sheet(sheet: FlightSheet) -> str:
    """Return the HTML page of a flight sheet, without scripts and with all text escaped."""
    facts = (
        ("scene", sheet.scene),
        ("rules", sheet.standard),
        ("verdict", sheet.verdict),
        ("hcsearch", version("hcsearch")),
    )
    return (
        template_environment()
        .get_template("sheet.html")
        .render(
            data=_Page(f"Flight sheet of {sheet.title}", facts),
            sheet=sheet,
            drawn=sheet_drawings(sheet),
            cells=sheet_cells(sheet),
            payload=Markup(as_script([])),
            style=Markup(page_style("style.css", "plots.css", "design.css")),
            scripts=[],
            digests=[],
        )
    )
