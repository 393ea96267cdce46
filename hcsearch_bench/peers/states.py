"""States of systems in plain NumPy, many at once: where bodies are, energy, closure; what other engines give back.

Nothing here is shared with the compiled recursions, so that it can judge them too.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.scenes.laws import Law
from hcsearch.springs.dynamics.body_trees import GROUND, Weld
from hcsearch.springs.dynamics.system import JointDrive, System
from hcsearch_bench.run.machine import MISSING
from hcsearch_bench.run.work_precision import UnableError

TURNS, GAPS = (0, 1, 2), (3, 4, 5)


@dataclass(frozen=True)
class Trajectory:
    """What an engine gives back: coordinates and velocities (k, n_joints) at times (k,), s.

    seconds : of the integration alone, on the wall; the model stands before. evaluations : of the accelerations.
    """

    times: Reals
    q: Reals
    v: Reals
    seconds: float
    evaluations: int


class Forces(Protocol):
    """Accelerations of a system, and how often they were asked for."""

    evaluations: int

    def accelerations(self, q: Reals, v: Reals) -> Reals:
        """Joint accelerations of one state, (n_joints,)."""


def integrated(
    forces: Forces, order: WholeNumbers, q: Reals, v: Reals, times: Reals, tolerance: float, method: str
) -> Trajectory:
    """SciPy's solve_ivp integrates accelerations to the times; order : of joints, where the forces have them."""
    from scipy.integrate import solve_ivp

    n = len(q)
    start = np.empty(2 * n)
    start[order], start[n + order] = q, v

    def rate(_: float, y: Reals) -> Reals:
        return np.concatenate([y[n:], forces.accelerations(y[:n], y[n:])])

    begin = time.perf_counter()
    solution = solve_ivp(rate, (times[0], times[-1]), start, method, times, rtol=tolerance, atol=tolerance)
    seconds = time.perf_counter() - begin
    if not solution.success or not np.isfinite(solution.y).all():
        raise UnableError(f"SciPy stopped: {solution.message}")
    return Trajectory(times, solution.y[order].T, solution.y[n + order].T, seconds, forces.evaluations)


def installed(module: str) -> Any:
    """A module of another engine; UnableError where there is none."""
    try:
        return import_module(module)
    except ImportError as error:
        raise UnableError(MISSING) from error


@dataclass(frozen=True)
class Places:
    """Bodies of k states: rotation from the reference state (k, n, 3, 3) and where their joints are (k, n, 3).

    spin, speed : angular velocities and velocities at the joints, (k, n, 3).
    """

    system: System
    turn: Reals
    place: Reals
    spin: Reals
    speed: Reals

    def point(self, body: int, point: Reals) -> tuple[Reals, Reals]:
        """Places and velocities, (k, 3) each, of a point that is given in the reference state (m)."""
        if body == GROUND:
            fixed = np.zeros((len(self.turn), 3))
            return fixed + point, fixed
        arm = self.turn[:, body] @ (point - self.system.joints[body].point)
        return self.place[:, body] + arm, self.speed[:, body] + np.cross(self.spin[:, body], arm)

    def turned(self, body: int) -> Reals:
        """Rotations of a body, (k, 3, 3)."""
        return np.broadcast_to(np.eye(3), (len(self.turn), 3, 3)) if body == GROUND else self.turn[:, body]


def places(system: System, q: Reals, v: Reals | None = None) -> Places:
    """Where the bodies of states (k, n_joints) are, and how they move."""
    q = np.atleast_2d(q)
    v = np.zeros_like(q) if v is None else np.atleast_2d(v)
    k, n = q.shape
    placed = Places(system, np.empty((k, n, 3, 3)), *(np.empty((k, n, 3)) for _ in range(3)))
    for i, joint in enumerate(system.joints):
        above = placed.turned(joint.parent)
        place, speed = placed.point(joint.parent, np.asarray(joint.point, float))
        spin = np.zeros((k, 3)) if joint.parent == GROUND else placed.spin[:, joint.parent]
        axis = above @ joint.axis
        if joint.slides:
            way = axis * q[:, i, None]
            place, speed = place + way, speed + np.cross(spin, way) + axis * v[:, i, None]
        else:
            above, spin = above @ rotations(joint.axis, q[:, i]), spin + axis * v[:, i, None]
        placed.turn[:, i], placed.place[:, i], placed.spin[:, i], placed.speed[:, i] = above, place, spin, speed
    return placed


