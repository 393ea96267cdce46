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
from hcsearch.kernels.compiling.compiled import compiled, lean
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

    low, high, lows, highs : ends of each interval as shares of the step, and poses there. lists, counts : its pairs.
    ways, keepers : for each pair, the direction that last separated it, fixed to its first panel (0) or second (1) and
        pointing away from that. corners : for each pair, the simplex at which the last search of its distance ended.
    spare : for each pair, a lower bound of its gap: its value at the end of the last interval in which it was computed,
        less the greatest approach of the panels since. After the last interval of a step it holds at its end.
    bends, speeds : bounds in the step of |x''| / 8, seen from either panel, and of |x'|.
    course, rates, accelerations : polynomials of the fold angles in the step, and bounds of their derivatives.
    seen : (2, 3, 4), poses of the second panel relative to the first at both ends. points : corners of the second prism
        relative to the first panel.
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
    book = IntervalTables(
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
    place_panels(chain, course.angles[0], book.end_poses[0])
    return book


@lean
def start_step_intervals(
    chain: Chain, prisms: Prisms, pairs: PrismPairs, course: Course, k: int, need: float, book: IntervalTables
) -> float:
    """Start the step from state k, listing the pairs whose gap may fall to the needed one in it.

    The gaps of all other pairs, as last computed, are too large for that. Returns the length of the step (s), 0 where
    two states have the same time.
    """
    h = course.times[k + 1] - course.times[k]
    _copy(book.end_poses[0], book.start_poses[0])
    place_panels(chain, course.angles[k + 1], book.end_poses[0])
    if h <= 0.0:
        return 0.0
    q, v, a = course.angles, course.rates, course.accelerations
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], book.course)
    bound_rates(book.course, h, book.rates, book.accelerations)
    listed = 0
    for p in range(len(pairs.prisms)):
        speed = path_speed(pairs, p, 0, book.rates, prisms.panels)
        book.gap_bounds[p] -= speed * h
        if book.gap_bounds[p] > need:
            continue
        book.gap_bounds[p] = -math.inf
        book.speeds[p] = speed
        for back in range(2):
            book.bends[p, back] = path_bend(pairs, p, back, book.rates, book.accelerations, prisms.panels) / 8.0
        book.pair_lists[0, listed] = p
        listed += 1
    book.start_shares[0], book.end_shares[0], book.pair_counts[0] = 0.0, 1.0, listed
    return float(h)


@lean
def halve_interval(chain: Chain, left: int, top: int, book: IntervalTables) -> None:
    """Split an interval for its first `left` pairs: push its first half onto the stack above its second."""
    middle = 0.5 * (book.start_shares[top] + book.end_shares[top])
    write_course_angles(book.course, middle, book.angles)
    book.start_shares[top + 1], book.end_shares[top + 1] = book.start_shares[top], middle
    _copy(book.start_poses[top], book.start_poses[top + 1])
    place_panels(chain, book.angles, book.end_poses[top + 1])
    book.start_shares[top] = middle
    _copy(book.end_poses[top + 1], book.start_poses[top])
    for i in range(left):
        book.pair_lists[top + 1, i] = book.pair_lists[top, i]
    book.pair_counts[top] = book.pair_counts[top + 1] = left


@lean
def _copy(poses: Reals, into: Reals) -> None:
    """Copy poses entry by entry; the assignment of whole tables would check for shared memory."""
    for k in range(len(poses)):
        for i in range(3):
            for j in range(4):
                into[k, i, j] = poses[k, i, j]


