"""One step on the closed states towards what is wanted, along contacts and stops, without friction.

A step moves each panel as a twist, so whether a condition holds takes a few products; its row, the derivative by every
hinge, is written for those alone that a step breaks.
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
from hcsearch.kernels.compiling.compiled import lean
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
"""Of the gap that a corner has to spare a step takes up to this."""
FACE_NORMAL_COSINE = 1.0 - 1e-7
"""Cosine from which a direction counts as the normal of a face."""


@lean
def near_stops(state: PlacedState, reach: float, work: SpaceWork) -> int:
    """Write the conditions of stops nearer than `reach` (rad); how many there are."""
    conditions, count = work.conditions, 0
    for h in range(len(state.angles)):
        for up in range(2):
            spare = math.pi - state.angles[h] if up else state.angles[h]
            if spare < reach:
                conditions.panels[count, 0], conditions.panels[count, 1] = -1, h
                put_vector(conditions.ways, count, 0, (-1.0 if up else 1.0, 0.0, 0.0))
                conditions.bounds[count] = -spare
                count += 1
    return count


@lean
def near_contacts(space: Space, state: PlacedState, reach: float, count: int, work: SpaceWork) -> int:
    """Add conditions for the corners of pairs nearer than `reach` (m) to some; how many there are then.

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


@lean
def _add_pair(space: Space, state: PlacedState, p: int, reach: float, count: int, work: SpaceWork) -> int:
    """Add the conditions of one pair."""
    own, other, way = space.pairs[p, 0], space.pairs[p, 1], vector_at(state.ways, p, 0)
    if not _is_normal(space, state, own, way) and _is_normal(space, state, other, way):
        own, other, way = other, own, scaled_vector(-1.0, way)
    top = -math.inf
    for j in range(space.prisms.counts[own, 0]):
        top = max(top, dot(way, vector_at(state.placed.vertices[own], j, 0)))
    conditions = work.conditions
    for j in range(space.prisms.counts[other, 0]):
        corner = vector_at(state.placed.vertices[other], j, 0)
        gap = dot(way, corner) - top
        if gap > state.gaps[p] + reach or count >= len(conditions.bounds):
            continue
        conditions.panels[count, 0], conditions.panels[count, 1] = space.prisms.panels[own], space.prisms.panels[other]
        put_vector(conditions.ways, count, 0, way)
        put_vector(conditions.corners, count, 0, corner)
        conditions.bounds[count] = SPARE_GAP_SHARE * (space.kept - gap)
        count += 1
    return count


@lean
def move_panels(space: Space, step: Reals, work: SpaceWork) -> None:
    """Write the twist of each panel for a step, about the origin; after `near_contacts`."""
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


@lean
def condition_change(step: Reals, k: int, work: SpaceWork) -> float:
    """What a step adds to the gap of a corner (m), or to what is left to a stop (rad); after `move_panels`."""
    here, there = work.conditions.panels[k, 0], work.conditions.panels[k, 1]
    if here < 0:
        return float(work.conditions.ways[k, 0] * step[there])
    spin = vector_difference(vector_at(work.twists, there, 0), vector_at(work.twists, here, 0))
    shift = vector_difference(vector_at(work.twists, there, 3), vector_at(work.twists, here, 3))
    return dot(
        vector_at(work.conditions.ways, k, 0), vector_sum(shift, cross(spin, vector_at(work.conditions.corners, k, 0)))
    )


@lean
def write_condition_row(space: Space, k: int, table: Reals, row: int, work: SpaceWork) -> None:
    """Write a condition as a row of a table: (row) . step is what `condition_change` gives."""
    here, there = work.conditions.panels[k, 0], work.conditions.panels[k, 1]
    way, corner = vector_at(work.conditions.ways, k, 0), vector_at(work.conditions.corners, k, 0)
    for h in range(len(space.folded)):
        table[row, h] = 0.0
        if here < 0:
            table[row, h] = way[0] if h == there else 0.0
            continue
        sign = space.across[there, h] - space.across[here, h]
        if sign != 0.0:
            arm = vector_difference(corner, vector_at(work.axes[1], h, 0))
            table[row, h] = sign * dot(way, cross(vector_at(work.axes[0], h, 0), arm))


@lean
def _is_normal(space: Space, state: PlacedState, f: int, way: Vector3) -> bool:
    """Whether a direction is that of a face of a prism."""
    pose = state.poses[space.prisms.panels[f]]
    x = dot((pose[0, 0], pose[1, 0], pose[2, 0]), way)
    y = dot((pose[0, 1], pose[1, 1], pose[2, 1]), way)
    z = dot((pose[0, 2], pose[1, 2], pose[2, 2]), way)
    for j in range(space.prisms.counts[f, 1]):
        if abs(dot((x, y, z), vector_at(space.prisms.normals[f], j, 0))) > FACE_NORMAL_COSINE:
            return True
    return False


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
