"""Certified clearance: that prisms stay apart at all times of a motion, and by how much.

Between two states of the motion every point of a panel, seen from another panel, stays within (dt^2 / 8) max |x''| of
the chord between its places at both ends. So where one direction, fixed to one of the two panels, has gaps g and g' at
the ends, the panels are at least min(g, g') - (dt^2 / 8) max |x''| apart in between. An interval in which no direction
tells two panels apart is halved, until one does, or it is shorter than can matter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled, lean
from hcsearch.kernels.courses import TERMS, bound_rates, follow, path_bounds, write_course
from hcsearch.kernels.distances import proximity
from hcsearch.kernels.loops import Chain, place_panels
from hcsearch.kernels.multibody.vectors import Vector, at, dot, minus, put, times
from hcsearch.kernels.paths import Pairs
from hcsearch.kernels.prisms import Prisms

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]

CLEAR, COLLIDES, UNDECIDED = 0, 1, 2
"""Verdicts: apart at all times; overlapping at a time; too close to tell in the shortest intervals."""

HALVINGS, MEASURED = 40, 12
"""An interval between two states is halved no more often than this to tell whether prisms meet, and to measure gaps."""


class Course(NamedTuple):
    """States of a motion, k of them: times (k,), fold angles, rates and accelerations (k, n_hinges).

    cubic : whether accelerations are not known.
    """

    times: Reals
    angles: Reals
    rates: Reals
    accelerations: Reals
    cubic: bool


class Search(NamedTuple):
    """What is asked of a motion: whether gaps are above a slack (m), or how small they come.

    near : distance (m) that counts as overlap. measuring : which of the two is asked. touch : pairs count from when
        they are first further apart than this (m) to when they last are. resolution : of the smallest gap (m).
    """

    slack: float
    near: float
    measuring: bool
    touch: float
    resolution: float


class Answer(NamedTuple):
    """What was found. All entries are written; each table has one.

    times : s, when a pair collides or is undecided. pairs : which. gaps : m, that no counted pair comes below;
        infinite without one. looks : intervals times pairs looked at.
    """

    times: Reals
    pairs: Whole
    gaps: Reals
    looks: Whole


class _Book(NamedTuple):
    """Tables of a search: intervals that wait, by depth; what is known of each pair; tables of the step.

    low, high, lows, highs : ends of the interval as shares of the step, and poses there. lists, counts : its pairs.
    ways, keepers : of each pair, the direction that last told it apart, fixed to its first panel (0) or second (1) and
        pointing away from that. bends, speeds : of the step, |x''| / 8 as seen from either panel, and |x'|.
    apart, waiting : whether it has been further apart than touch, and its smallest gap since it last was.
    course, rates, accelerations : polynomials of the fold angles in the step, and bounds. seen : (2, 3, 4), poses of
        the second panel from the first at both ends. points : corners of the second prism from the first panel.
    """

    low: Reals
    high: Reals
    lows: Reals
    highs: Reals
    lists: Whole
    counts: Whole
    ways: Reals
    keepers: Whole
    bends: Reals
    speeds: Reals
    apart: Whole
    waiting: Reals
    course: Reals
    rates: Reals
    accelerations: Reals
    angles: Reals
    seen: Reals
    points: Reals


@compiled
def search(chain: Chain, prisms: Prisms, pairs: Pairs, course: Course, wanted: Search, answer: Answer) -> int:
    """Follow all pairs through a motion; CLEAR, or what is found at the first time at which it is not."""
    book = _book_for(chain, prisms, pairs)
    count = len(pairs.prisms)
    answer.gaps[0] = math.inf
    answer.looks[0] = 0
    place_panels(chain, course.angles[0], book.highs[0])
    for k in range(len(course.times) - 1):
        h = course.times[k + 1] - course.times[k]
        if h <= 0.0:
            continue
        _begin(pairs, course, k, h, book)
        book.lows[0] = book.highs[0]
        place_panels(chain, course.angles[k + 1], book.highs[0])
        book.low[0], book.high[0], book.counts[0] = 0.0, 1.0, count
        for p in range(count):
            book.lists[0, p] = p
        top = 0
        while top >= 0:
            share = book.high[top] - book.low[top]
            last = share <= 0.5 ** (MEASURED if wanted.measuring else HALVINGS)
            left = _look(prisms, pairs, wanted, share * h, last, top, book, answer)
            if not left:
                top -= 1
            elif last:
                p = book.lists[top, 0]
                answer.times[0], answer.pairs[0] = course.times[k] + book.high[top] * h, p
                _relate(prisms, pairs, p, book.highs[top], book.seen[1])
                return COLLIDES if _nearest(prisms, pairs, p, book.seen[1], book)[0] <= wanted.near else UNDECIDED
            else:
                _halve(chain, left, top, book)
                top += 1
    return CLEAR


@compiled
def _book_for(chain: Chain, prisms: Prisms, pairs: Pairs) -> _Book:
    depth, panels, count, hinges = HALVINGS + 2, len(chain.order), len(pairs.prisms), len(chain.points)
    return _Book(
        low=np.zeros(depth),
        high=np.zeros(depth),
        lows=np.zeros((depth, panels, 3, 4)),
        highs=np.zeros((depth, panels, 3, 4)),
        lists=np.zeros((depth, count), np.int64),
        counts=np.zeros(depth, np.int64),
        ways=np.zeros((count, 3)),
        keepers=np.zeros(count, np.int64),
        bends=np.zeros((count, 2)),
        speeds=np.zeros(count),
        apart=np.zeros(count, np.int64),
        waiting=np.full(count, math.inf),
        course=np.zeros((hinges, TERMS)),
        rates=np.zeros(hinges),
        accelerations=np.zeros(hinges),
        angles=np.zeros(hinges),
        seen=np.zeros((2, 3, 4)),
        points=np.zeros((prisms.vertices.shape[1], 3)),
    )


@compiled
def _begin(pairs: Pairs, course: Course, k: int, h: float, book: _Book) -> None:
    """Bounds of how all pairs move in a step."""
    q, v, a = course.angles, course.rates, course.accelerations
    write_course(h, course.cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], book.course)
    bound_rates(book.course, h, book.rates, book.accelerations)
    bounds = book.rates, book.accelerations
    for p in range(len(pairs.prisms)):
        count = pairs.lengths[p]
        speed, bend = path_bounds(pairs.hinges, p, count, False, pairs.beyond, bounds[0], bounds[1])
        book.speeds[p], book.bends[p, 0] = speed, bend / 8.0
        _, bend = path_bounds(pairs.hinges, p, count, True, pairs.before, bounds[0], bounds[1])
        book.bends[p, 1] = bend / 8.0


@compiled
def _halve(chain: Chain, left: int, top: int, book: _Book) -> None:
    """The first half of an interval on top of the second, for the pairs that are left."""
    middle = 0.5 * (book.low[top] + book.high[top])
    follow(book.course, middle, book.angles)
    book.low[top + 1], book.high[top + 1] = book.low[top], middle
    book.lows[top + 1] = book.lows[top]
    place_panels(chain, book.angles, book.highs[top + 1])
    book.low[top] = middle
    book.lows[top] = book.highs[top + 1]
    for i in range(left):
        book.lists[top + 1, i] = book.lists[top, i]
    book.counts[top] = book.counts[top + 1] = left


@lean
def _look(
    prisms: Prisms, pairs: Pairs, wanted: Search, wait: float, last: bool, top: int, book: _Book, answer: Answer
) -> int:
    """Look at the pairs of an interval, a time `wait` long; those that it does not settle move to the front."""
    left = 0
    for i in range(book.counts[top]):
        p = book.lists[top, i]
        answer.looks[0] += 1
        _relate(prisms, pairs, p, book.lows[top], book.seen[0])
        need = wanted.slack
        if wanted.measuring:
            need = wanted.touch
            if book.apart[p]:
                need = max(min(answer.gaps[0], book.waiting[p]) - wanted.resolution, need)
        low = _spheres(prisms, pairs, p, book.seen[0]) - book.speeds[p] * wait
        first = second = low
        if not low > need:
            _relate(prisms, pairs, p, book.highs[top], book.seen[1])
            low, first, second = _tell_apart(prisms, pairs, p, need, wait, book)
        if wanted.measuring:
            settled = _measure(wanted, p, low, first, second, last, book, answer)
        else:
            settled = low > wanted.slack
        if not settled:
            book.lists[top, left] = p
            left += 1
    return left


@lean
def _measure(
    wanted: Search, p: int, low: float, first: float, second: float, last: bool, book: _Book, answer: Answer
) -> bool:
    """Whether the smallest gap of a pair in an interval is known well enough; book it.

    low : what it does not come below. first, second : its gaps at both ends, or what they do not come below.
    """
    touch = wanted.touch
    if not book.apart[p]:
        book.apart[p] = first > touch or second > touch
        if first <= touch:
            return True
    least = min(answer.gaps[0], book.waiting[p], first, second)
    # of prisms that touch there is no direction to go by, and nothing smaller to find
    if least > wanted.resolution and low < least - wanted.resolution and not last:
        return False
    book.waiting[p] = min(book.waiting[p], max(low, 0.0))
    if second > touch:
        answer.gaps[0] = min(answer.gaps[0], book.waiting[p])
        book.waiting[p] = math.inf
    return True


@lean
def _tell_apart(
    prisms: Prisms, pairs: Pairs, p: int, need: float, wait: float, book: _Book
) -> tuple[float, float, float]:
    """What the gap of a pair does not come below in an interval, and at its ends; the best found where that is less.

    The direction that told the pair apart before is tried first, then those of the shortest way at either end.
    """
    way = at(book.ways, p, 0)
    low, first, second = _gap(prisms, pairs, p, book.keepers[p], way, wait, book)
    if low > need:
        return low, first, second
    for end in range(2):
        distance, way = _nearest(prisms, pairs, p, book.seen[end], book)
        if end:
            second = distance
        else:
            first = distance
        for keeper in range(2):
            own = times(-1.0, _turned_back(book.seen[end], way)) if keeper else way
            found, _, _ = _gap(prisms, pairs, p, keeper, own, wait, book)
            if found > low:
                low = found
                book.keepers[p] = keeper
                put(book.ways, p, 0, own)
    return low, first, second


@lean
def _gap(
    prisms: Prisms, pairs: Pairs, p: int, keeper: int, way: Vector, wait: float, book: _Book
) -> tuple[float, float, float]:
    """What the gap along a direction does not come below in an interval, and the gaps at its ends.

    way : unit vector fixed to the panel of the first prism, pointing to the second, or with keeper 1 the other way.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    own, other = (g, f) if keeper else (f, g)
    top = _extent(prisms, own, way)
    gaps = (math.inf, math.inf)
    for end in range(2):
        seen = book.seen[end]
        if keeper:  # the place of the first panel, from the second, is -R^T t
            turned = _turned(seen, way)
            shift = -dot(turned, (seen[0, 3], seen[1, 3], seen[2, 3]))
        else:
            turned = _turned_back(seen, way)
            shift = dot(way, (seen[0, 3], seen[1, 3], seen[2, 3]))
        gap = shift - _extent(prisms, other, times(-1.0, turned)) - top
        gaps = (gaps[0], gap) if end else (gap, gaps[1])
    return min(gaps[0], gaps[1]) - book.bends[p, keeper] * wait * wait, gaps[0], gaps[1]


