"""Closed states of a linkage whose panels keep apart: single states, and straight pieces between two states."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, dot, put_vector, scaled_vector, vector_at
from hcsearch.kernels.collision.gjk import hull_gap
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import place_panels
from hcsearch.kernels.linkage.prisms import Prisms, place_prisms, sphere_distance
from hcsearch.kernels.planning.closed_states import PLANNING_CLOSURE_RESIDUAL, Closing, Loops, close_state, new_closing

CONDITIONS_PER_HINGE = 24
"""Contact conditions per hinge that a step takes into account."""


class Space(NamedTuple):
    """The linkage whose motion is planned.

    loops : its loops and its tree. folded : (m,), fold angles of the packed state; the flat state has 0.
    across : (n_panels, m), +1 or -1 where a hinge lies between the base and a panel, in the sense in which it is
        crossed, else 0.
    prisms : the panels, shrunk by the margin. pairs : (p, 2), those that must keep apart.
    lever : m, greatest distance that a point moves where one hinge turns by 1 rad. measured_distance : m, pairs further
    apart are not measured. min_gap : m, of shrunk panels in every state. step_gap : m, that a step leaves.
    parting_gap : m, that one direction has at both ends of a chord.
    """

    loops: Loops
    folded: Reals
    across: Reals
    prisms: Prisms
    pairs: WholeNumbers
    lever: float
    measured_distance: float
    min_gap: float
    step_gap: float
    parting_gap: float


class PlacedState(NamedTuple):
    """A state with the gaps of its pairs.

    angles : (m,). poses : (n_panels, 3, 4). prisms : placed at these poses. gaps : (p,), m. gap_directions : (p, 3), of
    each gap, from the first prism to the second. corners : (p, 4), where the search of each gap ended.
    """

    angles: Reals
    poses: Reals
    prisms: Prisms
    gaps: Reals
    gap_directions: Reals
    corners: WholeNumbers


class StateStack(NamedTuple):
    """Several states: tables of all that moves, with one row for each state; the rest of the prisms is shared."""

    angles: Reals
    poses: Reals
    prisms: Prisms
    vertices: Reals
    middles: Reals
    gaps: Reals
    gap_directions: Reals
    corners: WholeNumbers


class StepConditions(NamedTuple):
    """Linear conditions on a step, see `kernels.planning.sliding`.

    panels : (k, 2), a panel, and the other one of which a corner must not come nearer; -1 and the hinge, for a stop.
    directions : (k, 3), of the gap; +1 or -1 and zeros, for a stop: the sense in which the hinge leaves it. corners :
    (k, 3), m. bounds : (k,), least change of the gap (m), or of the distance to a stop (rad). order : (k,), in which
    conditions become active.
    """

    panels: WholeNumbers
    directions: Reals
    corners: Reals
    bounds: Reals
    order: WholeNumbers


class SpaceWork(NamedTuple):
    """Work tables that the kernels share.

    closing : of the loops. wanted_step, step, trial : (m,). allowed_steps : (2, m), the projection of the wanted step
    onto the closed directions, and that limited in length. axes : (2, m, 3), directions of the hinges, and points on
    them. twists : (n_panels, 6), of panels in a step. conditions : on a step; rows, bounds, forces : (k, m), (k,),
    (k,), of the active ones, (row) . step >= bound.
    """

    closing: Closing
    wanted_step: Reals
    step: Reals
    trial: Reals
    allowed_steps: Reals
    axes: Reals
    twists: Reals
    conditions: StepConditions
    rows: Reals
    bounds: Reals
    forces: Reals


@compiled
def new_state_stack(space: Space, count: int) -> StateStack:
    """Return states that are not placed yet."""
    m, n, p = len(space.folded), len(space.loops.chain.order), len(space.pairs)
    f, v, _ = space.prisms.vertices.shape
    return StateStack(
        np.zeros((count, m)),
        np.zeros((count, n, 3, 4)),
        space.prisms,
        np.zeros((count, f, v, 3)),
        np.zeros((count, f, 3)),
        np.zeros((count, p)),
        np.zeros((count, p, 3)),
        np.full((count, p, 4), -1),
    )


@compiled
def pick_state(stack: StateStack, i: int) -> PlacedState:
    """Return one state of a stack."""
    shared = stack.prisms
    placed = Prisms(
        shared.panels, shared.counts, stack.vertices[i], stack.middles[i], shared.reaches, shared.normals, shared.edges
    )
    return PlacedState(
        stack.angles[i], stack.poses[i], placed, stack.gaps[i], stack.gap_directions[i], stack.corners[i]
    )


@compiled
def copy_state(state: PlacedState, target: PlacedState) -> None:
    """Copy a placed state."""
    for h in range(len(state.angles)):
        target.angles[h] = state.angles[h]
    for panel in range(len(state.poses)):
        for i in range(3):
            for j in range(4):
                target.poses[panel, i, j] = state.poses[panel, i, j]
    for f in range(len(state.prisms.middles)):
        for i in range(3):
            target.prisms.middles[f, i] = state.prisms.middles[f, i]
            for j in range(state.prisms.counts[f, 0]):
                target.prisms.vertices[f, j, i] = state.prisms.vertices[f, j, i]
    for p in range(len(state.gaps)):
        target.gaps[p] = state.gaps[p]
        for i in range(3):
            target.gap_directions[p, i] = state.gap_directions[p, i]
        for i in range(4):
            target.corners[p, i] = state.corners[p, i]


@compiled
def new_space_work(space: Space) -> SpaceWork:
    """Return empty tables."""
    m = len(space.folded)
    k = (2 + CONDITIONS_PER_HINGE) * m
    closing, wanted, axes = new_closing(space.loops), np.zeros((2, m)), np.zeros((2, m, 3))
    twists = np.zeros((len(space.loops.chain.order), 6))
    whole, directions = np.zeros((k, 2), np.int64), np.zeros((k, 3))
    conditions = StepConditions(whole, directions, np.zeros((k, 3)), np.zeros(k), np.zeros(k, np.int64))
    # seldom more than a few of these rows are written: memory that nobody writes to is not taken
    rows, bounds, forces = np.empty((k, m)), np.zeros(k), np.zeros(k)
    return SpaceWork(
        closing, np.zeros(m), np.zeros(m), np.zeros(m), wanted, axes, twists, conditions, rows, bounds, forces
    )


@compiled
def place_state(space: Space, angles: Reals, enough: float, state: PlacedState) -> bool:
    """Write a state; return whether all gaps are at least `enough`. Gaps after the first smaller one are left out."""
    for h in range(len(angles)):
        state.angles[h] = angles[h]
    place_panels(space.loops.chain, state.angles, state.poses)
    place_prisms(space.prisms, state.poses, state.prisms)
    for p in range(len(space.pairs)):
        f, g = space.pairs[p, 0], space.pairs[p, 1]
        gap = sphere_distance(state.prisms, f, g)
        if gap > space.measured_distance:
            direction = _between(state.prisms, f, g)
        else:
            guess = vector_at(state.gap_directions, p, 0)
            corners = (state.corners[p, 0], state.corners[p, 1], state.corners[p, 2], state.corners[p, 3])
            first, second = state.prisms.vertices[f], state.prisms.vertices[g]
            gap, direction, corners = hull_gap(
                first, space.prisms.counts[f, 0], second, space.prisms.counts[g, 0], guess, corners
            )
            state.corners[p, 0], state.corners[p, 1], state.corners[p, 2], state.corners[p, 3] = corners
        state.gaps[p] = gap
        put_vector(state.gap_directions, p, 0, direction)
        if gap < enough:
            return False
    return True


@compiled
def _between(placed: Prisms, f: int, g: int) -> tuple[float, float, float]:
    """The unit direction from the middle of one prism to that of another."""
    x = placed.middles[g, 0] - placed.middles[f, 0]
    y = placed.middles[g, 1] - placed.middles[f, 1]
    z = placed.middles[g, 2] - placed.middles[f, 2]
    return scaled_vector(1.0 / math.sqrt(x * x + y * y + z * z), (x, y, z))


@compiled
def greatest_angle_change(first: Reals, second: Reals) -> float:
    """The greatest difference of an angle between two states (rad)."""
    greatest = 0.0
    for h in range(len(first)):
        greatest = max(greatest, abs(first[h] - second[h]))
    return greatest


@compiled
def greatest_magnitude(values: Reals) -> float:
    """The greatest absolute value."""
    greatest = 0.0
    for value in values:
        greatest = max(greatest, abs(value))
    return greatest


@compiled
def squared_distance(first: Reals, second: Reals) -> float:
    """The squared distance of two states (rad^2)."""
    total = 0.0
    for h in range(len(first)):
        total += (first[h] - second[h]) ** 2
    return total


MAX_CHORD_DEVIATION = 0.5
"""Greatest deviation of the closed state half-way along a chord, as a share of half the chord's length."""


