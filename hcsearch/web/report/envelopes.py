"""How much room a folding takes packed and flat, and what it weighs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from hcsearch.basics.arrays import Reals
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene, panel_of
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True)
class Envelope:
    """The smallest box that stands upright around all panels, m: longer and shorter side of its base, height."""

    length: float
    width: float
    height: float

    @property
    def volume(self) -> float:
        """Of the box, m^3."""
        return self.length * self.width * self.height

    @property
    def text(self) -> str:
        """Sides in millimetres."""
        return " x ".join(f"{1e3 * side:.4g}" for side in (self.length, self.width, self.height)) + " mm"


@dataclass(frozen=True)
class Room:
    """A folding packed and flat; mass in kg, of the panels alone; area of the flat panels in m^2."""

    packed: Envelope
    flat: Envelope
    mass: float
    area: float


def room_of(folding: Folding, scene: Scene) -> Room:
    """The room that a folding takes with the panels of a scene, flat pairs rigid."""
    panel = panel_of(scene, folding.circuit.grid.name)
    linkage = folding.linkage(panel)
    area = linkage.pattern.area
    mass = scene.density_of(panel[2]) * area * panel[2]
    return Room(envelope_at(linkage, linkage.folded), envelope_at(linkage, linkage.flat), mass, area)


def envelope_at(linkage: Linkage, angles: Reals) -> Envelope:
    """The box around a linkage at a state, upright on the base panel's face, its base turned to be smallest."""
    points = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(angles)])
    corners = shapely.get_coordinates(shapely.minimum_rotated_rectangle(shapely.MultiPoint(points[:, :2])))
    sides = sorted(np.linalg.norm(np.diff(corners[:3], axis=0), axis=1).tolist(), reverse=True)
    return Envelope(sides[0], sides[1], float(np.ptp(points[:, 2])))
