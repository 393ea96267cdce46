"""One step on the closed states in a wanted direction, sliding along contacts and stops without friction.

A step moves each panel as a twist, so that checking a condition takes a few products. Its row, the derivative with
respect to every hinge, is written only for conditions that the step violates.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import (
    Vector3,
    add_vector,
    cross,
    divide_row,
    dot,
    put_vector,
    row_product,
    scaled_vector,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.planning.closed_states import (
    PLANNING_CLOSURE_RESIDUAL,
    close_state,
    largest_closure_residual,
    remove_span,
    write_closure_basis,
)
from hcsearch.kernels.planning.space import (
    PlacedState,
    Space,
    SpaceWork,
    greatest_angle_change,
    greatest_magnitude,
    place_state,
    separated,
)

SPARE_GAP_SHARE = 0.7
"""Share of the spare gap of a corner that one step may use."""
FACE_NORMAL_COSINE = 1.0 - 1e-7
"""Cosine from which a direction counts as the normal of a face."""


@compiled
def near_stops(state: PlacedState, reach: float, work: SpaceWork) -> int:
    """Write the conditions of stops nearer than `reach` (rad); return their number."""
    conditions, count = work.conditions, 0
    for h in range(len(state.angles)):
        for up in range(2):
            spare = math.pi - state.angles[h] if up else state.angles[h]
            if spare < reach:
                conditions.panels[count, 0], conditions.panels[count, 1] = -1, h
                put_vector(conditions.directions, count, 0, (-1.0 if up else 1.0, 0.0, 0.0))
                conditions.bounds[count] = -spare
                count += 1
    return count


@compiled
def near_contacts(space: Space, state: PlacedState, reach: float, count: int, work: SpaceWork) -> int:
    """Append conditions for the corners of pairs nearer than `reach` (m) to `count` others; return the new number.

    The direction of a gap is fixed to the panel of which it is a face's normal, else to the first, and each corner of
    the other panel within a reach of the gap keeps on its side.
    """
    axes = work.axes
    for panel in space.loops.chain.order:
        if space.loops.chain.parents[panel] >= 0:
            h, pose = space.loops.chain.hinges[panel], state.poses[panel]
            u, q = space.loops.chain.directions[h], space.loops.chain.points[h]
            for i in range(3):
                axes[0, h, i] = pose[i, 0] * u[0] + pose[i, 1] * u[1] + pose[i, 2] * u[2]
                axes[1, h, i] = pose[i, 0] * q[0] + pose[i, 1] * q[1] + pose[i, 2] * q[2] + pose[i, 3]
    for p in range(len(space.pairs)):
        if state.gaps[p] <= reach:
            count = _add_pair(space, state, p, reach, count, work)
    return count


@compiled
def _add_pair(space: Space, state: PlacedState, p: int, reach: float, count: int, work: SpaceWork) -> int:
    """Append the conditions of one pair; return the new number."""
    first, second, direction = space.pairs[p, 0], space.pairs[p, 1], vector_at(state.gap_directions, p, 0)
    if not _is_normal(space, state, first, direction) and _is_normal(space, state, second, direction):
        first, second, direction = second, first, scaled_vector(-1.0, direction)
    top = -math.inf
    for j in range(space.prisms.counts[first, 0]):
        top = max(top, dot(direction, vector_at(state.prisms.vertices[first], j, 0)))
    conditions = work.conditions
    for j in range(space.prisms.counts[second, 0]):
        corner = vector_at(state.prisms.vertices[second], j, 0)
        gap = dot(direction, corner) - top
        if gap > state.gaps[p] + reach or count >= len(conditions.bounds):
            continue
        conditions.panels[count, 0] = space.prisms.panels[first]
        conditions.panels[count, 1] = space.prisms.panels[second]
        put_vector(conditions.directions, count, 0, direction)
        put_vector(conditions.corners, count, 0, corner)
        conditions.bounds[count] = SPARE_GAP_SHARE * (space.step_gap - gap)
        count += 1
    return count


@compiled
def move_panels(space: Space, step: Reals, work: SpaceWork) -> None:
    """Write the twist of each panel in a step, about the origin; call `near_contacts` before."""
    chain, twists = space.loops.chain, work.twists
    for panel in chain.order:
        for i in range(6):
            twists[panel, i] = twists[chain.parents[panel], i] if chain.parents[panel] >= 0 else 0.0
        if chain.parents[panel] >= 0:
            h = chain.hinges[panel]
            axis = vector_at(work.axes[0], h, 0)
            turn = chain.signs[panel] * step[h]
            add_vector(twists, panel, 0, scaled_vector(turn, axis))
            add_vector(twists, panel, 3, scaled_vector(turn, cross(vector_at(work.axes[1], h, 0), axis)))


@compiled
def condition_change(step: Reals, k: int, work: SpaceWork) -> float:
    """The change of a corner's gap (m), or of the distance to a stop (rad), in a step; call `move_panels` before."""
    here, there = work.conditions.panels[k, 0], work.conditions.panels[k, 1]
    if here < 0:
        return float(work.conditions.directions[k, 0] * step[there])
    spin = vector_difference(vector_at(work.twists, there, 0), vector_at(work.twists, here, 0))
    shift = vector_difference(vector_at(work.twists, there, 3), vector_at(work.twists, here, 3))
    speed = vector_sum(shift, cross(spin, vector_at(work.conditions.corners, k, 0)))
    return dot(vector_at(work.conditions.directions, k, 0), speed)


