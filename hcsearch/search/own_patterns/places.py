"""Points of drawings: the plane that they lie in, and how messages write them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hcsearch.basics.arrays import Reals

EXACT = 1e-6
"""A coordinate that changes by less than this share of the greatest extent is the same for all points."""

_UP = (
    (2, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])),
    (1, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])),
    (0, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])),
)
"""Axes that may be upright on a drawing, z before y as in most programs, and the x and y of one that lies square to it,
seen from above the axis."""


def in_plane(points: Reals) -> tuple[Reals, Reals]:
    """Points, shape (k, 3), in the plane that they lie in: (k, 2), and how far each is off it, (k,).

    The plane has the least squares of distances. It is seen from the side that the nearest axis points to, without a
    turn about its normal; points that lie square to an axis keep their coordinates.
    """
    extent: Reals = np.ptp(points, axis=0)
    for axis, across in _UP:
        if extent[axis] <= EXACT * extent.max():
            return points @ across.T, np.zeros(len(points))
    middle = points.mean(axis=0)
    _, _, ways = np.linalg.svd(points - middle, full_matrices=False)
    normal = ways[2]
    nearest = max((abs(normal[axis]) * (1.0 + EXACT * axis), axis) for axis, _ in _UP)[1]
    axis, across = next(up for up in _UP if up[0] == nearest)
    normal = normal * math.copysign(1.0, normal[axis])
    upright = np.zeros(3)
    upright[axis] = 1.0
    # the rotation by the least angle that takes the axis to the normal
    turned = across - np.outer(across @ normal, upright + normal) / (1.0 + normal[axis])
    return points @ turned.T, np.abs((points - middle) @ normal)


def place_text(point: Sequence[float], side: float) -> str:
    """A point as messages write it, rounded to a thousandth of a side."""
    decimals = 3 - math.floor(math.log10(side)) if side > 0.0 and math.isfinite(side) else 9
    return "(" + ", ".join(f"{round(float(x), decimals) + 0.0:.12g}" for x in point) + ")"
