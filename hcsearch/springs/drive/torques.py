"""Torques of the driven hinges by inverse dynamics: inertia, gravity, springs and dampers along a closed motion.

With B a basis of the closed rates, forces of closure do no work along B, so that B^T (M q'' + h + springs + dampers) =
B_D^T tau, where B_D are the rows of the driven hinges. As many driven hinges as freedoms have one solution; of more,
that of least squares is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.springs.deployment.compiling import CompiledScene
from hcsearch.springs.drive.choosing import DrivenHinges, frames_at
from hcsearch.springs.drive.trajectory import TimedPath
from hcsearch.springs.dynamics.inverse import joint_forces


@dataclass(frozen=True, eq=False)
class Torques(ByValue):
    """A motion in time and what drives it.

    times : (k,), s. angles, rates, accelerations : (k, n_hinges). asked : (k, n_hinges), moments of inertia, gravity,
    springs and dampers at the hinges, N m. torques : (k, n_driven), N m. Both in the sense in which fold angles grow.
    kinetic, height, stored : (k,), J. damped : (k,), power of the dampers, W.
    inertias : (n_driven,), median along the way of what a driven hinge moves when it alone turns, kg m^2.
    """

    times: Reals
    angles: Reals
    rates: Reals
    accelerations: Reals
    asked: Reals
    torques: Reals
    kinetic: Reals
    height: Reals
    stored: Reals
    damped: Reals
    inertias: Reals
    driven: tuple[int, ...]

    @property
    def power(self) -> Reals:
        """Power of all driven hinges together, (k,), W."""
        power: Reals = (self.torques * self.rates[:, list(self.driven)]).sum(axis=1)
        return power

    @property
    def imbalance(self) -> float:
        """Greatest error of the energy balance, J: work of torques against energies and what dampers take."""
        step = np.diff(self.times)
        flow = self.power - self.damped
        work = np.r_[0.0, np.cumsum(0.5 * step * (flow[1:] + flow[:-1]))]
        # the trapezium rule's end corrections (Euler and Maclaurin), as powers do not begin and end evenly
        slope = np.gradient(flow, self.times, edge_order=2)
        work += np.r_[0.0, step[0] ** 2 / 12.0 * (slope[0] - slope[1:])]
        total = self.kinetic + self.height + self.stored
        return float(np.abs(work - (total - total[0])).max())


def torques_along(compiled: CompiledScene, timed: TimedPath, choice: DrivenHinges, count: int = 1000) -> Torques:
    """Torques at so many times of a motion in a scene, whose compilation leaves out no half of it."""
    times = np.linspace(0.0, timed.seconds, count)
    angles, rates, accelerations = timed.at(times)
    system, own = compiled.system, compiled.joint_of
    hinge_of = np.argsort(own)
    forces = joint_forces(system, angles[:, hinge_of], rates[:, hinge_of], accelerations[:, hinge_of])
    asked = forces.joints[:, own]
    drives = [system.drives[joint] for joint in own]
    stored, damping = np.zeros(count), np.array([drive.damping for drive in drives])
    for k, drive in enumerate(drives):
        branches = [
            drive.law.bent if drive.law.bent and a > drive.law.snap_up else drive.law.straight for a in angles[:, k]
        ]
        asked[:, k] += [branch.moment(angle) for branch, angle in zip(branches, angles[:, k], strict=True)]
        stored += [branch.energy(angle) for branch, angle in zip(branches, angles[:, k], strict=True)]
    asked += damping * rates
    frames, _ = frames_at(compiled.linkage, angles)
    bases = frames[:, :, -choice.freedoms :]
    driven = list(choice.hinges)
    pulled = np.einsum("knf,kn->kf", bases, asked)
    torques = np.einsum("kdf,kf->kd", np.linalg.pinv(bases[:, driven].transpose(0, 2, 1)), pulled)
    return Torques(
        times,
        angles,
        rates,
        accelerations,
        asked,
        torques,
        forces.kinetic,
        forces.height,
        stored,
        (damping * rates**2).sum(axis=1),
        _inertias(compiled, angles, bases, driven),
        choice.hinges,
    )


def _inertias(compiled: CompiledScene, angles: Reals, bases: Reals, driven: list[int]) -> Reals:
    """What each driven hinge moves when it turns and the other driven ones stand still, median over some states."""
    some = np.unique(np.linspace(0, len(angles) - 1, 20).astype(int))
    own = compiled.joint_of
    hinge_of = np.argsort(own)
    still = np.zeros((len(some), len(own)))
    weight = joint_forces(compiled.system, angles[some][:, hinge_of], still, still).joints
    turns = bases[some] @ np.linalg.pinv(bases[some][:, driven])  # (k, n, d)
    inertias = np.empty((len(some), len(driven)))
    for d in range(len(driven)):
        push = turns[:, :, d]
        moved = joint_forces(compiled.system, angles[some][:, hinge_of], still, push[:, hinge_of]).joints - weight
        inertias[:, d] = (moved[:, own] * push).sum(axis=1)
    median: Reals = np.median(inertias, axis=0)
    return median
