"""One step of an explicit Runge-Kutta method, with its error."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled, lean
from hcsearch.kernels.multibody.cuts import cut_energy
from hcsearch.kernels.multibody.hinges import lost_power
from hcsearch.kernels.multibody.motion import Hold, Mechanism, accelerate, closure_energy
from hcsearch.kernels.multibody.tree import Work

Reals = NDArray[np.float64]


class Method(NamedTuple):
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


@compiled
def step(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    tolerance: float,
    floor: float,
    h: float,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
) -> float:
    """One step from `start` to `end`, states (q, v, energy lost); the first stage is given. Its error."""
    n = len(hold.held)
    s = len(method.b)
    a = np.empty(n)
    for k in range(1, s + 1):
        for j in range(2 * n + 1):
            total = 0.0
            for i in range(k):
                total += (method.a[k, i] if k < s else method.b[i]) * stages[i, j]
            end[j] = start[j] + h * total
        accelerate(mechanism, hold, end[:n], end[n : 2 * n], scale, False, work, a)
        write_stage(mechanism, hold, end, a, work, stages[k])
    first = second = 0.0
    for j in range(2 * n):
        one = two = 0.0
        for i in range(s + 1):
            one += method.errors[0, i] * stages[i, j]
            two += method.errors[1, i] * stages[i, j]
        weight = floor + tolerance * max(abs(start[j]), abs(end[j]))
        first += (one / weight) ** 2
        second += (two / weight) ** 2
    if first == 0.0:
        return 0.0
    # DOP853 joins its estimates of orders 5 and 3 (Hairer, Norsett and Wanner 1993, section II.10)
    return h * first / math.sqrt((first + 0.01 * second) * 2 * n)


@lean
def write_stage(mechanism: Mechanism, hold: Hold, state: Reals, a: Reals, work: Work, stage: Reals) -> None:
    """Derivative of a state (q, v, energy lost), with the accelerations given; after `accelerate`."""
    n = len(a)
    for i in range(n):
        rate = a[i] if mechanism.overdamped else state[n + i]
        stage[i] = 0.0 if hold.held[i] else rate
        stage[n + i] = 0.0 if hold.held[i] or mechanism.overdamped else a[i]
    stage[2 * n] = lost_power(mechanism.hinges, mechanism.struts, state[:n], stage[:n], work)
    if len(mechanism.cuts.bodies):
        _, _, _, lost = cut_energy(mechanism.cuts, hold.cut_branches, work)
        stage[2 * n] += lost
    _, lost = closure_energy(mechanism, work)
    stage[2 * n] += lost
