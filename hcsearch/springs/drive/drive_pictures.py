"""Pictures of drives: fold angles and torques over time, as planned and as simulated under control."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.deployment_pictures import mark_collision
from hcsearch.springs.deployment.outcomes import reason_with_clearance
from hcsearch.springs.drive.driven_folding import Drive
from hcsearch.system.figures import figure_for, head, legend, line_style
from hcsearch.system.palette import curve_look

if TYPE_CHECKING:
    from hcsearch.system.figures import Axes

ENVELOPE_PART_COUNT = 60
"""Parts of the time in which the simulated torques are drawn as one mean, least and greatest each."""
LINE_SIMPLIFICATION_PIXELS = 0.5
"""Pixels by which a line may be drawn aside, so that it has fewer points."""


def draw_drive(drive: Drive, path: str) -> None:
    """Draw fold angles and torques over time: planned torques as lines, simulated ones as a mean in a faint band."""
    own, labels, deployment = drive.torques, labels_of(drive.linkage), drive.deployment
    with figure_for(path, (9, 7), simpler=LINE_SIMPLIFICATION_PIXELS) as figure:
        above, below = figure.subplots(2, 1, sharex=True)
        for number, k in enumerate(own.driven):
            above.plot(own.times, own.angles[:, k], label=labels.hinges[k], zorder=3.0, **line_style(number))
        for number, column in enumerate(np.delete(own.angles, own.driven, axis=1).T):
            label = "_others" if number else "others"
            above.plot(own.times, column, linewidth=0.6, color="grey", alpha=0.6, label=label)
        above.set(ylabel="fold angle, rad")
        reason = reason_with_clearance(deployment.reason, deployment.outcome, deployment.clearance, labels)
        head(above, f"{drive.folding.notation}: {reason}")
        mark_collision(above, deployment)
        for number, column in enumerate(own.torques.T):
            below.plot(own.times, column, label=labels.hinges[own.driven[number]], **line_style(number))
        _draw_simulated(below, drive)
        below.set(xlabel="time, s", ylabel="torque, N m (band: simulated)")
        for axes in (above, below):
            legend(axes, "driven hinge")


def _draw_simulated(axes: Axes, drive: Drive) -> None:
    """The simulated torques of each driven hinge: a faint band from the least to the greatest, and their mean."""
    driven = drive.deployment.driven
    if driven is None:
        return
    middles, mean, least, greatest = envelope(drive.deployment.motion.times, driven.torques)
    for number in range(mean.shape[1]):
        colour = curve_look(number).colour
        axes.fill_between(middles, least[:, number], greatest[:, number], color=colour, alpha=0.2, linewidth=0.0)
        axes.plot(middles, mean[:, number], color=colour, alpha=0.6, linewidth=0.4)


def envelope(times: Reals, values: Reals, parts: int = ENVELOPE_PART_COUNT) -> tuple[Reals, Reals, Reals, Reals]:
    """Mean, least and greatest of values, (k, n), in even parts of the time that hold any, and where these lie.

    The mean is over time, with straight lines between states.
    """
    edges = np.linspace(times[0], times[-1], parts + 1)[1:-1]
    part = np.searchsorted(edges, times, side="right")
    first = np.flatnonzero(np.r_[True, np.diff(part) > 0])
    least, greatest = np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)
    step = np.diff(times)
    weight = 0.5 * (np.r_[step, 0.0] + np.r_[0.0, step]) + 1e-300
    whole = np.add.reduceat(weight, first)
    mean = np.add.reduceat(values * weight[:, None], first) / whole[:, None]
    return np.add.reduceat(times * weight, first) / whole, mean, least, greatest
