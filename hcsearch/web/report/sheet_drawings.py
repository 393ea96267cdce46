"""Drawings of a flight sheet: torque margin along the travel, sensitivities, and the packed array in its envelope."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import shapely

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.shape.least_rectangles import least_rectangle
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.flight_figures import root_of
from hcsearch.springs.flight.flight_sheet import FlightSheet, Sensitivity
from hcsearch.springs.flight.moving_room import craft_corners, placed_solids
from hcsearch.springs.flight.travel import Travel
from hcsearch.system.terminal import short_number
from hcsearch.web.report.plots import DrawnPlot, PlotCurve, draw_plot

SWEPT_STATE_COUNT = 24
"""Number of states in a drawing of the swept volume."""


def margin_plot(sheet: FlightSheet) -> DrawnPlot | None:
    """Return the torque margin along the travel with the line of the rule; None where it is not known."""
    if not sheet.margins:
        return None
    required = next((row.required for row in sheet.rows if row.rule.startswith("torque")), None)
    places, margins = (list(values) for values in zip(*sheet.margins, strict=True))
    curves = [PlotCurve("torque margin", places, margins, "torque margin")]
    if required is not None:
        curves.append(PlotCurve("required", [0.0, 1.0], [required, required], "required"))
    title = "Torque margin along the travel"
    linear_to = 1.0 if required is None else required
    note = f"Springs over what resists, at states of the motion. Logarithmic beyond {short_number(linear_to, 3)}."
    x_label = "share of the travel, 0 packed, 1 flat"
    return draw_plot(curves, title, x_label, "torque margin", linear_to=linear_to, note=note)


def tornado(rows: Sequence[Sensitivity], figure: float) -> str:
    """Return bars from the figure at smaller to that at greater values of the scene, as inline SVG; `` without rows."""
    if not rows:
        return ""
    ends = [value for row in rows for value in (row.low, row.high)]
    low, high = min(*ends, figure), max(*ends, figure)
    span = (high - low) or 1.0
    width, left, step = 480.0, 170.0, 22.0

    def place(value: float) -> float:
        return left + (width - left - 10.0) * (value - low) / span

    body = [f'<path class="grid" d="M{place(figure):.1f} 4V{step * len(rows) + 4:.0f}"/>']
    for k, row in enumerate(rows):
        begin, end = sorted((place(row.low), place(row.high)))
        y = 6.0 + step * k
        body.append(f'<rect class="tornado" x="{begin:.1f}" y="{y:.0f}" width="{end - begin:.1f}" height="14"/>')
        body.append(f'<text x="{left - 8}" y="{y + 12:.0f}" text-anchor="end">{escape(row.value)}</text>')
    height = step * len(rows) + 26.0
    for value, anchor in ((low, "start"), (high, "end")):
        body.append(
            f'<text x="{place(value):.1f}" y="{height - 6:.0f}" text-anchor="{anchor}">{short_number(value, 3)}</text>'
        )
    view = f'viewBox="0 0 {width:.0f} {height:.0f}"'
    return f'<svg class="plot" role="img" {view}><title>Sensitivities</title>{"".join(body)}</svg>'


def stowed_drawing(linkage: Linkage, envelope: str = "") -> str:
    """Return the packed array from above and from the side, in its envelope if there is one, as inline SVG.

    Lengths in mm; the envelope is drawn in the placement that leaves most room along the height of the stacks.
    """
    solids = [1e3 * solid for solid in linkage.solids(linkage.folded)]
    points = np.concatenate([solid.reshape(-1, 3) for solid in solids])
    frame = _aligned(points[:, :2])
    flat = [(solid[..., :2] @ frame, solid[..., 2]) for solid in solids]
    least = np.concatenate([xy.reshape(-1, 2) for xy, _ in flat]).min(axis=0)
    size = np.concatenate([xy.reshape(-1, 2) for xy, _ in flat]).max(axis=0) - least
    bottom, height = float(points[:, 2].min()), float(np.ptp(points[:, 2]))
    rooms = _rooms((float(size[0]), float(size[1]), height), envelope)
    width, depth, tall = (max(side, room) for side, room in zip((*size.tolist(), height), rooms, strict=True))
    gap = 0.08 * width
    body = []
    if envelope:
        body.append(f'<rect class="envelope" x="0" y="0" width="{rooms[0]:.2f}" height="{rooms[1]:.2f}"/>')
        body.append(
            f'<rect class="envelope" x="0" y="{depth + gap:.2f}" width="{rooms[0]:.2f}" height="{rooms[2]:.2f}"/>'
        )
    for xy, z in flat:
        places = (xy - least).reshape(-1, 2)
        side = np.stack([places[:, 0], depth + gap + tall - (z.ravel() - bottom)], axis=1)
        body += [_shadow(places), _shadow(side)]
    view = f"{-0.02 * width:.2f} {-0.02 * width:.2f} {1.04 * width:.2f} {depth + gap + tall + 0.04 * width:.2f}"
    title = "The packed array from above, and from the side" + (f", in {escape(envelope)}" if envelope else "")
    return f'<svg class="stowage" role="img" viewBox="{view}"><title>{title}</title>{"".join(body)}</svg>'


def _shadow(points: Reals) -> str:
    """Return the outline of a convex panel, seen from one side, as an SVG polygon; points : of its corners, (k, 2)."""
    outline = shapely.get_coordinates(shapely.convex_hull(shapely.MultiPoint(points)))[:-1]
    corners = " ".join(f"{x:.2f},{y:.2f}" for x, y in outline.tolist())
    return f'<polygon class="stowed" points="{corners}"/>'


def swept_drawing(travel: Travel) -> str:
    """Return the places of all panels along a travel from above and from both sides, as inline SVG; in mm.

    The root panel stays; boxes of the craft are drawn where they are.
    """
    chosen = np.unique(np.linspace(0, len(travel.states) - 1, SWEPT_STATE_COUNT).round().astype(int))
    root = root_of(travel)
    places = [1e3 * points for state in travel.states[chosen] for points in placed_solids(travel.linkage, state, root)]
    boxes = [1e3 * corners for corners in craft_corners(travel.linkage, travel.setup.craft, root)]
    everything = np.concatenate([*places, *boxes])
    least, greatest = everything.min(axis=0), everything.max(axis=0)
    x, y, z = (greatest - least).tolist()
    gap = 0.06 * max(x, y, z)
    views = (((0, 1), 0.0, 0.0), ((0, 2), 0.0, y + gap), ((1, 2), x + gap, y + gap))
    body = []
    for (across, up), left, top in views:
        high = float((greatest - least)[up])
        for kind, solids in (("swept", places), ("craft", boxes)):
            for solid in solids:
                hull = shapely.get_coordinates(shapely.convex_hull(shapely.MultiPoint(solid[:, [across, up]])))
                shown = hull - least[[across, up]]
                corners = " ".join(f"{left + u:.1f},{top + high - v:.1f}" for u, v in shown.tolist())
                body.append(f'<polygon class="{kind}" points="{corners}"/>')
    width, height = max(x, x + gap + y), y + gap + z
    view = f"{-gap:.1f} {-gap:.1f} {width + 2 * gap:.1f} {height + 2 * gap:.1f}"
    title = "Places of the panels along the travel, from above and from two sides"
    return f'<svg class="stowage" role="img" viewBox="{view}"><title>{title}</title>{"".join(body)}</svg>'


def _aligned(points: np.ndarray) -> np.ndarray:
    """Return the axes of the smallest rectangle around points as columns, (2, 2), the longer side first."""
    unit = least_rectangle(points).along
    return np.column_stack([unit, [-unit[1], unit[0]]])


def _rooms(sides: tuple[float, float, float], envelope: str) -> tuple[float, float, float]:
    """Return the sides of the envelope along the box's, the longest beside the longest; zeros without an envelope."""
    if not envelope:
        return 0.0, 0.0, 0.0
    rooms = [0.0, 0.0, 0.0]
    for k, room in zip(np.argsort(sides)[::-1].tolist(), envelope_sides(envelope), strict=True):
        rooms[k] = room
    return rooms[0], rooms[1], rooms[2]
