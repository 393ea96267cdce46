"""The least gap of prisms on a motion, below 0 where they overlap: minus how deep panels as built cut into each other.

An interval is halved until some direction shows that its gaps are no less than one that was met, but for a resolution.
Prisms that overlap are separated least by a normal of a face or the cross product of two edges.
"""

from __future__ import annotations

import math

from hcsearch.kernels.algebra.vectors import Vector, at, cross, dot, put, times
from hcsearch.kernels.collision.intervals import (
    Book,
    Course,
    begin,
    book_for,
    bound,
    chord_gap,
    halve,
    nearest,
    relate,
    spheres,
    turned,
)
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import Chain
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.linkage.reaches import Pairs

SHORTEST = 0.5**20
"""Share of a step below which gaps are not known better than they are."""
PARALLEL = 1e-6
"""Edges whose directions differ by less (rad) have no direction across both."""


@compiled
def least_gap(chain: Chain, prisms: Prisms, pairs: Pairs, course: Course, resolution: float) -> float:
    """The least gap that a pair has at a time of a motion, m; infinite without pairs.

    It is one that a pair has; at no time has one less by more than the resolution (m).
    """
    book = book_for(chain, prisms, pairs, course)
    least = _first(prisms, pairs, book)
    for k in range(len(course.times) - 1):
        h = begin(chain, prisms, pairs, course, k, least - resolution, book)
        top = 0 if h > 0.0 else -1
        while top >= 0:
            share = book.high[top] - book.low[top]
            left, least = _look(prisms, pairs, resolution, least, share * h, share <= SHORTEST, top, book)
            if not left:
                top -= 1
            else:
                halve(chain, left, top, book)
                top += 1
    return least


@lean
def _first(prisms: Prisms, pairs: Pairs, book: Book) -> float:
    """The least gap at the beginning of the motion."""
    least = math.inf
    for p in range(len(pairs.prisms)):
        for end in range(2):
            relate(prisms, pairs, p, book.highs[0], book.seen[end])
        if spheres(prisms, pairs, p, book.seen[1]) < least:
            gap = nearest(prisms, pairs, p, book.seen[1], book)[0]
            least = min(least, gap if gap > 0.0 else _along_axes(prisms, pairs, p, 1, 0.0, book)[0])
    return least


@lean
def _look(
    prisms: Prisms,
    pairs: Pairs,
    resolution: float,
    least: float,
    wait: float,
    last: bool,
    top: int,
    book: Book,
) -> tuple[int, float]:
    """Look at the pairs of an interval, a time `wait` long; those whose gap may come below move to the front.

    Returns how many these are, and the least gap with those at the ends of the interval.
    """
    left = 0
    for i in range(book.counts[top]):
        p = book.lists[top, i]
        low, first, second = bound(prisms, pairs, p, least - resolution, wait, top, book)
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
def _along_axes(prisms: Prisms, pairs: Pairs, p: int, end: int, wait: float, book: Book) -> tuple[float, float]:
    """The gap of a pair that overlaps at an end of an interval, and what it does not come below in all of that.

    Both are the greatest along normals of the first prism, of the second, and across edges of both, to either side.
    """
    f, g = pairs.prisms[p, 0], pairs.prisms[p, 1]
    a, b = prisms.counts[f, 1], prisms.counts[g, 1]
    gap, low = -math.inf, -math.inf
    for number in range(a + b + a * b):
        keeper = 0
        if number < a:
            way = at(prisms.normals[f], number, 0)
        elif number < a + b:
            keeper, way = 1, at(prisms.normals[g], number - a, 0)
        else:
            one = at(prisms.edges[f], (number - a - b) // b, 0)
            two = turned(book.seen[end], at(prisms.edges[g], (number - a - b) % b, 0))
            way = cross(one, two)
            length = math.sqrt(dot(way, way))
            if length < PARALLEL:
                continue
            way = times(1.0 / length, way)
        for side in range(2):
            own: Vector = times(-1.0, way) if side else way
            lower, first, second = chord_gap(prisms, pairs, p, keeper, own, wait, book)
            gap = max(gap, second if end else first)
            if lower > low:
                low = lower
                book.keepers[p] = keeper
                put(book.ways, p, 0, own)
    return gap, low
