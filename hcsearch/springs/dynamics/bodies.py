"""Mass, centre and inertia of panels: uniform prisms over convex polygons."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.equality import ByValue


@dataclass(frozen=True, eq=False)
class Body(ByValue):
    """A rigid body in the reference state: mass (kg), centre of mass (m), inertia about it (kg m^2), world axes."""

    mass: float
    centre: Reals
    inertia: Reals

    def share(self, part: float) -> Body:
        """The same body with a part of its mass."""
        return Body(part * self.mass, self.centre, part * self.inertia)

    def about(self, point: Reals) -> Reals:
        """Inertia about another point, shape (3, 3)."""
        way = self.centre - point
        return self.inertia + self.mass * (way @ way * np.eye(3) - np.outer(way, way))


def joined_body(bodies: Iterable[Body]) -> Body:
    """Bodies that are one."""
    parts = list(bodies)
    mass = sum(part.mass for part in parts)
    if not mass:
        return Body(0.0, parts[0].centre, sum((part.inertia for part in parts), np.zeros((3, 3))))
    centre = sum((part.mass * part.centre for part in parts), np.zeros(3)) / mass
    return Body(mass, centre, sum((part.about(centre) for part in parts), np.zeros((3, 3))))


def prism_body(corners: Sequence[tuple[float, float]], thickness: float, density: float) -> Body:
    """A prism between z = 0 and its thickness over a polygon whose corners run counterclockwise; lengths in m.

    Source: second moments of a polygon by Green's theorem.
    """
    x, y = np.array(corners, float).T
    x0, y0 = x.mean(), y.mean()  # near the polygon, so that nothing cancels far from the origin
    x, y = x - x0, y - y0
    x2, y2 = np.append(x[1:], x[0]), np.append(y[1:], y[0])
    cross = x * y2 - x2 * y
    area = cross.sum() / 2
    cx, cy = ((x + x2) * cross).sum() / (6 * area), ((y + y2) * cross).sum() / (6 * area)
    xx = ((x * x + x * x2 + x2 * x2) * cross).sum() / 12 - area * cx * cx
    yy = ((y * y + y * y2 + y2 * y2) * cross).sum() / 12 - area * cy * cy
    xy = ((x * y2 + 2 * x * y + 2 * x2 * y2 + x2 * y) * cross).sum() / 24 - area * cx * cy
    zz = area * thickness**2 / 12
    by_height = density * thickness
    inertia = by_height * np.array([[yy + zz, -xy, 0.0], [-xy, xx + zz, 0.0], [0.0, 0.0, xx + yy]])
    return Body(by_height * area, np.array([cx + x0, cy + y0, thickness / 2]), inertia)