@compiled
def write_condition_row(space: Space, k: int, table: Reals, row: int, work: SpaceWork) -> None:
    """Write a condition as a row of a table: (row) . step equals `condition_change`."""
    here, there = work.conditions.panels[k, 0], work.conditions.panels[k, 1]
    direction, corner = vector_at(work.conditions.directions, k, 0), vector_at(work.conditions.corners, k, 0)
    for h in range(len(space.folded)):
        table[row, h] = 0.0
        if here < 0:
            table[row, h] = direction[0] if h == there else 0.0
            continue
        sign = space.across[there, h] - space.across[here, h]
        if sign != 0.0:
            arm = vector_difference(corner, vector_at(work.axes[1], h, 0))
            table[row, h] = sign * dot(direction, cross(vector_at(work.axes[0], h, 0), arm))


@compiled
def _is_normal(space: Space, state: PlacedState, f: int, direction: Vector3) -> bool:
    """Whether a direction is normal to a face of a prism."""
    pose = state.poses[space.prisms.panels[f]]
    x = dot((pose[0, 0], pose[1, 0], pose[2, 0]), direction)
    y = dot((pose[0, 1], pose[1, 1], pose[2, 1]), direction)
    z = dot((pose[0, 2], pose[1, 2], pose[2, 2]), direction)
    for j in range(space.prisms.counts[f, 1]):
        if abs(dot((x, y, z), vector_at(space.prisms.normals[f], j, 0))) > FACE_NORMAL_COSINE:
            return True
    return False


MAX_ASCENT_SWEEPS = 150
"""Greatest number of sweeps over all conditions in a step."""
MAX_CONDITION_ROUNDS = 6
"""Greatest number of times that violated conditions are added to the active ones."""
ASCENT_TOLERANCE = 1e-4
"""Sweeps end when they change the step by no more than this share of its length."""
MIN_CONDITION_NORM = 1e-7
"""A condition whose reduced row is no longer than this is dropped: no free direction changes it."""
MAX_CLOSING_DEVIATION = 0.5
"""Greatest shift of a step's end by the closing of loops, as a share of the step's length."""
MIN_SLIDE_STEP = 2e-5
"""A step that turns no hinge by more than this (rad) counts as none."""


