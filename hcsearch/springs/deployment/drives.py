"""Drives of a deployment: the driven hinges, their course and gains, and motions under their control.

Drives have feedforward torques, and feedback towards a course. The controller is sampled, as controllers of machines
are: it computes targets of angle, rate and torque every period. Drives interpolate between two targets, as motor drives
in interpolated position mode do, so that torques do not jump with the targets. A table of a TOML file holds them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.kernels.multibody.hinges import Targets
from hcsearch.shape.labels import Labels, is_label, label_data
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
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
    period : the sampling period of the controller, s.
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
    angle_errors : (k, n_driven), angles less those planned. greatest_torques : (n_driven,), N m, until the end of the
    course, even if the motion is flat before.
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
    """Simulate a system under control from a closed state at rest up to a time (s); options as in `simulate_system`."""
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

    Damping is integrated by Simpson's rule, with cubics between rates; friction exactly, as no joint turns back within
    a step.
    """
    damping, friction = np.array([(drive.damping, drive.friction) for drive in system.drives]).T
    step, v, a = np.diff(motion.times)[:, None], motion.v, motion.a
    middle = 0.5 * (v[1:] + v[:-1]) + step * (a[:-1] - a[1:]) / 8.0
    taken = (damping * step * (v[1:] ** 2 + v[:-1] ** 2 + 4.0 * middle**2) / 6.0).sum(axis=1)
    taken += np.abs(np.diff(motion.q, axis=0)) @ friction
    return np.asarray(np.r_[0.0, np.cumsum(taken)], float)


START_CLOSURE_TOLERANCE = 1e-6
"""Greatest closure residual of a closed start."""
MAX_COURSE_TIMES = 100_000
"""Greatest number of times of a course."""
MIN_CONTROL_PERIOD, MAX_CONTROL_PERIOD = 1e-5, 0.1
"""Bounds of the period of a controller (s)."""
MIN_COURSE_TIME_STEP = 1e-9
"""Least distance of the times of a course (s)."""
_NO_NUMBERS = "[drive] holds what is no table of numbers: write it with hcsearch drive"


_DEMAND = tuple(field.name for field in fields(DriveDemand))
_NUMBERS = ("start", *_DEMAND)
_NAMES = ("driven", *_NUMBERS)
"""Keys of the table, in this order: the driven hinges by their names on pictures, and numbers."""


@dataclass(frozen=True, eq=False)
class Drives(DriveDemand):
    """Driven hinges with their targets and gains.

    hinges : (n_driven,), numbers. start : (n_hinges,), fold angles at which the motion starts, at rest.
    """

    hinges: tuple[int, ...]
    start: Reals

    def commands(self, compiled: CompiledScene) -> JointCommands:
        """Return the commands of the joints of a compiled scene."""
        joints = tuple(int(compiled.joint_of[hinge]) for hinge in self.hinges)
        return JointCommands(joints=joints, **{name: getattr(self, name) for name in _DEMAND})

    def start_in(self, compiled: CompiledScene) -> Reals:
        """Return the start as coordinates of the joints."""
        angles = compiled.start.copy()
        angles[compiled.joint_of] = self.start
        return angles

    def check(self, linkage: Linkage) -> None:
        """Refuse drives that do not belong to a linkage."""
        n = linkage.n_hinges
        if len(self.start) != n or not all(0 <= hinge < n for hinge in self.hinges):
            raise SceneError(f"the drive is not one of this design, which has {n} hinges: write it with hcsearch drive")
        gap = float(np.abs(linkage.closure(self.start)[0]).max(initial=0.0))
        least, greatest = self.start.min(initial=0.0), self.start.max(initial=0.0)
        if gap > START_CLOSURE_TOLERANCE or least < -0.01 or greatest > np.pi + 0.01:
            raise SceneError(
                "the drive does not start from a closed state within the stops: give the panels and flat pairs that it "
                "was made for, or write it with hcsearch drive"
            )


