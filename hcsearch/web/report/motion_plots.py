"""The plots of a motion: nearest gap, fold angles and energies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.labels import Labels, label_ranges
from hcsearch.springs.deployment.deployment_facts import deployment_energies
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.subjects.replay import Replay, thin_states
from hcsearch.system.curve_labels import COINCIDING_ANGLE, coinciding
from hcsearch.system.terminal import short_number
from hcsearch.web.player import Payload
from hcsearch.web.report.plots import DrawnPlot, PlotCurve, PlotMark, draw_plot

_FINE = 0.004
"""Tolerance of a plotted curve, as a share of the largest energy."""
_NEAR = 0.01
"""Gap (mm) beyond which the scale is logarithmic: gaps of sliding panels are small, others large."""
_ONE_DIGIT = 0.05
"""Greatest relative difference of times that agree in two digits."""
_AXES = {"time": "time, s", "path": "share of the path"}


def plots_of(
    replay: Replay, payload: Payload, deployment: Deployment | None = None, flat_time: float | None = None
) -> list[DrawnPlot]:
    """Return the plots of a motion, with energies for a deployment.

    payload : of the same replay, with the nearest panels at each state. flat_time : as in `marks_of_motion`. Nothing is
    plotted where nothing moves.
    """
    if len(replay.at) < 2:
        return []
    marks = marks_of_motion(replay, deployment, flat_time)
    plots = [_gaps(replay, payload, marks), _angles(replay, marks)]
    if deployment is not None:
        plots.append(_energies(deployment, marks))
    return [drawn for drawn in plots if drawn is not None]


def marks_of_motion(
    replay: Replay, deployment: Deployment | None = None, flat_time: float | None = None
) -> list[PlotMark]:
    """Return marks at the first collision and where a deployment becomes flat.

    flat_time : s, in the digits on which simulations at several tolerances agree; the mark, which stands at the end of
    this one, names no other time.
    """
    marks = []
    if replay.collision is not None:
        place, (first, second) = replay.collision
        names = replay.labels.panels
        marks.append(
            PlotMark(place, f"panels {names[first]} and {names[second]} collide at {place:.4g} s", is_collision=True)
        )
    if deployment is not None and deployment.outcome == "flat":
        end = float(replay.at[-1])
        marks.append(PlotMark(end, _flat_text(end, flat_time)))
    return marks


def _flat_text(end: float, flat_time: float | None) -> str:
    """Return the text of the mark at the end of a motion that becomes flat."""
    if flat_time is None:
        return "flat"
    about = "" if math.isclose(end, flat_time, rel_tol=_ONE_DIGIT) else "about "
    return f"flat, {about}{short_number(flat_time)} s"


def _gaps(replay: Replay, payload: Payload, marks: Sequence[PlotMark]) -> DrawnPlot | None:
    pairs = np.array(payload["nearest"]).reshape(-1, 2)
    gaps = [
        None if pair[0] < 0 else 0.1 * payload["unit"] * gap for pair, gap in zip(pairs, payload["gaps"], strict=True)
    ]
    if all(gap is None for gap in gaps):
        return None
    title = "Nearest gap between panels"
    curve = PlotCurve("nearest gap", replay.at.tolist(), gaps)
    note = f"Of panels that no hinge joins and that do not touch; below 0 they overlap. Logarithmic beyond {_NEAR} mm."
    if replay.certified:
        note += f" Green under the axis: certified clear with {1e3 * replay.margin:.2g} mm of play on every face."
    return draw_plot(
        *([curve], title, _AXES[replay.axis], "nearest gap, mm"),
        marks=marks,
        spans=replay.certified,
        linear_to=_NEAR,
        note=note,
    )


def _angles(replay: Replay, marks: Sequence[PlotMark]) -> DrawnPlot:
    degrees, places = np.degrees(replay.angles), replay.at.tolist()
    curves = [
        _angle_curve(replay.labels, group, places, degrees[:, group[0]].tolist())
        for group in coinciding(degrees, COINCIDING_ANGLE)
    ]
    return draw_plot(
        *(curves, "Fold angles of the hinges", _AXES[replay.axis], "fold angle, degrees"),
        marks=marks,
        spans=replay.certified,
        degrees=True,
        note="Flat at 0, closed at 180. Curves that coincide are drawn once, with the numbers of all their hinges.",
    )


def _angle_curve(labels: Labels, hinges: Sequence[int], x: Sequence[float], y: Sequence[float]) -> PlotCurve:
    """Return the curve of hinges that turn alike."""
    label = label_ranges([labels.hinges[hinge] for hinge in hinges])
    word = "crease" if labels.design else "hinge"
    return PlotCurve(f"{word}{'s' if len(hinges) > 1 else ''} {label}", x, y, label, hinges)


def _energies(deployment: Deployment, marks: Sequence[PlotMark]) -> DrawnPlot | None:
    kinds = _changing(deployment_energies(deployment))
    times = np.asarray(deployment.motion.times, float)
    if not kinds:
        return None
    columns = np.stack([1e3 * values for values in kinds.values()], axis=1)
    indices, _ = thin_states(times, columns, _FINE * max(float(np.abs(columns).max()), 1e-300))
    names = [name.removesuffix("_J").replace("_", " ") for name in kinds]
    curves = [
        PlotCurve(name, times[indices].tolist(), columns[indices, k].tolist(), name) for k, name in enumerate(names)
    ]
    return draw_plot(curves, "Energies", "time, s", "energy, mJ", marks=marks)


def _changing(kinds: Mapping[str, Reals]) -> dict[str, Reals]:
    """Return the energies that vary and are finite; a diverged simulation may have overflowed."""
    return {name: values for name, values in kinds.items() if np.isfinite(values).all() and np.ptp(values) > 0.0}
