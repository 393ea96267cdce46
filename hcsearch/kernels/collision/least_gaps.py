"""Least gaps of prisms in a motion (negative where they overlap), dips of gaps, and approach speeds.

An interval is halved until some direction proves its gaps no smaller, up to a resolution, than the least one computed.
The gap of overlapping prisms is the greatest along face normals and cross products of edges.

Neighbours touch in the packed state and in the flat one, so that pairs that only separate, or only close, would make
every smallest gap 0. So for the smallest dip a gap counts only if, both before and after it, the pair is further apart
by at least a given rise.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import Vector3, cross, dot, put_vector, scaled_vector, vector_at
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
from hcsearch.kernels.linkage.courses import COURSE_TERM_COUNT, write_course, write_course_angles
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms

MIN_GAP_INTERVAL = 0.5**20
"""Share of a step below which intervals are not halved for least gaps."""
GAP_PARALLEL_ANGLE = 1e-6
"""Edges at a smaller angle (rad) count as parallel and define no separating axis."""


@compiled
def least_pair_gap(chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, resolution: float) -> float:
    """Return the least gap of any pair at any time of a motion, m; infinite without pairs.

    The result is attained by some pair; no gap is smaller by more than the resolution (m).
    """
    book = new_interval_tables(chain, prisms, pairs, course)
    least = _first(prisms, pairs, book)
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, least - resolution, book)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = book.end_shares[top] - book.start_shares[top]
            left, least = _look(prisms, pairs, resolution, least, share * h, share <= MIN_GAP_INTERVAL, top, book)
            if not left:
                top -= 1
            else:
                halve_interval(chain, left, top, book)
                top += 1
    return least


@lean
def _first(prisms: Prisms, pairs: PrismPairs, book: IntervalTables) -> float:
    """Return the least gap at the start of the motion."""
    least = math.inf
    for p in range(len(pairs.prisms)):
        for end in range(2):
            write_relative_pose(prisms, pairs, p, book.end_poses[0], book.relative_poses[end])
        if sphere_gap_bound(prisms, pairs, p, book.relative_poses[1]) < least:
            gap = pair_distance(prisms, pairs, p, book.relative_poses[1], book)[0]
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
    """Bound the gaps of the pairs of an interval, and move those that may have a smaller gap to the front.

    Returns the number of these pairs, and the least gap, updated by the gaps at both ends of the interval.

    wait : length of the interval, s. last : whether the interval is not halved any further.
    """
    left = 0
    for i in range(book.pair_counts[top]):
        p = book.pair_lists[top, i]
        low, first, second = bound_gap(prisms, pairs, p, least - resolution, wait, top, book)
        if low > least - resolution:
            if not second > 0.0:  # a distance of 0 is no measure of the overlap
                book.gap_bounds[p] = low
            continue
        if not first > 0.0:
            first, own = _along_axes(prisms, pairs, p, 0, wait, book)
            low = max(low, own)
        if not second > 0.0:
            second, own = _along_axes(prisms, pairs, p, 1, wait, book)
            low = max(low, own)
        book.gap_bounds[p] = second
        least = min(least, first, second)
        if not (low > least - resolution or last):
            book.pair_lists[top, left] = p
            left += 1
    return left, least


@lean
def _along_axes(
    prisms: Prisms, pairs: PrismPairs, p: int, end: int, wait: float, book: IntervalTables
) -> tuple[float, float]:
    """Return the gap of an overlapping pair at an end of an interval, and a lower bound in the whole interval.

    Both are the greatest along all separating axes: normals of either prism and cross products of their edges.
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
            two = rotated_by_pose(book.relative_poses[end], vector_at(prisms.edges[g], (number - a - b) % b, 0))
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
                book.direction_panels[p] = keeper
                put_vector(book.directions, p, 0, own)
    return gap, low


MIN_DIP_INTERVAL = 0.5**20
"""Share of a step below which intervals are not halved for dips."""


class _Dips(NamedTuple):
    """State of the search for dips, m; per pair, shape (p,), except `best`.

    widest : widest gap at a state so far. lows, ups : lower and upper bound of the least gap since the pair last rose
        and then narrowed by the rise; infinite before. best : (2,), least of either bound over all completed dips.
    """

    widest: Reals
    lows: Reals
    highs: Reals
    best: Reals


