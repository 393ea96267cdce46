"""Distance of the convex hulls of two point sets by GJK, with a direction that certifies it.

A simplex of differences of vertices (second hull minus first) is moved towards the origin (Gilbert, Johnson and Keerthi
1988, https://doi.org/10.1109/56.2083). Only the end of the search differs: the length of the simplex's nearest point
bounds the distance from above, the gap of the hulls along a direction bounds it from below, and the search ends where
both agree. The direction is the normal of the simplex, not the normalised nearest point, which is noise where the hulls
nearly touch. Where rounding keeps both bounds apart, all candidate directions are tried.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, cross, dot, scaled_vector, vector_difference
from hcsearch.kernels.collision.simplices import (
    across_edge,
    across_flat,
    nearest_simplex_point,
    side_with_last,
    simplex_normal,
    unit_vector,
)
from hcsearch.kernels.compiling.compiled import inlined, lean

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


@lean
def hull_distance(
    first: Reals, n_first: int, second: Reals, n_second: int, guess: Vector3
) -> tuple[float, float, float, float]:
    """Return the distance of the hulls of two point sets, and the unit direction that certifies it.

    The direction points from the first hull to the second, and the distance is the gap along it: least coordinate of
    the second minus greatest of the first. Where the hulls touch or overlap the distance is 0, and the direction that
    of the greatest gap encountered, which need not separate touching hulls.

    first, second : (>= n, 3), of which the first n_first and n_second rows count. guess : direction to start from,
        usually the last result; zero for none.
    """
    gap, way, _ = hull_gap(first, n_first, second, n_second, guess, (-1, -1, -1, -1))
    return max(gap, 0.0), way[0], way[1], way[2]


@inlined
def hull_gap(
    first: Reals, n_first: int, second: Reals, n_second: int, guess: Vector3, corners: SimplexCorners
) -> HullGap:
    """Return signed gap, direction and final simplex of two hulls, starting from a direction and a simplex.

    Like `hull_distance`, but where the hulls touch or overlap the result is the gap along the direction, at most 0; the
    overlap is no greater than that.
    """
    long = math.sqrt(dot(guess, guess))
    guessed = MIN_DIRECTION_LENGTH < long < 1.0 / MIN_DIRECTION_LENGTH
    n = scaled_vector(1.0 / long, guess) if guessed else vector_difference(_row(second, 0), _row(first, 0))
    best, way = -math.inf, n if guessed else (1.0, 0.0, 0.0)
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
                best = gap_along(first, n_first, second, n_second, way)
            if best < -DISTANCE_RELATIVE_TOLERANCE * size and k > 2:
                best, way = _better(first, n_first, second, n_second, across_flat(k, p0, p1, p2, p3), best, way)
            return min(best, 0.0), way, (c0, c1, c2, c3)
        if k == 4:
            break
        n = simplex_normal(k, p0, p1, p2)
        corner = _facing(first, n_first, second, n_second, n)
        point = _difference(first, second, corner)
        size = max(size, _size(first, second, corner))
        lower = dot(n, point)
        if lower > best:
            best, way = lower, n
        if upper - best <= DISTANCE_RELATIVE_TOLERANCE * size:
            return best, way, (c0, c1, c2, c3)
        if corner in (c0, c1, c2):
            break
        if k == 1:
            p1, c1 = point, corner
        elif k == 2:
            p2, c2 = point, corner
        else:
            p3, c3 = point, corner
        k += 1
    best, way = exhaustive_gap(first, n_first, second, n_second)
    return best, way, (-1, -1, -1, -1)


@lean
def write_hull_gaps(
    first: Reals,
    n_first: WholeNumbers,
    second: Reals,
    n_second: WholeNumbers,
    ways: Reals,
    corners: WholeNumbers,
    gaps: Reals,
) -> None:
    """Write the gaps of pairs of hulls, and the directions and simplices at which the searches end; see `hull_gap`.

    first, second : (k, >= n, 3). n_first, n_second : (k,). ways, corners : (k, 3), (k, 4), directions and simplices
        from which the searches start, overwritten; 0 and -1 for none. gaps : (k,).
    """
    for k in range(len(gaps)):
        _write(first, n_first, second, n_second, ways, corners, gaps, k)


@lean
def _write(
    first: Reals,
    n_first: WholeNumbers,
    second: Reals,
    n_second: WholeNumbers,
    ways: Reals,
    corners: WholeNumbers,
    gaps: Reals,
    k: int,
) -> None:
    way, at = _row(ways, k), (corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3])
    gaps[k], way, at = hull_gap(first[k], n_first[k], second[k], n_second[k], way, at)
    ways[k, 0], ways[k, 1], ways[k, 2] = way
    corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3] = at


@inlined
def _row(points: Reals, k: int) -> Vector3:
    return points[k, 0], points[k, 1], points[k, 2]


@inlined
def _outermost(points: Reals, n: int, way: Vector3) -> int:
    """Return the index of the point furthest along a direction."""
    best, most = 0, -math.inf
    for k in range(n):
        far = points[k, 0] * way[0] + points[k, 1] * way[1] + points[k, 2] * way[2]
        if far > most:
            best, most = k, far
    return best


@inlined
def _facing(first: Reals, n_first: int, second: Reals, n_second: int, way: Vector3) -> int:
    """Return the packed difference of vertices that is least along a direction."""
    return (_outermost(first, n_first, way) << CORNER_INDEX_BITS) | _outermost(
        second, n_second, scaled_vector(-1.0, way)
    )


@inlined
def gap_along(first: Reals, n_first: int, second: Reals, n_second: int, way: Vector3) -> float:
    """Return the gap of two hulls along a direction."""
    return dot(way, _difference(first, second, _facing(first, n_first, second, n_second, way)))


@inlined
def _difference(first: Reals, second: Reals, corner: int) -> Vector3:
    return vector_difference(_row(second, corner & CORNER_INDEX_MASK), _row(first, corner >> CORNER_INDEX_BITS))


@inlined
def _size(first: Reals, second: Reals, corner: int) -> float:
    """Return the greatest absolute coordinate of two vertices, to which rounding is relative."""
    i, j = corner >> CORNER_INDEX_BITS, corner & CORNER_INDEX_MASK
    one, two = _row(first, i), _row(second, j)
    return max(abs(one[0]), abs(one[1]), abs(one[2]), abs(two[0]), abs(two[1]), abs(two[2]))


@lean
def exhaustive_gap(first: Reals, n_first: int, second: Reals, n_second: int) -> tuple[float, Vector3]:
    """Return the greatest gap of two hulls along all candidate directions, and that direction.

    The candidates, thousands of them, are the directions across all pairs of vertices, edges and faces. The gap is
    negative where the hulls overlap. This is the fallback where rounding makes the search fail.
    """
    best, way = -math.inf, (1.0, 0.0, 0.0)
    for i in range(n_first):
        a = _row(first, i)
        for j in range(n_second):
            b = _row(second, j)
            best, way = _better(first, n_first, second, n_second, unit_vector(vector_difference(b, a)), best, way)
            for m in range(j):
                n = across_edge(vector_difference(b, a), vector_difference(_row(second, m), a))
                best, way = _better(first, n_first, second, n_second, n, best, way)
            for k in range(i):
                e = vector_difference(_row(first, k), a)
                n = across_edge(vector_difference(b, a), vector_difference(b, _row(first, k)))
                best, way = _better(first, n_first, second, n_second, n, best, way)
                for m in range(j):
                    n = unit_vector(cross(e, vector_difference(_row(second, m), b)))
                    best, way = _better(first, n_first, second, n_second, n, best, way)
    for points, count in ((first, n_first), (second, n_second)):
        for i in range(count):
            a = _row(points, i)
            for j in range(i):
                for k in range(j):
                    n = unit_vector(cross(vector_difference(_row(points, j), a), vector_difference(_row(points, k), a)))
                    best, way = _better(first, n_first, second, n_second, n, best, way)
    return best, way


@lean
def _better(
    first: Reals, n_first: int, second: Reals, n_second: int, n: Vector3, best: float, way: Vector3
) -> tuple[float, Vector3]:
    """Return the best gap and its direction, updated by a direction and its opposite."""
    for sign in (1.0, -1.0):
        m = scaled_vector(sign, n)
        gap = gap_along(first, n_first, second, n_second, m)
        if gap > best:
            best, way = gap, m
    return best, way