def drives_in(table: Mapping[str, Any], labels: Labels) -> Drives:
    """Read drives from a table of a file, for a linkage with these labels; SceneError for an invalid table."""
    wrong = [name for name in _NAMES if name not in table] + [key for key in table if key not in _NAMES]
    if wrong:
        raise SceneError(f"[drive] has, or lacks, {wrong[0]!r}: it holds {', '.join(_NAMES)}; see hcsearch drive")
    hinges = _driven(table["driven"], labels)
    values = {name: _numbers(table[name]) for name in _NUMBERS}
    times = values["times"]
    k, d = times.size, len(hinges)
    shapes = {"times": (k,), "angles": (k, d), "torques": (k, d), "stiffness": (d,), "damping": (d,)}
    valid = all(values[name].shape == shape for name, shape in shapes.items())
    valid = valid and values["start"].ndim == 1 and values["period"].ndim == 0 and 2 <= k <= MAX_COURSE_TIMES and d > 0
    if not valid or not all(np.isfinite(value).all() for value in values.values()):
        raise SceneError("[drive] must hold as many numbers for each hinge and time: write it with hcsearch drive")
    if len(set(hinges)) < d:
        raise SceneError("[drive] must name each driven hinge once, by its number: write it with hcsearch drive")
    gains = (values["stiffness"] >= 0.0).all() and (values["damping"] >= 0.0).all()
    if times[0] != 0.0 or (np.diff(times) < MIN_COURSE_TIME_STEP).any() or not gains:
        raise SceneError(
            f"[drive] needs times that grow from 0, by {MIN_COURSE_TIME_STEP:g} s at least, and gains of 0 or more"
        )
    period = float(values["period"])
    if not MIN_CONTROL_PERIOD <= period <= MAX_CONTROL_PERIOD:
        raise SceneError(
            f"[drive] has a period of {period:g} s: give one from {MIN_CONTROL_PERIOD:g} to {MAX_CONTROL_PERIOD:g} s"
        )
    arrays = {name: values[name] for name in _NUMBERS if name != "period"}
    return Drives(hinges=tuple(hinges), period=period, **arrays)


def _driven(names: Any, labels: Labels) -> list[int]:
    """Return the numbers of hinges by their names, as `drives_text` writes them."""
    if not isinstance(names, list) or not all(_is_named(name) for name in names):
        raise SceneError("[drive] must name each driven hinge once, as pictures do: write it with hcsearch drive")
    try:
        return [labels.hinge(str(name)) for name in names]
    except HcsearchError as error:
        raise SceneError(f"the drive is not one of this design: {error}; write it with hcsearch drive") from error


def _is_named(name: Any) -> bool:
    """Return whether a value of a file is the name of a hinge, a number or a text."""
    return isinstance(name, int | str) and not isinstance(name, bool) and is_label(str(name))


def _numbers(value: Any) -> Reals:
    """Convert a value to an array of numbers; SceneError for other values."""
    try:
        numbers = np.array(value)
    except ValueError as error:
        raise SceneError(_NO_NUMBERS) from error
    if numbers.dtype.kind not in "iuf" or _holds_truth(value):  # NumPy takes true among numbers for 1
        raise SceneError(_NO_NUMBERS)
    return numbers.astype(float)


def _holds_truth(value: Any) -> bool:
    return isinstance(value, bool) or (isinstance(value, list) and any(map(_holds_truth, value)))


def drives_text(drives: Drives, labels: Labels) -> str:
    """Write drives as the table that `drives_in` reads; angles of the course to 1e-9 rad, torques to 1e-9 N m."""
    lines = ["[drive]", f"driven = {json.dumps([label_data(labels.hinges[hinge]) for hinge in drives.hinges])}"]
    for name in _NUMBERS:
        value = getattr(drives, name)
        if name in {"times", "angles", "torques"}:
            value = np.round(value, 9) + 0.0
        data = value.tolist() if isinstance(value, np.ndarray) else value
        if name in {"angles", "torques"}:
            rows = ",\n".join(f"  {json.dumps(row)}" for row in data)
            lines.append(f"{name} = [\n{rows},\n]")
        else:
            lines.append(f"{name} = {json.dumps(data)}")
    return "".join(f"{line}\n" for line in lines)
