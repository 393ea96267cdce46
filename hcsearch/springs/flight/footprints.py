"""The footprint of the packed stacks, and how it lies in a rectangle (docs/explanation/flight_stowage.md, 4)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import shapely

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage

FOOTPRINT_ROUNDING = 1e-9
"""Footprints that are wider than a rectangle by no more than this share of their size lie in it: coordinates round."""


@dataclass(frozen=True, eq=False)
class Footprint(ByValue):
    """The packed array as seen along the stacks.

    corners : (k, 2), of the convex hull, m. layers : number of panels in the higher stack. thickness : of a panel, m.
    """

    corners: Reals
    layers: int
    thickness: float

    def lies_in(self, length: float, width: float) -> bool:
        """Return whether it lies in a rectangle (m) after some turn about the direction of the stacks."""
        spans = self.corners[:, None] - self.corners
        spans = spans[np.linalg.norm(spans, axis=2) > 0.0]
        rounding = FOOTPRINT_ROUNDING * float(np.linalg.norm(spans, axis=1).max())
        turns = np.concatenate([_turns(spans, length), _turns(spans, width) - 0.5 * math.pi, np.zeros(1)])
        along, across = (self._widths(turns + quarter) for quarter in (0.0, 0.5 * math.pi))
        return bool(((along <= length + rounding) & (across <= width + rounding)).any())

    def _widths(self, turns: Reals) -> Reals:
        """Return the extent along the direction of each angle, m."""
        places = self.corners @ np.array([np.cos(turns), np.sin(turns)])
        widths: Reals = np.ptp(places, axis=0)
        return widths

    def greatest_thickness(self, sides: tuple[float, float, float]) -> float:
        """Return the greatest thickness of panels with which the stacks fit into a box, m; 0 where none does.

        sides : of the box, m, along any of which the stacks may stand.
        """
        return max(self._heights(sides), default=0.0) / self.layers

    def greatest_layers(self, sides: tuple[float, float, float]) -> int:
        """Return how many layers of panels of this thickness fit into a box; sides : of the box, m."""
        return math.floor(max(self._heights(sides), default=0.0) / self.thickness * (1.0 + FOOTPRINT_ROUNDING))

    def _heights(self, sides: tuple[float, float, float]) -> Iterator[float]:
        """Yield the sides of a box along which stacks with this footprint may stand, m."""
        for length, width, height in permutations(sides):
            if length >= width and self.lies_in(length, width):
                yield height


def footprint_of(linkage: Linkage) -> Footprint:
    """Return the footprint of a linkage in its packed state."""
    points = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(linkage.folded)])
    hull = shapely.convex_hull(shapely.MultiPoint(points[:, :2]))
    thickness = linkage.pattern.thickness
    layers = round(float(np.ptp(points[:, 2])) / thickness)
    return Footprint(shapely.get_coordinates(hull)[:-1], layers, thickness)


def _turns(spans: Reals, width: float) -> Reals:
    """Return the angles at which spans between corners, (k, 2), are as long as a width (m) along their direction."""
    lengths = np.linalg.norm(spans, axis=1)
    long = lengths >= width
    directions = np.arctan2(spans[long, 1], spans[long, 0])
    off = np.arccos(width / lengths[long])
    return np.concatenate([directions - off, directions + off])