@compiled
def smallest_dip(
    chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, rise: float, resolution: float
) -> tuple[float, int]:
    """Return a lower bound of all gaps in dips of a given rise, tight to a resolution (m); infinite without dips.

    Also returns how often the gap of a pair was bounded.
    """
    book = new_interval_tables(chain, prisms, pairs, course)
    count = len(pairs.prisms)
    dips = _Dips(np.full(count, -math.inf), np.full(count, math.inf), np.full(count, math.inf), np.full(2, math.inf))
    _rise(prisms, pairs, rise, book, dips)
    looks = 0
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, dips.best[0] + rise, book)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = book.end_shares[top] - book.start_shares[top]
            looks += book.pair_counts[top]
            left = _fall(prisms, pairs, rise, resolution, share * h, share <= MIN_DIP_INTERVAL, top, book, dips)
            if not left:
                top -= 1
            else:
                halve_interval(chain, left, top, book)
                top += 1
        _rise(prisms, pairs, rise, book, dips)
    return dips.best[0], looks


@lean
def _fall(
    prisms: Prisms,
    pairs: PrismPairs,
    rise: float,
    resolution: float,
    wait: float,
    last: bool,
    top: int,
    book: IntervalTables,
    dips: _Dips,
) -> int:
    """Update the dips by the gaps in an interval; move pairs with loose bounds to the front; return their number."""
    left = 0
    for i in range(book.pair_counts[top]):
        p = book.pair_lists[top, i]
        need = min(dips.widest[p] - rise, dips.lows[p], dips.best[0])
        if need <= 0.0:
            continue
        low, first, second = bound_gap(prisms, pairs, p, need, wait, top, book)
        low = max(low, 0.0)
        if low >= need:
            continue
        up = min(first, second)
        if low < min(up, dips.highs[p], dips.best[1]) - resolution and not last:
            book.pair_lists[top, left] = p
            left += 1
            continue
        dips.lows[p] = low
        if up <= dips.widest[p] - rise:
            dips.highs[p] = min(dips.highs[p], up)
    return left


@lean
def _rise(prisms: Prisms, pairs: PrismPairs, rise: float, book: IntervalTables, dips: _Dips) -> None:
    """Complete the dips of pairs whose gap has risen by the end of a step."""
    for p in range(len(pairs.prisms)):
        gap, enough = book.gap_bounds[p], dips.best[0] + rise
        if not gap > enough:  # else the gap is wide enough, whatever its value
            write_relative_pose(prisms, pairs, p, book.end_poses[0], book.relative_poses[1])
            gap = sphere_gap_bound(prisms, pairs, p, book.relative_poses[1])
            if not gap > enough:
                gap = pair_distance(prisms, pairs, p, book.relative_poses[1], book)[0]
            book.gap_bounds[p] = gap
        dips.widest[p] = max(dips.widest[p], gap)
        if gap >= dips.lows[p] + rise:
            dips.best[0] = min(dips.best[0], dips.lows[p])
            dips.best[1] = min(dips.best[1], dips.highs[p])
            dips.lows[p] = dips.highs[p] = math.inf


APPROACH_INTERVAL, MAX_APPROACH_INTERVALS = 1e-4, 100
"""Time (s) before contact over which the approach speed is averaged; greatest number of such times searched back."""


@compiled
def angles_at(course: Course, time: float, angles: Reals) -> None:
    """Write the fold angles at a time."""
    k = min(max(int(np.searchsorted(course.times, time)) - 1, 0), len(course.times) - 2)
    h = course.times[k + 1] - course.times[k]
    q, v, a = course.angles, course.rates, course.accelerations
    if h <= 0.0:
        angles[:] = q[k + 1]
        return
    polynomials = np.empty((len(angles), COURSE_TERM_COUNT))
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], polynomials)
    write_course_angles(polynomials, (time - course.times[k]) / h, angles)


@compiled
def approach_speed(chain: Chain, prisms: Prisms, pairs: PrismPairs, p: int, course: Course, time: float) -> float:
    """Return the mean speed (m/s) at which the gap of a pair closed in the last `APPROACH_INTERVAL` before contact.

    A collision is reported when prisms certainly overlap, which can be some time after contact. The result is 0 if the
    pair was not apart in all of the time searched back.
    """
    book = new_interval_tables(chain, prisms, pairs, course)
    last = 0.0
    for k in range(MAX_APPROACH_INTERVALS):
        before = time - APPROACH_INTERVAL * k
        if before < course.times[0]:
            return 0.0
        angles_at(course, before, book.angles)
        place_panels(chain, book.angles, book.end_poses[0])
        write_relative_pose(prisms, pairs, p, book.end_poses[0], book.relative_poses[0])
        gap = pair_distance(prisms, pairs, p, book.relative_poses[0], book)[0]
        if k > 0 and gap > 0.0:
            return float(max(gap - last, 0.0) / APPROACH_INTERVAL)
        last = gap
    return 0.0
