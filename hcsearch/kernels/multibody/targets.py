"""Joints under position control: what their drives are asked for at a time, and the torques that these give.

A controller computes targets every period: angle, rate and torque. Within a period each drive interpolates: the angle
by the cubic through angles and rates at both ends, the torque by a straight line. It pulls without pause.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.multibody.tree import Work

TARGET_ANGLE, TARGET_RATE, TARGET_TORQUE = 0, 1, 2
"""Columns of `Work.asked`, a row a drive: rad, rad/s, N m."""


class Targets(NamedTuple):
    """Drives of joints, d of them, and their courses.

    joints : (d,). stiffness, damping : (d,), torque for an angle (N m/rad) and a rate (N m s/rad) that is missed.
    period : of the controller, s. times : (k,), s, from 0. cubics : (k - 1, d, 4), angles by the time from the first of
    two times, coefficients of 1, x, x^2, x^3. torques : (k, d), N m, straight lines between the times.
    """

    joints: WholeNumbers
    stiffness: Reals
    damping: Reals
    period: float
    times: Reals
    cubics: Reals
    torques: Reals


@compiled
def no_targets() -> Targets:
    """The targets of joints that no drive moves."""
    return Targets(
        joints=np.zeros(0, np.int64),
        stiffness=np.zeros(0),
        damping=np.zeros(0),
        period=1.0,
        times=np.zeros(0),
        cubics=np.zeros((0, 0, 4)),
        torques=np.zeros((0, 0)),
    )


@lean
def _piece(times: Reals, time: float) -> int:
    """The last piece of a course that begins at a time or before it."""
    low, high = 0, len(times) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if times[middle] <= time:
            low = middle
        else:
            high = middle
    return low


@lean
def _planned(targets: Targets, piece: int, drive: int, time: float) -> tuple[float, float, float]:
    """Angle, rate and torque of a course at a time; at rest after its end."""
    first, last = targets.times[piece], targets.times[piece + 1]
    x = min(time, last) - first
    c = targets.cubics[piece, drive]
    angle = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
    rate = 0.0 if time >= last else c[1] + x * (2.0 * c[2] + x * 3.0 * c[3])
    begun, ended = targets.torques[piece, drive], targets.torques[piece + 1, drive]
    return angle, rate, begun + (ended - begun) * x / (last - first)


@lean
def write_drive_targets(targets: Targets, time: float, work: Work) -> None:
    """Write what drives are asked for at a time: interpolated between the targets of two periods."""
    if not len(targets.joints):
        return
    h = targets.period
    begun = h * math.floor(time / h)
    first, last = _piece(targets.times, begun), _piece(targets.times, begun + h)
    x = (time - begun) / h
    for d in range(len(targets.joints)):
        q0, v0, t0 = _planned(targets, first, d, begun)
        q1, v1, t1 = _planned(targets, last, d, begun + h)
        rise = q1 - q0
        b, c = 3.0 * rise - h * (2.0 * v0 + v1), h * (v0 + v1) - 2.0 * rise
        work.asked[d, TARGET_ANGLE] = q0 + x * (h * v0 + x * (b + x * c))
        work.asked[d, TARGET_RATE] = v0 + x * (2.0 * b + x * 3.0 * c) / h
        work.asked[d, TARGET_TORQUE] = t0 + x * (t1 - t0)


@lean
def add_drive_torques(targets: Targets, q: Reals, v: Reals, work: Work, torques: Reals) -> None:
    """Add the torques of drives to joint forces; after `write_drive_targets`."""
    for d in range(len(targets.joints)):
        torques[targets.joints[d]] += _torque(targets, d, q, v, work)


@lean
def add_drive_torques_ahead(targets: Targets, h: float, q: Reals, v: Reals, work: Work) -> None:
    """As `add_drive_torques`, with the torques as they will be after a time h, for which drives were asked."""
    for d in range(len(targets.joints)):
        i = targets.joints[d]
        work.soft[i] += h * targets.damping[d] + h * h * targets.stiffness[d]
        work.torques[i] += _torque(targets, d, q, v, work) - h * targets.stiffness[d] * v[i]


@lean
def driving_power(targets: Targets, q: Reals, v: Reals, work: Work) -> float:
    """Power of all drives, W; after `write_drive_targets`."""
    power = 0.0
    for d in range(len(targets.joints)):
        power += _torque(targets, d, q, v, work) * v[targets.joints[d]]
    return power


@lean
def _torque(targets: Targets, d: int, q: Reals, v: Reals, work: Work) -> float:
    i, asked = targets.joints[d], work.asked[d]
    pull: float = targets.stiffness[d] * (asked[TARGET_ANGLE] - q[i]) + targets.damping[d] * (asked[TARGET_RATE] - v[i])
    return pull + float(asked[TARGET_TORQUE])