def rotations(axis: Reals, angles: Reals) -> Reals:
    """Rotations about one axis, (k, 3, 3)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    c, s = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    turned: Reals = c * np.eye(3) + s * skew + (1 - c) * np.outer(axis, axis)
    return turned


def energies(system: System, q: Reals, v: Reals) -> Reals:
    """Energy of motion, of linear laws, struts and gravity, J, (k,)."""
    q, v = np.atleast_2d(q), np.atleast_2d(v)
    placed = places(system, q, v)
    total = np.zeros(len(q))
    for i, (body, drive) in enumerate(zip(system.bodies, system.drives, strict=True)):
        centre, speed = placed.point(i, body.centre)
        own = np.einsum("kji,kj->ki", placed.turn[:, i], placed.spin[:, i])
        total += 0.5 * body.mass * (speed**2).sum(1) + 0.5 * np.einsum("ki,ij,kj->k", own, body.inertia, own)
        total -= body.mass * (centre @ np.array(system.gravity))
        preload, stiffness = line_of(drive.law)
        total += q[:, i] * (preload + 0.5 * stiffness * q[:, i])
    for strut in system.struts:
        way = placed.point(strut.second, strut.second_point)[0] - placed.point(strut.first, strut.first_point)[0]
        total += 0.5 * strut.stiffness * (np.linalg.norm(way, axis=1) - strut.rest) ** 2
    return total


def energy_error(system: System, motion: Trajectory) -> float | None:
    """Greatest error of the energy balance, J; None where something is damped."""
    if any(drive.damping for drive in system.drives) or any(strut.damping for strut in system.struts):
        return None
    energy = energies(system, motion.q, motion.v)
    return float(np.abs(energy - energy[0]).max())


def closure(system: System, q: Reals) -> float:
    """Greatest gap of welds, m; turns count times the system's size."""
    if not system.welds:
        return 0.0
    placed = places(system, q)
    worst = 0.0
    for weld in system.welds:
        here, there = placed.turned(weld.first), placed.turned(weld.second)
        gap = placed.point(weld.second, weld.point)[0] - placed.point(weld.first, weld.point)[0]
        turn = 0.5 * np.cross(here, there, axis=1).sum(2)
        ways = here @ weld.frame.T  # columns: the weld's directions
        rows = np.hstack([system.size * np.einsum("kij,ki->kj", ways, turn), np.einsum("kij,ki->kj", ways, gap)])
        worst = max(worst, float(np.abs(rows[:, list(weld.kinds)]).max()))
    return worst


def line_of(law: Law) -> tuple[float, float]:
    """Moment at angle 0 (N m) and stiffness (N m/rad) of a linear law; UnableError for others."""
    pieces = law.straight.cubics
    if law.bent is not None or len(pieces) > 1 or any(pieces[0][2:]):
        raise UnableError("laws that are not linear")
    moment, stiffness, *_ = pieces[0]
    return moment - stiffness * law.straight.breaks[0], stiffness


def lines_of(system: System) -> tuple[Reals, Reals, Reals]:
    """Moments at angle 0, stiffnesses and dampings of the joints; UnableError where more acts."""
    if any(_stops(drive) for drive in system.drives):
        raise UnableError("stops")
    if system.cuts or system.overdamped:
        raise UnableError("cut hinges and motion without inertia")
    lines = np.array([line_of(drive.law) for drive in system.drives]).reshape(-1, 2)
    return lines[:, 0], lines[:, 1], np.array([drive.damping for drive in system.drives])


def _stops(drive: JointDrive) -> bool:
    return bool(np.isfinite([drive.lower, drive.upper]).any())


def depth_first(system: System) -> list[int]:
    """Joints in an order in which those above any of them come right after it, as other engines want them."""
    children: dict[int, list[int]] = {}
    for i, joint in enumerate(system.joints):
        children.setdefault(joint.parent, []).append(i)
    order: list[int] = []
    waiting = children.get(GROUND, [])[::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += children.get(order[-1], [])[::-1]
    return order


def common_points(system: System, weld: Weld) -> list[Reals]:
    """Points (m) that keep a weld closed when both bodies share them, for engines that can only join points.

    One for a spherical joint, two on the axis of a hinge, three for a full weld. A planar pin is a spherical joint
    where all joints turn about one direction; UnableError for other kinds.
    """
    turns = tuple(kind for kind in weld.kinds if kind in TURNS)
    gaps = tuple(kind for kind in weld.kinds if kind in GAPS)
    frame = np.asarray(weld.frame, float)
    if gaps == (3, 4) and not turns and _planar(system, frame[2]):
        gaps = GAPS
    if gaps != GAPS or len(turns) == 1:
        raise UnableError("welds of other kinds than points, hinges and whole bodies")
    arm = 0.5 * system.size
    if not turns:
        return [weld.point]
    if len(turns) == 2:
        (free,) = set(TURNS) - set(turns)
        return [weld.point - arm * frame[free], weld.point + arm * frame[free]]
    return [weld.point, weld.point + arm * frame[0], weld.point + arm * frame[1]]


def _planar(system: System, normal: Reals) -> bool:
    return all(not joint.slides and abs(joint.axis @ normal) > 1 - 1e-12 for joint in system.joints)
