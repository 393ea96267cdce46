"""Signed gaps between panels at many states: distances of their prisms, or negative depths of overlap."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, dot, vector_at
from hcsearch.kernels.collision.gjk import gap_along, hull_gap
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import Prisms, copy_prisms, place_prisms, sphere_distance, turn_axes

OVERLAP_PARALLEL_ANGLE = 1e-6
"""Edges at a smaller angle (rad) count as parallel and define no separating axis."""


@compiled
def first_overlap(
    chain: Chain, prisms: Prisms, pairs: WholeNumbers, states: Reals, allowed: float, depths: Reals
) -> int:
    """Return the first state at which a pair of prisms overlaps more than allowed; -1 without one.

    pairs : (p, 2), prisms. states : (k, n_hinges), fold angles. depths : (p,), overlaps in that state, written; 0 for
        pairs whose enclosing spheres are apart.
    """
    placed = copy_prisms(prisms)
    poses = np.empty((len(chain.order), 3, 4))
    last = np.zeros(len(pairs), np.int64)
    for k in range(len(states)):
        place_panels(chain, states[k], poses)
        place_prisms(prisms, poses, placed)
        for f in range(len(prisms.panels)):
            turn_axes(prisms, poses, placed, f)
        for p in range(len(pairs)):
            if prism_overlap(placed, pairs[p, 0], pairs[p, 1], allowed, last, p) > allowed:
                for r in range(len(pairs)):
                    depths[r] = max(0.0, prism_overlap(placed, pairs[r, 0], pairs[r, 1], -math.inf, last, r))
                return k
    return -1


@compiled
def deepest_overlap(chain: Chain, prisms: Prisms, pairs: WholeNumbers, states: Reals) -> float:
    """Return the greatest overlap of pairs of prisms over all states, 0 where they only touch.

    Depths are measured as in `first_overlap`.
    """
    placed = copy_prisms(prisms)
    poses = np.empty((len(chain.order), 3, 4))
    last = np.zeros(len(pairs), np.int64)
    deepest = 0.0
    for k in range(len(states)):
        place_panels(chain, states[k], poses)
        place_prisms(prisms, poses, placed)
        for f in range(len(prisms.panels)):
            turn_axes(prisms, poses, placed, f)
        for p in range(len(pairs)):
            deepest = max(deepest, prism_overlap(placed, pairs[p, 0], pairs[p, 1], deepest, last, p))
    return deepest


@compiled
def prism_overlap(prisms: Prisms, first: int, second: int, enough: float, last: WholeNumbers, pair: int) -> float:
    """Return the least overlap of two prisms along all separating axes, or any overlap that is at most `enough`.

    last : of each pair, the axis that settled it last, which is tried first; updated.
    """
    if sphere_distance(prisms, first, second) >= 0.0:
        return 0.0
    least_overlap = _along(prisms, first, second, last[pair])
    if least_overlap <= enough:
        return least_overlap
    first_axes, second_axes = prisms.counts[first, 1], prisms.counts[second, 1]
    for number in range(first_axes + second_axes + first_axes * second_axes):
        depth = _along(prisms, first, second, number)
        least_overlap = min(least_overlap, depth)
        if least_overlap <= enough:
            last[pair] = number
            return least_overlap
    return least_overlap


@compiled
def _along(prisms: Prisms, first: int, second: int, number: int) -> float:
    """Return the overlap along a numbered axis: normals of the first, of the second, cross products of edges."""
    first_axes, second_axes = prisms.counts[first, 1], prisms.counts[second, 1]
    if number < first_axes:
        x, y, z = prisms.normals[first, number]
    elif number < first_axes + second_axes:
        x, y, z = prisms.normals[second, number - first_axes]
    else:
        s, t, u = prisms.edges[first, (number - first_axes - second_axes) // second_axes]
        e, f, g = prisms.edges[second, (number - first_axes - second_axes) % second_axes]
        x, y, z = t * g - u * f, u * e - s * g, s * f - t * e
        length = math.sqrt(x * x + y * y + z * z)
        if length < OVERLAP_PARALLEL_ANGLE:
            return math.inf
        x, y, z = x / length, y / length, z / length
    low, high = _extent(prisms, first, (x, y, z))
    second_low, second_high = _extent(prisms, second, (x, y, z))
    return min(high - second_low, second_high - low)


@compiled
def _extent(prisms: Prisms, f: int, direction: Vector3) -> tuple[float, float]:
    """Return the extent of a prism along a direction, lowest and highest, from its bottom vertices and its height."""
    low, high = math.inf, -math.inf
    half = prisms.counts[f, 0] // 2
    for k in range(half):
        coordinate = dot(direction, vector_at(prisms.vertices[f], k, 0))
        low, high = min(low, coordinate), max(high, coordinate)
    height = dot(direction, vector_at(prisms.vertices[f], half, 0)) - dot(
        direction, vector_at(prisms.vertices[f], 0, 0)
    )
    return low + min(height, 0.0), high + max(height, 0.0)


class PanelPairs(NamedTuple):
    """Pairs of panels, each with the pairs of their prisms.

    prisms : (q, 2). starts : (p + 1,), pair k of panels has the pairs of prisms `starts[k]` to `starts[k + 1] - 1`.
    """

    prisms: WholeNumbers
    starts: WholeNumbers


class _Memory(NamedTuple):
    """Results of the last state, from which searches in the next state start.

    gaps, directions, corners : (q,), (q, 3), (q, 4), of `hull_gap` for pairs of prisms. axes : (q,), of
        `prism_overlap`. nearest : (p,), nearest pair of prisms for each pair of panels.
    turned : (f,), whether the axes of a prism have been rotated to this state.
    """

    gaps: Reals
    directions: Reals
    corners: WholeNumbers
    axes: WholeNumbers
    nearest: WholeNumbers
    turned: Flags


@compiled
def gaps_at(
    chain: Chain, prisms: Prisms, pairs: PanelPairs, states: Reals, reach: float, allowed: float, gaps: Reals
) -> None:
    """Write the gaps of pairs of panels at states: the least distance of their prisms, or minus their overlap.

    states : (k, n_hinges), fold angles. reach : for gaps beyond it, only a lower bound, also beyond it, is written.
    allowed : overlaps up to this depth count as touching, gap 0. gaps : (k, p), written.
    """
    placed = copy_prisms(prisms)
    poses = np.empty((len(chain.order), 3, 4))
    q = len(pairs.prisms)
    memory = _Memory(
        np.full(q, -np.inf),
        np.zeros((q, 3)),
        np.full((q, 4), -1),
        np.zeros(q, np.int64),
        pairs.starts[:-1].copy(),
        np.zeros(len(prisms.panels), np.bool_),
    )
    for k in range(len(states)):
        place_panels(chain, states[k], poses)
        place_prisms(prisms, poses, placed)
        _write(prisms, placed, poses, pairs, reach, allowed, memory, gaps[k])


@compiled
def _write(
    prisms: Prisms,
    placed: Prisms,
    poses: Reals,
    pairs: PanelPairs,
    reach: float,
    allowed: float,
    memory: _Memory,
    gaps: Reals,
) -> None:
    """Write the gaps at one state."""
    directions, corners, nearest = memory.directions, memory.corners, memory.nearest
    memory.turned[:] = False
    for p in range(len(gaps)):
        start, last_nearest, least_gap = pairs.starts[p], nearest[p], math.inf
        # the nearest prisms of the last state come first: others are not searched if a bound is no less
        for number in range(start - 1, pairs.starts[p + 1]):
            k = last_nearest if number < start else number
            if number == last_nearest:
                continue
            f, g = pairs.prisms[k, 0], pairs.prisms[k, 1]
            enough = min(reach, least_gap)
            gap = sphere_distance(placed, f, g)
            if gap < enough:
                first, second = placed.vertices[f], placed.vertices[g]
                a, b = placed.counts[f, 0], placed.counts[g, 0]
                direction = (directions[k, 0], directions[k, 1], directions[k, 2])
                if memory.gaps[k] >= enough:
                    gap = gap_along(first, a, second, b, direction)
                if not gap >= enough:
                    simplex = (corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3])
                    gap, direction, simplex = hull_gap(first, a, second, b, direction, simplex)
                    memory.gaps[k] = gap
                    directions[k, 0], directions[k, 1], directions[k, 2] = direction
                    corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3] = simplex
            if gap < least_gap:
                least_gap = gap
                nearest[p] = k
        if least_gap < -allowed:
            # this is the overlap along one direction only
            least_gap = -_deepest(prisms, placed, poses, pairs, p, allowed, memory)
        gaps[p] = least_gap if least_gap > 0.0 or least_gap < -allowed else 0.0


@compiled
def _deepest(
    prisms: Prisms, placed: Prisms, poses: Reals, pairs: PanelPairs, pair: int, allowed: float, memory: _Memory
) -> float:
    """Return the greatest overlap of the prisms of two panels; not exact where it is allowed."""
    depth = 0.0
    for p in range(pairs.starts[pair], pairs.starts[pair + 1]):
        for side in range(2):
            f = pairs.prisms[p, side]
            if not memory.turned[f]:
                turn_axes(prisms, poses, placed, f)
                memory.turned[f] = True
        depth = max(depth, prism_overlap(placed, pairs.prisms[p, 0], pairs.prisms[p, 1], allowed, memory.axes, p))
    return depth