@compiled
def separated(space: Space, first: PlacedState, second: PlacedState) -> bool:
    """Whether every pair has a direction, fixed to one of its panels, that separates it at both states.

    This is only a filter: states in between are checked by the proof.
    """
    moved = space.lever * greatest_angle_change(first.angles, second.angles)
    for p in range(len(space.pairs)):
        if first.gaps[p] + second.gaps[p] > moved:
            continue
        if not (_separates(space, first, second, p) or _separates(space, second, first, p)):
            return False
    return True


@compiled
def _separates(space: Space, first: PlacedState, second: PlacedState, p: int) -> bool:
    """Whether the gap direction of a pair at one state, fixed to either panel, also separates it at another state."""
    f, g = space.pairs[p, 0], space.pairs[p, 1]
    direction = vector_at(first.gap_directions, p, 0)
    for _ in range(2):
        a, b = first.poses[space.prisms.panels[f]], second.poses[space.prisms.panels[f]]
        x = dot((a[0, 0], a[1, 0], a[2, 0]), direction)
        y = dot((a[0, 1], a[1, 1], a[2, 1]), direction)
        z = dot((a[0, 2], a[1, 2], a[2, 2]), direction)
        way = (x, y, z)
        turned = (dot(vector_at(b, 0, 0), way), dot(vector_at(b, 1, 0), way), dot(vector_at(b, 2, 0), way))
        if _gap(space, second, f, g, turned) >= space.parting_gap:
            return True
        f, g, direction = g, f, scaled_vector(-1.0, direction)
    return False


