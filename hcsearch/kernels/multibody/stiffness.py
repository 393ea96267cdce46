"""Stiffness of a motion: the fastest rate at which dampers, or springs without inertia, would stop it."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import Stepper, accelerate
from hcsearch.kernels.multibody.integrators import IntegrationMethod
from hcsearch.kernels.multibody.paused_simulation import (
    PACE_LIMITED_STEPS,
    PACE_SCALE,
    PACE_STATES_WATCHED,
    PACE_STIFF,
    PACE_TIME,
    Simulation,
)

STABLE_STEP = 3.3
"""Longest step of Dormand and Prince's method that is stable, times the rate (Hairer and Wanner 1996, section IV.2)."""
STIFF_STEPS = 20_000.0
"""Number of such steps in a motion from which on it is stiff at its start. In the scene `default` the assemblies and
foldings of up to 16 squares and 12 hexagons have at most 2,500."""
LIMITED_STEP = 2.0
"""Step, times the rate, from which on it counts as limited by stability. Steps of motions near singular states, which
their error limits, have 0.5 to 1.2; those at the limit oscillate about 3.3."""
LIMITED_STEPS, STIFF_STEPS_LEFT = 30.0, 4000.0
"""Surplus of limited steps over others after which the rate is estimated again, and number of stable steps in the rest
of the motion from which on it is then stiff. In the scene `default` such motions have hardly over 3,000."""
RUN_OUT_SHARE = 0.75
"""Share of the states that a record holds after which implicit steps take over whatever the stiffness."""
_ITERATIONS, _PERTURBATION = 8, 1e-6


@compiled
def fastest_rate(simulation: Simulation) -> float:
    """Estimate the spectral radius of the derivative of accelerations by velocities, at closed loops, 1/s.

    In overdamped motion, that of velocities by coordinates. By power iteration on difference quotients: as the operator
    is symmetric in the mass metric, few iterations come within a third of it. Tables in `work` are overwritten.
    """
    mechanism, hold, work, scale = simulation.mechanism, simulation.hold, simulation.work, simulation.pace[PACE_SCALE]
    n = len(simulation.q)
    q, v, start, moved = simulation.q.copy(), simulation.v.copy(), np.zeros(n), np.zeros(n)
    direction = np.zeros(n)
    for i in range(n):
        direction[i] = 0.0 if hold.held[i] else 1.0 + 0.5 * math.sin(1.0 + 2.0 * i)
    accelerate(mechanism, hold, q, v, scale, True, work, start)
    rate = 0.0
    for _ in range(_ITERATIONS):
        size = math.sqrt((direction * direction).sum())
        if not 0.0 < size < np.inf:
            break
        step = _PERTURBATION / size
        for i in range(n):
            q[i] = simulation.q[i] + (step * direction[i] if mechanism.overdamped else 0.0)
            v[i] = simulation.v[i] + (0.0 if mechanism.overdamped else step * direction[i])
        accelerate(mechanism, hold, q, v, scale, False, work, moved)
        for i in range(n):
            direction[i] = 0.0 if hold.held[i] else (moved[i] - start[i]) / _PERTURBATION
        rate = math.sqrt((direction * direction).sum())
    return rate


@compiled
def is_to_be_watched(simulation: Simulation) -> bool:
    """Return whether the stiffness is to be estimated again before the next step."""
    record = simulation.record
    states, room = record.counts[0], len(record.times)
    watched: float = simulation.pace[PACE_STATES_WATCHED]
    is_to_be: bool = simulation.pace[PACE_LIMITED_STEPS] >= LIMITED_STEPS or watched <= RUN_OUT_SHARE * room < states
    return is_to_be


@compiled
def watch_step(method: IntegrationMethod, stepper: Stepper, pace: Reals) -> None:
    """Count an explicit step as limited by stability or not, by its last two stages (Hairer and Wanner 1996, IV.2)."""
    stages, last = stepper.stages, len(method.b) - 1
    n = len(stepper.hold.held)
    change_of_rates = change = 0.0
    for j in range(2 * n):
        between = 0.0
        for i in range(last + 1):
            between += (method.b[i] - method.a[last, i]) * stages[i, j]
        change += between * between
        change_of_rates += (stages[last + 1, j] - stages[last, j]) ** 2
    is_limited = change_of_rates > LIMITED_STEP * LIMITED_STEP * change
    pace[PACE_LIMITED_STEPS] = max(0.0, pace[PACE_LIMITED_STEPS] + (1.0 if is_limited else -1.0))


@compiled
def watch_stiffness(simulation: Simulation) -> None:
    """Decide whether implicit steps go on with a motion, at its start and where `is_to_be_watched`."""
    pace, record, plan = simulation.pace, simulation.record, simulation.plan
    states, room = record.counts[0], len(record.times)
    pace[PACE_STATES_WATCHED], pace[PACE_LIMITED_STEPS] = states, 0.0
    stable_steps = fastest_rate(simulation) * (plan.end - pace[PACE_TIME]) / STABLE_STEP
    if stable_steps > (STIFF_STEPS_LEFT if states else STIFF_STEPS) or states > RUN_OUT_SHARE * room:
        pace[PACE_STIFF] = 1.0
        record.counts[5] = states
