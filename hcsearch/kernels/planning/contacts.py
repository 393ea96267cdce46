"""Conditions on a small step: no corner of a near pair comes nearer than it may, and no hinge turns beyond its stops.

A step moves each panel as a twist, so whether a condition holds takes a few products; its row, the derivative by every
hinge, is written for those alone that a step breaks.
"""

from __future__ import annotations

import math

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.algebra.vectors import (
    Vector3,
    add_vector,
    cross,
    dot,
    put_vector,
    scaled_vector,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.planning.space import PlacedState, Space, SpaceWork

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
