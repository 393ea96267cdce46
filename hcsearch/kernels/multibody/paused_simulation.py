"""A simulation that is paused between two steps: its state, and how it goes on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import HELD_BY_FRICTION, DiscreteState, Mechanism, accelerate
from hcsearch.kernels.multibody.integrators import IntegrationMethod
from hcsearch.kernels.multibody.recording import SimulationRecord
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.tree import Work

(
    PACE_TIME,
    PACE_STEP,
    PACE_SCALE,
    PACE_GRIP,
    PACE_START_ENERGY,
    PACE_LARGEST_ENERGY,
    PACE_STOPS_KEPT,
    PACE_CROWD_COUNT,
    PACE_CROWD_TIME,
    PACE_EVENT_COUNT,
    PACE_STIFF,
    PACE_STATES_WATCHED,
    PACE_LIMITED_STEPS,
    PACE_IMPLICIT_REJECTIONS,
    PACE_COORDINATES,
) = range(15)
"""Entries of `Simulation.pace`: time and next step size (s); `largest_pivot`; pull above which a stop lets go (N m);
energy at the start, and largest energy (J); whether stops that seemed to pull were kept; number of crowded events, and
time of the last event (s); number of events since a joint last moved away from the reference coordinates, which follow
from `PACE_COORDINATES` on; whether steps are those of the stiff method, and number of states when that was decided;
surplus of steps limited by stability over others since then; number of implicit steps that were rejected."""


class Simulation(NamedTuple):
    """A simulation paused between two steps.

    method, stiff_method : of the steps of motions that are not stiff, and of those that are; the latter takes over for
        good. q, v : (n,), the current state. pace : (PACE_COORDINATES + n,), from `new_pace`.
    """

    mechanism: Mechanism
    hold: DiscreteState
    method: IntegrationMethod
    stiff_method: IntegrationMethod
    plan: StepPlan
    q: Reals
    v: Reals
    work: Work
    pace: Reals
    record: SimulationRecord


@compiled
def new_pace(n: int) -> Reals:
    """Return an uninitialised pace table for a simulation of n joints."""
    return np.empty(PACE_COORDINATES + n)


@compiled
def current_method(simulation: Simulation) -> IntegrationMethod:
    """Return the method of the next step."""
    if simulation.pace[PACE_STIFF] > 0.0:
        return simulation.stiff_method
    return simulation.method


@compiled
def accelerate_simulation(simulation: Simulation, a: Reals) -> None:
    """Write the accelerations of the current state; 0, and not the holding force, where friction holds a joint."""
    mechanism, hold, work = simulation.mechanism, simulation.hold, simulation.work
    accelerate(mechanism, hold, simulation.q, simulation.v, simulation.pace[PACE_SCALE], True, work, a)
    for i in range(len(hold.slides)):
        if hold.held[i] == HELD_BY_FRICTION:
            a[i] = 0.0