@lean
def _extent(prisms: Prisms, f: int, way: Vector) -> float:
    """How far a prism reaches along a direction, in the flat state."""
    far = -math.inf
    for k in range(prisms.counts[f, 0]):
        far = max(far, dot(way, at(prisms.vertices[f], k, 0)))
    return far


@lean
def _nearest(prisms: Prisms, pairs: Pairs, p: int, seen: Reals, book: _Book) -> tuple[float, Vector]:
    """Distance of a pair, and the direction from the first prism to the second, as the first panel sees it."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    for k in range(prisms.counts[g, 0]):
        x = _turned(seen, at(prisms.vertices[g], k, 0))
        put(book.points, k, 0, (x[0] + seen[0, 3], x[1] + seen[1, 3], x[2] + seen[2, 3]))
    guess = at(book.ways, p, 0)
    if book.keepers[p]:
        guess = times(-1.0, _turned(seen, guess))
    corners = prisms.counts[f, 0], prisms.counts[g, 0]
    distance, along, across, up = proximity(prisms.vertices[f], corners[0], book.points, corners[1], guess)
    return distance, (along, across, up)


@lean
def _spheres(prisms: Prisms, pairs: Pairs, p: int, seen: Reals) -> float:
    """What the distance of a pair does not come below, by the spheres around both."""
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    x = _turned(seen, at(prisms.middles, g, 0))
    way = minus((x[0] + seen[0, 3], x[1] + seen[1, 3], x[2] + seen[2, 3]), at(prisms.middles, f, 0))
    return math.sqrt(dot(way, way)) - float(prisms.reaches[f] + prisms.reaches[g])


@lean
def _relate(prisms: Prisms, pairs: Pairs, p: int, poses: Reals, seen: Reals) -> None:
    """Write the pose of the second panel of a pair, as the first sees it."""
    one = poses[prisms.panels[pairs.prisms[p, 0]]]
    two = poses[prisms.panels[pairs.prisms[p, 1]]]
    for j in range(4):
        x, y, z = two[0, j], two[1, j], two[2, j]
        if j == 3:
            x, y, z = x - one[0, 3], y - one[1, 3], z - one[2, 3]
        for i in range(3):
            seen[i, j] = one[0, i] * x + one[1, i] * y + one[2, i] * z


@lean
def _turned(pose: Reals, a: Vector) -> Vector:
    """The rotation of a pose, times a vector."""
    return (
        dot((pose[0, 0], pose[0, 1], pose[0, 2]), a),
        dot((pose[1, 0], pose[1, 1], pose[1, 2]), a),
        dot((pose[2, 0], pose[2, 1], pose[2, 2]), a),
    )


@lean
def _turned_back(pose: Reals, a: Vector) -> Vector:
    """The rotation of a pose, transposed, times a vector."""
    return (
        dot((pose[0, 0], pose[1, 0], pose[2, 0]), a),
        dot((pose[0, 1], pose[1, 1], pose[2, 1]), a),
        dot((pose[0, 2], pose[1, 2], pose[2, 2]), a),
    )
