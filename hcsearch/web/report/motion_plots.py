"""Plots of one motion: the nearest gap, hinge angles and energies over time or along the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.cases.replays.replay import Replay, thin_states
from hcsearch.springs.deployment.deploying import Deployment
from hcsearch.springs.deployment.facts import deployment_energies
from hcsearch.web.player import Payload
from hcsearch.web.report.plots import Curve, Mark, plot

_FINE = 0.004
"""Share of the largest energy that a plotted curve may miss."""
_NEAR = 0.01
"""Gap (mm) beyond which its scale is logarithmic: panels slide along each other, and are far apart packed and flat."""
_AXES = {"time": "time, s", "path": "share of the path"}


@dataclass(frozen=True)
class Plot:
    """A drawn plot; names : of its curves, in the order of their looks, for a legend; empty for one that needs none."""

    title: str
    svg: str
    names: tuple[str, ...] = ()
    note: str = ""


def plots_of(replay: Replay, payload: Payload, deployment: Deployment | None = None) -> list[Plot]:
    """The plots of a motion, energies where it is a deployment.

    payload : of the same replay, which names the nearest panels at each of its states.
    """
    marks = marks_of(replay, deployment)
    plots = [_gaps(replay, payload, marks), _angles(replay, marks)]
    if deployment is not None:
        plots.append(_energies(deployment, marks))
    return [one for one in plots if one is not None]


def marks_of(replay: Replay, deployment: Deployment | None = None) -> list[Mark]:
    """Where panels collide first, and where a deployment is flat."""
    marks = []
    if replay.collision is not None:
        at, (one, two) = replay.collision
        names = replay.labels.panels
        marks.append(Mark(at, f"panels {names[one]} and {names[two]} collide at {at:.4g} s", bad=True))
    if deployment is not None and deployment.outcome == "flat":
        end = float(replay.at[-1])
        marks.append(Mark(end, f"flat, {end:.4g} s"))
    return marks


def _gaps(replay: Replay, payload: Payload, marks: Sequence[Mark]) -> Plot | None:
    pairs = np.array(payload["nearest"]).reshape(-1, 2)
    gaps = [
        None if pair[0] < 0 else 0.1 * payload["unit"] * gap for pair, gap in zip(pairs, payload["gaps"], strict=True)
    ]
    if all(gap is None for gap in gaps):
        return None
    title = "Nearest gap between panels"
    curve = Curve("nearest gap", replay.at.tolist(), gaps)
    svg = plot(
        [curve], title, _AXES[replay.axis], "nearest gap, mm", marks=marks, spans=replay.certified, linear_to=_NEAR
    )
    note = f"Of panels that no hinge joins and that do not touch; below 0 they overlap. Logarithmic beyond {_NEAR} mm."
    if replay.certified:
        note += f" Green under the axis: certified clear with {1e3 * replay.margin:.2g} mm of play on every face."
    return Plot(title, svg, (), note)


def _angles(replay: Replay, marks: Sequence[Mark]) -> Plot:
    title = "Fold angles of the hinges"
    names = tuple(f"crease {name}" for name in replay.labels.hinges)
    curves = [
        Curve(name, replay.at.tolist(), column.tolist()) for name, column in zip(names, replay.angles.T, strict=True)
    ]
    svg = plot(curves, title, _AXES[replay.axis], "fold angle, rad", marks=marks, spans=replay.certified)
    return Plot(title, svg, names, "Flat at 0, closed at pi.")


def _energies(deployment: Deployment, marks: Sequence[Mark]) -> Plot | None:
    kinds = _changing(deployment_energies(deployment))
    times = np.asarray(deployment.motion.times, float)
    if not kinds:
        return None
    columns = np.stack([1e3 * values for values in kinds.values()], axis=1)
    kept, _ = thin_states(times, columns, _FINE * max(float(np.abs(columns).max()), 1e-300))
    names = tuple(name.removesuffix("_J").replace("_", " ") for name in kinds)
    curves = [Curve(name, times[kept].tolist(), columns[kept, k].tolist()) for k, name in enumerate(names)]
    title = "Energies"
    return Plot(title, plot(curves, title, "time, s", "energy, mJ", marks=marks), names)


def _changing(kinds: Mapping[str, Reals]) -> dict[str, Reals]:
    """Energies that change, and are numbers: what diverged may have overflowed."""
    return {name: values for name, values in kinds.items() if np.isfinite(values).all() and np.ptp(values) > 0.0}
