"""Distance of two convex hulls of points: GJK, each answer with a direction that proves it.

A simplex of differences of vertices, of the second less of the first, is moved towards the origin (Gilbert, Johnson and
Keerthi 1988, https://doi.org/10.1109/56.2083). Its part nearest to the origin is found by signed volumes (Montanari,
Petrinic and Barbieri 2017, https://doi.org/10.1145/3083724). We depart from both in what ends the search: the length of
the nearest point bounds the distance from above, the gap of the hulls along a direction bounds it from below, and the
search ends where both agree. The direction is the normal of the simplex, not the nearest point made a unit vector,
which is noise where the hulls nearly touch. Where rounding keeps both bounds apart, all directions that can be the
answer are tried.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled, inlined, lean
from hcsearch.kernels.multibody.vectors import Vector, cross, dot, minus, times

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]
Corners = tuple[int, int, int, int]
"""Which differences of vertices span a simplex: the numbers in the first and in the second, packed; -1 for none."""
BITS = 20
MASK = (1 << BITS) - 1
Shares = tuple[float, float, float, float]
Answer = tuple[float, Vector, Corners]

EXACT = 1e-14
"""Both bounds of a distance agree where they differ by no more than this share of the coordinates."""
ROUNDS = 50
"""Steps after which a search is stuck; ten are many."""


@lean
def proximity(
    first: Reals, n_first: int, second: Reals, n_second: int, guess: Vector
) -> tuple[float, float, float, float]:
    """Distance of the hulls of two sets of points, and the unit direction from the first to the second that proves it.

    first, second : (>= n, 3), of which the first n_first and n_second rows count. guess : direction to start from, the
        last answer; zero for none. The distance is the gap of the hulls along the direction: least of the second less
        greatest of the first. Where they touch or overlap it is 0, and the direction any: that of the greatest gap that
        was met, which need not separate hulls that touch.
    """
    gap, way, _ = closest(first, n_first, second, n_second, guess, (-1, -1, -1, -1))
    return max(gap, 0.0), way[0], way[1], way[2]


@inlined
def closest(first: Reals, n_first: int, second: Reals, n_second: int, guess: Vector, corners: Corners) -> Answer:
    """The same, from the direction and the simplex of the last answer, and with the simplex of this one.

    Where they touch or overlap: the gap along the direction, not above 0; they overlap by no more than that.
    """
    long = math.sqrt(dot(guess, guess))
    n = minus(_row(second, 0), _row(first, 0)) if long == 0.0 else times(1.0 / long, guess)
    best, way = -math.inf, n if long > 0.0 else (1.0, 0.0, 0.0)
    c0, c1, c2, c3 = corners
    if c0 < 0:
        c0 = _facing(first, n_first, second, n_second, n)
        if long > 0.0:
            best = dot(n, _difference(first, second, c0))
    p0 = _difference(first, second, c0)
    p1 = _difference(first, second, c1) if c1 >= 0 else p0
    p2 = _difference(first, second, c2) if c2 >= 0 else p0
    p3 = _difference(first, second, c3) if c3 >= 0 else p0
    k = 1 + (c1 >= 0) + (c2 >= 0) + (c3 >= 0)
    size = _size(first, second, c0)
    upper = math.inf
    for step in range(ROUNDS):
        square, (s0, s1, s2, s3) = _nearest(k, p0, p1, p2, p3)
        if step > 0:
            # the last corner lies nearer along the direction: without rounding it would always stay
            if k == 2 and s1 <= 0.0:
                s0 = s1 = 1.0
            elif k == 3 and s2 <= 0.0:
                s0 = s1 = s2 = 1.0
            elif k == 4 and s3 <= 0.0:
                s0, s1, s2, s3 = _side_with_last(p0, p1, p2, p3)
        # what does not carry the nearest point is left out, and the rest moved to the front
        if s2 <= 0.0:
            p2, c2, s2, s3 = p3, c3, s3, 0.0
        if s1 <= 0.0:
            p1, c1, s1, p2, c2, s2, s3 = p2, c2, s2, p3, c3, s3, 0.0
        if s0 <= 0.0:
            p0, c0, s0, p1, c1, s1, p2, c2, s2, s3 = p1, c1, s1, p2, c2, s2, p3, c3, s3, 0.0
        k = 1 + (s1 > 0.0) + (s2 > 0.0) + (s3 > 0.0)
        c1, c2, c3 = c1 if k > 1 else -1, c2 if k > 2 else -1, c3 if k > 3 else -1
        upper = min(upper, math.sqrt(square))
        if upper <= EXACT * size:
            if best == -math.inf:
                best = gap_along(first, n_first, second, n_second, way)
            if best < -EXACT * size and k > 2:
                best, way = _better(first, n_first, second, n_second, _flat(k, p0, p1, p2, p3), best, way)
            return min(best, 0.0), way, (c0, c1, c2, c3)
        if k == 4:
            break
        n = _normal(k, p0, p1, p2)
        corner = _facing(first, n_first, second, n_second, n)
        point = _difference(first, second, corner)
        size = max(size, _size(first, second, corner))
        lower = dot(n, point)
        if lower > best:
            best, way = lower, n
        if upper - best <= EXACT * size:
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
    best, way = exhaustive(first, n_first, second, n_second)
    return best, way, (-1, -1, -1, -1)


@compiled
def closest_of_pairs(
    first: Reals, n_first: Whole, second: Reals, n_second: Whole, ways: Reals, corners: Whole, gaps: Reals
) -> None:
    """Write the gaps of pairs of hulls as `closest` does, and where each search ends.

    first, second : (k, >= n, 3). n_first, n_second : (k,). ways, corners : (k, 3), (k, 4), where each search begins;
        0 and -1 for anywhere. gaps : (k,).
    """
    for k in range(len(gaps)):
        _write(first, n_first, second, n_second, ways, corners, gaps, k)


@lean
def _write(
    first: Reals, n_first: Whole, second: Reals, n_second: Whole, ways: Reals, corners: Whole, gaps: Reals, k: int
) -> None:
    way, at = _row(ways, k), (corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3])
    gaps[k], way, at = closest(first[k], n_first[k], second[k], n_second[k], way, at)
    ways[k, 0], ways[k, 1], ways[k, 2] = way
    corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3] = at


@inlined
def _row(points: Reals, k: int) -> Vector:
    return points[k, 0], points[k, 1], points[k, 2]


@inlined
def _outermost(points: Reals, n: int, way: Vector) -> int:
    """The point that is furthest along a direction."""
    found, most = 0, -math.inf
    for k in range(n):
        far = points[k, 0] * way[0] + points[k, 1] * way[1] + points[k, 2] * way[2]
        if far > most:
            found, most = k, far
    return found


@inlined
def _facing(first: Reals, n_first: int, second: Reals, n_second: int, way: Vector) -> int:
    """The difference of vertices that is least along a direction."""
    return (_outermost(first, n_first, way) << BITS) | _outermost(second, n_second, times(-1.0, way))


@inlined
def gap_along(first: Reals, n_first: int, second: Reals, n_second: int, way: Vector) -> float:
    """The gap along a direction."""
    return dot(way, _difference(first, second, _facing(first, n_first, second, n_second, way)))


@inlined
def _difference(first: Reals, second: Reals, corner: int) -> Vector:
    return minus(_row(second, corner & MASK), _row(first, corner >> BITS))


@inlined
def _size(first: Reals, second: Reals, corner: int) -> float:
    """How large the coordinates of two vertices are, which is what is rounded."""
    i, j = corner >> BITS, corner & MASK
    one, two = _row(first, i), _row(second, j)
    return max(abs(one[0]), abs(one[1]), abs(one[2]), abs(two[0]), abs(two[1]), abs(two[2]))


@inlined
def _nearest(k: int, a: Vector, b: Vector, c: Vector, d: Vector) -> tuple[float, Shares]:
    """The point of a simplex nearest to the origin: square of its length, and the corners' shares, none below 0."""
    if k == 1:
        return dot(a, a), (1.0, 0.0, 0.0, 0.0)
    if k == 2:
        square, s, t = _nearest_of_edge(a, b)
        return square, (s, t, 0.0, 0.0)
    if k == 3:
        square, s, t, u = _nearest_of_triangle(a, b, c)
        return square, (s, t, u, 0.0)
    return _nearest_of_tetrahedron(a, b, c, d)