@compiled
def _gap(space: Space, state: PlacedState, f: int, g: int, direction: Vector3) -> float:
    """The gap of two prisms along a direction, from the first prism to the second."""
    highest, lowest = -math.inf, math.inf
    for j in range(space.prisms.counts[f, 0]):
        highest = max(highest, dot(direction, vector_at(state.prisms.vertices[f], j, 0)))
    for j in range(space.prisms.counts[g, 0]):
        lowest = min(lowest, dot(direction, vector_at(state.prisms.vertices[g], j, 0)))
    return lowest - highest


@compiled
def link_states(
    space: Space, start: Reals, end: Reals, longest: float, depth: int, stack: StateStack, work: SpaceWork, found: Reals
) -> int:
    """Write closed states along the straight piece between two states, in order, without its ends; return their number.

    longest : rad, pieces that turn a hinge by more are halved. depth : how often a piece may be halved; the stack has
    two states more. The state half-way must be closed near its place, and panels keep apart at all states. -1 where the
    states cannot be linked.
    """
    left, right = pick_state(stack, 0), pick_state(stack, 1)
    if not (place_state(space, start, space.min_gap, left) and place_state(space, end, space.min_gap, right)):
        return -1
    top, count = 1, 0
    while top > 0:
        right = pick_state(stack, top)
        if greatest_angle_change(left.angles, right.angles) <= longest and separated(space, left, right):
            if top > 1:
                if count == len(found):
                    return -1
                found[count] = right.angles
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
    """Write the closed state half-way between two; return whether it is near the midpoint and panels keep apart."""
    for h in range(len(work.trial)):
        work.trial[h] = 0.5 * (left.angles[h] + right.angles[h])
    if not close_state(space.loops, work.trial, PLANNING_CLOSURE_RESIDUAL, 0.0, 12, work.closing):
        return False
    deviation = 0.0
    for h in range(len(work.trial)):
        deviation += (work.trial[h] - 0.5 * (left.angles[h] + right.angles[h])) ** 2
    if deviation > MAX_CHORD_DEVIATION * MAX_CHORD_DEVIATION * 0.25 * squared_distance(left.angles, right.angles):
        return False
    return place_state(space, work.trial, space.min_gap, middle)
