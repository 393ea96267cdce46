"""Simplices of up to four points: the point nearest to the origin, and normals.

The method is that of signed volumes (Montanari, Petrinic and Barbieri 2017, https://doi.org/10.1145/3083724): the
nearest point lies inside, or on one of the sides that face the origin.
"""

from __future__ import annotations

import math

from hcsearch.kernels.algebra import Vector3, cross, dot, scaled_vector, vector_difference
from hcsearch.kernels.compiling.compiled import compiled

CornerShares = tuple[float, float, float, float]
"""Barycentric coordinates of a point of a simplex; they sum to 1."""


@compiled
def nearest_simplex_point(k: int, a: Vector3, b: Vector3, c: Vector3, d: Vector3) -> tuple[float, CornerShares]:
    """Return squared length and barycentric coordinates (none below 0) of a simplex's point nearest to the origin."""
    if k == 1:
        return dot(a, a), (1.0, 0.0, 0.0, 0.0)
    if k == 2:
        square, s, t = _of_edge(a, b)
        return square, (s, t, 0.0, 0.0)
    if k == 3:
        square, s, t, u = _of_triangle(a, b, c)
        return square, (s, t, u, 0.0)
    return _of_tetrahedron(a, b, c, d)


@compiled
def _of_edge(a: Vector3, b: Vector3) -> tuple[float, float, float]:
    e = vector_difference(b, a)
    square_length = dot(e, e)
    t = -dot(a, e)
    if t <= 0.0 or square_length == 0.0:
        return dot(a, a), 1.0, 0.0
    if t >= square_length:
        return dot(b, b), 0.0, 1.0
    t /= square_length
    s = 1.0 - t
    x, y, z = s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]
    return x * x + y * y + z * z, s, t


@compiled
def _of_triangle(a: Vector3, b: Vector3, c: Vector3) -> tuple[float, float, float, float]:
    n = cross(vector_difference(b, a), vector_difference(c, a))
    s, t, u = dot(n, cross(b, c)), dot(n, cross(c, a)), dot(n, cross(a, b))
    total = s + t + u
    least_square, shares = math.inf, (0.0, 0.0, 0.0)
    if s > 0.0 and t > 0.0 and u > 0.0:
        shares = (s / total, t / total, u / total)
        nearest = _point(a, b, c, c, (shares[0], shares[1], shares[2], 0.0))
        least_square = dot(nearest, nearest)
    # else it lies on a side that faces the origin; on any side, where the area is 0
    if not s > 0.0:
        square, x, y = _of_edge(b, c)
        if square < least_square:
            least_square, shares = square, (0.0, x, y)
    if not t > 0.0:
        square, x, y = _of_edge(a, c)
        if square < least_square:
            least_square, shares = square, (x, 0.0, y)
    if not u > 0.0:
        square, x, y = _of_edge(a, b)
        if square < least_square:
            least_square, shares = square, (x, y, 0.0)
    return least_square, shares[0], shares[1], shares[2]


@compiled
def _of_tetrahedron(a: Vector3, b: Vector3, c: Vector3, d: Vector3) -> tuple[float, CornerShares]:
    m, n = cross(a, b), cross(c, d)
    s, t, u, v = dot(b, n), -dot(a, n), dot(d, m), -dot(c, m)
    volume = s + t + u + v
    if volume < 0.0:
        s, t, u, v, volume = -s, -t, -u, -v, -volume
    least_square, shares = math.inf, (0.0, 0.0, 0.0, 0.0)
    if s > 0.0 and t > 0.0 and u > 0.0 and v > 0.0:
        shares = (s / volume, t / volume, u / volume, v / volume)
        shares = _refined(a, b, c, d, shares)
        least_square = dot(_point(a, b, c, d, shares), _point(a, b, c, d, shares))
    if not s > 0.0:
        square, x, y, z = _of_triangle(b, c, d)
        if square < least_square:
            least_square, shares = square, (0.0, x, y, z)
    if not t > 0.0:
        square, x, y, z = _of_triangle(a, c, d)
        if square < least_square:
            least_square, shares = square, (x, 0.0, y, z)
    if not u > 0.0:
        square, x, y, z = _of_triangle(a, b, d)
        if square < least_square:
            least_square, shares = square, (x, y, 0.0, z)
    if not v > 0.0:
        square, x, y, z = _of_triangle(a, b, c)
        if square < least_square:
            least_square, shares = square, (x, y, z, 0.0)
    return least_square, shares


