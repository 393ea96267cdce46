"""The rectangle of least area around points in the plane."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import shapely

from hcsearch.basics.array_values import Reals

ROUNDING_SHARE = 1e-9
"""Length of a side of a hull, over the longest one, that counts as rounding; and by what equal areas and lengths
differ."""


class LeastRectangle(NamedTuple):
    """A rectangle by its longer and its shorter side, and a unit vector along the longer one, (2,), to the right."""

    length: float
    width: float
    along: Reals


def least_rectangle(points: Reals) -> LeastRectangle:
    """Return the rectangle of least area around points, (k, 2); of several, the shortest and most level one.

    A side lies along a side of the convex hull (Freeman and Shapira 1975), so it is exact. Sides of the hull between
    points that differ by rounding have no direction, and GEOS, which takes them too, computes rectangles that are too
    small.
    """
    sides = np.diff(shapely.get_coordinates(shapely.MultiPoint(points).convex_hull), axis=0)
    lengths = np.linalg.norm(sides, axis=1)
    ways = sides[lengths > ROUNDING_SHARE * lengths.max()]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    across = ways[:, ::-1] * [-1.0, 1.0]
    spans = np.ptp(points @ np.stack([ways.T, across.T]), axis=1)
    areas, longer = spans.prod(axis=0), spans.max(axis=0)
    least = np.flatnonzero(areas <= (1.0 + ROUNDING_SHARE) * areas.min())
    least = least[longer[least] <= (1.0 + ROUNDING_SHARE) * longer[least].min()]
    along = np.where(spans[:1].T >= spans[1:].T, ways, across)[least]
    along *= np.where(np.round(along @ [1.0, ROUNDING_SHARE], 12) < 0.0, -1.0, 1.0)[:, None]
    best = int(np.round(along[:, 0], 9).argmax())
    return LeastRectangle(float(longer[least[best]]), float(spans[:, least[best]].min()), along[best])
