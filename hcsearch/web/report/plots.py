"""Line plots as inline SVG: curves with labels, and marks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from hcsearch.system.curve_labels import LabelFrame, label_places
from hcsearch.system.figures import CurveLook, curve_look

PLOT_WIDTH, PLOT_HEIGHT = 480, 220
_LEFT, _RIGHT, _TOP, _BOTTOM = 74, 12, 10, 42
_MARK_LINE = 15
"""Height of the label of a mark, which stands above the plot, pixels."""
_SURE = 4
"""Distance of certified intervals below the axis, so that they hide no curve, pixels."""
_TICKS = 6
_LETTER, _LABEL_HEIGHT = 7.5, 16.0
"""Width of a letter and height of a label on a curve, pixels, where the page is narrow and letters are larger."""
_DEGREES = (1, 5, 10, 30, 45, 90, 180, 360)

PlottedNumber = float | None


@dataclass(frozen=True)
class PlotCurve:
    """A curve of a plot, interrupted where a value is None.

    label : written on the curve, where it fits. hinges : numbers of the hinges whose curve it is, in the payload of the
    plotted motion; a page marks the curve together with them.
    """

    name: str
    x: Sequence[float]
    y: Sequence[PlottedNumber]
    label: str = ""
    hinges: Sequence[int] = ()


@dataclass(frozen=True)
class PlotMark:
    """A labelled event on the horizontal axis; `is_collision` for a collision."""

    x: float
    text: str
    is_collision: bool = False


@dataclass(frozen=True)
class DrawnPlot:
    """A drawn plot. legend : each curve that has no room for its label, with its number."""

    title: str
    svg: str
    legend: tuple[tuple[int, PlotCurve], ...] = ()
    note: str = ""


def draw_plot(
    curves: Sequence[PlotCurve],
    title: str,
    x_label: str,
    y_label: str,
    *,
    marks: Sequence[PlotMark] = (),
    spans: Sequence[tuple[float, float]] = (),
    linear_to: float | None = None,
    degrees: bool = False,
    note: str = "",
) -> DrawnPlot:
    """Return a drawing of curves over a common axis; texts have the colour of the page.

    spans : intervals drawn below the horizontal axis. linear_to : absolute value beyond which the vertical scale is
    logarithmic, on both sides; linear if not given. degrees : the vertical scale has ticks for angles in degrees. The
    curves need at least one number.
    """
    top = _TOP + _MARK_LINE * len(marks)
    x_scale = _scale([x for curve in curves for x in curve.x], _LEFT, PLOT_WIDTH - _RIGHT, tight=True)
    values = [y for curve in curves for y in curve.y if y is not None]
    y_places = (PLOT_HEIGHT - _BOTTOM, top)
    if linear_to is None:
        y_scale = _scale(values, *y_places, tight=False, steps=_DEGREES if degrees else None)
    else:
        y_scale = _log_scale(values, *y_places, linear_to)
    body = [_grid(x_scale, y_scale, top), _labels(x_label, y_label, top)]
    base = PLOT_HEIGHT - _BOTTOM
    for begin, end in spans:
        body.append(f'<path class="sure" d="M{x_scale.at(begin):.1f} {base + _SURE}H{x_scale.at(end):.1f}"/>')
    places = _label_places(curves, x_scale, y_scale, top)
    body += [_line(curve, curve_look(k), x_scale, y_scale) for k, curve in enumerate(curves)]
    body += [
        f'<text class="name" x="{place[0]:.1f}" y="{place[1] + 4:.1f}" text-anchor="middle"{_hinges(curve)}>'
        f"{escape(curve.label)}</text>"
        for curve, place in zip(curves, places, strict=True)
        if place is not None
    ]
    for k, mark in enumerate(marks):
        x, kind = x_scale.at(mark.x), "bad" if mark.is_collision else "mark"
        anchor = "end" if x > 0.6 * PLOT_WIDTH else "start"
        y = _TOP + _MARK_LINE * k
        body.append(f'<path class="{kind}" d="M{x:.1f} {y + 5}V{base}"/>')
        body.append(f'<text class="{kind}" x="{x:.1f}" y="{y + 2}" text-anchor="{anchor}">{escape(mark.text)}</text>')
    svg = (
        f'<svg class="plot" role="img" viewBox="0 0 {PLOT_WIDTH} {PLOT_HEIGHT}" data-left="{_LEFT}" '
        f'data-right="{PLOT_WIDTH - _RIGHT}"><title>{escape(title)}</title>{"".join(body)}</svg>'
    )
    numbered = enumerate(zip(curves, places, strict=True))
    legend = tuple((k, curve) for k, (curve, place) in numbered if curve.label and place is None)
    return DrawnPlot(title, svg, legend, note)


def _label_places(
    curves: Sequence[PlotCurve], x_scale: _Scale, y_scale: _Scale, top: float
) -> list[tuple[float, float] | None]:
    """Return the centre of the label of each curve, None where it does not fit or there is none."""
    lines = [
        [(x_scale.at(x), y_scale.at(y)) for x, y in zip(curve.x, curve.y, strict=True) if y is not None]
        for curve in curves
    ]
    frame = LabelFrame(_LEFT, PLOT_WIDTH - _RIGHT, top, PLOT_HEIGHT - _BOTTOM, _LABEL_HEIGHT)
    places = label_places(lines, [_LETTER * len(curve.label) for curve in curves], frame)
    return [place if curve.label else None for curve, place in zip(curves, places, strict=True)]


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


def _scale(
    values: Sequence[float], begin: float, end: float, *, tight: bool, steps: Sequence[float] | None = None
) -> _Scale:
    """Return a linear scale over some values, tight or extended to the next ticks.

    steps : possible distances of ticks; 1, 2 or 5 times a power of ten by default.
    """
    low, high = min(values), max(values)
    if high - low < 1e-12 * max(1.0, abs(high)):
        low, high = low - 0.5, high + 0.5
    least = (high - low) / _TICKS
    step = _step(least) if steps is None else next((step for step in steps if step >= least), _step(least))
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


def _grid(x_scale: _Scale, y_scale: _Scale, top: float) -> str:
    base = PLOT_HEIGHT - _BOTTOM
    lines = "".join(f"M{_LEFT} {y_scale.at(y):.1f}H{PLOT_WIDTH - _RIGHT}" for y, _ in y_scale.ticks)
    lines += "".join(f"M{x_scale.at(x):.1f} {top}V{base}" for x, _ in x_scale.ticks)
    texts = "".join(
        f'<text x="{_LEFT - 6}" y="{y_scale.at(y) + 4:.1f}" text-anchor="end">{text}</text>'
        for y, text in y_scale.ticks
    )
    texts += "".join(
        f'<text x="{x_scale.at(x):.1f}" y="{base + 19}" text-anchor="middle">{text}</text>' for x, text in x_scale.ticks
    )
    return f'<path class="grid" d="{lines}"/>{texts}'


def _labels(x_label: str, y_label: str, top: float) -> str:
    middle = 0.5 * (top + PLOT_HEIGHT - _BOTTOM)
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
    return f'<g class="line"{_hinges(curve)}><title>{escape(curve.name)}</title>{path}</g>'


def _hinges(curve: PlotCurve) -> str:
    """Return the attribute by which a page marks a curve together with its hinges."""
    return f' data-hinges="{" ".join(map(str, curve.hinges))}"' if curve.hinges else ""


def _stroke(drawn: CurveLook) -> str:
    """Return the SVG attributes of a curve; dashes in pixels, as its line is two pixels wide (plots.css)."""
    dashes = " ".join(f"{2.0 * length:g}" for length in drawn.dashes)
    return f' stroke="{drawn.colour}"' + (f' stroke-dasharray="{dashes}"' if dashes else "")
