"""Curves of fold angles in a picture: in degrees, one curve for hinges that turn alike, with their names on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.labels import label_ranges
from hcsearch.system.curve_labels import COINCIDING_ANGLE, coinciding
from hcsearch.system.figures import CURVE_COLOURS, DEGREE_STEPS, line_style

if TYPE_CHECKING:
    from hcsearch.system.figures import Axes


def draw_angle_curves(axes: Axes, places: Reals, angles: Reals, names: Sequence[str]) -> list[int]:
    """Draw fold angles over time or arc length; `label_curves` then writes the names of hinges on the curves.

    places : (k,). angles : (k, n), rad. names : of the n hinges. Return a number of each hinge for `line_style`: other
    curves of the hinge then have the colour of its fold angle, and look different for each hinge.
    """
    degrees = np.degrees(angles)
    groups = coinciding(degrees, COINCIDING_ANGLE)
    stride = len(CURVE_COLOURS) * -(-len(groups) // len(CURVE_COLOURS))
    numbers = [0] * len(names)
    for number, group in enumerate(groups):
        label = label_ranges([names[hinge] for hinge in group])
        axes.plot(places, degrees[:, group[0]], label=label, zorder=3.0, **line_style(number))
        for rank, hinge in enumerate(group):
            numbers[hinge] = number + stride * rank
    axes.set(ylabel="fold angle, degrees")
    ticks: Any = axes.yaxis.get_major_locator()
    ticks.set_params(steps=DEGREE_STEPS)
    return numbers
