"""Rigid bodies, and trees of bodies with revolute and prismatic joints and welds, as tables of the kernels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.multibody.tree import BodyTree


@dataclass(frozen=True, eq=False)
class Body(ByValue):
    """A rigid body in the reference state: mass (kg), centre of mass (m), inertia about it (kg m^2), world axes."""

    mass: float
    centre: Reals
    inertia: Reals

    def share(self, part: float) -> Body:
        """Return the body with a part of its mass and inertia."""
        return Body(part * self.mass, self.centre, part * self.inertia)

    def about(self, point: Reals) -> Reals:
        """Return the inertia about another point, shape (3, 3)."""
        offset = self.centre - point
        squares = float((offset * offset).sum())  # BLAS would add them up in another order on another processor
        return self.inertia + self.mass * (squares * np.eye(3) - np.outer(offset, offset))


def joined_body(bodies: Iterable[Body]) -> Body:
    """Join rigid bodies into one."""
    parts = list(bodies)
    mass = sum(part.mass for part in parts)
    if not mass:
        return Body(0.0, parts[0].centre, sum((part.inertia for part in parts), np.zeros((3, 3))))
    centre = sum((part.mass * part.centre for part in parts), np.zeros(3)) / mass
    return Body(mass, centre, sum((part.about(centre) for part in parts), np.zeros((3, 3))))


def prism_body(corners: Sequence[tuple[float, float]], thickness: float, density: float) -> Body:
    """Return a prism from z = 0 to its thickness over a polygon with counterclockwise corners; lengths in m.

    Second moments of the polygon by Green's theorem.
    """
    x, y = np.array(corners, float).T
    x0, y0 = x.mean(), y.mean()  # near the polygon, to avoid cancellation far from the origin
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


GROUND = -1


@dataclass(frozen=True, eq=False)
class TreeJoint(ByValue):
    """A joint that connects a body to one of a lower number, or to the ground.

    axis : unit vector; point : on the joint's line, m; both in the reference state. slides : whether the joint slides
    along its axis; else it turns about it.
    """

    parent: int
    axis: Reals
    point: Reals
    slides: bool = False


@dataclass(frozen=True, eq=False)
class Weld(ByValue):
    """A weld of two bodies, in all or some directions.

    first, second : bodies; the first may be the ground. point : in the reference state, m.
    kinds : the closed directions: 0 to 2 turns about, 3 to 5 gaps along the rows of `frame`, which moves with the first
        body. A single turn is closed only where the bodies move in the plane normal to it anyway.
    """

    first: int
    second: int
    point: Reals
    kinds: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    frame: Reals = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        if not set(self.kinds) <= set(range(6)) or len(set(self.kinds)) < len(self.kinds):
            raise HcsearchError(f"a weld cannot close {self.kinds}: give kinds from 0 to 5, each once")

    @property
    def free_turn(self) -> int:
        """The only direction of the frame about which the second body may turn; -1 unless there is exactly one."""
        free = [kind for kind in range(3) if kind not in self.kinds]
        return free[0] if len(free) == 1 else -1


def tree_of(
    joints: Sequence[TreeJoint],
    bodies: Sequence[Body],
    welds: Sequence[Weld] = (),
    *,
    gravity: Sequence[float] = (0.0, 0.0, 0.0),
    size: float = 1.0,
) -> BodyTree:
    """Return the tables of a tree whose body i is moved by joint i; gravity in m/s^2, gaps divided by `size` (m)."""
    n = len(joints)
    origin = np.zeros(3)

    def place(body: int) -> Reals:
        return origin if body < 0 else np.asarray(joints[body].point, float)

    table, links = np.zeros((n, 16)), np.zeros((n, 4), np.int64)
    for i, (joint, tree_body) in enumerate(zip(joints, bodies, strict=True)):
        inertia = tree_body.inertia
        table[i] = [
            *joint.axis,
            *(place(i) - place(joint.parent)),
            *(tree_body.centre - place(i)),
            *(inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]),
            tree_body.mass,
        ]
        links[i, :2] = joint.parent, joint.slides
    rows = [(w, kind) for w, weld in enumerate(welds) for kind in weld.kinds]
    slot_of = _slots(joints, [(welds[w].first, welds[w].second) for w, _ in rows])
    slots = np.empty((len(slot_of), 2), np.int64)
    for (body, row), slot in slot_of.items():
        slots[slot] = row, slot_of.get((joints[body].parent, row), -1)
    counts = np.bincount([body for body, _ in slot_of], minlength=n) if slot_of else np.zeros(n, np.int64)
    links[:, 3] = np.cumsum(counts)
    links[:, 2] = links[:, 3] - counts
    return BodyTree(
        bodies=table,
        links=links,
        welds=np.array([(weld.first, weld.second) for weld in welds], np.int64).reshape(-1, 2),
        weld_places=np.array(
            [[*(w.point - place(w.first)), *(w.point - place(w.second)), *w.frame.ravel()] for w in welds], float
        ).reshape(-1, 15),
        rows=np.array(
            [
                (w, kind, slot_of.get((welds[w].first, row), -1), slot_of[welds[w].second, row], welds[w].free_turn)
                for row, (w, kind) in enumerate(rows)
            ],
            np.int64,
        ).reshape(-1, 5),
        slots=slots,
        gravity=np.array(gravity, float),
        size=float(size),
    )


def _slots(joints: Sequence[TreeJoint], ends: Sequence[tuple[int, int]]) -> dict[tuple[int, int], int]:
    """Number the pairs of a body and a closure row that depends on its joint, by body and then by row."""
    through: list[set[int]] = [set() for _ in joints]
    for row, pair in enumerate(ends):
        for end in pair:
            body = end
            while body >= 0:
                through[body].add(row)
                body = joints[body].parent
    return {key: k for k, key in enumerate((body, row) for body, rows in enumerate(through) for row in sorted(rows))}
