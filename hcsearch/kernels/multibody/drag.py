"""Drag of panels: air pushes against each point of a facet along its normal, as the square of its speed along it.

The force per area is -1/2 rho c |v_n| v_n, with rho the density of the air, c the drag coefficient and v_n the velocity
of the point along the normal. It is summed over the points of a quadrature.
"""

from __future__ import annotations

from typing import NamedTuple

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import (
    Vector3,
    add_vector,
    cross,
    dot,
    rotated,
    rotated_back,
    scaled_vector,
    vector_at,
)
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.tree import (
    WORK_PULL_COUPLE,
    WORK_PULL_FORCE,
    WORK_ROTATION,
    WORK_SPEED,
    WORK_SPIN,
    Work,
)

DRAG_POINT, DRAG_WEIGHT = 0, 3
"""Columns of `Drag.points`: the arm from the joint of the body in the reference state, and half of density and
coefficient times a share of the area, kg/m."""


class Drag(NamedTuple):
    """Facets on which air acts; k facets, p points.

    bodies : (k,). pieces : (k, 2), first and last point (exclusive) of each facet. normals : (k, 3), unit vectors in
    the reference state. points : (p, 4).
    """

    bodies: WholeNumbers
    pieces: WholeNumbers
    normals: Reals
    points: Reals


@compiled
def _normal_velocity(drag: Drag, k: int, work: Work) -> tuple[float, Vector3]:
    """Return the velocity of the joint along a facet's normal, and its slope by the arm, in the body's axes."""
    b, body = work.bodies, drag.bodies[k]
    normal = vector_at(drag.normals, k, 0)
    speed = rotated_back(b, body, WORK_ROTATION, vector_at(b, body, WORK_SPEED))
    spin = rotated_back(b, body, WORK_ROTATION, vector_at(b, body, WORK_SPIN))
    return dot(normal, speed), cross(normal, spin)


@compiled
def pull_drag(drag: Drag, work: Work) -> None:
    """Add the drag of all facets to the external forces on bodies; call `move_bodies` first."""
    for k in range(len(drag.bodies)):
        body, normal = drag.bodies[k], vector_at(drag.normals, k, 0)
        along, slope = _normal_velocity(drag, k, work)
        force, moment = 0.0, (0.0, 0.0, 0.0)
        for p in range(drag.pieces[k, 0], drag.pieces[k, 1]):
            arm = vector_at(drag.points, p, DRAG_POINT)
            velocity = along + dot(slope, arm)
            push = -drag.points[p, DRAG_WEIGHT] * abs(velocity) * velocity
            force += push
            moment = (moment[0] + push * arm[0], moment[1] + push * arm[1], moment[2] + push * arm[2])
        add_vector(
            work.bodies, body, WORK_PULL_COUPLE, rotated(work.bodies, body, WORK_ROTATION, cross(moment, normal))
        )
        add_vector(
            work.bodies, body, WORK_PULL_FORCE, rotated(work.bodies, body, WORK_ROTATION, scaled_vector(force, normal))
        )


@compiled
def drag_power(drag: Drag, work: Work) -> float:
    """Return the power lost to drag; call `move_bodies` first."""
    power = 0.0
    for k in range(len(drag.bodies)):
        along, slope = _normal_velocity(drag, k, work)
        for p in range(drag.pieces[k, 0], drag.pieces[k, 1]):
            velocity = along + dot(slope, vector_at(drag.points, p, DRAG_POINT))
            power += drag.points[p, DRAG_WEIGHT] * abs(velocity) * velocity * velocity
    return power