@lean
def bound_gap(
    prisms: Prisms, pairs: PrismPairs, p: int, need: float, wait: float, top: int, book: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap of a pair in an interval, and its gaps at both ends.

    The gaps at the ends are exact only if the bound is no more than needed.

    need : gap needed, m. wait : length of the interval, s.
    """
    write_relative_pose(prisms, pairs, p, book.start_poses[top], book.relative_poses[0])
    low = sphere_gap_bound(prisms, pairs, p, book.relative_poses[0]) - book.speeds[p] * wait
    if low > need:
        book.gap_bounds[p] = low
        return low, low, low
    write_relative_pose(prisms, pairs, p, book.end_poses[top], book.relative_poses[1])
    low, first, second = _separate(prisms, pairs, p, need, wait, book)
    book.gap_bounds[p] = second
    return low, first, second


@lean
def _separate(
    prisms: Prisms, pairs: PrismPairs, p: int, need: float, wait: float, book: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap of a pair in an interval, by the best direction tried, and its gaps at both ends.

    The direction that last separated the pair is tried first, then those of the shortest distance at either end.
    """
    way = vector_at(book.directions, p, 0)
    low, first, second = chord_gap(prisms, pairs, p, book.direction_panels[p], way, wait, book)
    if low > need:
        return low, first, second
    for end in range(2):
        distance, way = pair_distance(prisms, pairs, p, book.relative_poses[end], book)
        if end:
            second = distance
        else:
            first = distance
        for keeper in range(2):
            own = scaled_vector(-1.0, _turned_back(book.relative_poses[end], way)) if keeper else way
            gap, _, _ = chord_gap(prisms, pairs, p, keeper, own, wait, book)
            if gap > low:
                low = gap
                book.direction_panels[p] = keeper
                put_vector(book.directions, p, 0, own)
    return low, first, second


@lean
def chord_gap(
    prisms: Prisms, pairs: PrismPairs, p: int, keeper: int, way: Vector3, wait: float, book: IntervalTables
) -> tuple[float, float, float]:
    """Return a lower bound of the gap along a direction in an interval, and the gaps along it at both ends.

    way : unit vector fixed to the panel of the first prism and pointing to the second; with keeper 1 vice versa.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    own, other = (g, f) if keeper else (f, g)
    top = _extent(prisms, own, way)
    gaps = (math.inf, math.inf)
    for end in range(2):
        seen = book.relative_poses[end]
        if keeper:  # the place of the first panel, from the second, is -R^T t
            other_way = rotated_by_pose(seen, way)
            shift = -dot(other_way, (seen[0, 3], seen[1, 3], seen[2, 3]))
        else:
            other_way = _turned_back(seen, way)
            shift = dot(way, (seen[0, 3], seen[1, 3], seen[2, 3]))
        gap = shift - _extent(prisms, other, scaled_vector(-1.0, other_way)) - top
        gaps = (gaps[0], gap) if end else (gap, gaps[1])
    return min(gaps[0], gaps[1]) - book.bends[p, keeper] * wait * wait, gaps[0], gaps[1]


@lean
def _extent(prisms: Prisms, f: int, way: Vector3) -> float:
    """Return the highest coordinate of a prism along a direction, in the flat state."""
    far = -math.inf
    for k in range(prisms.counts[f, 0]):
        far = max(far, dot(way, vector_at(prisms.vertices[f], k, 0)))
    return far


@lean
def pair_distance(
    prisms: Prisms, pairs: PrismPairs, p: int, seen: Reals, book: IntervalTables
) -> tuple[float, Vector3]:
    """Return the distance of a pair, and the direction from first to second prism relative to the first panel."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    for k in range(prisms.counts[g, 0]):
        x = rotated_by_pose(seen, vector_at(prisms.vertices[g], k, 0))
        put_vector(book.points, k, 0, (x[0] + seen[0, 3], x[1] + seen[1, 3], x[2] + seen[2, 3]))
    guess = vector_at(book.directions, p, 0)
    if book.direction_panels[p]:
        guess = scaled_vector(-1.0, rotated_by_pose(seen, guess))
    last = (book.corners[p, 0], book.corners[p, 1], book.corners[p, 2], book.corners[p, 3])
    gap, way, last = hull_gap(prisms.vertices[f], prisms.counts[f, 0], book.points, prisms.counts[g, 0], guess, last)
    book.corners[p, 0], book.corners[p, 1], book.corners[p, 2], book.corners[p, 3] = last
    return max(gap, 0.0), way


@lean
def sphere_gap_bound(prisms: Prisms, pairs: PrismPairs, p: int, seen: Reals) -> float:
    """Return a lower bound of the distance of a pair, by their enclosing spheres."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    x = rotated_by_pose(seen, vector_at(prisms.middles, g, 0))
    way = vector_difference((x[0] + seen[0, 3], x[1] + seen[1, 3], x[2] + seen[2, 3]), vector_at(prisms.middles, f, 0))
    return math.sqrt(dot(way, way)) - float(prisms.reaches[f] + prisms.reaches[g])


@lean
def write_relative_pose(prisms: Prisms, pairs: PrismPairs, p: int, poses: Reals, seen: Reals) -> None:
    """Write the pose of the second panel of a pair relative to the first."""
    one = poses[prisms.panels[pairs.prisms[p, 0]]]
    two = poses[prisms.panels[pairs.prisms[p, 1]]]
    for j in range(4):
        x, y, z = two[0, j], two[1, j], two[2, j]
        if j == 3:
            x, y, z = x - one[0, 3], y - one[1, 3], z - one[2, 3]
        for i in range(3):
            seen[i, j] = one[0, i] * x + one[1, i] * y + one[2, i] * z


@lean
def rotated_by_pose(pose: Reals, a: Vector3) -> Vector3:
    """Return the rotation of a pose times a vector."""
    return (
        dot((pose[0, 0], pose[0, 1], pose[0, 2]), a),
        dot((pose[1, 0], pose[1, 1], pose[1, 2]), a),
        dot((pose[2, 0], pose[2, 1], pose[2, 2]), a),
    )


@lean
def _turned_back(pose: Reals, a: Vector3) -> Vector3:
    """Return the transposed rotation of a pose times a vector."""
    return (
        dot((pose[0, 0], pose[1, 0], pose[2, 0]), a),
        dot((pose[0, 1], pose[1, 1], pose[2, 1]), a),
        dot((pose[0, 2], pose[1, 2], pose[2, 2]), a),
    )
