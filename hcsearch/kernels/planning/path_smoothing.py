"""Smoothing of a path: shortcuts, relaxation, and thinning of its states."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.planning.sliding import SPARE_GAP_SHARE, near_contacts, slide, write_condition_row
from hcsearch.kernels.planning.space import (
    PlacedState,
    Space,
    SpaceWork,
    StateStack,
    copy_state,
    greatest_angle_change,
    link_states,
    pick_state,
    place_state,
    separated,
    squared_distance,
)

MAX_SMOOTHING_PIECE = 0.1
"""Longest straight piece (rad)."""
MAX_SMOOTHING_HALVINGS = 9
"""Pieces are halved no more often than this."""
MAX_SHORTCUT_RATIO = 0.999
"""Greatest length of a shortcut over the length of the part of the path that it replaces."""
MAX_RELAXATION_STEP = 0.03
"""Longest step (rad) by which a state of the path is moved."""
SMOOTHING_ZERO_SINGULAR_VALUE = 1e-7
"""Singular values of the closure Jacobian up to this count as zeros."""
STOP_DISTANCE_ANGLE = 0.01
"""Distance (rad) that hinges of the path keep from their stops; less near its ends."""
CONTACT_PUSH_ANGLE = 0.02
"""Step (rad) by which contact moves a state where panels touch."""


@compiled
def shorten_path(
    space: Space, path: Reals, count: int, tries: int, seed: int, stack: StateStack, work: SpaceWork, between: Reals
) -> int:
    """Replace random parts of a path by shorter straight links of states; return the new number of states.

    path : (capacity, m), of which the first `count` rows are the path. between : (k, m), room for a shortcut.
    """
    np.random.seed(seed)
    for _ in range(tries):
        if count < 3:
            break
        i, j = np.random.randint(count), np.random.randint(count)
        i, j = min(i, j), max(i, j)
        if j - i < 2:
            continue
        new = link_states(space, path[i], path[j], MAX_SMOOTHING_PIECE, MAX_SMOOTHING_HALVINGS, stack, work, between)
        if new < 0 or count + new - (j - i - 1) > len(path):
            continue
        before = _length(path[i : j + 1])
        after = math.sqrt(squared_distance(path[i], between[0] if new else path[j]))
        if new:
            after += _length(between[:new]) + math.sqrt(squared_distance(between[new - 1], path[j]))
        if after < MAX_SHORTCUT_RATIO * before:
            rest = path[j:count].copy()
            path[i + 1 : i + 1 + new] = between[:new]
            path[i + 1 + new : i + 1 + new + len(rest)] = rest
            count = i + 1 + new + len(rest)
    return count


@compiled
def _length(states: Reals) -> float:
    """The length of the path through a list of states (rad)."""
    total = 0.0
    for i in range(len(states) - 1):
        total += math.sqrt(squared_distance(states[i], states[i + 1]))
    return total


@compiled
def relax_path(
    space: Space, path: Reals, count: int, sweeps: int, wished_gap: float, stack: StateStack, work: SpaceWork
) -> None:
    """Move the states of a path, in place, towards the middle of their neighbours and away from contact.

    wished_gap : m, gap of shrunk panels up to which contact pushes. A state moves only where panels keep apart at its
    new place and on both adjacent pieces.
    """
    before, here, after, moved = pick_state(stack, 0), pick_state(stack, 1), pick_state(stack, 2), pick_state(stack, 3)
    for _ in range(sweeps):
        place_state(space, path[0], -math.inf, before)
        place_state(space, path[1], -math.inf, here)
        for k in range(1, count - 1):
            place_state(space, path[k + 1], -math.inf, after)
            _want(space, before, here, after, wished_gap, work)
            if slide(space, here, MAX_RELAXATION_STEP, SMOOTHING_ZERO_SINGULAR_VALUE, work, moved) > 0.0 and _fits(
                space, before, moved, after
            ):
                path[k] = moved.angles
                copy_state(moved, here)
            copy_state(here, before)
            copy_state(after, here)


@compiled
def _want(
    space: Space, before: PlacedState, here: PlacedState, after: PlacedState, wished_gap: float, work: SpaceWork
) -> None:
    """Write the wanted step of a state: half-way between its neighbours, panels apart, and hinges off their stops."""
    count = near_contacts(space, here, wished_gap, 0, work)
    push = np.zeros(len(work.wanted_step))
    for k in range(count):
        weight = max(0.0, 1.0 - (space.step_gap - work.conditions.bounds[k] / SPARE_GAP_SHARE) / wished_gap)
        write_condition_row(space, k, work.rows, 0, work)
        for h in range(len(push)):
            push[h] += weight * work.rows[0, h]
    greatest_push = max(np.abs(push).max(), 1e-12)
    contact_share = max(0.0, 1.0 - here.gaps.min() / wished_gap) if len(here.gaps) else 0.0
    stop_distance = min(
        STOP_DISTANCE_ANGLE, 0.1 * min(greatest_angle_change(here.angles, space.folded), np.abs(here.angles).max())
    )
    for h in range(len(push)):
        middle = 0.5 * (before.angles[h] + after.angles[h])
        work.wanted_step[h] = middle - here.angles[h] + CONTACT_PUSH_ANGLE * contact_share * push[h] / greatest_push
        # off the stops, by which pieces between states would overshoot them
        from_upper = here.angles[h] - math.pi + stop_distance
        work.wanted_step[h] += max(0.0, stop_distance - here.angles[h]) - max(0.0, from_upper)


@compiled
def _fits(space: Space, before: PlacedState, here: PlacedState, after: PlacedState) -> bool:
    """Whether the pieces to both neighbours are straight enough, and panels keep apart along them."""
    to_here, on = greatest_angle_change(before.angles, here.angles), greatest_angle_change(here.angles, after.angles)
    if max(to_here, on) > 1.5 * MAX_SMOOTHING_PIECE:
        return False
    return separated(space, before, here) and separated(space, here, after)


@compiled
def thin_path(space: Space, path: Reals, count: int, min_distance: float, stack: StateStack) -> int:
    """Leave out states nearer than a distance (rad) to the one before, where panels stay apart; return the number."""
    last = 0
    before, after = pick_state(stack, 0), pick_state(stack, 1)
    for k in range(1, count):
        if k < count - 1 and greatest_angle_change(path[k], path[last]) < min_distance:
            place_state(space, path[last], -math.inf, before)
            place_state(space, path[k + 1], -math.inf, after)
            if greatest_angle_change(path[last], path[k + 1]) < 1.5 * MAX_SMOOTHING_PIECE and separated(
                space, before, after
            ):
                continue
        last += 1
        path[last] = path[k]
    return last + 1
