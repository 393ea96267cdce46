"""The room that an array takes: the upright boxes around its panels, packed and flat, its mass, and its footprint."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import shapely

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.shape.least_rectangles import least_rectangle
from hcsearch.shape.linkage import Linkage

FOOTPRINT_ROUNDING = 1e-9
"""Footprints that are wider than a rectangle by no more than this share of their size lie in it: coordinates round."""


@dataclass(frozen=True)
class UprightBox:
    """The smallest upright box around all panels, m: longer and shorter side of its base, and height."""

    length: float
    width: float
    height: float

    @property
    def sides(self) -> tuple[float, float, float]:
        """Length, width and height."""
        return self.length, self.width, self.height

    @property
    def volume(self) -> float:
        """The volume of the box, m^3."""
        return self.length * self.width * self.height

    @property
    def text(self) -> str:
        """The sides in millimetres."""
        return " x ".join(f"{1e3 * side:.4g}" for side in self.sides) + " mm"

    def room_in(self, envelope: str) -> float:
        """Return how much longer each side could be at least in an envelope, m; negative where the box does not fit.

        envelope : a name or lengths in mm. Sides are parallel to its sides: sorted, none must be longer.
        """
        pairs = zip(sorted(self.sides), sorted(envelope_sides(envelope)), strict=True)
        return round(min(1e-3 * room - side for side, room in pairs), 9) + 0.0


@dataclass(frozen=True)
class Stowage:
    """The room that an array takes; mass of the panels with what is mounted on them, kg; area of flat panels, m^2."""

    packed: UprightBox
    flat: UprightBox
    mass: float
    area: float

    @property
    def area_per_volume(self) -> float:
        """Area of the flat panels over the volume of the packed box, 1/m."""
        return self.area / self.packed.volume


def stowage_of(linkage: Linkage, density: float) -> Stowage:
    """Return the room that a linkage takes with panels of a density (kg/m^3)."""
    area = linkage.pattern.area
    mass = density * area * linkage.pattern.thickness
    return Stowage(upright_box_at(linkage, linkage.folded), upright_box_at(linkage, linkage.flat), mass, area)


def upright_box_at(linkage: Linkage, angles: Reals) -> UprightBox:
    """Return the box around a linkage at a state, upright on the base panel, with its base of minimal area."""
    points = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(angles)])
    base = least_rectangle(points[:, :2])
    return UprightBox(base.length, base.width, float(np.ptp(points[:, 2])))


@dataclass(frozen=True, eq=False)
class Footprint(ByValue):
    """The packed array as seen along the stacks, and its places in a rectangle (docs/explanation/flight_stowage.md, 4).

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
