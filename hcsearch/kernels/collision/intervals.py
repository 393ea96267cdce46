"""Lower bounds of the gaps between pairs of prisms in intervals of a motion.

Between two states of the motion every point of a panel, seen from another panel, stays within (dt^2 / 8) max |x''| of
the chord between its places at both ends. So where one direction, fixed to one of the two panels, has gaps g and g' at
the ends, the panels are at least min(g, g') - (dt^2 / 8) max |x''| apart in between (docs/explanation/collision.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, dot, put_vector, scaled_vector, vector_at, vector_difference
from hcsearch.kernels.collision.gjk import hull_gap
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.courses import (
    COURSE_TERM_COUNT,
    bound_rates,
    path_bend,
    path_speed,
    write_course,
    write_course_angles,
)
from hcsearch.kernels.linkage.loops import Chain, place_panels
from hcsearch.kernels.linkage.prisms import PrismPairs, Prisms

MAX_INTERVAL_HALVINGS = 40
"""Greatest number of times that an interval between two states is halved."""


class Course(NamedTuple):
    """A motion given by k states: times (k,), fold angles, rates and accelerations (k, n_hinges).

    cubic : whether accelerations are unknown, so that angles are cubics between states, not quintics.
    """

    times: Reals
    angles: Reals
    rates: Reals
    accelerations: Reals
    cubic: bool


class IntervalTables(NamedTuple):
    """Work tables of a search: a stack of intervals, bounds for each pair, and polynomials of the step.

    start_shares, end_shares, start_poses, end_poses : ends of each interval as shares of the step, and poses there.
    pair_lists, pair_counts : pairs of each interval.
    directions, direction_panels : for each pair, the direction that last separated it, fixed to its first panel (0) or
        second (1) and pointing away from that. corners : for each pair, the simplex at which the last search of its
        distance ended.
    gap_bounds : for each pair, a lower bound of its gap: its value at the end of the last interval in which it was
        computed, less the greatest approach of the panels since. After the last interval of a step it holds at its end.
    bends, speeds : bounds in the step of |x''| / 8, seen from either panel, and of |x'|.
    course, rates, accelerations : polynomials of the fold angles in the step, and bounds of their derivatives.
    relative_poses : (2, 3, 4), poses of the second panel relative to the first at both ends. points : corners of the
        second prism relative to the first panel.
    """

    start_shares: Reals
    end_shares: Reals
    start_poses: Reals
    end_poses: Reals
    pair_lists: WholeNumbers
    pair_counts: WholeNumbers
    directions: Reals
    direction_panels: WholeNumbers
    corners: WholeNumbers
    gap_bounds: Reals
    bends: Reals
    speeds: Reals
    course: Reals
    rates: Reals
    accelerations: Reals
    angles: Reals
    relative_poses: Reals
    points: Reals


@compiled
def new_interval_tables(chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course) -> IntervalTables:
    """Return tables for a search, with the panels placed at the start of the motion."""
    depth, panels, count, hinges = MAX_INTERVAL_HALVINGS + 2, len(chain.order), len(pairs.prisms), len(chain.points)
    tables = IntervalTables(
        start_shares=np.zeros(depth),
        end_shares=np.zeros(depth),
        start_poses=np.zeros((depth, panels, 3, 4)),
        end_poses=np.zeros((depth, panels, 3, 4)),
        pair_lists=np.zeros((depth, count), np.int64),
        pair_counts=np.zeros(depth, np.int64),
        directions=np.zeros((count, 3)),
        direction_panels=np.zeros(count, np.int64),
        corners=np.full((count, 4), -1),
        gap_bounds=np.full(count, -math.inf),
        bends=np.zeros((count, 2)),
        speeds=np.zeros(count),
        course=np.zeros((hinges, COURSE_TERM_COUNT)),
        rates=np.zeros(hinges),
        accelerations=np.zeros(hinges),
        angles=np.zeros(hinges),
        relative_poses=np.zeros((2, 3, 4)),
        points=np.zeros((prisms.vertices.shape[1], 3)),
    )
    place_panels(chain, course.angles[0], tables.end_poses[0])
    return tables


@compiled
def start_step_intervals(
    chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, k: int, needed_gap: float, tables: IntervalTables
) -> float:
    """Start the step from state k, listing the pairs whose gap may fall to the needed one in it.

    The gaps of all other pairs, as last computed, are too large for that. Returns the length of the step (s), 0 where
    two states have the same time.
    """
    h = course.times[k + 1] - course.times[k]
    _copy(tables.end_poses[0], tables.start_poses[0])
    place_panels(chain, course.angles[k + 1], tables.end_poses[0])
    if h <= 0.0:
        return 0.0
    q, v, a = course.angles, course.rates, course.accelerations
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], tables.course)
    bound_rates(tables.course, h, tables.rates, tables.accelerations)
    listed = 0
    for p in range(len(pairs.prisms)):
        speed = path_speed(pairs, p, 0, tables.rates, prisms.panels)
        tables.gap_bounds[p] -= speed * h
        if tables.gap_bounds[p] > needed_gap:
            continue
        tables.gap_bounds[p] = -math.inf
        tables.speeds[p] = speed
        for side in range(2):
            tables.bends[p, side] = path_bend(pairs, p, side, tables.rates, tables.accelerations, prisms.panels) / 8.0
        tables.pair_lists[0, listed] = p
        listed += 1
    tables.start_shares[0], tables.end_shares[0], tables.pair_counts[0] = 0.0, 1.0, listed
    return float(h)


@compiled
def halve_interval(chain: Chain, count: int, top: int, tables: IntervalTables) -> None:
    """Split an interval for its first `count` pairs: push its first half onto the stack above its second."""
    middle = 0.5 * (tables.start_shares[top] + tables.end_shares[top])
    write_course_angles(tables.course, middle, tables.angles)
    tables.start_shares[top + 1], tables.end_shares[top + 1] = tables.start_shares[top], middle
    _copy(tables.start_poses[top], tables.start_poses[top + 1])
    place_panels(chain, tables.angles, tables.end_poses[top + 1])
    tables.start_shares[top] = middle
    _copy(tables.end_poses[top + 1], tables.start_poses[top])
    for i in range(count):
        tables.pair_lists[top + 1, i] = tables.pair_lists[top, i]
    tables.pair_counts[top] = tables.pair_counts[top + 1] = count


@compiled
def _copy(poses: Reals, into: Reals) -> None:
    """Copy poses entry by entry; the assignment of whole tables would check for shared memory."""
    for k in range(len(poses)):
        for i in range(3):
            for j in range(4):
                into[k, i, j] = poses[k, i, j]


@compiled
def bound_gap(
    prisms: Prisms, pairs: PrismPairs, p: int, needed_gap: float, duration: float, top: int, tables: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap of a pair in an interval, and its gaps at both ends.

    The gaps at the ends are exact only if the bound is no more than needed.

    needed_gap : m. duration : of the interval, s.
    """
    write_relative_pose(prisms, pairs, p, tables.start_poses[top], tables.relative_poses[0])
    low = sphere_gap_bound(prisms, pairs, p, tables.relative_poses[0]) - tables.speeds[p] * duration
    if low > needed_gap:
        tables.gap_bounds[p] = low
        return low, low, low
    write_relative_pose(prisms, pairs, p, tables.end_poses[top], tables.relative_poses[1])
    low, first, second = _separate(prisms, pairs, p, needed_gap, duration, tables)
    tables.gap_bounds[p] = second
    return low, first, second