@compiled
def _point(a: Vector3, b: Vector3, c: Vector3, d: Vector3, shares: CornerShares) -> Vector3:
    s, t, u, v = shares
    return (
        s * a[0] + t * b[0] + u * c[0] + v * d[0],
        s * a[1] + t * b[1] + u * c[1] + v * d[1],
        s * a[2] + t * b[2] + u * c[2] + v * d[2],
    )


@compiled
def _refined(a: Vector3, b: Vector3, c: Vector3, d: Vector3, shares: CornerShares) -> CornerShares:
    """Return corrected barycentric coordinates of the origin in a tetrahedron, which may be nearly flat."""
    error = _point(a, b, c, d, shares)
    x, y, z = vector_difference(b, a), vector_difference(c, a), vector_difference(d, a)
    volume = dot(x, cross(y, z))
    if volume == 0.0:
        return shares
    t, u, v = dot(error, cross(y, z)) / volume, dot(error, cross(z, x)) / volume, dot(error, cross(x, y)) / volume
    shifted = (shares[0] + t + u + v, shares[1] - t, shares[2] - u, shares[3] - v)
    return shifted if shifted[0] > 0.0 and shifted[1] > 0.0 and shifted[2] > 0.0 and shifted[3] > 0.0 else shares


@compiled
def side_with_last(a: Vector3, b: Vector3, c: Vector3, d: Vector3) -> CornerShares:
    """Return, as 1 or 0 per corner, the side nearest to the origin among those with a tetrahedron's last corner."""
    opposite_a, opposite_b, opposite_c = (_of_triangle(b, c, d)[0], _of_triangle(a, c, d)[0], _of_triangle(a, b, d)[0])
    if opposite_a <= opposite_b and opposite_a <= opposite_c:
        return 0.0, 1.0, 1.0, 1.0
    return (1.0, 0.0, 1.0, 1.0) if opposite_b <= opposite_c else (1.0, 1.0, 0.0, 1.0)


@compiled
def across_flat(k: int, a: Vector3, b: Vector3, c: Vector3, d: Vector3) -> Vector3:
    """Return the unit normal of a triangle, or of a flat tetrahedron."""
    n = cross(vector_difference(b, a), vector_difference(c, a))
    if k == 4:
        # the greatest of the cross products of opposite edges
        for m in (
            cross(vector_difference(c, a), vector_difference(d, b)),
            cross(vector_difference(b, a), vector_difference(d, c)),
            cross(vector_difference(d, a), vector_difference(c, b)),
        ):
            if dot(m, m) > dot(n, n):
                n = m
    return unit_vector(n)


@compiled
def simplex_normal(k: int, a: Vector3, b: Vector3, c: Vector3) -> Vector3:
    """Return the unit normal, away from the origin, of the point, edge or triangle nearest to it."""
    if k == 1:
        return unit_vector(a)
    if k == 2:
        return across_edge(a, b)
    # of the three sides, the two shorter ones
    e, f, g = vector_difference(b, a), vector_difference(c, a), vector_difference(c, b)
    ee, ff, gg = dot(e, e), dot(f, f), dot(g, g)
    if ee >= ff and ee >= gg:
        e = g
    elif ff >= gg:
        f = g
    n = cross(e, f)
    height = dot(n, a)
    return unit_vector(scaled_vector(-1.0, n) if height < 0.0 else n)


@compiled
def across_edge(a: Vector3, b: Vector3) -> Vector3:
    """Return the unit direction from the origin to the line through two points."""
    e = vector_difference(b, a)
    square_length = dot(e, e)
    if dot(b, b) < dot(a, a):
        a = b
    if square_length == 0.0:
        return unit_vector(a)
    share = 1.0 / square_length
    t = share * dot(a, e)
    n = unit_vector((a[0] - t * e[0], a[1] - t * e[1], a[2] - t * e[2]))
    # again: the rounding error along the line is relative to the line's length, not to the distance
    t = share * dot(n, e)
    n = (n[0] - t * e[0], n[1] - t * e[1], n[2] - t * e[2])
    excess = 1.0 - dot(n, n)
    return scaled_vector(1.0 + 0.5 * excess, n) if excess < 1e-8 else unit_vector(n)


@compiled
def unit_vector(a: Vector3) -> Vector3:
    """Return a normalised vector; the first axis for a zero vector."""
    square = dot(a, a)
    return scaled_vector(1.0 / math.sqrt(square), a) if square > 0.0 else (1.0, 0.0, 0.0)
