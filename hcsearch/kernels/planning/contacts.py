"""Conditions of contact on a small step: no corner of a near pair comes nearer than it may."""

from __future__ import annotations

import math

from hcsearch.kernels.compiled import lean
from hcsearch.kernels.multibody.vectors import Vector, at, cross, dot, minus, times
from hcsearch.kernels.planning.space import Space, State, Work

SHARE = 0.7
"""Of the gap that a corner has to spare a step takes up to this."""
FACING = 1.0 - 1e-7
"""Cosine from which a direction counts as the normal of a face."""


@lean
def contact_rows(space: Space, state: State, reach: float, count: int, work: Work) -> int:
    """Add conditions (row) . step >= bound for the corners of pairs nearer than `reach`; how many rows there are now.

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
            count = _pair_rows(space, state, p, reach, count, work)
    return count


@lean
def _pair_rows(space: Space, state: State, p: int, reach: float, count: int, work: Work) -> int:
    """Add the conditions of one pair."""
    own, other, way = space.pairs[p, 0], space.pairs[p, 1], at(state.ways, p, 0)
    if not _is_normal(space, state, own, way) and _is_normal(space, state, other, way):
        own, other, way = other, own, times(-1.0, way)
    top = -math.inf
    for j in range(space.prisms.counts[own, 0]):
        top = max(top, dot(way, at(state.placed.vertices[own], j, 0)))
    here, there = space.prisms.panels[own], space.prisms.panels[other]
    for j in range(space.prisms.counts[other, 0]):
        corner = at(state.placed.vertices[other], j, 0)
        gap = dot(way, corner) - top
        if gap > state.gaps[p] + reach or count >= len(work.bounds):
            continue
        for h in range(len(space.folded)):
            sign = space.across[there, h] - space.across[here, h]
            value = 0.0
            if sign != 0.0:
                value = sign * dot(way, cross(at(work.axes[0], h, 0), minus(corner, at(work.axes[1], h, 0))))
            work.rows[count, h] = value
        work.bounds[count] = SHARE * (space.kept - gap)
        count += 1
    return count


@lean
def _is_normal(space: Space, state: State, f: int, way: Vector) -> bool:
    """Whether a direction is that of a face of a prism."""
    pose = state.poses[space.prisms.panels[f]]
    x = dot((pose[0, 0], pose[1, 0], pose[2, 0]), way)
    y = dot((pose[0, 1], pose[1, 1], pose[2, 1]), way)
    z = dot((pose[0, 2], pose[1, 2], pose[2, 2]), way)
    for j in range(space.prisms.counts[f, 1]):
        if abs(dot((x, y, z), at(space.prisms.normals[f], j, 0))) > FACING:
            return True
    return False
