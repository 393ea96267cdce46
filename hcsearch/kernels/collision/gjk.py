"""Distance of the convex hulls of two point sets by GJK, with a direction that certifies it.

A simplex of differences of vertices (second hull minus first) is moved towards the origin (Gilbert, Johnson and Keerthi
1988, https://doi.org/10.1109/56.2083). Only the end of the search differs: the length of the simplex's nearest point
bounds the distance from above, the gap of the hulls along a direction bounds it from below, and the search ends where
both agree. The direction is the normal of the simplex, not the normalised nearest point, which is noise where the hulls
nearly touch. Where rounding keeps both bounds apart, all candidate directions are tried.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import Vector3, cross, dot, scaled_vector, vector_difference
from hcsearch.kernels.collision.simplices import (
    across_edge,
    across_flat,
    nearest_simplex_point,
    side_with_last,
    simplex_normal,
    unit_vector,
)
from hcsearch.kernels.compiling.compiled import compiled

SimplexCorners = tuple[int, int, int, int]
"""Differences of vertices that span a simplex: indices in the first and second hull, packed; -1 for none."""
CORNER_INDEX_BITS = 20
CORNER_INDEX_MASK = (1 << CORNER_INDEX_BITS) - 1
HullGap = tuple[float, Vector3, SimplexCorners]

DISTANCE_RELATIVE_TOLERANCE = 1e-14
"""Difference, relative to the coordinates, up to which both bounds of a distance agree."""
MIN_DIRECTION_LENGTH = 1e-100
"""Shortest vector accepted as a starting direction: the squares of shorter ones lose digits."""
MAX_SIMPLEX_STEPS = 50
"""Steps after which a search counts as stuck; more than ten are rare."""


@compiled
def hull_gap(
    first: Reals, n_first: int, second: Reals, n_second: int, guess: Vector3, corners: SimplexCorners
) -> HullGap:
    """Return signed gap, direction and final simplex of two hulls, starting from a direction and a simplex.

    The unit direction points from the first hull to the second and certifies the gap along it, m: least coordinate of
    the second minus greatest of the first. Where the hulls touch or overlap it is the greatest gap encountered, at most
    0, and its direction need not separate touching hulls; the overlap is no greater than that.

    first, second : (>= n, 3), of which the first n_first and n_second rows count. guess : direction to start from,
        usually the last result; zero for none.
    """
    length = math.sqrt(dot(guess, guess))
    guessed = MIN_DIRECTION_LENGTH < length < 1.0 / MIN_DIRECTION_LENGTH
    n = scaled_vector(1.0 / length, guess) if guessed else vector_difference(_row(second, 0), _row(first, 0))
    best, direction = -math.inf, n if guessed else (1.0, 0.0, 0.0)
    c0, c1, c2, c3 = corners
    if c0 < 0:
        c0 = _facing(first, n_first, second, n_second, n)
        if guessed:
            best = dot(n, _difference(first, second, c0))
    p0 = _difference(first, second, c0)
    p1 = _difference(first, second, c1) if c1 >= 0 else p0
    p2 = _difference(first, second, c2) if c2 >= 0 else p0
    p3 = _difference(first, second, c3) if c3 >= 0 else p0
    k = 1 + (c1 >= 0) + (c2 >= 0) + (c3 >= 0)
    size = _size(first, second, c0)
    upper = math.inf
    for step in range(MAX_SIMPLEX_STEPS):
        square, (s0, s1, s2, s3) = nearest_simplex_point(k, p0, p1, p2, p3)
        if step > 0:
            # the last corner lies nearer along the direction: in exact arithmetic it would always stay
            if k == 2 and s1 <= 0.0:
                s0 = s1 = 1.0
            elif k == 3 and s2 <= 0.0:
                s0 = s1 = s2 = 1.0
            elif k == 4 and s3 <= 0.0:
                s0, s1, s2, s3 = side_with_last(p0, p1, p2, p3)
        # drop corners that do not support the nearest point, and move the others to the front
        if s2 <= 0.0:
            p2, c2, s2, s3 = p3, c3, s3, 0.0
        if s1 <= 0.0:
            p1, c1, s1, p2, c2, s2, s3 = p2, c2, s2, p3, c3, s3, 0.0
        if s0 <= 0.0:
            p0, c0, s0, p1, c1, s1, p2, c2, s2, s3 = p1, c1, s1, p2, c2, s2, p3, c3, s3, 0.0
        k = 1 + (s1 > 0.0) + (s2 > 0.0) + (s3 > 0.0)
        c1, c2, c3 = c1 if k > 1 else -1, c2 if k > 2 else -1, c3 if k > 3 else -1
        upper = min(upper, math.sqrt(square))
        if upper <= DISTANCE_RELATIVE_TOLERANCE * size:
            if best == -math.inf:
                best = gap_along(first, n_first, second, n_second, direction)
            if best < -DISTANCE_RELATIVE_TOLERANCE * size and k > 2:
                best, direction = _best_gap(
                    first, n_first, second, n_second, across_flat(k, p0, p1, p2, p3), best, direction
                )
            return min(best, 0.0), direction, (c0, c1, c2, c3)
        if k == 4:
            break
        n = simplex_normal(k, p0, p1, p2)
        corner = _facing(first, n_first, second, n_second, n)
        point = _difference(first, second, corner)
        size = max(size, _size(first, second, corner))
        lower = dot(n, point)
        if lower > best:
            best, direction = lower, n
        if upper - best <= DISTANCE_RELATIVE_TOLERANCE * size:
            return best, direction, (c0, c1, c2, c3)
        if corner in (c0, c1, c2):
            break
        if k == 1:
            p1, c1 = point, corner
        elif k == 2:
            p2, c2 = point, corner
        else:
            p3, c3 = point, corner
        k += 1
    best, direction = exhaustive_gap(first, n_first, second, n_second)
    return best, direction, (-1, -1, -1, -1)


@compiled
def _row(points: Reals, k: int) -> Vector3:
    return points[k, 0], points[k, 1], points[k, 2]


@compiled
def _outermost(points: Reals, n: int, direction: Vector3) -> int:
    """Return the index of the point furthest along a direction."""
    best, furthest = 0, -math.inf
    for k in range(n):
        coordinate = points[k, 0] * direction[0] + points[k, 1] * direction[1] + points[k, 2] * direction[2]
        if coordinate > furthest:
            best, furthest = k, coordinate
    return best


@compiled
def _facing(first: Reals, n_first: int, second: Reals, n_second: int, direction: Vector3) -> int:
    """Return the packed difference of vertices that is least along a direction."""
    return (_outermost(first, n_first, direction) << CORNER_INDEX_BITS) | _outermost(
        second, n_second, scaled_vector(-1.0, direction)
    )


@compiled
def gap_along(first: Reals, n_first: int, second: Reals, n_second: int, direction: Vector3) -> float:
    """Return the gap of two hulls along a direction."""
    return dot(direction, _difference(first, second, _facing(first, n_first, second, n_second, direction)))


@compiled
def _difference(first: Reals, second: Reals, corner: int) -> Vector3:
    return vector_difference(_row(second, corner & CORNER_INDEX_MASK), _row(first, corner >> CORNER_INDEX_BITS))


@compiled
def _size(first: Reals, second: Reals, corner: int) -> float:
    """Return the greatest absolute coordinate of two vertices, to which rounding is relative."""
    x, y, z = _row(first, corner >> CORNER_INDEX_BITS)
    u, v, w = _row(second, corner & CORNER_INDEX_MASK)
    return max(abs(x), abs(y), abs(z), abs(u), abs(v), abs(w))


@compiled
def exhaustive_gap(first: Reals, n_first: int, second: Reals, n_second: int) -> tuple[float, Vector3]:
    """Return the greatest gap of two hulls along all candidate directions, and that direction.

    The candidates, thousands of them, are the directions across all pairs of vertices, edges and faces. The gap is
    negative where the hulls overlap. This is the fallback where rounding makes the search fail.
    """
    best, direction = -math.inf, (1.0, 0.0, 0.0)
    for i in range(n_first):
        a = _row(first, i)
        for j in range(n_second):
            b = _row(second, j)
            best, direction = _best_gap(
                first, n_first, second, n_second, unit_vector(vector_difference(b, a)), best, direction
            )
            for m in range(j):
                n = across_edge(vector_difference(b, a), vector_difference(_row(second, m), a))
                best, direction = _best_gap(first, n_first, second, n_second, n, best, direction)
            for k in range(i):
                e = vector_difference(_row(first, k), a)
                n = across_edge(vector_difference(b, a), vector_difference(b, _row(first, k)))
                best, direction = _best_gap(first, n_first, second, n_second, n, best, direction)
                for m in range(j):
                    n = unit_vector(cross(e, vector_difference(_row(second, m), b)))
                    best, direction = _best_gap(first, n_first, second, n_second, n, best, direction)
    for points, count in ((first, n_first), (second, n_second)):
        for i in range(count):
            a = _row(points, i)
            for j in range(i):
                for k in range(j):
                    n = unit_vector(cross(vector_difference(_row(points, j), a), vector_difference(_row(points, k), a)))
                    best, direction = _best_gap(first, n_first, second, n_second, n, best, direction)
    return best, direction


@compiled
def _best_gap(
    first: Reals, n_first: int, second: Reals, n_second: int, n: Vector3, best: float, direction: Vector3
) -> tuple[float, Vector3]:
    """Return the best gap and its direction, updated by a direction and its opposite."""
    for sign in (1.0, -1.0):
        m = scaled_vector(sign, n)
        gap = gap_along(first, n_first, second, n_second, m)
        if gap > best:
            best, direction = gap, m
    return best, direction