@inlined
def _nearest_of_edge(a: Vector, b: Vector) -> tuple[float, float, float]:
    e = minus(b, a)
    long = dot(e, e)
    t = -dot(a, e)
    if t <= 0.0 or long == 0.0:
        return dot(a, a), 1.0, 0.0
    if t >= long:
        return dot(b, b), 0.0, 1.0
    t /= long
    s = 1.0 - t
    x, y, z = s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]
    return x * x + y * y + z * z, s, t


@inlined
def _nearest_of_triangle(a: Vector, b: Vector, c: Vector) -> tuple[float, float, float, float]:
    n = cross(minus(b, a), minus(c, a))
    s, t, u = dot(n, cross(b, c)), dot(n, cross(c, a)), dot(n, cross(a, b))
    whole = s + t + u
    least, shares = math.inf, (0.0, 0.0, 0.0)
    if s > 0.0 and t > 0.0 and u > 0.0:
        shares = (s / whole, t / whole, u / whole)
        near = _point(a, b, c, c, (shares[0], shares[1], shares[2], 0.0))
        least = dot(near, near)
    # the nearest point lies on a side that the origin is beyond, or within; not above: without an area, too
    if not s > 0.0:
        square, x, y = _nearest_of_edge(b, c)
        if square < least:
            least, shares = square, (0.0, x, y)
    if not t > 0.0:
        square, x, y = _nearest_of_edge(a, c)
        if square < least:
            least, shares = square, (x, 0.0, y)
    if not u > 0.0:
        square, x, y = _nearest_of_edge(a, b)
        if square < least:
            least, shares = square, (x, y, 0.0)
    return least, shares[0], shares[1], shares[2]


