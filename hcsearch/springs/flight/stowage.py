"""The room that an array takes: the upright boxes around its panels, packed and flat, and its mass."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.envelopes import envelope_sides
from hcsearch.shape.least_rectangles import least_rectangle
from hcsearch.shape.linkage import Linkage


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

        envelope : a name or lengths in mm. Sides are parallel to those of the envelope: sorted, none must be longer.
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
