"""Line plots as inline SVG: curves, marks, and the plots of a motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.cases.replay import Replay, thin_states
from hcsearch.springs.deployment.deployment_facts import deployment_energies
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.system.figures import CurveLook, curve_look
from hcsearch.web.player import Payload

PLOT_WIDTH, PLOT_HEIGHT = 480, 220
_LEFT, _RIGHT, _TOP, _BOTTOM = 74, 12, 10, 42
_SURE = 4
"""Distance of certified intervals below the axis, so that they hide no curve, pixels."""
_TICKS = 6

PlottedNumber = float | None


@dataclass(frozen=True)
class PlotCurve:
    """A curve of a plot, interrupted where a value is None."""

    name: str
    x: Sequence[float]
    y: Sequence[PlottedNumber]


@dataclass(frozen=True)
class PlotMark:
    """A labelled event on the horizontal axis; `is_collision` for a collision."""

    x: float
    text: str
    is_collision: bool = False


def draw_plot(
    curves: Sequence[PlotCurve],
    title: str,
    x_label: str,
    y_label: str,
    *,
    marks: Sequence[PlotMark] = (),
    spans: Sequence[tuple[float, float]] = (),
    linear_to: float | None = None,
) -> str:
    """Return a drawing of curves over a common axis; texts have the colour of the page.

    spans : intervals drawn below the horizontal axis. linear_to : absolute value beyond which the vertical scale is
    logarithmic, on both sides; linear if not given. The curves need at least one number.
    """
    x_scale = _scale([x for curve in curves for x in curve.x], _LEFT, PLOT_WIDTH - _RIGHT, tight=True)
    values = [y for curve in curves for y in curve.y if y is not None]
    y_places = (PLOT_HEIGHT - _BOTTOM, _TOP)
    y_scale = _scale(values, *y_places, tight=False) if linear_to is None else _log_scale(values, *y_places, linear_to)
    body = [_grid(x_scale, y_scale), _labels(x_label, y_label)]
    base = PLOT_HEIGHT - _BOTTOM
    for begin, end in spans:
        body.append(f'<path class="sure" d="M{x_scale.at(begin):.1f} {base + _SURE}H{x_scale.at(end):.1f}"/>')
    body += [_line(curve, curve_look(k), x_scale, y_scale) for k, curve in enumerate(curves)]
    for k, mark in enumerate(marks):
        x, kind = x_scale.at(mark.x), "bad" if mark.is_collision else "mark"
        anchor, beside = ("end", -5) if x > 0.6 * PLOT_WIDTH else ("start", 5)
        body.append(f'<path class="{kind}" d="M{x:.1f} {_TOP}V{base}"/>')
        body.append(
            f'<text class="{kind}" x="{x + beside:.1f}" y="{_TOP + 12 + 15 * k}" text-anchor="{anchor}">'
            f"{escape(mark.text)}</text>"
        )
    return (
        f'<svg class="plot" role="img" viewBox="0 0 {PLOT_WIDTH} {PLOT_HEIGHT}"><title>{escape(title)}</title>'
        f"{''.join(body)}</svg>"
    )


def curve_swatch(k: int) -> str:
    """Return a sample of curve k for a legend."""
    return (
        '<svg class="swatch" viewBox="0 0 40 8" aria-hidden="true">'
        f'<path d="M1 4H39"{_stroke(curve_look(k))} stroke-width="2.5"/></svg>'
    )


@dataclass(frozen=True)
class _Scale:
    """A map from values to coordinates, and ticks with their labels."""

    low: float
    high: float
    begin: float
    end: float
    ticks: tuple[tuple[float, str], ...]
    linear_to: float | None = None

    def at(self, value: float) -> float:
        share = (self._moved(value) - self._moved(self.low)) / (self._moved(self.high) - self._moved(self.low))
        return self.begin + share * (self.end - self.begin)

    def _moved(self, value: float) -> float:
        """Return the value on the drawn scale: linear up to `linear_to`, beyond it one unit per power of ten."""
        if self.linear_to is None:
            return value
        ratio = abs(value) / self.linear_to
        return math.copysign(ratio if ratio <= 1.0 else 1.0 + math.log10(ratio), value)


def _scale(values: Sequence[float], begin: float, end: float, *, tight: bool) -> _Scale:
    """Return a linear scale over some values, tight or extended to the next ticks."""
    low, high = min(values), max(values)
    if high - low < 1e-12 * max(1.0, abs(high)):
        low, high = low - 0.5, high + 0.5
    step = _step((high - low) / _TICKS)
    if not tight:
        low, high = step * math.floor(low / step + 1e-9), step * math.ceil(high / step - 1e-9)
    first_tick, last_tick = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    ticks = tuple((step * k, f"{step * k:.6g}") for k in range(first_tick, last_tick + 1))
    return _Scale(low, high, begin, end, ticks)


def _log_scale(values: Sequence[float], begin: float, end: float, linear_to: float) -> _Scale:
    """Return a symmetric logarithmic scale over 0 and some values, with ticks at 0 and +-`linear_to` * 10^k."""

    def beyond(size: float) -> list[float]:
        powers = math.ceil(math.log10(max(size / linear_to, 1.0)) - 1e-9) if size > 0.0 else -1
        return [linear_to * 10.0**k for k in range(powers + 1)]

    tick_values = [*(-value for value in beyond(-min(values))), 0.0, *beyond(max(values))]
    if len(tick_values) == 1:
        tick_values.append(linear_to)
    ticks = tuple((value, f"{value:.6g}") for value in sorted(tick_values))
    return _Scale(min(tick_values), max(tick_values), begin, end, ticks, linear_to)


def _step(minimum: float) -> float:
    """Return the smallest of 1, 2 or 5 times a power of ten that is not below a value."""
    power = 10.0 ** math.floor(math.log10(minimum))
    return next(power * k for k in (1, 2, 5, 10) if power * k >= minimum * (1 - 1e-9))


def _grid(x_scale: _Scale, y_scale: _Scale) -> str:
    base = PLOT_HEIGHT - _BOTTOM
    lines = "".join(f"M{_LEFT} {y_scale.at(y):.1f}H{PLOT_WIDTH - _RIGHT}" for y, _ in y_scale.ticks)
    lines += "".join(f"M{x_scale.at(x):.1f} {_TOP}V{base}" for x, _ in x_scale.ticks)
    texts = "".join(
        f'<text x="{_LEFT - 6}" y="{y_scale.at(y) + 4:.1f}" text-anchor="end">{text}</text>'
        for y, text in y_scale.ticks
    )
    texts += "".join(
        f'<text x="{x_scale.at(x):.1f}" y="{base + 19}" text-anchor="middle">{text}</text>' for x, text in x_scale.ticks
    )
    return f'<path class="grid" d="{lines}"/>{texts}'


def _labels(x_label: str, y_label: str) -> str:
    middle = 0.5 * (_TOP + PLOT_HEIGHT - _BOTTOM)
    return (
        f'<text x="{0.5 * (_LEFT + PLOT_WIDTH - _RIGHT):.0f}" y="{PLOT_HEIGHT - 5}" text-anchor="middle">'
        f"{escape(x_label)}</text>"
        f'<text x="14" y="{middle:.0f}" text-anchor="middle" transform="rotate(-90 14 {middle:.0f})">'
        f"{escape(y_label)}</text>"
    )


def _line(curve: PlotCurve, drawn: CurveLook, x_scale: _Scale, y_scale: _Scale) -> str:
    data, drawing = [], False
    for x, y in zip(curve.x, curve.y, strict=True):
        if y is not None:
            data.append(f"{'L' if drawing else 'M'}{x_scale.at(x):.1f} {y_scale.at(y):.1f}")
        drawing = y is not None
    path = f'<path class="curve" d="{"".join(data)}"{_stroke(drawn)}/>'
    return f"<g><title>{escape(curve.name)}</title>{path}</g>"


def _stroke(drawn: CurveLook) -> str:
    """Return the SVG attributes of a curve; dashes in pixels, as its line is two pixels wide (design.css)."""
    dashes = " ".join(f"{2.0 * length:g}" for length in drawn.dashes)
    return f' stroke="{drawn.colour}"' + (f' stroke-dasharray="{dashes}"' if dashes else "")


_FINE = 0.004
"""Tolerance of a plotted curve, as a share of the largest energy."""
_NEAR = 0.01
"""Gap (mm) beyond which the scale is logarithmic: gaps of sliding panels are small, others large."""
_AXES = {"time": "time, s", "path": "share of the path"}


@dataclass(frozen=True)
class DrawnPlot:
    """A drawn plot; names : of its curves in drawing order, for a legend; empty without a legend."""

    title: str
    svg: str
    names: tuple[str, ...] = ()
    note: str = ""


def plots_of(replay: Replay, payload: Payload, deployment: Deployment | None = None) -> list[DrawnPlot]:
    """Return the plots of a motion, with energies for a deployment.

    payload : of the same replay, with the nearest panels at each state.
    """
    marks = marks_of_motion(replay, deployment)
    plots = [_gaps(replay, payload, marks), _angles(replay, marks)]
    if deployment is not None:
        plots.append(_energies(deployment, marks))
    return [drawn for drawn in plots if drawn is not None]


def marks_of_motion(replay: Replay, deployment: Deployment | None = None) -> list[PlotMark]:
    """Return marks at the first collision and where a deployment becomes flat."""
    marks = []
    if replay.collision is not None:
        place, (first, second) = replay.collision
        names = replay.labels.panels
        marks.append(
            PlotMark(place, f"panels {names[first]} and {names[second]} collide at {place:.4g} s", is_collision=True)
        )
    if deployment is not None and deployment.outcome == "flat":
        end = float(replay.at[-1])
        marks.append(PlotMark(end, f"flat, {end:.4g} s"))
    return marks


def _gaps(replay: Replay, payload: Payload, marks: Sequence[PlotMark]) -> DrawnPlot | None:
    pairs = np.array(payload["nearest"]).reshape(-1, 2)
    gaps = [
        None if pair[0] < 0 else 0.1 * payload["unit"] * gap for pair, gap in zip(pairs, payload["gaps"], strict=True)
    ]
    if all(gap is None for gap in gaps):
        return None
    title = "Nearest gap between panels"
    curve = PlotCurve("nearest gap", replay.at.tolist(), gaps)
    svg = draw_plot(
        [curve], title, _AXES[replay.axis], "nearest gap, mm", marks=marks, spans=replay.certified, linear_to=_NEAR
    )
    note = f"Of panels that no hinge joins and that do not touch; below 0 they overlap. Logarithmic beyond {_NEAR} mm."
    if replay.certified:
        note += f" Green under the axis: certified clear with {1e3 * replay.margin:.2g} mm of play on every face."
    return DrawnPlot(title, svg, (), note)


def _angles(replay: Replay, marks: Sequence[PlotMark]) -> DrawnPlot:
    title = "Fold angles of the hinges"
    names = tuple(f"crease {name}" for name in replay.labels.hinges)
    curves = [
        PlotCurve(name, replay.at.tolist(), column.tolist())
        for name, column in zip(names, replay.angles.T, strict=True)
    ]
    svg = draw_plot(curves, title, _AXES[replay.axis], "fold angle, rad", marks=marks, spans=replay.certified)
    return DrawnPlot(title, svg, names, "Flat at 0, closed at pi.")


def _energies(deployment: Deployment, marks: Sequence[PlotMark]) -> DrawnPlot | None:
    kinds = _changing(deployment_energies(deployment))
    times = np.asarray(deployment.motion.times, float)
    if not kinds:
        return None
    columns = np.stack([1e3 * values for values in kinds.values()], axis=1)
    indices, _ = thin_states(times, columns, _FINE * max(float(np.abs(columns).max()), 1e-300))
    names = tuple(name.removesuffix("_J").replace("_", " ") for name in kinds)
    curves = [PlotCurve(name, times[indices].tolist(), columns[indices, k].tolist()) for k, name in enumerate(names)]
    title = "Energies"
    return DrawnPlot(title, draw_plot(curves, title, "time, s", "energy, mJ", marks=marks), names)


def _changing(kinds: Mapping[str, Reals]) -> dict[str, Reals]:
    """Return the energies that vary and are finite; a diverged simulation may have overflowed."""
    return {name: values for name, values in kinds.items() if np.isfinite(values).all() and np.ptp(values) > 0.0}