@lean
def _nearest_of_tetrahedron(a: Vector, b: Vector, c: Vector, d: Vector) -> tuple[float, Shares]:
    m, n = cross(a, b), cross(c, d)
    s, t, u, v = dot(b, n), -dot(a, n), dot(d, m), -dot(c, m)
    whole = s + t + u + v
    if whole < 0.0:
        s, t, u, v, whole = -s, -t, -u, -v, -whole
    least, shares = math.inf, (0.0, 0.0, 0.0, 0.0)
    if s > 0.0 and t > 0.0 and u > 0.0 and v > 0.0:
        shares = (s / whole, t / whole, u / whole, v / whole)
        shares = _refined(a, b, c, d, shares)
        least = dot(_point(a, b, c, d, shares), _point(a, b, c, d, shares))
    if not s > 0.0:
        square, x, y, z = _nearest_of_triangle(b, c, d)
        if square < least:
            least, shares = square, (0.0, x, y, z)
    if not t > 0.0:
        square, x, y, z = _nearest_of_triangle(a, c, d)
        if square < least:
            least, shares = square, (x, 0.0, y, z)
    if not u > 0.0:
        square, x, y, z = _nearest_of_triangle(a, b, d)
        if square < least:
            least, shares = square, (x, y, 0.0, z)
    if not v > 0.0:
        square, x, y, z = _nearest_of_triangle(a, b, c)
        if square < least:
            least, shares = square, (x, y, z, 0.0)
    return least, shares


@lean
def _point(a: Vector, b: Vector, c: Vector, d: Vector, shares: Shares) -> Vector:
    s, t, u, v = shares
    return (
        s * a[0] + t * b[0] + u * c[0] + v * d[0],
        s * a[1] + t * b[1] + u * c[1] + v * d[1],
        s * a[2] + t * b[2] + u * c[2] + v * d[2],
    )


@lean
def _refined(a: Vector, b: Vector, c: Vector, d: Vector, shares: Shares) -> Shares:
    """Shares of the origin in a tetrahedron, corrected by where they lead: it may be flat."""
    off = _point(a, b, c, d, shares)
    x, y, z = minus(b, a), minus(c, a), minus(d, a)
    whole = dot(x, cross(y, z))
    if whole == 0.0:
        return shares
    t, u, v = dot(off, cross(y, z)) / whole, dot(off, cross(z, x)) / whole, dot(off, cross(x, y)) / whole
    found = (shares[0] + t + u + v, shares[1] - t, shares[2] - u, shares[3] - v)
    return found if found[0] > 0.0 and found[1] > 0.0 and found[2] > 0.0 and found[3] > 0.0 else shares


