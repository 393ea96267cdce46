"""Motions under position control: feedforward torques in driven joints, and feedback towards a course.

The controller is sampled, as those of machines are: it computes targets of angle, rate and torque every period. Drives
interpolate between two targets, as motor drives in interpolated position mode do, so that torques do not jump with the
targets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.kernels.multibody.hinges import Targets
from hcsearch.springs.dynamics.system import System
from hcsearch.springs.dynamics.time_integration import Motion, simulate_system

FIRST_STEP_SHARE, LONGEST_STEP_SHARE = 1e-5, 0.001
"""First and longest step, as shares of the duration of the course."""


@dataclass(frozen=True, eq=False)
class DriveDemand(ByValue):
    """Targets and gains of drives.

    times : (k,), s, from 0. angles, torques : (k, n_driven), rad and N m: splines through the angles, at rest at both
    ends, linear interpolation of the torques; constant after the end.
    stiffness, damping : (n_driven,), feedback torque by the error of the angle (N m/rad) and of the rate (N m s/rad).
    period : of the controller, s.
    """

    times: Reals
    angles: Reals
    torques: Reals
    stiffness: Reals
    damping: Reals
    period: float

    @cached_property
    def _course(self) -> Any:
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - loads slowly

        return CubicSpline(self.times, self.angles, bc_type="clamped")

    def at(self, times: Reals) -> tuple[Reals, Reals, Reals]:
        """Return the planned angles, rates and torques at times, each (len(times), n_driven)."""
        ended = times >= self.times[-1]
        clipped = np.clip(times, self.times[0], self.times[-1])
        angles, rates = np.asarray(self._course(clipped), float), np.asarray(self._course(clipped, 1), float)
        rates[ended] = 0.0
        torques = np.array([np.interp(clipped, self.times, column) for column in self.torques.T]).T
        return angles, rates, torques.reshape(angles.shape)

    def interpolated(self, times: Reals) -> tuple[Reals, Reals, Reals]:
        """Return the targets as drives interpolate them within a period: cubics for angles, lines for torques."""
        period = self.period
        begin = period * np.floor(times / period)
        x = ((times - begin) / period)[:, None]
        (q0, v0, t0), (q1, v1, t1) = self.at(begin), self.at(begin + period)
        rise = q1 - q0
        b, c = 3.0 * rise - period * (2.0 * v0 + v1), period * (v0 + v1) - 2.0 * rise
        angles = q0 + x * (period * v0 + x * (b + x * c))
        rates = v0 + x * (2.0 * b + x * 3.0 * c) / period
        return angles, rates, t0 + x * (t1 - t0)


@dataclass(frozen=True, eq=False)
class JointCommands(DriveDemand):
    """Targets and gains of driven joints; joints : their numbers."""

    joints: tuple[int, ...]

    @property
    def targets(self) -> Targets:
        """The targets as tables for the kernels."""
        return Targets(
            joints=np.array(self.joints, np.int64),
            stiffness=np.array(self.stiffness, float),
            damping=np.array(self.damping, float),
            period=float(self.period),
            times=np.array(self.times, float),
            cubics=np.ascontiguousarray(np.asarray(self._course.c, float)[::-1].transpose(1, 2, 0)),
            torques=np.array(self.torques, float),
        )


@dataclass(frozen=True, eq=False)
class DrivenMotion(ByValue):
    """A motion under control.

    motion : its energies are those of the system without its drives, and `work` (k,) is the work of the drives (J).
    planned, torques : (k, n_driven), feedforward torques and total torques of the drives at the states, N m.
    angle_errors : (k, n_driven), angles less those planned. greatest_torques : (n_driven,), until the end of the
    course, even if the motion ends before, where it is flat, N m.
    """

    motion: Motion
    work: Reals
    planned: Reals
    torques: Reals
    angle_errors: Reals
    greatest_torques: Reals

    @property
    def drift(self) -> float:
        """Greatest error of the energy balance, J."""
        motion = self.motion
        total = motion.kinetic + motion.stored + motion.height + motion.in_stops + motion.damped + motion.lost
        total = total - self.work
        return float(np.abs(total - total[0]).max())


def simulate_driven(
    system: System,
    commands: JointCommands,
    q: Reals,
    *,
    end: float,
    method: str = "dormand-prince",
    tolerance: float = 1e-6,
    restitution: float = 0.0,
    flat: float | None = None,
    watched: Flags | None = None,
    max_steps: int = 200_000,
) -> DrivenMotion:
    """Simulate a system under control from a closed state at rest up to a time (s); options as of `simulate_system`."""
    motion = simulate_system(
        system.under_control(commands.targets),
        q,
        end=end,
        method=method,
        tolerance=tolerance,
        restitution=restitution,
        flat=flat,
        watched=watched,
        first_step=FIRST_STEP_SHARE * float(commands.times[-1]),
        longest_step=LONGEST_STEP_SHARE * float(commands.times[-1]),
        max_steps=max_steps,
    )
    damped = _damped(system, motion)
    joints = list(commands.joints)
    angles, rates = motion.q[:, joints], motion.v[:, joints]
    target_angles, target_rates, feedforward = commands.interpolated(motion.times)
    torques = feedforward + commands.stiffness * (target_angles - angles) + commands.damping * (target_rates - rates)
    planned_angles, _, planned = commands.at(motion.times)
    # in the kernel's books, dissipation is the energy taken by dampers and friction less the work of drives
    work, errors, greatest = damped - motion.damped, angles - planned_angles, np.abs(torques).max(axis=0)
    return DrivenMotion(replace(motion, damped=damped), work, planned, torques, errors, greatest)


def _damped(system: System, motion: Motion) -> Reals:
    """Return the energy dissipated by the dampers and the friction of the joints, (k,), J.

    Of dampers by Simpson's rule, with cubics between rates; of friction exactly, as no joint turns back within a step.
    """
    damping, friction = np.array([(drive.damping, drive.friction) for drive in system.drives]).T
    step, v, a = np.diff(motion.times)[:, None], motion.v, motion.a
    middle = 0.5 * (v[1:] + v[:-1]) + step * (a[:-1] - a[1:]) / 8.0
    taken = (damping * step * (v[1:] ** 2 + v[:-1] ** 2 + 4.0 * middle**2) / 6.0).sum(axis=1)
    taken += np.abs(np.diff(motion.q, axis=0)) @ friction
    return np.asarray(np.r_[0.0, np.cumsum(taken)], float)
