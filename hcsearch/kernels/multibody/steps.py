"""One step of a motion: with which method, how long, and repeated so that it ends where something happens."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.multibody.events import greatest_pull, threshold
from hcsearch.kernels.multibody.explicit import Method, step, write_stage
from hcsearch.kernels.multibody.implicit import implicit_step
from hcsearch.kernels.multibody.motion import Hold, Mechanism, accelerate, project
from hcsearch.kernels.multibody.tree import Work

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]

REACHED = 1e-11
"""A joint is at a stop within this (rad)."""


class Plan(NamedTuple):
    """What a simulation is asked for.

    end : s. tolerance, floor : relative and absolute. first : first step (s), 0 to find one; longest : longest step.
    restitution : of stops, 0 to 1. slow : speed (rad/s) below which stops do not bounce.
    flat : (n,), coordinates of the flat state, NaN where they do not count. near : distance from them that counts as
        flat; below 0 never.
    rest : what a joint may move by its speed or acceleration in the time left, or in 1 s, to be at rest (rad); below 0
        never. closed : residual after projection.
    """

    end: float
    tolerance: float
    floor: float
    first: float
    longest: float
    restitution: float
    slow: float
    flat: Reals
    near: float
    rest: float
    closed: float


@compiled
def take_step(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    h: float,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """One step by the method; its error. The last stage holds the derivative at its end."""
    if not method.columns:
        counts[2] += len(method.b)
        return step(mechanism, hold, method, plan.tolerance, plan.floor, h, scale, work, stages, start, end)
    n, columns = len(hold.held), method.columns
    counts[2] += columns * (columns + 1) // 2 + 1
    error = implicit_step(mechanism, hold, columns, plan.tolerance, plan.floor, h, scale, work, stages[1:], start, end)
    a = np.empty(n)
    accelerate(mechanism, hold, end[:n], end[n : 2 * n], scale, False, work, a)
    write_stage(mechanism, hold, end, a, work, stages[columns])
    return error


@compiled
def first_step(plan: Plan, order: int, q: Reals, v: Reals, a: Reals) -> float:
    """A first step from the size of the motion (Hairer, Norsett and Wanner 1993, section II.4, in part)."""
    if plan.first > 0.0:
        return plan.first
    n = len(q)
    size = rate = 0.0
    for i in range(n):
        weight_q, weight_v = plan.floor + plan.tolerance * abs(q[i]), plan.floor + plan.tolerance * abs(v[i])
        size += (q[i] / weight_q) ** 2 + (v[i] / weight_v) ** 2
        rate += (v[i] / weight_q) ** 2 + (a[i] / weight_v) ** 2
    if rate == 0.0:
        return plan.longest
    guess = 0.01 * math.sqrt(size / rate) if size > 0.0 else 1e-6
    return min(plan.longest, max(guess, 1e-9 * plan.end))


@compiled
def land(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    guess: float,
    longest: float,
    joint: int,
    kind: int,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """Repeat the step so that it ends where the joint has its event; its length."""
    n = len(hold.held)
    limit = threshold(mechanism, hold, joint, kind)
    h = guess
    low, high = 0.0, longest
    for _ in range(12):
        take_step(mechanism, hold, method, plan, h, scale, work, stages, start, end, counts)
        past = (end[joint] - limit) * (1.0 if kind % 2 else -1.0)
        if abs(past) <= REACHED:
            break
        if past > 0.0:
            high = min(high, h)
        else:
            low = max(low, h)
        speed = end[n + joint]
        trial = h - (end[joint] - limit) / speed if speed != 0.0 else 0.5 * (low + high)
        h = trial if low < trial < high else 0.5 * (low + high)
    return h


@compiled
def loosen(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    grip: float,
    longest: float,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """Repeat the step so that it ends where a stop begins to pull, if one does at its end only; its length.

    A step across a release would have an error of its own length squared, whatever the tolerance. The factor that is
    left is one at the end, for the projection that follows.
    """
    n = len(hold.held)
    if not np.abs(hold.held).max():
        return longest
    above = _pull(mechanism, hold, plan, scale, work, end)
    if not above > grip:
        return longest
    below = _pull(mechanism, hold, plan, scale, work, start)
    low, high, h = 0.0, longest, longest
    for k in range(40):
        if below > grip or above <= 3.0 * grip or high - low <= 1e-12 * longest:
            break
        # by the secant, a third of the times by halves, so that one end does not stay
        share = 0.5 if k % 3 == 2 else (2.0 * grip - below) / (above - below)
        h = low + (high - low) * min(max(share, 0.01), 0.99)
        accelerate(mechanism, hold, start[:n], start[n : 2 * n], scale, True, work, np.empty(n))
        take_step(mechanism, hold, method, plan, h, scale, work, stages, start, end, counts)
        pull = _pull(mechanism, hold, plan, scale, work, end)
        if pull > grip:
            high, above = h, pull
        else:
            low, below = h, pull
    accelerate(mechanism, hold, start[:n], start[n : 2 * n], scale, True, work, np.empty(n))
    take_step(mechanism, hold, method, plan, high, scale, work, stages, start, end, counts)
    return high


@compiled
def _pull(mechanism: Mechanism, hold: Hold, plan: Plan, scale: float, work: Work, state: Reals) -> float:
    """By how much a stop would have to pull at most at a state (q, v, energy lost), N m."""
    n = len(hold.held)
    q, v, forces = state[:n].copy(), state[n : 2 * n].copy(), np.empty(n)
    project(mechanism.tree, hold.held, q, v, plan.closed, work)
    accelerate(mechanism, hold, q, v, scale, True, work, forces)
    return greatest_pull(hold, forces)
