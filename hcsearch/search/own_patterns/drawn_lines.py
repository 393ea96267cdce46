"""Lines and points of a drawing: the plane that they lie in, and lines split where they meet.

Programs draw lines of any length, each with ends of its own. Points nearer to each other than a tolerance are one
place, at their mean. A line that is shorter vanishes, and a line is split at each place on it and at each line that it
crosses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.shape.mesh import PlanePoint

MAX_LINE_PAIRS_AT_ONCE = 4_000_000
"""Pairs of lines that are looked at together, at most."""


_SHARE, _REACH = 0.25, 0.26
"""The tolerance as a share of the cells that points are looked up in, and how far a point looks, rounding included."""


class CrossingError(ValueError):
    """Lines that cross more often than is allowed."""


class SplitLines(NamedTuple):
    """Lines that meet at their ends only.

    points : places, those of the ends first, then crossings. place : of each point that was given, -1 where no line
    ends there. ways : of each line that was given, the places along it, from its first end to its second; none where it
    vanishes.
    """

    points: list[PlanePoint]
    place: list[int]
    ways: list[list[int]]


class PointNumbers:
    """Numbers of points of the plane, the same for points nearer than a tolerance."""

    def __init__(self, tolerance: float) -> None:
        self._step = tolerance / _SHARE
        self._near = tolerance
        self._known: dict[tuple[int, int], list[tuple[PlanePoint, int]]] = {}
        self._count = 0

    def number(self, point: PlanePoint) -> int:
        """The number of a point: that of the first one that is the same."""
        x, y = point[0] / self._step, point[1] / self._step
        rows = range(math.floor(y - _REACH), math.floor(y + _REACH) + 1)
        for i in range(math.floor(x - _REACH), math.floor(x + _REACH) + 1):
            for j in rows:
                for other, number in self._known.get((i, j), ()):
                    if math.dist(point, other) < self._near:
                        return number
        self._known.setdefault((math.floor(x), math.floor(y)), []).append((point, self._count))
        self._count += 1
        return self._count - 1


def split_lines(points: Reals, lines: Sequence[tuple[int, int]], tolerance: float, most: int) -> SplitLines:
    """Split lines, given by numbers of points, shape (k, 2); CrossingError where they cross more than `most` times."""
    places, own, place = _merged(points, lines, tolerance)
    ends = [(place[a], place[b]) for a, b in lines]
    distinct = sorted({(min(pair), max(pair)) for pair in ends if pair[0] != pair[1]})
    number = {pair: k for k, pair in enumerate(distinct)}
    along: list[dict[int, float]] = [{} for _ in distinct]
    if distinct:
        table, sides = np.array(own), np.array(distinct)
        for v, k, share in _on_lines(table, sides, tolerance, most):
            along[k][v] = share
        for j, k, x, shares in _crossings(table, sides, along, most):
            v = places.number(x)
            if v == len(own):
                own.append(x)
            for line, share in ((j, shares[0]), (k, shares[1])):
                if v not in distinct[line]:
                    along[line].setdefault(v, share)
    ways: list[list[int]] = []
    for a, b in ends:
        if a == b:
            ways.append([])
            continue
        low, high = min(a, b), max(a, b)
        within = along[number[low, high]]
        way = [low, *sorted(within, key=within.__getitem__), high]
        ways.append(way if a < b else way[::-1])
    return SplitLines(own, place, ways)


def _merged(
    points: Reals, lines: Sequence[tuple[int, int]], tolerance: float
) -> tuple[PointNumbers, list[PlanePoint], list[int]]:
    """The places of points at which lines end: to look them up, where they are, and the place of each point."""
    places, place = PointNumbers(tolerance), [-1] * len(points)
    members: list[list[int]] = []
    for v in dict.fromkeys(v for line in lines for v in line):
        place[v] = places.number((float(points[v, 0]), float(points[v, 1])))
        if place[v] == len(members):
            members.append([])
        members[place[v]].append(v)
    own = []
    for group in members:
        first = points[group[0]]
        x, y = first + (points[group] - first).mean(axis=0)  # points that are the same keep their digits
        own.append((float(x), float(y)))
    return places, own, place


def _on_lines(points: Reals, lines: WholeNumbers, tolerance: float, most: int) -> list[tuple[int, int, float]]:
    """Places that lie within lines, each with its line and its share of the way along it."""
    import shapely  # noqa: PLC0415 - only drawings need it

    starts, ways = points[lines[:, 0]], points[lines[:, 1]] - points[lines[:, 0]]
    found: list[tuple[int, int, float]] = []
    tree = shapely.STRtree(shapely.points(points))
    for part, (low, high) in _boxes(points, lines, tolerance):
        k, v = tree.query(shapely.box(*low.T, *high.T))
        k = k + part
        arms, own = points[v] - starts[k], ways[k]
        squares = (own * own).sum(axis=1)
        shares = (arms * own).sum(axis=1) / squares
        off = np.abs(own[:, 0] * arms[:, 1] - own[:, 1] * arms[:, 0]) / np.sqrt(squares)
        on = (off < tolerance) & (shares > 0.0) & (shares < 1.0) & (lines[k] != v[:, None]).all(axis=1)
        found += zip(v[on].tolist(), k[on].tolist(), shares[on].tolist(), strict=True)
        if len(found) > most:
            raise CrossingError
    return found


def _crossings(
    points: Reals, lines: WholeNumbers, along: Sequence[dict[int, float]], most: int
) -> list[tuple[int, int, PlanePoint, tuple[float, float]]]:
    """Where two lines cross that no place on both of them joins: the lines, the point, and its shares of both ways."""
    import shapely  # noqa: PLC0415

    starts, ways = points[lines[:, 0]], points[lines[:, 1]] - points[lines[:, 0]]
    found: list[tuple[int, int, PlanePoint, tuple[float, float]]] = []
    boxes = _boxes(points, lines, 0.0)
    tree = shapely.STRtree(np.concatenate([shapely.box(*low.T, *high.T) for _, (low, high) in boxes]))
    for part, (low, high) in boxes:
        j, k = tree.query(shapely.box(*low.T, *high.T))
        j = j + part
        j, k = j[j < k], k[j < k]
        a, b, apart = ways[j], ways[k], starts[k] - starts[j]
        across = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (apart[:, 0] * b[:, 1] - apart[:, 1] * b[:, 0]) / across
            t = (apart[:, 0] * a[:, 1] - apart[:, 1] * a[:, 0]) / across
        meet = (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
        for one, two, share, other in zip(j[meet].tolist(), k[meet].tolist(), s[meet], t[meet], strict=True):
            if not _joined(lines[one].tolist(), lines[two].tolist(), along[one], along[two]):
                x, y = starts[one] + share * ways[one]
                found.append((one, two, (float(x), float(y)), (float(share), float(other))))
                if len(found) > most:
                    raise CrossingError
    return found


def _joined(one: list[int], two: list[int], on_one: dict[int, float], on_two: dict[int, float]) -> bool:
    """Whether two lines have a place in common already, so that they meet there."""
    return any(v in one or v in on_one for v in two) or any(v in on_two for v in (*one, *on_one))


def _boxes(points: Reals, lines: WholeNumbers, wider: float) -> list[tuple[int, tuple[Reals, Reals]]]:
    """Boxes around lines, in parts: the number of the first, and the lower and upper corners of all."""
    ends = points[lines]
    low, high = ends.min(axis=1) - wider, ends.max(axis=1) + wider
    size = max(1, MAX_LINE_PAIRS_AT_ONCE // max(len(lines), len(points)))
    return [(k, (low[k : k + size], high[k : k + size])) for k in range(0, len(lines), size)]


FLAT_COORDINATE_SHARE = 1e-6
"""A coordinate that changes by less than this share of the greatest extent is the same for all points."""

_UP = (
    (2, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])),
    (1, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])),
    (0, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])),
)
"""Axes that may be upright on a drawing, z before y as in most programs, and the x and y of one that lies square to it,
seen from above the axis."""


def in_plane(points: Reals) -> tuple[Reals, Reals]:
    """Points, shape (k, 3), in the plane that they lie in: (k, 2), and how far each is off it, (k,).

    The plane has the least squares of distances. It is seen from the side that the nearest axis points to, without a
    turn about its normal; points that lie square to an axis keep their coordinates.
    """
    extent: Reals = np.ptp(points, axis=0)
    for axis, across in _UP:
        if extent[axis] <= FLAT_COORDINATE_SHARE * extent.max():
            return points @ across.T, np.zeros(len(points))
    middle = points.mean(axis=0)
    _, _, ways = np.linalg.svd(points - middle, full_matrices=False)
    normal = ways[2]
    nearest = max((abs(normal[axis]) * (1.0 + FLAT_COORDINATE_SHARE * axis), axis) for axis, _ in _UP)[1]
    axis, across = next(up for up in _UP if up[0] == nearest)
    normal = normal * math.copysign(1.0, normal[axis])
    upright = np.zeros(3)
    upright[axis] = 1.0
    # the rotation by the least angle that takes the axis to the normal
    turned = across - np.outer(across @ normal, upright + normal) / (1.0 + normal[axis])
    return points @ turned.T, np.abs((points - middle) @ normal)


def place_text(point: Sequence[float], side: float) -> str:
    """A point as messages write it, rounded to a thousandth of a side."""
    decimals = 3 - math.floor(math.log10(side)) if side > 0.0 and math.isfinite(side) else 9
    return "(" + ", ".join(f"{round(float(x), decimals) + 0.0:.12g}" for x in point) + ")"
