"""Integration methods, and explicit Runge-Kutta steps with error estimates."""

from __future__ import annotations

import math
from typing import NamedTuple

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import (
    DiscreteState,
    Mechanism,
    Stepper,
    accelerate,
    closure_energy,
)
from hcsearch.kernels.multibody.drag import drag_power
from hcsearch.kernels.multibody.hinges import driving_power, friction_power, lost_power
from hcsearch.kernels.multibody.tree import Work
from hcsearch.kernels.multibody.welds import cut_energy


class IntegrationMethod(NamedTuple):
    """An integration method: explicit or singly diagonally implicit Runge-Kutta of s stages, or extrapolated Euler.

    a : (s, s). b : (s,). errors : (2, s + 1), weights of the error estimate, and of the second estimate that DOP853
        combines with it (0 elsewhere); the last stage is at the end of the step. order : of the error estimate plus 1.
    diagonal : of `a` in implicit stages, all but the first; 0 for other methods. predictors : (s, s), weights of
        earlier stages in the first guess of the derivative of an implicit stage; no rows for other methods.
    extrapolation_order : order s of the extrapolated method, all of whose coefficients are 0; 0 for other methods.
    """

    a: Reals
    b: Reals
    errors: Reals
    order: int
    diagonal: float
    predictors: Reals
    extrapolation_order: int


@compiled
def is_implicit(method: IntegrationMethod) -> bool:
    """Return whether all steps are implicit, or extrapolated from implicit ones."""
    return method.diagonal > 0.0 or method.extrapolation_order > 0


@compiled
def explicit_step(method: IntegrationMethod, stepper: Stepper, h: float) -> float:
    """Take an explicit step of length h whose first stage is given; return its error over the tolerance."""
    mechanism, hold, work, stages, end = stepper.mechanism, stepper.hold, stepper.work, stepper.stages, stepper.end
    n = len(hold.held)
    s = len(method.b)
    a, q, v = work.accelerations, end[:n], end[n : 2 * n]
    for k in range(1, s + 1):
        combine_stages(method.a[k] if k < s else method.b, k, h, stages, stepper.start, end)
        work.time[0] = end[2 * n + 1]
        accelerate(mechanism, hold, q, v, stepper.scale, False, work, a)
        write_stage(mechanism, hold, end, a, work, stages[k])
    return h * step_error(method.errors, stepper)


@compiled
def combine_stages(weights: Reals, count: int, h: float, stages: Reals, start: Reals, end: Reals) -> None:
    """Write the start state plus h times the weighted sum of the first stages; zero weights are skipped."""
    for j in range(len(start)):
        end[j] = start[j]
    for i in range(count):
        weight = h * weights[i]
        if weight != 0.0:
            for j in range(len(start)):
                end[j] += weight * stages[i, j]


@compiled
def step_error(weights: Reals, stepper: Stepper) -> float:
    """Return the error of a step, relative to the tolerance and divided by the step length."""
    stages, start, end = stepper.stages, stepper.start, stepper.end
    first = second = 0.0
    count = len(start) - 2
    for j in range(count):
        estimate = second_estimate = 0.0
        for i in range(weights.shape[1]):
            estimate += weights[0, i] * stages[i, j]
            second_estimate += weights[1, i] * stages[i, j]
        allowed = stepper.absolute_tolerance + stepper.relative_tolerance * max(abs(start[j]), abs(end[j]))
        first += (estimate / allowed) ** 2
        second += (second_estimate / allowed) ** 2
    if first == 0.0:
        return 0.0
    # DOP853 joins its estimates of orders 5 and 3 (Hairer, Norsett and Wanner 1993, section II.10)
    return first / math.sqrt((first + 0.01 * second) * count)


@compiled
def write_stage(mechanism: Mechanism, hold: DiscreteState, state: Reals, a: Reals, work: Work, stage: Reals) -> None:
    """Write the derivative of a state (q, v, energy lost, time) for given accelerations; call `accelerate` first."""
    n = len(a)
    for i in range(n):
        rate = a[i] if mechanism.overdamped else state[n + i]
        stage[i] = 0.0 if hold.held[i] else rate
        stage[n + i] = 0.0 if hold.held[i] or mechanism.overdamped else a[i]
    stage[2 * n] = lost_power(mechanism.hinges, mechanism.struts, state[:n], stage[:n], work)
    stage[2 * n] -= driving_power(mechanism.targets, state[:n], stage[:n], work)
    if len(hold.slides):
        stage[2 * n] += friction_power(mechanism.hinges, hold.slides, stage[:n])
    stage[2 * n + 1] = 1.0
    if len(mechanism.cuts.bodies):
        _, _, _, lost = cut_energy(mechanism.cuts, hold.cut_branches, work)
        stage[2 * n] += lost
    _, lost = closure_energy(mechanism, work)
    stage[2 * n] += lost
    if len(mechanism.drag.bodies):
        stage[2 * n] += drag_power(mechanism.drag, work)
