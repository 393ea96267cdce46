"""The least gap of prisms on a motion, below 0 where they overlap: minus how deep panels as built cut into each other.

An interval is halved until some direction shows that its gaps are no less than one that was met, but for a resolution.
Prisms that overlap are separated least by a normal of a face or the cross product of two edges.
"""

from __future__ import annotations

import math

from hcsearch.kernels.algebra.vectors import Vector3, cross, dot, put_vector, scaled_vector, vector_at
from hcsearch.kernels.collision.intervals import (
    Course,
    IntervalTables,
    bound_gap,
    chord_gap,
    halve_interval,
    new_interval_tables,
    pair_distance,
    rotated_by_pose,
    sphere_gap_bound,
    start_step_intervals,
    write_relative_pose,
)
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import Chain
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.linkage.reaches import PrismPairs

MIN_GAP_INTERVAL = 0.5**20
"""Share of a step below which gaps are not known better than they are."""
GAP_PARALLEL_ANGLE = 1e-6
"""Edges whose directions differ by less (rad) have no direction across both."""


@compiled
def least_pair_gap(chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, resolution: float) -> float:
    """The least gap that a pair has at a time of a motion, m; infinite without pairs.

    It is one that a pair has; at no time has one less by more than the resolution (m).
    """
    book = new_interval_tables(chain, prisms, pairs, course)
    least = _first(prisms, pairs, book)
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, least - resolution, book)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = book.high[top] - book.low[top]
            left, least = _look(prisms, pairs, resolution, least, share * h, share <= MIN_GAP_INTERVAL, top, book)
            if not left:
                top -= 1
            else:
                halve_interval(chain, left, top, book)
                top += 1
    return least


@lean
def _first(prisms: Prisms, pairs: PrismPairs, book: IntervalTables) -> float:
    """The least gap at the beginning of the motion."""
    least = math.inf
    for p in range(len(pairs.prisms)):
        for end in range(2):
            write_relative_pose(prisms, pairs, p, book.highs[0], book.seen[end])
        if sphere_gap_bound(prisms, pairs, p, book.seen[1]) < least:
            gap = pair_distance(prisms, pairs, p, book.seen[1], book)[0]
            least = min(least, gap if gap > 0.0 else _along_axes(prisms, pairs, p, 1, 0.0, book)[0])
    return least


@lean
def _look(
    prisms: Prisms,
    pairs: PrismPairs,
    resolution: float,
    least: float,
    wait: float,
    last: bool,
    top: int,
    book: IntervalTables,
) -> tuple[int, float]:
    """Look at the pairs of an interval, a time `wait` long; those whose gap may come below move to the front.

    Returns how many these are, and the least gap with those at the ends of the interval.
    """
    left = 0
    for i in range(book.counts[top]):
        p = book.lists[top, i]
        low, first, second = bound_gap(prisms, pairs, p, least - resolution, wait, top, book)
        if low > least - resolution:
            if not second > 0.0:  # a distance of 0 says nothing of how deep the pair overlaps
                book.spare[p] = low
            continue
        if not first > 0.0:
            first, own = _along_axes(prisms, pairs, p, 0, wait, book)
            low = max(low, own)
        if not second > 0.0:
            second, own = _along_axes(prisms, pairs, p, 1, wait, book)
            low = max(low, own)
        book.spare[p] = second
        least = min(least, first, second)
        if not (low > least - resolution or last):
            book.lists[top, left] = p
            left += 1
    return left, least


@lean
def _along_axes(
    prisms: Prisms, pairs: PrismPairs, p: int, end: int, wait: float, book: IntervalTables
) -> tuple[float, float]:
    """The gap of a pair that overlaps at an end of an interval, and what it does not come below in all of that.

    Both are the greatest along normals of the first prism, of the second, and across edges of both, to either side.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    a, b = prisms.counts[f, 1], prisms.counts[g, 1]
    gap, low = -math.inf, -math.inf
    for number in range(a + b + a * b):
        keeper = 0
        if number < a:
            way = vector_at(prisms.normals[f], number, 0)
        elif number < a + b:
            keeper, way = 1, vector_at(prisms.normals[g], number - a, 0)
        else:
            one = vector_at(prisms.edges[f], (number - a - b) // b, 0)
            two = rotated_by_pose(book.seen[end], vector_at(prisms.edges[g], (number - a - b) % b, 0))
            way = cross(one, two)
            length = math.sqrt(dot(way, way))
            if length < GAP_PARALLEL_ANGLE:
                continue
            way = scaled_vector(1.0 / length, way)
        for side in range(2):
            own: Vector3 = scaled_vector(-1.0, way) if side else way
            lower, first, second = chord_gap(prisms, pairs, p, keeper, own, wait, book)
            gap = max(gap, second if end else first)
            if lower > low:
                low = lower
                book.keepers[p] = keeper
                put_vector(book.ways, p, 0, own)
    return gap, low
