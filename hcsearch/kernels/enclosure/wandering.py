"""Random walks through closed states, which estimate the extent of a component before it is proved."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import Refutation, reaches_closed_state

MAX_WALK_STEP = 0.15
"""Longest step, of the angle that turns most (rad)."""
WALK_RESTART_STEPS = 20
"""Number of steps after which a walk starts again at any of its states."""
WALK_BEND_SHARE = 0.3
"""Random change of direction between steps, relative to their length."""
MAX_STEP_FAILURES, STEP_REDUCTION_FACTOR, STEP_GROWTH_FACTOR = 50, 0.5, 1.5
"""A climb shortens its steps by a factor after this many failures in a row, and lengthens them after each success."""
MIN_WALK_STEP = 1e-3
"""Step length (rad) at which a climb or an approach ends when it makes no progress."""
MAX_GOAL_STEP = 0.1
"""Longest step towards a state (rad): components of the closed states are further apart."""
RANDOM_STEP_SHARE, MAX_RANDOM_GROWTH = 0.5, 7
"""The random part of a step towards a state, as a share of its length; it grows by as much with each failure in a row,
up to MAX_RANDOM_GROWTH times, then starts again."""


@compiled
def random_walk(rings: HingeRings, start: Reals, steps: int, seed: int, work: Refutation) -> Reals:
    """Return the closed states, (m, n), of a random walk of so many steps from a closed state, (n,).

    Panels are clear at them, where they do not pass through each other. A step that leads to no closed state is not
    taken.
    """
    np.random.seed(seed)
    n, count = len(start), 1
    low, high = np.zeros(n), np.full(n, np.pi)
    states = np.zeros((steps + 1, n))
    states[0] = start
    here, direction, state = start.copy(), np.random.standard_normal(n), start.copy()
    for step in range(steps):
        if step % WALK_RESTART_STEPS == 0:
            here[:] = states[np.random.randint(count)]
            direction[:] = np.random.standard_normal(n)
        moved = _step(rings, here, direction, MAX_WALK_STEP, low, high, state, work)
        if moved < 1e-6:
            direction[:] = np.random.standard_normal(n)
            continue
        direction[:] = state - here + WALK_BEND_SHARE * moved * np.random.standard_normal(n)
        here[:] = state
        states[count] = state
        count += 1
    return states[:count]


@compiled
def climb_angles(
    rings: HingeRings, states: Reals, low: Reals, high: Reals, steps: int, seed: int, work: Refutation
) -> Reals:
    """Turn each angle of closed states, (m, n), as far as possible both ways; return them with the states passed.

    low, high : (n,), a box in which climbs stay, and between the stops. steps : greatest number in each climb, which
    begins at the furthest state so far; a step that does not turn the angle further is not taken.
    """
    np.random.seed(seed)
    count, n = states.shape
    high_or_stop = np.minimum(high, np.pi)
    passed = np.zeros((count + 2 * n * steps, n))
    passed[:count] = states
    for hinge in range(n):
        for sign in (-1.0, 1.0):
            count = _climb_along(rings, hinge, sign, low, high_or_stop, steps, count, passed, work)
    return passed[:count]


@compiled
def _climb_along(
    rings: HingeRings, h: int, sign: float, low: Reals, high: Reals, steps: int, n: int, path: Reals, work: Refutation
) -> int:
    """Turn one angle as far as steps lead; return the new number of states passed."""
    here = path[np.argmax(sign * path[:n, h])].copy()
    direction, state = np.random.standard_normal(len(here)), here.copy()
    longest, failures = MAX_WALK_STEP, 0
    for _ in range(steps):
        moved = _step(rings, here, direction, longest, low, high, state, work)
        if moved > 0.0 and sign * (state[h] - here[h]) > 0.0:
            direction[:] = state - here + WALK_BEND_SHARE * moved * np.random.standard_normal(len(here))
            here[:] = state
            path[n] = state
            n += 1
            longest, failures = min(STEP_GROWTH_FACTOR * longest, MAX_WALK_STEP), 0
            continue
        direction[:] = np.random.standard_normal(len(here))
        failures += 1
        if failures == MAX_STEP_FAILURES:
            if longest <= MIN_WALK_STEP:
                break
            longest, failures = max(STEP_REDUCTION_FACTOR * longest, MIN_WALK_STEP), 0
    return n


@compiled
def approach_goal(
    rings: HingeRings, start: Reals, goal: Reals, steps: int, seed: int, work: Refutation
) -> tuple[Reals, int]:
    """Step from one state, (n,), towards another; return the closed states passed, (m, n), and the number of tries.

    Each is nearer to the goal than the one before; the first is the start, and the last the goal, nearly, if steps lead
    there. steps : greatest number of tries.
    """
    np.random.seed(seed)
    n, count, failures, tried = len(start), 1, 0, 0
    low, high, longest = np.zeros(n), np.full(n, np.pi), MAX_GOAL_STEP
    passed = np.zeros((steps + 1, n))
    passed[0] = start
    here, state = start.copy(), start.copy()
    distance = np.sqrt(((goal - here) ** 2).sum())
    while tried < steps and distance >= MIN_WALK_STEP and longest >= MIN_WALK_STEP:
        tried += 1
        astray = RANDOM_STEP_SHARE * (1 + failures % MAX_RANDOM_GROWTH) / np.sqrt(n)
        direction = (goal - here) / distance + astray * np.random.standard_normal(n)
        moved = _step(rings, here, direction, longest, low, high, state, work)
        nearer = np.sqrt(((goal - state) ** 2).sum())
        if 0.0 < moved <= 1.5 * longest and nearer < distance:
            here[:] = state
            passed[count] = state
            count += 1
            distance, longest, failures = nearer, min(STEP_GROWTH_FACTOR * longest, MAX_GOAL_STEP), 0
            continue
        failures += 1
        if failures % MAX_STEP_FAILURES == 0:
            longest *= STEP_REDUCTION_FACTOR
    return passed[:count], tried


@compiled
def _step(
    rings: HingeRings, here: Reals, way: Reals, longest: float, low: Reals, high: Reals, state: Reals, work: Refutation
) -> float:
    """Write the closed state at the end of a step no longer than `longest`; return its distance (rad), 0 without one.

    A state further away than a step may be of another component, and does not count.
    """
    length = longest * np.random.random() / np.abs(way).max()
    state[:] = np.minimum(np.maximum(here + length * way, low), high)
    closed = reaches_closed_state(rings, low, high, state, work)
    moved = np.abs(state - here).max()
    return moved if closed and moved <= 1.5 * MAX_WALK_STEP else 0.0
