"""Inverse dynamics of a tree of bodies on revolute joints: the joint forces of a given motion, at many times at once.

The recursive Newton-Euler algorithm in world axes (Featherstone 2008, chapter 5). It shares no code with the compiled
recursions, so that each can be checked by the other. Loops are not closed here: `joint_forces` returns the forces of
the tree, and the caller projects them onto closed motions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.dynamics.body_trees import GROUND
from hcsearch.springs.dynamics.system import System


@dataclass(frozen=True, eq=False)
class Forces(ByValue):
    """Joint forces and energies of a motion at k times.

    joints : (k, n_joints), moments about the joints that balance inertia, gravity and drag, N m.
    kinetic, height : (k,), kinetic energy and potential energy of gravity, J.
    """

    joints: Reals
    kinetic: Reals
    height: Reals


@dataclass(frozen=True, eq=False)
class _Placed(ByValue):
    """A body at k times: its rotation, angular velocity and acceleration, and the motion of its joint's point."""

    turn: Reals
    place: Reals
    spin: Reals
    speed: Reals
    spin_up: Reals
    speed_up: Reals


def joint_forces(system: System, q: Reals, v: Reals, a: Reals) -> Forces:
    """Return the joint moments that balance inertia, gravity and drag.

    q, v, a : (k, n_joints), coordinates, rates, accelerations.
    """
    if any(joint.slides for joint in system.joints):
        raise HcsearchError("inverse dynamics is for a base that is held: hold a panel, such as held = 'bottom'")
    count, n = q.shape
    gravity = np.array(system.gravity)
    lines, placed = _outward(system, q, v, a)
    pulls, couples = np.zeros((n, count, 3)), np.zeros((n, count, 3))
    _add_drag(system, placed, pulls, couples)
    kinetic, height = np.zeros(count), np.zeros(count)
    forces = np.empty((count, n))
    for i in range(n - 1, -1, -1):
        body, placed_body = system.bodies[i], placed[i]
        arm = placed_body.turn @ (body.centre - system.joints[i].point)
        inertia = placed_body.turn @ body.inertia @ placed_body.turn.transpose(0, 2, 1)
        momentum = _times(inertia, placed_body.spin)
        speed = placed_body.speed + np.cross(placed_body.spin, arm)
        inward = np.cross(placed_body.spin, np.cross(placed_body.spin, arm))
        speed_up = placed_body.speed_up + np.cross(placed_body.spin_up, arm) + inward
        force = body.mass * (speed_up - gravity)
        couple = _times(inertia, placed_body.spin_up) + np.cross(placed_body.spin, momentum)
        pulls[i] += force
        couples[i] += couple + np.cross(arm, force)
        kinetic += 0.5 * body.mass * (speed**2).sum(axis=1) + 0.5 * (placed_body.spin * momentum).sum(axis=1)
        height -= body.mass * (placed_body.place + arm) @ gravity
        forces[:, i] = (lines[i] * couples[i]).sum(axis=1)
        parent = system.joints[i].parent
        if parent != GROUND:
            pulls[parent] += pulls[i]
            couples[parent] += couples[i] + np.cross(placed_body.place - placed[parent].place, pulls[i])
    return Forces(forces, kinetic, height)


def _add_drag(system: System, placed: list[_Placed], pulls: Reals, couples: Reals) -> None:
    """Add what balances the drag of facets to forces and couples about the joints, (n, k, 3)."""
    for facet in system.drags:
        body = placed[facet.body]
        normal = body.turn @ facet.normal
        arms = (facet.points - system.joints[facet.body].point) @ body.turn.transpose(0, 2, 1)  # (k, p, 3)
        velocities = body.speed[:, None] + np.cross(body.spin[:, None], arms)
        along = np.einsum("kpi,ki->kp", velocities, normal)
        forces = (facet.weights * np.abs(along) * along)[..., None] * normal[:, None]
        pulls[facet.body] += forces.sum(axis=1)
        couples[facet.body] += np.cross(arms, forces).sum(axis=1)


def _outward(system: System, q: Reals, v: Reals, a: Reals) -> tuple[list[Reals], list[_Placed]]:
    """Return the axes of the joints, (k, 3) each, and the motion of the bodies, from the root outwards."""
    count = len(q)
    still = np.zeros((count, 3))
    ground = _Placed(np.broadcast_to(np.eye(3), (count, 3, 3)), still, still, still, still, still)
    lines: list[Reals] = []
    placed: list[_Placed] = []
    for i, joint in enumerate(system.joints):
        base = ground if joint.parent == GROUND else placed[joint.parent]
        origin = np.zeros(3) if joint.parent == GROUND else system.joints[joint.parent].point
        line: Reals = base.turn @ joint.axis
        arm = base.turn @ (joint.point - origin)
        turning = v[:, i, None] * line
        lines.append(line)
        placed.append(
            _Placed(
                base.turn @ _rotations(joint.axis, q[:, i]),
                base.place + arm,
                base.spin + turning,
                base.speed + np.cross(base.spin, arm),
                base.spin_up + a[:, i, None] * line + np.cross(base.spin, turning),
                base.speed_up + np.cross(base.spin_up, arm) + np.cross(base.spin, np.cross(base.spin, arm)),
            )
        )
    return lines, placed


def _rotations(axis: Reals, angles: Reals) -> Reals:
    """Return rotations about an axis by angles (rad), shape (k, 3, 3), by Rodrigues' formula."""
    across = np.cross(axis, np.eye(3)).T
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    rotations: Reals = np.eye(3) + sine * across + (1.0 - cosine) * (across @ across)
    return rotations


def _times(matrices: Reals, vectors: Reals) -> Reals:
    """Return the products of matrices (k, 3, 3) and vectors (k, 3)."""
    products: Reals = np.einsum("kij,kj->ki", matrices, vectors)
    return products