@lean
def _side_with_last(a: Vector, b: Vector, c: Vector, d: Vector) -> Shares:
    """The side of a tetrahedron, of those with its last corner, that is nearest to the origin; 0 for who is not in."""
    one, two, three = (
        _nearest_of_triangle(b, c, d)[0],
        _nearest_of_triangle(a, c, d)[0],
        _nearest_of_triangle(a, b, d)[0],
    )
    if one <= two and one <= three:
        return 0.0, 1.0, 1.0, 1.0
    return (1.0, 0.0, 1.0, 1.0) if two <= three else (1.0, 1.0, 0.0, 1.0)


@lean
def _flat(k: int, a: Vector, b: Vector, c: Vector, d: Vector) -> Vector:
    """The unit direction across a triangle, or a tetrahedron that is flat."""
    n = cross(minus(b, a), minus(c, a))
    if k == 4:
        # of the products of two opposite edges the greatest
        for m in (cross(minus(c, a), minus(d, b)), cross(minus(b, a), minus(d, c)), cross(minus(d, a), minus(c, b))):
            if dot(m, m) > dot(n, n):
                n = m
    return _unit(n)


@inlined
def _normal(k: int, a: Vector, b: Vector, c: Vector) -> Vector:
    """The unit direction away from the origin across a point, an edge or a triangle that it is nearest to."""
    if k == 1:
        return _unit(a)
    if k == 2:
        return _across(a, b)
    # of the three sides, the two shorter ones
    e, f, g = minus(b, a), minus(c, a), minus(c, b)
    ee, ff, gg = dot(e, e), dot(f, f), dot(g, g)
    if ee >= ff and ee >= gg:
        e = g
    elif ff >= gg:
        f = g
    n = cross(e, f)
    long = dot(n, a)
    return _unit(times(-1.0, n) if long < 0.0 else n)


@inlined
def _across(a: Vector, b: Vector) -> Vector:
    """The unit direction to the line through two points."""
    e = minus(b, a)
    long = dot(e, e)
    if dot(b, b) < dot(a, a):
        a = b
    if long == 0.0:
        return _unit(a)
    share = 1.0 / long
    t = share * dot(a, e)
    n = _unit((a[0] - t * e[0], a[1] - t * e[1], a[2] - t * e[2]))
    # again: what rounding has left along the line counts by the line's length, not by the distance
    t = share * dot(n, e)
    n = (n[0] - t * e[0], n[1] - t * e[1], n[2] - t * e[2])
    off = 1.0 - dot(n, n)
    return times(1.0 + 0.5 * off, n) if off < 1e-8 else _unit(n)


@inlined
def _unit(a: Vector) -> Vector:
    square = dot(a, a)
    return times(1.0 / math.sqrt(square), a) if square > 0.0 else (1.0, 0.0, 0.0)


@lean
def exhaustive(first: Reals, n_first: int, second: Reals, n_second: int) -> tuple[float, Vector]:
    """The greatest gap along all directions across vertices, edges and faces that can face each other, and where.

    Below 0 where the hulls overlap. Thousands of directions: for what rounding keeps the search from.
    """
    best, way = -math.inf, (1.0, 0.0, 0.0)
    for i in range(n_first):
        a = _row(first, i)
        for j in range(n_second):
            b = _row(second, j)
            best, way = _better(first, n_first, second, n_second, _unit(minus(b, a)), best, way)
            for m in range(j):
                n = _across(minus(b, a), minus(_row(second, m), a))
                best, way = _better(first, n_first, second, n_second, n, best, way)
            for k in range(i):
                e = minus(_row(first, k), a)
                n = _across(minus(b, a), minus(b, _row(first, k)))
                best, way = _better(first, n_first, second, n_second, n, best, way)
                for m in range(j):
                    n = _unit(cross(e, minus(_row(second, m), b)))
                    best, way = _better(first, n_first, second, n_second, n, best, way)
    for points, count in ((first, n_first), (second, n_second)):
        for i in range(count):
            a = _row(points, i)
            for j in range(i):
                for k in range(j):
                    n = _unit(cross(minus(_row(points, j), a), minus(_row(points, k), a)))
                    best, way = _better(first, n_first, second, n_second, n, best, way)
    return best, way


@lean
def _better(
    first: Reals, n_first: int, second: Reals, n_second: int, n: Vector, best: float, way: Vector
) -> tuple[float, Vector]:
    """The gap along a direction or its opposite, where it is greater."""
    for sign in (1.0, -1.0):
        m = times(sign, n)
        gap = gap_along(first, n_first, second, n_second, m)
        if gap > best:
            best, way = gap, m
    return best, way