@compiled
def _separate(
    prisms: Prisms, pairs: PrismPairs, p: int, needed_gap: float, duration: float, tables: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap of a pair in an interval, by the best direction tried, and its gaps at both ends.

    The direction that last separated the pair is tried first, then those of the shortest distance at either end.
    """
    direction = vector_at(tables.directions, p, 0)
    low, first, second = chord_gap(prisms, pairs, p, tables.direction_panels[p], direction, duration, tables)
    if low > needed_gap:
        return low, first, second
    for end in range(2):
        distance, direction = pair_distance(prisms, pairs, p, tables.relative_poses[end], tables)
        if end:
            second = distance
        else:
            first = distance
        for side in range(2):
            fixed_direction = (
                scaled_vector(-1.0, _turned_back(tables.relative_poses[end], direction)) if side else direction
            )
            gap, _, _ = chord_gap(prisms, pairs, p, side, fixed_direction, duration, tables)
            if gap > low:
                low = gap
                tables.direction_panels[p] = side
                put_vector(tables.directions, p, 0, fixed_direction)
    return low, first, second


@compiled
def chord_gap(
    prisms: Prisms, pairs: PrismPairs, p: int, side: int, direction: Vector3, duration: float, tables: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap along a direction in an interval, and the gaps along it at both ends.

    direction : unit vector fixed to the panel of the first prism and pointing to the second; with side 1 vice versa.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    f_fixed, f_moving = (g, f) if side else (f, g)
    fixed_extent = _extent(prisms, f_fixed, direction)
    gaps = (math.inf, math.inf)
    for end in range(2):
        pose = tables.relative_poses[end]
        if side:  # the place of the first panel, from the second, is -R^T t
            moving_direction = rotated_by_pose(pose, direction)
            shift = -dot(moving_direction, (pose[0, 3], pose[1, 3], pose[2, 3]))
        else:
            moving_direction = _turned_back(pose, direction)
            shift = dot(direction, (pose[0, 3], pose[1, 3], pose[2, 3]))
        gap = shift - _extent(prisms, f_moving, scaled_vector(-1.0, moving_direction)) - fixed_extent
        gaps = (gaps[0], gap) if end else (gap, gaps[1])
    return min(gaps[0], gaps[1]) - tables.bends[p, side] * duration * duration, gaps[0], gaps[1]


@compiled
def _extent(prisms: Prisms, f: int, direction: Vector3) -> float:
    """Return the highest coordinate of a prism along a direction, in the flat state."""
    highest = -math.inf
    for k in range(prisms.counts[f, 0]):
        highest = max(highest, dot(direction, vector_at(prisms.vertices[f], k, 0)))
    return highest


@compiled
def pair_distance(
    prisms: Prisms, pairs: PrismPairs, p: int, pose: Reals, tables: IntervalTables
) -> tuple[float, Vector3]:
    """Return the distance of a pair, and the direction from first to second prism relative to the first panel."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    for k in range(prisms.counts[g, 0]):
        x = rotated_by_pose(pose, vector_at(prisms.vertices[g], k, 0))
        put_vector(tables.points, k, 0, (x[0] + pose[0, 3], x[1] + pose[1, 3], x[2] + pose[2, 3]))
    guess = vector_at(tables.directions, p, 0)
    if tables.direction_panels[p]:
        guess = scaled_vector(-1.0, rotated_by_pose(pose, guess))
    simplex = (tables.corners[p, 0], tables.corners[p, 1], tables.corners[p, 2], tables.corners[p, 3])
    gap, direction, simplex = hull_gap(
        prisms.vertices[f], prisms.counts[f, 0], tables.points, prisms.counts[g, 0], guess, simplex
    )
    tables.corners[p, 0], tables.corners[p, 1], tables.corners[p, 2], tables.corners[p, 3] = simplex
    return max(gap, 0.0), direction


@compiled
def sphere_gap_bound(prisms: Prisms, pairs: PrismPairs, p: int, pose: Reals) -> float:
    """Return a lower bound of the distance of a pair, by their enclosing spheres."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    x = rotated_by_pose(pose, vector_at(prisms.middles, g, 0))
    offset = vector_difference(
        (x[0] + pose[0, 3], x[1] + pose[1, 3], x[2] + pose[2, 3]), vector_at(prisms.middles, f, 0)
    )
    return math.sqrt(dot(offset, offset)) - float(prisms.reaches[f] + prisms.reaches[g])


@compiled
def write_relative_pose(prisms: Prisms, pairs: PrismPairs, p: int, poses: Reals, relative_pose: Reals) -> None:
    """Write the pose of the second panel of a pair relative to the first."""
    first_pose = poses[prisms.panels[pairs.prisms[p, 0]]]
    second_pose = poses[prisms.panels[pairs.prisms[p, 1]]]
    for j in range(4):
        x, y, z = second_pose[0, j], second_pose[1, j], second_pose[2, j]
        if j == 3:
            x, y, z = x - first_pose[0, 3], y - first_pose[1, 3], z - first_pose[2, 3]
        for i in range(3):
            relative_pose[i, j] = first_pose[0, i] * x + first_pose[1, i] * y + first_pose[2, i] * z


@compiled
def rotated_by_pose(pose: Reals, a: Vector3) -> Vector3:
    """Return the rotation of a pose times a vector."""
    return dot(vector_at(pose, 0, 0), a), dot(vector_at(pose, 1, 0), a), dot(vector_at(pose, 2, 0), a)


@compiled
def _turned_back(pose: Reals, a: Vector3) -> Vector3:
    """Return the transposed rotation of a pose times a vector."""
    return (
        dot((pose[0, 0], pose[1, 0], pose[2, 0]), a),
        dot((pose[0, 1], pose[1, 1], pose[2, 1]), a),
        dot((pose[0, 2], pose[1, 2], pose[2, 2]), a),
    )
