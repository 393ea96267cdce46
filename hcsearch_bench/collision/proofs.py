"""Which of two distances is right: exact lower and upper bounds from the result of a search."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.collision.gjk import CORNER_INDEX_BITS, CORNER_INDEX_MASK
from hcsearch_bench.kernels.hull_gaps import write_hull_gaps

Exact = list[Fraction]

PROVED = 1e-12
"""An answer is right where it lies within exact bounds, or beyond them by this share of a panel's width."""


@dataclass(frozen=True)
class Disagreements:
    """Pairs on which two programs differ: how many, and of how many each is right."""

    beyond: int
    ours: int
    theirs: int


def settle(solids: Sequence[tuple[Reals, Reals]], ours: Reals, theirs: Reals, width: float) -> Disagreements:
    """Decide which program is right about some pairs of hulls; ours, theirs : distances, m."""
    within = PROVED * width
    right = [0, 0]
    for k, (one, two) in enumerate(solids):
        _, way, corners = search(one, two)
        lower, upper = bounds(one, two, way, corners)
        for side, distances in enumerate((ours, theirs)):
            right[side] += int(upper - lower <= within and lower - within <= distances[k] <= upper + within)
    return Disagreements(len(solids), *right)


def search(first: Reals, second: Reals) -> tuple[float, Reals, list[int]]:
    """Gap, direction and corners of two hulls by `closest`, from nowhere."""
    gap, way, corners = np.empty(1), np.zeros((1, 3)), np.full((1, 4), -1)
    counts = np.array([[len(first)], [len(second)]])
    write_hull_gaps(first[None], counts[0], second[None], counts[1], way, corners, gap)
    return float(gap[0]), way[0], corners[0].tolist()


def bounds(first: Reals, second: Reals, way: Reals, corners: Sequence[int]) -> tuple[float, float]:
    """Below and above the distance of two hulls: the gap along a direction, and a point of their difference's hull.

    corners : of `closest`, differences of vertices that carry the point; none: no upper bound. The bounds hold whatever
    the direction and the corners are: they are only good ones if these are.
    """
    one, two = ([[Fraction(x) for x in point] for point in points] for points in (first.tolist(), second.tolist()))
    n = [Fraction(x) for x in way.tolist()]
    gap = min(_dot(n, point) for point in two) - max(_dot(n, point) for point in one)
    lower = float(gap) / _root(_dot(n, n)) if gap > 0 else 0.0
    points = [
        [b - a for a, b in zip(one[c >> CORNER_INDEX_BITS], two[c & CORNER_INDEX_MASK], strict=True)]
        for c in corners
        if c >= 0
    ]
    if not points:
        return lower, math.inf
    # none below 0, so that what they lead to is in the hull
    shares = [max(share, Fraction(0)) for share in _shares(points)]
    whole = sum(shares, Fraction(0))
    nearest = [_dot(shares, [point[i] for point in points]) / whole for i in range(3)]
    return lower, _root(_dot(nearest, nearest))


def _shares(points: list[Exact]) -> Exact:
    """Those of the point nearest to the origin in the flat through some points; redundant points get 0."""
    edges: list[Exact] = []
    of: list[int] = []
    rows: list[Exact] = []
    for k, point in enumerate(points[1:], 1):
        edge = [a - b for a, b in zip(point, points[0], strict=True)]
        grown = [*edges, edge]
        gram = [[_dot(a, b) for b in grown] for a in grown]
        if _determinant(gram) != 0:
            edges, rows = grown, gram
            of.append(k)
    right = [-_dot(edge, points[0]) for edge in edges]
    shares = [Fraction(0)] * len(points)
    whole = _determinant(rows)
    for i, k in enumerate(of):
        replaced = [[*row[:i], r, *row[i + 1 :]] for row, r in zip(rows, right, strict=True)]
        shares[k] = _determinant(replaced) / whole
    shares[0] = 1 - sum(shares, Fraction(0))
    return shares


def _determinant(rows: list[Exact]) -> Fraction:
    if not rows:
        return Fraction(1)
    total = Fraction(0)
    for j, first in enumerate(rows[0]):
        total += (-1) ** j * first * _determinant([[*row[:j], *row[j + 1 :]] for row in rows[1:]])
    return total


def _dot(a: Exact, b: Exact) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _root(square: Fraction) -> float:
    """A square root, also of what is less than the least float."""
    if square == 0:
        return 0.0
    scale = 2 ** max(0, square.denominator.bit_length() - square.numerator.bit_length())
    return math.sqrt(float(square * scale)) / math.sqrt(scale)
