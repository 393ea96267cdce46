"""Curves of fold angles in a picture: in degrees, one curve for hinges that turn alike, with their names on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.labels import label_ranges
from hcsearch.system.curve_labels import COINCIDING_ANGLE, coinciding
from hcsearch.system.figures import DEGREE_STEPS, line_style

if TYPE_CHECKING:
    from hcsearch.system.figures import Axes


def draw_angle_curves(axes: Axes, places: Reals, angles: Reals, names: Sequence[str]) -> None:
    """Draw fold angles over time or arc length; `label_curves` then writes the names of hinges on the curves.

    places : (k,). angles : (k, n), rad. names : of the n hinges.
    """
    degrees = np.degrees(angles)
    for number, group in enumerate(coinciding(degrees, COINCIDING_ANGLE)):
        label = label_ranges([names[hinge] for hinge in group])
        axes.plot(places, degrees[:, group[0]], label=label, zorder=3.0, **line_style(number))
    axes.set(ylabel="fold angle, degrees")
    ticks: Any = axes.yaxis.get_major_locator()
    ticks.set_params(steps=DEGREE_STEPS)
