"""Torques of the driven hinges by inverse dynamics, and the gains of position control.

With B a basis of the closed rates, forces of closure do no work along B, so that B^T (M q'' + h + springs + dampers +
friction) = B_D^T tau, where B_D are the rows of the driven hinges. The solution is unique for as many driven hinges as
freedoms; for more, the least-norm solution is taken.

Along a closed motion q + t v + t^2 w / 2, J w = -b(v, v) with b the second derivative of closure, the forces g borne by
closure, g = J^T m, give g w = -m b(v, v). With the slopes K of the springs the motion is statically stable where
v (K - m b) v is positive for all closed rates v; control with the stiffness k of all driven hinges adds k |v_D|^2.
Near the packed state the curvature of closure is greatest, and closure alone resists the springs. Forces of inertia are
included in g, their derivatives are neglected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.drives import Drives
from hcsearch.springs.drive.choosing import DrivenHinges, frames_at
from hcsearch.springs.drive.trajectory import TimedPath
from hcsearch.springs.dynamics.inverse import joint_forces

MIN_SLIDING_SHARE = 1e-9
"""Share of the greatest rate of a motion below which a hinge is at rest, and its friction does not resist."""


@dataclass(frozen=True, eq=False)
class Torques(ByValue):
    """A motion in time with its driving torques.

    times : (k,), s. angles, rates, accelerations : (k, n_hinges). hinge_moments : (k, n_hinges), moments of inertia,
    gravity, springs, dampers and friction at the hinges, N m. torques : (k, n_driven), N m. Both are positive where
    fold angles grow.
    kinetic, height, stored : (k,), J. damped : (k,), power lost in dampers and to friction, W.
    inertias : (n_driven,), median along the path of the inertia felt by a driven hinge when it alone turns, kg m^2.
    """

    times: Reals
    angles: Reals
    rates: Reals
    accelerations: Reals
    hinge_moments: Reals
    torques: Reals
    kinetic: Reals
    height: Reals
    stored: Reals
    damped: Reals
    inertias: Reals
    driven: tuple[int, ...]

    @property
    def power(self) -> Reals:
        """Total power of all driven hinges, (k,), W."""
        power: Reals = (self.torques * self.rates[:, list(self.driven)]).sum(axis=1)
        return power

    @property
    def imbalance(self) -> float:
        """Greatest error of the energy balance, J: work of torques less energies and dissipation in dampers."""
        step = np.diff(self.times)
        flow = self.power - self.damped
        work = np.r_[0.0, np.cumsum(0.5 * step * (flow[1:] + flow[:-1]))]
        # end corrections of the trapezoidal rule (Euler and Maclaurin), as the power has a slope at both ends
        slope = np.gradient(flow, self.times, edge_order=2)
        work += np.r_[0.0, step[0] ** 2 / 12.0 * (slope[0] - slope[1:])]
        total = self.kinetic + self.height + self.stored
        return float(np.abs(work - (total - total[0])).max())


def torques_along(compiled: CompiledScene, timed: TimedPath, choice: DrivenHinges, count: int = 1000) -> Torques:
    """Compute torques at `count` times of a motion in a scene that is compiled without omitting a mirror half."""
    times = np.linspace(0.0, timed.seconds, count)
    angles, rates, accelerations = timed.at(times)
    system, joint_of = compiled.system, compiled.joint_of
    hinge_of = np.argsort(joint_of)
    forces = joint_forces(system, angles[:, hinge_of], rates[:, hinge_of], accelerations[:, hinge_of])
    hinge_moments = forces.joints[:, joint_of]
    drives = [system.drives[joint] for joint in joint_of]
    stored, damping = np.zeros(count), np.array([drive.damping for drive in drives])
    for k, drive in enumerate(drives):
        branches = [
            drive.law.bent if drive.law.bent and a > drive.law.snap_up else drive.law.straight for a in angles[:, k]
        ]
        hinge_moments[:, k] += [branch.moment(angle) for branch, angle in zip(branches, angles[:, k], strict=True)]
        stored += [branch.energy(angle) for branch, angle in zip(branches, angles[:, k], strict=True)]
    slowing = damping * rates + np.array([drive.friction for drive in drives]) * _senses(rates)
    hinge_moments += slowing
    frames, _ = frames_at(compiled.linkage, angles)
    bases = frames[:, :, -choice.freedoms :]
    driven = list(choice.hinges)
    generalized = np.einsum("knf,kn->kf", bases, hinge_moments)
    torques = np.einsum("kdf,kf->kd", np.linalg.pinv(bases[:, driven].transpose(0, 2, 1)), generalized)
    return Torques(
        times,
        angles,
        rates,
        accelerations,
        hinge_moments,
        torques,
        forces.kinetic,
        forces.height,
        stored,
        (slowing * rates).sum(axis=1),
        _inertias(compiled, angles, bases, driven),
        choice.hinges,
    )


def _senses(rates: Reals) -> Reals:
    """Return the signs of the rates of a motion, (k, n), 0 where a hinge stays at rest.

    At both ends, where all hinges are at rest, they are the signs of the motion that begins or ends there.
    """
    senses = np.where(np.abs(rates) > MIN_SLIDING_SHARE * np.abs(rates).max(initial=0.0), np.sign(rates), 0.0)
    senses[0], senses[-1] = senses[1], senses[-2]
    return senses


def _inertias(compiled: CompiledScene, angles: Reals, bases: Reals, driven: list[int]) -> Reals:
    """Return the inertia felt by each driven hinge while the other driven ones stand still, median over some states."""
    rows = np.unique(np.linspace(0, len(angles) - 1, 20).astype(int))
    joint_of = compiled.joint_of
    hinge_of = np.argsort(joint_of)
    still = np.zeros((len(rows), len(joint_of)))
    gravity_moments = joint_forces(compiled.system, angles[rows][:, hinge_of], still, still).joints
    turns = bases[rows] @ np.linalg.pinv(bases[rows][:, driven])  # (k, n, d)
    inertias = np.empty((len(rows), len(driven)))
    for d in range(len(driven)):
        rates = turns[:, :, d]
        moments = (
            joint_forces(compiled.system, angles[rows][:, hinge_of], still, rates[:, hinge_of]).joints - gravity_moments
        )
        inertias[:, d] = (moments[:, joint_of] * rates).sum(axis=1)
    median: Reals = np.median(inertias, axis=0)
    return median


MAX_CONTROL_YIELD = 0.05
"""Greatest angle by which control yields under the greatest torque of the motion (rad)."""
STABILITY_SAFETY_FACTOR = 3.0
"""Ratio of the stiffness of control to that at which the motion is statically stable."""
STABILITY_STATE_COUNT = 100
"""Number of states along the motion at which stability is evaluated."""
DEFAULT_CONTROL_PERIOD = 0.002
"""Default period of the controller, s."""


@dataclass(frozen=True)
class Stability:
    """The least stiffness of control (N m/rad) for a statically stable motion, and the time (s) that determines it."""

    stiffness: float
    time: float


def static_stability(compiled: CompiledScene, torques: Torques) -> Stability:
    """Compute the stiffness of all driven hinges for a statically stable motion, neglecting the slopes of gravity."""
    rows = np.unique(np.linspace(0, len(torques.times) - 1, STABILITY_STATE_COUNT).astype(int))
    linkage, driven = compiled.linkage, list(torques.driven)
    angles = torques.angles[rows]
    frames, values = frames_at(linkage, angles)
    rank = values.shape[1]
    needed = np.zeros(len(rows))
    for row, state in enumerate(angles):
        basis = frames[row, :, rank:]
        borne = torques.hinge_moments[rows[row]].copy()
        borne[driven] -= torques.torques[rows[row]]
        stiffness = basis.T @ (_slopes(compiled, state)[:, None] * basis) + _bent(linkage, state, borne, basis)
        _, singular_values, right = np.linalg.svd(basis[driven])
        # in these directions control has the stiffness 1
        directions = right / np.maximum(singular_values, 1e-9)[:, None]
        needed[row] = max(0.0, -float(np.linalg.eigvalsh(directions @ stiffness @ directions.T)[0]))
    worst = int(needed.argmax())
    return Stability(float(needed[worst]), float(torques.times[rows[worst]]))


def position_control(compiled: CompiledScene, torques: Torques, period: float = DEFAULT_CONTROL_PERIOD) -> Drives:
    """Return position control for a motion: stiff enough for its torques and stability, with critical damping.

    The damping is critical for the inertia felt by each driven hinge.
    """
    driven = list(torques.driven)
    greatest = float(np.abs(torques.torques).max(initial=0.0))
    stiffness = np.full(
        len(driven),
        max(
            greatest / MAX_CONTROL_YIELD, STABILITY_SAFETY_FACTOR * static_stability(compiled, torques).stiffness, 1e-9
        ),
    )
    return Drives(
        hinges=torques.driven,
        start=torques.angles[0],
        times=torques.times,
        angles=torques.angles[:, driven],
        torques=torques.torques,
        stiffness=stiffness,
        damping=2.0 * np.sqrt(stiffness * torques.inertias),
        period=period,
    )


def _slopes(compiled: CompiledScene, angles: Reals) -> Reals:
    """Return the slopes of the springs at fold angles, (n_hinges,), N m/rad, by central differences."""
    slopes = np.zeros(len(angles))
    for k, angle in enumerate(angles):
        law = compiled.system.drives[compiled.joint_of[k]].law
        branch = law.bent if law.bent is not None and angle > law.snap_up else law.straight
        slopes[k] = (branch.moment(angle + 1e-5) - branch.moment(angle - 1e-5)) / 2e-5
    return slopes


def _bent(linkage: Linkage, angles: Reals, forces: Reals, basis: Reals) -> Reals:
    """Return -m b in a basis (n_hinges, f) of closed rates, shape (f, f), for forces borne by closure."""
    _, jacobian = linkage.closure(angles)
    borne = np.linalg.lstsq(jacobian.T, forces, rcond=1e-10)[0]
    count = basis.shape[1]
    curvature = np.zeros((count, count))
    for i in range(count):
        for j in range(i + 1):
            total, difference = basis[:, i] + basis[:, j], basis[:, i] - basis[:, j]
            difference_of_bends = linkage.bend(jacobian, total) - linkage.bend(jacobian, difference)
            curvature[i, j] = curvature[j, i] = -0.25 * float(borne @ difference_of_bends)
    return curvature
