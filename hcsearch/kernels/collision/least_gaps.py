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
from hcsearch.kernels.compiling.compiled import compiled
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
    tables = new_interval_tables(chain, prisms, pairs, course)
    least_gap = _first_gap(prisms, pairs, tables)
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, least_gap - resolution, tables)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = tables.end_shares[top] - tables.start_shares[top]
            last = share <= MIN_GAP_INTERVAL
            undecided, least_gap = _bound_pairs(prisms, pairs, resolution, least_gap, share * h, last, top, tables)
            if not undecided:
                top -= 1
            else:
                halve_interval(chain, undecided, top, tables)
                top += 1
    return least_gap


@compiled
def _first_gap(prisms: Prisms, pairs: PrismPairs, tables: IntervalTables) -> float:
    """Return the least gap at the start of the motion."""
    least_gap = math.inf
    for p in range(len(pairs.prisms)):
        for end in range(2):
            write_relative_pose(prisms, pairs, p, tables.end_poses[0], tables.relative_poses[end])
        if sphere_gap_bound(prisms, pairs, p, tables.relative_poses[1]) < least_gap:
            gap = pair_distance(prisms, pairs, p, tables.relative_poses[1], tables)[0]
            least_gap = min(least_gap, gap if gap > 0.0 else _along_axes(prisms, pairs, p, 1, 0.0, tables)[0])
    return least_gap


@compiled
def _bound_pairs(
    prisms: Prisms,
    pairs: PrismPairs,
    resolution: float,
    least_gap: float,
    duration: float,
    last: bool,
    top: int,
    tables: IntervalTables,
) -> tuple[int, float]:
    """Bound the gaps of the pairs of an interval, and move those that may have a smaller gap to the front.

    Returns the number of these pairs, and the least gap, updated by the gaps at both ends of the interval.

    duration : of the interval, s. last : whether the interval is not halved any further.
    """
    undecided = 0
    for i in range(tables.pair_counts[top]):
        p = tables.pair_lists[top, i]
        low, first, second = bound_gap(prisms, pairs, p, least_gap - resolution, duration, top, tables)
        if low > least_gap - resolution:
            if not second > 0.0:  # a distance of 0 is no measure of the overlap
                tables.gap_bounds[p] = low
            continue
        if not first > 0.0:
            first, axis_bound = _along_axes(prisms, pairs, p, 0, duration, tables)
            low = max(low, axis_bound)
        if not second > 0.0:
            second, axis_bound = _along_axes(prisms, pairs, p, 1, duration, tables)
            low = max(low, axis_bound)
        tables.gap_bounds[p] = second
        least_gap = min(least_gap, first, second)
        if not (low > least_gap - resolution or last):
            tables.pair_lists[top, undecided] = p
            undecided += 1
    return undecided, least_gap


