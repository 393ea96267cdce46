"""Where in a step a joint comes to its stop, a law snaps, and whether stops would have to pull."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.multibody.motion import DiscreteState, Mechanism

NEAR_STOP_ANGLE, PASSED_STOP_ANGLE = 1e-9, 1e-6
"""A joint is at a stop from this far inside (rad), and has passed it when it is this far beyond."""

EVENT_LOWER_STOP, EVENT_UPPER_STOP, EVENT_SNAP_DOWN, EVENT_SNAP_UP = 0, 1, 2, 3
"""What a joint can come to: its stops, and the angles at which its law snaps. Odd ones are passed upwards."""


class IntegrationStep(NamedTuple):
    """A step of length h (s): coordinates, velocities and accelerations at its start and its end, (n,)."""

    h: float
    q0: Reals
    v0: Reals
    a0: Reals
    q1: Reals
    v1: Reals
    a1: Reals


@lean
def quintic(x: float, h: float, q0: float, v0: float, a0: float, q1: float, v1: float, a1: float) -> float:
    """The polynomial through positions, velocities and accelerations at both ends of a step, at a share x of it."""
    c3 = 10.0 * (q1 - q0) - h * (6.0 * v0 + 4.0 * v1) - 0.5 * h * h * (3.0 * a0 - a1)
    c4 = -15.0 * (q1 - q0) + h * (8.0 * v0 + 7.0 * v1) + 0.5 * h * h * (3.0 * a0 - 2.0 * a1)
    c5 = 6.0 * (q1 - q0) - 3.0 * h * (v0 + v1) - 0.5 * h * h * (a0 - a1)
    return q0 + x * (h * v0 + x * (0.5 * h * h * a0 + x * (c3 + x * (c4 + x * c5))))


@lean
def _coordinate(span: IntegrationStep, i: int, x: float) -> float:
    """The coordinate of a joint at a share x of a step."""
    if x == 1.0:
        return float(span.q1[i])
    return quintic(x, span.h, span.q0[i], span.v0[i], span.a0[i], span.q1[i], span.v1[i], span.a1[i])


@lean
def event_threshold(mechanism: Mechanism, hold: DiscreteState, i: int, kind: int) -> float:
    """The coordinate at which a joint has an event of a kind; infinite where it has none."""
    hinges = mechanism.hinges
    hard = hinges.stop_stiffness == 0.0 and not hold.held[i]
    if kind == EVENT_LOWER_STOP:
        return hinges.lower[i] if hard else -np.inf
    if kind == EVENT_UPPER_STOP:
        return hinges.upper[i] if hard else np.inf
    if kind == EVENT_SNAP_DOWN:
        return hinges.snaps_down[i] if hold.branches[i] else -np.inf
    return np.inf if hold.branches[i] else hinges.snaps_up[i]


@lean
def first_event(mechanism: Mechanism, hold: DiscreteState, span: IntegrationStep) -> tuple[float, int, int]:
    """Share of the step at which the first joint passes a stop or snap, the joint and the kind; 2 if none does."""
    best, joint, what = 2.0, -1, -1
    for i in range(len(span.q0)):
        for kind in range(4):
            limit = event_threshold(mechanism, hold, i, kind)
            if math.isinf(limit):
                continue
            sign = 1.0 if kind % 2 else -1.0
            before = 0.0
            for k in range(1, 5):
                x = 0.25 * k
                if sign * (_coordinate(span, i, x) - limit) > PASSED_STOP_ANGLE:
                    after = x
                    for _ in range(50):
                        x = 0.5 * (before + after)
                        if sign * (_coordinate(span, i, x) - limit) > 0.0:
                            after = x
                        else:
                            before = x
                    if after < best:
                        best, joint, what = after, i, kind
                    break
                before = x
    return best, joint, what


@lean
def first_near(span: IntegrationStep, place: Reals, near: float) -> float:
    """Share of the step at which all coordinates are first within `near` of a place; 2 if at none of its quarters.

    place : (n,), NaN where a coordinate does not count.
    """
    before = 0.0
    for k in range(1, 5):
        after = 0.25 * k
        if _within(after, span, place, near):
            for _ in range(40):
                x = 0.5 * (before + after)
                if _within(x, span, place, near):
                    after = x
                else:
                    before = x
            return after
        before = after
    return 2.0


@lean
def _within(x: float, span: IntegrationStep, place: Reals, near: float) -> bool:
    within = True
    for i in range(len(span.q0)):
        within = within and not abs(_coordinate(span, i, x) - place[i]) > near
    return within


@lean
def greatest_pull(hold: DiscreteState, forces: Reals) -> float:
    """By how much a stop would have to pull at most to go on holding; negative where all push."""
    most = -np.inf
    for i in range(len(forces)):
        if hold.held[i]:
            most = max(most, hold.held[i] * forces[i])
    return most