@compiled
def slide(
    space: Space, state: PlacedState, longest: float, zero_singular_value: float, work: SpaceWork, end: PlacedState
) -> float:
    """Step from a state by `work.wanted_step`, no hinge by more than `longest` (rad), and write the state at its end.

    zero_singular_value : singular directions of closure count as free below this. Returns the greatest change of an
    angle, 0 where no step is possible. The step is the one nearest to the wanted one that loops, stops and contacts
    allow (Hildreth's dual coordinate ascent).
    """
    m = len(space.folded)
    largest_closure_residual(space.loops, state.angles, work.closing)
    rank = write_closure_basis(work.closing, zero_singular_value)
    for h in range(m):
        work.allowed_steps[0, h] = work.wanted_step[h]
    remove_span(work.closing.basis, rank, work.allowed_steps, 0)
    greatest = greatest_magnitude(work.allowed_steps[0])
    if greatest < 1e-12:
        return 0.0
    size = longest
    for _ in range(3):
        for h in range(m):
            work.step[h] = work.allowed_steps[1, h] = work.allowed_steps[0, h] * min(1.0, size / greatest)
        _allow(space, state, size, rank, work)
        moved = greatest_magnitude(work.step)
        if moved < max(1e-3 * longest, MIN_SLIDE_STEP):
            return 0.0
        for _ in range(2):
            change = _take(space, state, work, end)
            if change > 0.0:
                return change
            for h in range(m):
                work.step[h] *= 0.4
        size *= 0.25
    return 0.0


@compiled
def _take(space: Space, state: PlacedState, work: SpaceWork, end: PlacedState) -> float:
    """Take the step and close the loops at its end; return the greatest change of an angle, 0 where that fails."""
    for h in range(len(work.trial)):
        work.trial[h] = state.angles[h] + work.step[h]
    if not close_state(space.loops, work.trial, PLANNING_CLOSURE_RESIDUAL, 0.0, 8, work.closing):
        return 0.0
    deviation = length = 0.0
    for h in range(len(work.trial)):
        deviation += (work.trial[h] - state.angles[h] - work.step[h]) ** 2
        length += work.step[h] ** 2
    change = greatest_angle_change(work.trial, state.angles)
    if deviation > MAX_CLOSING_DEVIATION * MAX_CLOSING_DEVIATION * length or change < 0.5 * MIN_SLIDE_STEP:
        return 0.0
    if place_state(space, work.trial, space.min_gap, end) and separated(space, state, end):
        return change
    return 0.0


@compiled
def _allow(space: Space, state: PlacedState, size: float, rank: int, work: SpaceWork) -> None:
    """Replace the step by the nearest one that stops and contacts allow.

    Few conditions are active: violated ones are added and the step is computed again until all hold.
    """
    count = near_contacts(space, state, size * space.lever, near_stops(state, 2.0 * size, work), work)
    for k in range(count):
        work.conditions.order[k] = k
        work.forces[k] = 0.0
    active = 0
    for _ in range(MAX_CONDITION_ROUNDS):
        now_active = _take_in(space, rank, active, count, work)
        if now_active == active:
            return
        active = now_active
        _ascend(active, work)


@compiled
def _take_in(space: Space, rank: int, active: int, count: int, work: SpaceWork) -> int:
    """Add the violated conditions to the active rows, each normalized to unit length; return the number of active rows.

    The free directions of the step are orthogonal to the rows of closure, so the component along these is removed.
    """
    m = len(work.step)
    order, bounds = work.conditions.order, work.conditions.bounds
    move_panels(space, work.step, work)
    for i in range(active, count):
        k = order[i]
        if condition_change(work.step, k, work) >= bounds[k]:
            continue
        order[i], order[active] = order[active], k
        write_condition_row(space, k, work.rows, active, work)
        remove_span(work.closing.basis, rank, work.rows, active)
        norm = math.sqrt(row_product(work.rows, active, work.rows, active, m))
        if norm > MIN_CONDITION_NORM:
            divide_row(work.rows, active, norm, m)
            work.bounds[active] = bounds[k] / norm
            active += 1
        else:
            bounds[k] = -math.inf  # no step changes it
    return active


@compiled
def _ascend(count: int, work: SpaceWork) -> None:
    """Apply the forces of the active conditions to the step until all of these hold."""
    m = len(work.step)
    size = 0.0
    for h in range(m):
        work.step[h] = work.allowed_steps[1, h]
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
