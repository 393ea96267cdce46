"""Lines and points of a drawing: projection onto their plane, and splitting of lines where they meet.

Programs draw lines of any length, each with its own end points. Points nearer to each other than a tolerance are merged
into one place at their mean. Lines shorter than the tolerance vanish; others are split where they cross, and at the
places on them where others end.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.shape.mesh import PlanePoint

MAX_DRAWN_PANELS = 1000
"""Greatest number of faces of a drawing that is no design: matrices of larger linkages take gigabytes."""
MAX_LINE_PAIRS_AT_ONCE = 1_000_000
"""Limit of the pairs of lines that are tested together."""
_CROSSINGS_PER_FACE = 3
"""Lines that cross at this many places per face, and once each besides, bound more faces: a place adds a face at least,
and a loose end takes half a face."""

_SHARE, _REACH = 0.25, 0.26
"""The tolerance over the cell size of the lookup grid, and the lookup radius in cells, rounding included."""


class CrossingError(ValueError):
    """Lines cross more often than allowed; the message says how often."""


class SplitLines(NamedTuple):
    """Lines that meet at their ends only.

    points : coordinates of the places, first ends of lines, then crossings. place_of_point : place of each given point,
    -1 where no line ends there. places_along : for each given line, the places along it from its first end to its
    second; empty where it vanishes.
    """

    points: list[PlanePoint]
    place_of_point: list[int]
    places_along: list[list[int]]


class PointNumbers:
    """Numbering of points of the plane that gives points nearer than a tolerance the same number."""

    def __init__(self, tolerance: float) -> None:
        self._step = tolerance / _SHARE
        self._near = tolerance
        self._known: dict[tuple[int, int], list[tuple[PlanePoint, int]]] = {}
        self._count = 0

    def number(self, point: PlanePoint) -> int:
        """Return the number of the first known point within the tolerance of a point, or else a new number."""
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


def split_lines(
    points: Reals,
    lines: Sequence[tuple[int, int]],
    tolerance: float,
    max_crossings: int,
    borders: Collection[int] = (),
) -> SplitLines:
    """Split lines, given by indices of points (k, 2), where they meet.

    borders : the lines that alone bound faces. Errors: CrossingError above `max_crossings`, and where borders cross at
    so many places that they bound more than `MAX_DRAWN_PANELS` faces.
    """
    places, merged_points, place_of_point = _merged(points, lines, tolerance)
    ends = [(place_of_point[a], place_of_point[b]) for a, b in lines]
    distinct = sorted({(min(pair), max(pair)) for pair in ends if pair[0] != pair[1]})
    number = {pair: k for k, pair in enumerate(distinct)}
    along: list[dict[int, float]] = [{} for _ in distinct]
    bounding = {number[min(ends[k]), max(ends[k])] for k in borders if ends[k][0] != ends[k][1]}
    max_places, crossed = _CROSSINGS_PER_FACE * MAX_DRAWN_PANELS + len(bounding), set[int]()
    if distinct:
        table, sides = np.array(merged_points), np.array(distinct)
        for v, k, share in _on_lines(table, sides, tolerance, max_crossings):
            along[k][v] = share
        ended = [dict(places) for places in along]  # crossings are added to the others meanwhile
        for j, k, x, shares in _crossings(table, sides, ended, max_crossings):
            v = places.number(x)
            if v == len(merged_points):
                merged_points.append(x)
            if j in bounding and k in bounding:
                crossed.add(v)
                if len(crossed) > max_places:
                    raise CrossingError(
                        f"cross at more than {max_places:,} places, and so bound more than {MAX_DRAWN_PANELS:,} faces"
                    )
            for line, share in ((j, shares[0]), (k, shares[1])):
                if v not in distinct[line]:
                    along[line].setdefault(v, share)
    places_along: list[list[int]] = []
    for a, b in ends:
        if a == b:
            places_along.append([])
            continue
        low, high = min(a, b), max(a, b)
        within = along[number[low, high]]
        path = [low, *sorted(within, key=within.__getitem__), high]
        places_along.append(path if a < b else path[::-1])
    return SplitLines(merged_points, place_of_point, places_along)


def _merged(
    points: Reals, lines: Sequence[tuple[int, int]], tolerance: float
) -> tuple[PointNumbers, list[PlanePoint], list[int]]:
    """Merge the end points of lines; return the lookup of places, their coordinates, and the place of each point."""
    places, place_of_point = PointNumbers(tolerance), [-1] * len(points)
    members: list[list[int]] = []
    for v in dict.fromkeys(v for line in lines for v in line):
        place_of_point[v] = places.number((float(points[v, 0]), float(points[v, 1])))
        if place_of_point[v] == len(members):
            members.append([])
        members[place_of_point[v]].append(v)
    merged_points = []
    for group in members:
        first = points[group[0]]
        x, y = first + (points[group] - first).mean(axis=0)  # points that are the same keep their digits
        merged_points.append((float(x), float(y)))
    return places, merged_points, place_of_point


def _on_lines(points: Reals, lines: WholeNumbers, tolerance: float, max_crossings: int) -> list[tuple[int, int, float]]:
    """Return the places of ends in the interior of lines: place, line, and share of the line's length."""
    import shapely  # noqa: PLC0415 - only drawings need it

    starts, vectors = points[lines[:, 0]], points[lines[:, 1]] - points[lines[:, 0]]
    is_end = np.zeros(len(points), bool)  # others are specks: near a corner they would split both lines that meet there
    is_end[lines] = True
    interior: list[tuple[int, int, float]] = []
    tree = shapely.STRtree(shapely.points(points))
    for first_line, (low, high) in _boxes(points, lines, tolerance):
        k, v = tree.query(shapely.box(*low.T, *high.T))
        k = k + first_line
        arms, line_vectors = points[v] - starts[k], vectors[k]
        squares = (line_vectors * line_vectors).sum(axis=1)
        shares = (arms * line_vectors).sum(axis=1) / squares
        distances = np.abs(line_vectors[:, 0] * arms[:, 1] - line_vectors[:, 1] * arms[:, 0]) / np.sqrt(squares)
        on = is_end[v] & (distances < tolerance) & (shares > 0.0) & (shares < 1.0)
        on &= (lines[k] != v[:, None]).all(axis=1)
        interior += zip(v[on].tolist(), k[on].tolist(), shares[on].tolist(), strict=True)
        if len(interior) > max_crossings:
            raise _crossing_error(max_crossings)
    return interior


