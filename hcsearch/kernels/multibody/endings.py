"""Endings of simulations: where time is up, nothing moves any more, or numbers fail."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import Mechanism
from hcsearch.kernels.multibody.paused_simulation import (
    PACE_COORDINATES,
    PACE_CROWD_COUNT,
    PACE_EVENT_COUNT,
    PACE_IMPLICIT_REJECTIONS,
    PACE_LARGEST_ENERGY,
    PACE_SCALE,
    PACE_START_ENERGY,
    PACE_STEP,
    PACE_TIME,
    Simulation,
    accelerate_simulation,
)
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.sticking import frictionless_acceleration, nothing_moves, only_creeps

ENDING_NONE = -1
(
    ENDING_TIME_OUT,
    ENDING_FLAT,
    ENDING_REST,
    ENDING_TOO_MANY_STEPS,
    ENDING_SMALL_STEP,
    ENDING_OPEN,
    ENDING_INVALID_NUMBER,
    ENDING_UNBALANCED,
    ENDING_JAMMED,
    ENDING_STUCK,
    ENDING_SINGULAR,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
"""Endings of a simulation, in this order: time is up; flat; at rest elsewhere; out of steps; step size too small; loops
could not be closed; a number is not finite; the energy balance is violated; jammed, with event after event at stops and
hardly any motion; stuck, where friction holds what would else move; singular, where rounding limits implicit steps."""

MAX_CROWDED_EVENTS, CROWDED_TIME_SHARE = 40, 1e-6
"""A motion counts as jammed after this many successive events, each within this share of the simulated time after the
one before: the loops drive joints that can hardly move against their stops, as at a dead point."""
MAX_UNMOVED_EVENTS, UNMOVED_JOINT_ANGLE = 100, 1e-3
"""A motion also counts as jammed after this many events and releases during which no joint has moved by more than this
angle (rad) at the end of a step; with restitution e, after 1 / (1 - e) times as many, as a step may span a bounce.
Motions of 14 squares that come flat have at most 34."""
SINGULAR_REJECTION_SHARE = 0.3
"""Implicit steps are limited by rounding, as near singular states, where more than this share of them are rejected: of
those that a record holds, at any time, or of those that were taken, when it is full. Smooth motions have under 0.1."""
MAX_BALANCE_ERROR = 1e-2
"""Error of the energy balance, as a share of the largest energy, at which a simulation is aborted."""
OPEN_LOOP_RESIDUAL = 1e-3
"""Closure residual after projection at which loops count as open."""


@compiled
def update_pace(pace: Reals, q: Reals, energies: Reals) -> None:
    """Update the largest energy; restart the count of events when a joint has moved by `UNMOVED_JOINT_ANGLE`."""
    moved = False
    for i in range(len(q)):
        moved = moved or abs(q[i] - pace[PACE_COORDINATES + i]) > UNMOVED_JOINT_ANGLE
    if moved:
        pace[PACE_EVENT_COUNT] = 0.0
        for i in range(len(q)):
            pace[PACE_COORDINATES + i] = q[i]
    for i in range(len(energies)):
        pace[PACE_LARGEST_ENERGY] = max(pace[PACE_LARGEST_ENERGY], abs(energies[i]))


@compiled
def ending_after(
    mechanism: Mechanism, plan: StepPlan, residual: float, flat: bool, pace: Reals, energies: Reals
) -> int:
    """Return the ending reached after a step, or `ENDING_NONE`."""
    limit = OPEN_LOOP_RESIDUAL if mechanism.closure_stiffness == 0.0 else np.inf
    unmoved = pace[PACE_EVENT_COUNT] * (1.0 - plan.restitution) > MAX_UNMOVED_EVENTS
    ending = ENDING_NONE
    if not residual <= limit:
        ending = ENDING_OPEN if residual > limit else ENDING_INVALID_NUMBER
    elif not abs(energies.sum() - pace[PACE_START_ENERGY]) <= MAX_BALANCE_ERROR * pace[PACE_LARGEST_ENERGY]:
        ending = ENDING_UNBALANCED
    elif pace[PACE_CROWD_COUNT] > MAX_CROWDED_EVENTS or unmoved:
        ending = ENDING_JAMMED
    elif flat:
        ending = ENDING_FLAT
    return ending


@compiled
def ending_before(simulation: Simulation, a: Reals) -> int:
    """Return the ending reached before a step, or `ENDING_NONE`."""
    hold, plan, pace, record = simulation.hold, simulation.plan, simulation.pace, simulation.record
    q, v, time = simulation.q, simulation.v, pace[PACE_TIME]
    is_flat = plan.flat_distance >= 0.0
    for i in range(len(q)):
        is_flat = is_flat and not abs(q[i] - plan.flat[i]) > plan.flat_distance
    is_slow = is_at_rest = plan.rest_distance >= 0.0
    time_left = max(1.0, plan.end - time)  # a slow motion with much time left is not at rest
    for i in range(len(q)):
        is_slow = is_slow and (hold.held[i] != 0 or abs(v[i]) * time_left <= plan.rest_distance)
        is_at_rest = is_at_rest and is_slow and (hold.held[i] != 0 or abs(a[i]) * time_left**2 <= plan.rest_distance)
    is_stuck = False
    mechanism = simulation.mechanism
    frees = len(mechanism.targets.joints) + len(mechanism.hinges.factors)  # drives and laws that rise free what sticks
    can_stick = len(hold.slides) > 0 and frees == 0
    if can_stick and (is_slow or not hold.slides.any()):
        is_stuck = _is_stuck(simulation, is_slow, is_at_rest, a)
    ending = ENDING_NONE
    if is_flat:
        ending = ENDING_FLAT
    elif time >= plan.end * (1.0 - 1e-14):
        ending = ENDING_TIME_OUT
    elif is_stuck:
        ending = ENDING_STUCK
    elif is_at_rest:
        ending = ENDING_REST
    elif _rounding_limits_steps(simulation):
        ending = ENDING_SINGULAR
    elif record.counts[0] >= len(record.times):
        ending = ENDING_TOO_MANY_STEPS
    elif pace[PACE_STEP] < 1e-15 * max(time, 1e-3 * plan.end):
        ending = ENDING_SMALL_STEP
    return ending


@compiled
def _rounding_limits_steps(simulation: Simulation) -> bool:
    """Return whether so many steps of the stiff method were rejected that their errors must be rounding errors.

    Not where implicit steps were asked for: a method that is given goes on to its last step.
    """
    counts, room = simulation.record.counts, len(simulation.record.times)
    steps = room - counts[5] if counts[0] >= room else room
    rejected = simulation.pace[PACE_IMPLICIT_REJECTIONS]
    limits: bool = counts[5] >= 0 and rejected > SINGULAR_REJECTION_SHARE * steps
    return limits


@compiled
def _is_stuck(simulation: Simulation, is_slow: bool, is_at_rest: bool, a: Reals) -> bool:
    """Return whether all joints are at rest, or creep towards it, and some would move without friction.

    is_slow : whether no joint would move by more than the plan's distance at its rate. is_at_rest : nor by its
        acceleration; else joints must not move at all, or creep.
    """
    mechanism, hold, plan, pace = simulation.mechanism, simulation.hold, simulation.plan, simulation.pace
    q, v, scale, work, slow = simulation.q, simulation.v, pace[PACE_SCALE], simulation.work, plan.min_bounce_speed
    time_left = max(1.0, plan.end - pace[PACE_TIME])
    is_still = is_at_rest or nothing_moves(mechanism, hold, slow, q, v, scale, work)
    if not is_still and is_slow:
        is_still = only_creeps(mechanism, hold, slow, q, plan.rest_distance / time_left, scale, work)
    least = max(0.0, plan.rest_distance) / time_left**2
    is_stuck = is_still and frictionless_acceleration(mechanism, hold, slow, q, scale, work) > least
    accelerate_simulation(simulation, a)  # tables of the current state, for the projection that follows
    return is_stuck
