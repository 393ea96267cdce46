"""One step on the closed states towards what is wanted: along contacts and stops, without friction."""

from __future__ import annotations

import math

from hcsearch.kernels.algebra.rows import divide_row, row_product
from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.planning.chords import separated
from hcsearch.kernels.planning.closing import (
    PLANNING_CLOSURE_RESIDUAL,
    close_state,
    largest_closure_residual,
    remove_span,
    write_closure_basis,
)
from hcsearch.kernels.planning.contacts import (
    condition_change,
    move_panels,
    near_contacts,
    near_stops,
    write_condition_row,
)
from hcsearch.kernels.planning.space import (
    PlacedState,
    Space,
    SpaceWork,
    greatest_angle_change,
    greatest_magnitude,
    place_state,
)

MAX_ASCENT_SWEEPS = 150
"""Rounds over all conditions of a step."""
MAX_CONDITION_ROUNDS = 6
"""How often conditions are taken in."""
ASCENT_TOLERANCE = 1e-4
"""Rounds end where they change the step by no more than this share."""
MIN_CONDITION_NORM = 1e-7
"""A condition is no condition where the freedoms change it by no more than this."""
MAX_CLOSING_DEVIATION = 0.5
"""Closing may move the end of a step by this share of its length."""
MIN_SLIDE_STEP = 2e-5
"""A step that turns no hinge by more than this (rad) is none."""


@lean
def slide(space: Space, state: PlacedState, longest: float, least: float, work: SpaceWork, end: PlacedState) -> float:
    """Step from a state as `work.want` says, no hinge by more than `longest` (rad); write the state it leads to.

    least : singular directions of closure count as free below this. Returns the greatest change of an angle, 0 where
    nothing moves. The step is the nearest to what is wanted that loops, stops and contacts allow (Hildreth's dual
    coordinate ascent).
    """
    m = len(space.folded)
    largest_closure_residual(space.loops, state.angles, work.closing)
    rank = write_closure_basis(work.closing, least)
    for h in range(m):
        work.wanted[0, h] = work.want[h]
    remove_span(work.closing.basis, rank, work.wanted, 0)
    big = greatest_magnitude(work.wanted[0])
    if big < 1e-12:
        return 0.0
    size = longest
    for _ in range(3):
        for h in range(m):
            work.step[h] = work.wanted[1, h] = work.wanted[0, h] * min(1.0, size / big)
        _allow(space, state, size, rank, work)
        moved = greatest_magnitude(work.step)
        if moved < max(1e-3 * longest, MIN_SLIDE_STEP):
            return 0.0
        for _ in range(2):
            far = _take(space, state, work, end)
            if far > 0.0:
                return far
            for h in range(m):
                work.step[h] *= 0.4
        size *= 0.25
    return 0.0


@lean
def _take(space: Space, state: PlacedState, work: SpaceWork, end: PlacedState) -> float:
    """Take the step, and close its end; the greatest change of an angle, 0 where it cannot be taken."""
    for h in range(len(work.trial)):
        work.trial[h] = state.angles[h] + work.step[h]
    if not close_state(space.loops, work.trial, PLANNING_CLOSURE_RESIDUAL, 0.0, 8, work.closing):
        return 0.0
    off = length = 0.0
    for h in range(len(work.trial)):
        off += (work.trial[h] - state.angles[h] - work.step[h]) ** 2
        length += work.step[h] ** 2
    far = greatest_angle_change(work.trial, state.angles)
    if off > MAX_CLOSING_DEVIATION * MAX_CLOSING_DEVIATION * length or far < 0.5 * MIN_SLIDE_STEP:
        return 0.0
    if place_state(space, work.trial, space.least, end) and separated(space, state, end):
        return far
    return 0.0


@lean
def _allow(space: Space, state: PlacedState, size: float, rank: int, work: SpaceWork) -> None:
    """Replace the step by the nearest that stops and contacts allow.

    Few of the conditions push: those that do not hold are taken in, and the step is computed anew, until all hold.
    """
    count = near_contacts(space, state, size * space.lever, near_stops(state, 2.0 * size, work), work)
    for k in range(count):
        work.conditions.order[k] = k
        work.forces[k] = 0.0
    kept = 0
    for _ in range(MAX_CONDITION_ROUNDS):
        more = _take_in(space, rank, kept, count, work)
        if more == kept:
            return
        kept = more
        _ascend(kept, work)


@lean
def _take_in(space: Space, rank: int, kept: int, count: int, work: SpaceWork) -> int:
    """Add the conditions that do not hold to the rows that were taken in, each of unit length; how many there are now.

    The freedoms of the step lie across the rows of closure, so what lies along those is taken off a condition.
    """
    m = len(work.step)
    order, bounds = work.conditions.order, work.conditions.bounds
    move_panels(space, work.step, work)
    for i in range(kept, count):
        k = order[i]
        if condition_change(work.step, k, work) >= bounds[k]:
            continue
        order[i], order[kept] = order[kept], k
        write_condition_row(space, k, work.rows, kept, work)
        remove_span(work.closing.basis, rank, work.rows, kept)
        long = math.sqrt(row_product(work.rows, kept, work.rows, kept, m))
        if long > MIN_CONDITION_NORM:
            divide_row(work.rows, kept, long, m)
            work.bounds[kept] = bounds[k] / long
            kept += 1
        else:
            bounds[k] = -math.inf  # no step changes it
    return kept


@lean
def _ascend(count: int, work: SpaceWork) -> None:
    """Move the step by forces of the conditions that were taken in until these hold."""
    m = len(work.step)
    size = 0.0
    for h in range(m):
        work.step[h] = work.wanted[1, h]
        size += work.step[h] ** 2
    size = math.sqrt(size)
    for row in range(count):
        for h in range(m):
            work.step[h] += work.forces[row] * work.rows[row, h]
    for _ in range(MAX_ASCENT_SWEEPS):
        worst = 0.0
        for row in range(count):
            push = work.bounds[row]
            for h in range(m):
                push -= work.rows[row, h] * work.step[h]
            push = max(push, -work.forces[row])
            if push != 0.0:
                work.forces[row] += push
                for h in range(m):
                    work.step[h] += push * work.rows[row, h]
                worst = max(worst, abs(push))
        if worst <= ASCENT_TOLERANCE * size:
            return
