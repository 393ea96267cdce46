"""One step of an explicit Runge-Kutta method, with its error."""

from __future__ import annotations

import math
from typing import NamedTuple

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.compiling.compiled import inlined, lean
from hcsearch.kernels.multibody.cuts import cut_energy
from hcsearch.kernels.multibody.hinges import lost_power
from hcsearch.kernels.multibody.motion import DiscreteState, Mechanism, Stepper, accelerate_inlined, closure_energy
from hcsearch.kernels.multibody.targets import driving_power
from hcsearch.kernels.multibody.tree import Work


class IntegrationMethod(NamedTuple):
    """An explicit Runge-Kutta method of s stages whose last derivative is taken at the end of the step.

    a : (s, s). b : (s,). errors : (2, s + 1), weights of the error estimate, and of a second that DOP853 joins to it
        (0 elsewhere). order : of the error estimate plus 1.
    columns : 0; else the order of the extrapolated linearly implicit method, s as well, and all coefficients are 0.
    """

    a: Reals
    b: Reals
    errors: Reals
    order: int
    columns: int


@lean
def explicit_step(method: IntegrationMethod, stepper: Stepper, h: float) -> float:
    """One step of length h, whose first stage is given. Its error."""
    mechanism, hold, work, stages, end = stepper.mechanism, stepper.hold, stepper.work, stepper.stages, stepper.end
    n = len(hold.held)
    s = len(method.b)
    a, q, v = work.accelerations, end[:n], end[n : 2 * n]
    for k in range(1, s + 1):
        _join(method.a[k] if k < s else method.b, k, h, stages, stepper.start, end)
        work.clock[0] = end[2 * n + 1]
        accelerate_inlined(mechanism, hold, q, v, stepper.scale, False, work, a)
        write_stage(mechanism, hold, end, a, work, stages[k])
    return h * _error(method.errors, stepper)


@lean
def _join(weights: Reals, count: int, h: float, stages: Reals, start: Reals, end: Reals) -> None:
    """Write the state that the first stages lead to; many weights are 0."""
    for j in range(len(start)):
        end[j] = start[j]
    for i in range(count):
        weight = h * weights[i]
        if weight != 0.0:
            for j in range(len(start)):
                end[j] += weight * stages[i, j]


@lean
def _error(weights: Reals, stepper: Stepper) -> float:
    """Error of a step over what is allowed, and over its length."""
    stages, start, end = stepper.stages, stepper.start, stepper.end
    first = second = 0.0
    count = len(start) - 2
    for j in range(count):
        one = two = 0.0
        for i in range(len(stages)):
            one += weights[0, i] * stages[i, j]
            two += weights[1, i] * stages[i, j]
        allowed = stepper.floor + stepper.tolerance * max(abs(start[j]), abs(end[j]))
        first += (one / allowed) ** 2
        second += (two / allowed) ** 2
    if first == 0.0:
        return 0.0
    # DOP853 joins its estimates of orders 5 and 3 (Hairer, Norsett and Wanner 1993, section II.10)
    return first / math.sqrt((first + 0.01 * second) * count)


@inlined
def write_stage(mechanism: Mechanism, hold: DiscreteState, state: Reals, a: Reals, work: Work, stage: Reals) -> None:
    """Derivative of a state (q, v, energy lost, time), with the accelerations given; after `evaluate`."""
    n = len(a)
    for i in range(n):
        rate = a[i] if mechanism.overdamped else state[n + i]
        stage[i] = 0.0 if hold.held[i] else rate
        stage[n + i] = 0.0 if hold.held[i] or mechanism.overdamped else a[i]
    stage[2 * n] = lost_power(mechanism.hinges, mechanism.struts, state[:n], stage[:n], work)
    stage[2 * n] -= driving_power(mechanism.targets, state[:n], stage[:n], work)
    stage[2 * n + 1] = 1.0
    if len(mechanism.cuts.bodies):
        _, _, _, lost = cut_energy(mechanism.cuts, hold.cut_branches, work)
        stage[2 * n] += lost
    _, lost = closure_energy(mechanism, work)
    stage[2 * n] += lost