@compiled
def _along_axes(
    prisms: Prisms, pairs: PrismPairs, p: int, end: int, duration: float, tables: IntervalTables
) -> tuple[float, float]:
    """Return the gap of an overlapping pair at an end of an interval, and a lower bound in the whole interval.

    Both are the greatest along all separating axes: normals of either prism and cross products of their edges.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    first_axes, second_axes = prisms.counts[f, 1], prisms.counts[g, 1]
    gap, low = -math.inf, -math.inf
    for number in range(first_axes + second_axes + first_axes * second_axes):
        panel_side = 0
        if number < first_axes:
            direction = vector_at(prisms.normals[f], number, 0)
        elif number < first_axes + second_axes:
            panel_side, direction = 1, vector_at(prisms.normals[g], number - first_axes, 0)
        else:
            k = number - first_axes - second_axes
            first_edge = vector_at(prisms.edges[f], k // second_axes, 0)
            second_edge = vector_at(prisms.edges[g], k % second_axes, 0)
            direction = cross(first_edge, rotated_by_pose(tables.relative_poses[end], second_edge))
            length = math.sqrt(dot(direction, direction))
            if length < GAP_PARALLEL_ANGLE:
                continue
            direction = scaled_vector(1.0 / length, direction)
        for side in range(2):
            oriented: Vector3 = scaled_vector(-1.0, direction) if side else direction
            lower, first, second = chord_gap(prisms, pairs, p, panel_side, oriented, duration, tables)
            gap = max(gap, second if end else first)
            if lower > low:
                low = lower
                tables.direction_panels[p] = panel_side
                put_vector(tables.directions, p, 0, oriented)
    return gap, low


MIN_DIP_INTERVAL = 0.5**20
"""Share of a step below which intervals are not halved for dips."""


class _Dips(NamedTuple):
    """State of the search for dips, m; per pair, shape (p,), except `best`.

    widest : widest gap at a state so far. lows, highs : lower and upper bound of the least gap since the pair last rose
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
    tables = new_interval_tables(chain, prisms, pairs, course)
    count = len(pairs.prisms)
    dips = _Dips(np.full(count, -math.inf), np.full(count, math.inf), np.full(count, math.inf), np.full(2, math.inf))
    _complete_dips(prisms, pairs, rise, tables, dips)
    bound_count = 0
    for k in range(len(course.times) - 1):
        h = start_step_intervals(chain, prisms, pairs, course, k, dips.best[0] + rise, tables)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = tables.end_shares[top] - tables.start_shares[top]
            bound_count += tables.pair_counts[top]
            last = share <= MIN_DIP_INTERVAL
            undecided = _narrow_dips(prisms, pairs, rise, resolution, share * h, last, top, tables, dips)
            if not undecided:
                top -= 1
            else:
                halve_interval(chain, undecided, top, tables)
                top += 1
        _complete_dips(prisms, pairs, rise, tables, dips)
    return dips.best[0], bound_count


@compiled
def _narrow_dips(
    prisms: Prisms,
    pairs: PrismPairs,
    rise: float,
    resolution: float,
    duration: float,
    last: bool,
    top: int,
    tables: IntervalTables,
    dips: _Dips,
) -> int:
    """Update the dips by the gaps in an interval; move pairs with loose bounds to the front; return their number."""
    undecided = 0
    for i in range(tables.pair_counts[top]):
        p = tables.pair_lists[top, i]
        needed_gap = min(dips.widest[p] - rise, dips.lows[p], dips.best[0])
        if needed_gap <= 0.0:
            continue
        low, first, second = bound_gap(prisms, pairs, p, needed_gap, duration, top, tables)
        low = max(low, 0.0)
        if low >= needed_gap:
            continue
        high = min(first, second)
        if low < min(high, dips.highs[p], dips.best[1]) - resolution and not last:
            tables.pair_lists[top, undecided] = p
            undecided += 1
            continue
        dips.lows[p] = low
        if high <= dips.widest[p] - rise:
            dips.highs[p] = min(dips.highs[p], high)
    return undecided


@compiled
def _complete_dips(prisms: Prisms, pairs: PrismPairs, rise: float, tables: IntervalTables, dips: _Dips) -> None:
    """Complete the dips of pairs whose gap has risen by the end of a step."""
    for p in range(len(pairs.prisms)):
        gap, enough = tables.gap_bounds[p], dips.best[0] + rise
        if not gap > enough:  # else the gap is wide enough, whatever its value
            write_relative_pose(prisms, pairs, p, tables.end_poses[0], tables.relative_poses[1])
            gap = sphere_gap_bound(prisms, pairs, p, tables.relative_poses[1])
            if not gap > enough:
                gap = pair_distance(prisms, pairs, p, tables.relative_poses[1], tables)[0]
            tables.gap_bounds[p] = gap
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
    tables = new_interval_tables(chain, prisms, pairs, course)
    last_gap = 0.0
    for k in range(MAX_APPROACH_INTERVALS):
        earlier = time - APPROACH_INTERVAL * k
        if earlier < course.times[0]:
            return 0.0
        angles_at(course, earlier, tables.angles)
        place_panels(chain, tables.angles, tables.end_poses[0])
        write_relative_pose(prisms, pairs, p, tables.end_poses[0], tables.relative_poses[0])
        gap = pair_distance(prisms, pairs, p, tables.relative_poses[0], tables)[0]
        if k > 0 and gap > 0.0:
            return float(max(gap - last_gap, 0.0) / APPROACH_INTERVAL)
        last_gap = gap
    return 0.0
