"""Straight pieces between closed states: whether panels keep apart beside them, and closed states along them."""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra.vectors import Vector3, dot, scaled_vector, vector_at
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.planning.closed_states import PLANNING_CLOSURE_RESIDUAL, close_state
from hcsearch.kernels.planning.space import (
    PlacedState,
    Space,
    SpaceWork,
    StateStack,
    copy_state,
    greatest_angle_change,
    pick_state,
    place_state,
    squared_distance,
)

MAX_CHORD_DEVIATION = 0.5
"""The closed state half-way along a chord may be off by this share of half its length."""


@lean
def separated(space: Space, one: PlacedState, two: PlacedState) -> bool:
    """Whether every pair has a direction, fixed to one of its panels, that separates it at both states.

    What lies between is left to the proof: this screens.
    """
    moved = space.lever * greatest_angle_change(one.angles, two.angles)
    for p in range(len(space.pairs)):
        if one.gaps[p] + two.gaps[p] > moved:
            continue
        if not (_separates(space, one, two, p) or _separates(space, two, one, p)):
            return False
    return True


@lean
def _separates(space: Space, one: PlacedState, two: PlacedState, p: int) -> bool:
    """Whether the direction of a pair's gap at a state, fixed to either panel, has a gap at another state, too."""
    f, g = space.pairs[p, 0], space.pairs[p, 1]
    way = vector_at(one.ways, p, 0)
    for _ in range(2):
        a, b = one.poses[space.prisms.panels[f]], two.poses[space.prisms.panels[f]]
        x = dot((a[0, 0], a[1, 0], a[2, 0]), way)
        y = dot((a[0, 1], a[1, 1], a[2, 1]), way)
        z = dot((a[0, 2], a[1, 2], a[2, 2]), way)
        turned = (
            dot((b[0, 0], b[0, 1], b[0, 2]), (x, y, z)),
            dot((b[1, 0], b[1, 1], b[1, 2]), (x, y, z)),
            dot((b[2, 0], b[2, 1], b[2, 2]), (x, y, z)),
        )
        if _gap(space, two, f, g, turned) >= space.parted:
            return True
        f, g, way = g, f, scaled_vector(-1.0, way)
    return False


@lean
def _gap(space: Space, state: PlacedState, f: int, g: int, way: Vector3) -> float:
    """The gap of two prisms along a direction from the first to the second."""
    top, low = -math.inf, math.inf
    for j in range(space.prisms.counts[f, 0]):
        top = max(top, dot(way, vector_at(state.placed.vertices[f], j, 0)))
    for j in range(space.prisms.counts[g, 0]):
        low = min(low, dot(way, vector_at(state.placed.vertices[g], j, 0)))
    return low - top


@compiled
def link_states(
    space: Space, one: Reals, two: Reals, longest: float, depth: int, stack: StateStack, work: SpaceWork, between: Reals
) -> int:
    """Write closed states between two beside the straight piece, in order, without the ends; how many, -1 where not.

    longest : rad, pieces that turn a hinge by more are halved. depth : how often a piece may be halved; the stack has
    two states more. The state half-way must be closed near its place, and panels keep apart at all states.
    """
    left, right = pick_state(stack, 0), pick_state(stack, 1)
    if not (place_state(space, one, space.least, left) and place_state(space, two, space.least, right)):
        return -1
    top, count = 1, 0
    while top > 0:
        right = pick_state(stack, top)
        if greatest_angle_change(left.angles, right.angles) <= longest and separated(space, left, right):
            if top > 1:
                if count == len(between):
                    return -1
                between[count] = right.angles
                count += 1
                copy_state(right, left)
            top -= 1
        elif top > depth or not _half_way(space, left, right, work, pick_state(stack, top + 1)):
            return -1
        else:
            top += 1
    return count


@compiled
def _half_way(space: Space, left: PlacedState, right: PlacedState, work: SpaceWork, middle: PlacedState) -> bool:
    """Write the closed state half-way between two, and whether it is near its place and panels keep apart there."""
    for h in range(len(work.trial)):
        work.trial[h] = 0.5 * (left.angles[h] + right.angles[h])
    if not close_state(space.loops, work.trial, PLANNING_CLOSURE_RESIDUAL, 0.0, 12, work.closing):
        return False
    off = 0.0
    for h in range(len(work.trial)):
        off += (work.trial[h] - 0.5 * (left.angles[h] + right.angles[h])) ** 2
    if off > MAX_CHORD_DEVIATION * MAX_CHORD_DEVIATION * 0.25 * squared_distance(left.angles, right.angles):
        return False
    return place_state(space, work.trial, space.least, middle)