def _crossings(
    points: Reals, lines: WholeNumbers, along: Sequence[dict[int, float]], max_crossings: int
) -> Iterator[tuple[int, int, PlanePoint, tuple[float, float]]]:
    """Yield crossings of lines without a common place: both lines, the point, and its shares of their lengths."""
    import shapely  # noqa: PLC0415

    starts, vectors = points[lines[:, 0]], points[lines[:, 1]] - points[lines[:, 0]]
    n_crossings = 0
    boxes = _boxes(points, lines, 0.0)
    tree = shapely.STRtree(np.concatenate([shapely.box(*low.T, *high.T) for _, (low, high) in boxes]))
    for first_line, (low, high) in boxes:
        j, k = tree.query(shapely.box(*low.T, *high.T))
        j = j + first_line
        j, k = j[j < k], k[j < k]
        a, b, apart = vectors[j], vectors[k], starts[k] - starts[j]
        across = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (apart[:, 0] * b[:, 1] - apart[:, 1] * b[:, 0]) / across
            t = (apart[:, 0] * a[:, 1] - apart[:, 1] * a[:, 0]) / across
        meet = (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
        for first, second, first_share, second_share in zip(
            j[meet].tolist(), k[meet].tolist(), s[meet], t[meet], strict=True
        ):
            if not _joined(lines[first].tolist(), lines[second].tolist(), along[first], along[second]):
                x, y = starts[first] + first_share * vectors[first]
                n_crossings += 1
                if n_crossings > max_crossings:
                    raise _crossing_error(max_crossings)
                yield first, second, (float(x), float(y)), (float(first_share), float(second_share))


def _crossing_error(max_crossings: int) -> CrossingError:
    return CrossingError(f"cross more than {max_crossings:,} times")


def _joined(first: list[int], second: list[int], on_first: dict[int, float], on_second: dict[int, float]) -> bool:
    """Whether two lines already have a place in common."""
    return any(v in first or v in on_first for v in second) or any(v in on_second for v in (*first, *on_first))


def _boxes(points: Reals, lines: WholeNumbers, margin: float) -> list[tuple[int, tuple[Reals, Reals]]]:
    """Return bounding boxes of lines in chunks: number of the first line, and lower and upper corners."""
    ends = points[lines]
    low, high = ends.min(axis=1) - margin, ends.max(axis=1) + margin
    size = max(1, MAX_LINE_PAIRS_AT_ONCE // max(len(lines), len(points)))
    return [(k, (low[k : k + size], high[k : k + size])) for k in range(0, len(lines), size)]


FLAT_COORDINATE_SHARE = 1e-6
"""A coordinate whose extent is below this share of the greatest extent counts as constant."""

_UP = (
    (2, np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])),
    (1, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])),
    (0, np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])),
)
"""Candidate normals of a drawing's plane, z before y as in most programs, each with the projection onto x and y as seen
from the tip of the axis."""


def in_plane(points: Reals) -> tuple[Reals, Reals]:
    """Project points (k, 3) onto their plane; return coordinates (k, 2) and distances from the plane (k,).

    The plane is fitted by least squares. It is seen from the side to which the nearest axis points, without a rotation
    about its normal; points in a plane normal to an axis keep their coordinates.
    """
    extent: Reals = np.ptp(points, axis=0)
    for axis, projection in _UP:
        if extent[axis] <= FLAT_COORDINATE_SHARE * extent.max():
            return points @ projection.T, np.zeros(len(points))
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    normal = axes[2]
    nearest = max((abs(normal[axis]) * (1.0 + FLAT_COORDINATE_SHARE * axis), axis) for axis, _ in _UP)[1]
    axis, projection = next(up for up in _UP if up[0] == nearest)
    normal = normal * math.copysign(1.0, normal[axis])
    upright = np.zeros(3)
    upright[axis] = 1.0
    # the minimal rotation that takes the axis to the normal
    turned = projection - np.outer(projection @ normal, upright + normal) / (1.0 + normal[axis])
    return points @ turned.T, np.abs((points - middle) @ normal)


def place_text(point: Sequence[float], side: float) -> str:
    """Format a point for messages, rounded to about a thousandth of a side."""
    decimals = 3 - math.floor(math.log10(side)) if side > 0.0 and math.isfinite(side) else 9
    return "(" + ", ".join(f"{round(float(x), decimals) + 0.0:.12g}" for x in point) + ")"
