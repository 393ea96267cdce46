"""A flat pattern as a mesh that is cut along its slits: one surface whose faces meet along creases alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hcsearch.pattern import Pair, Pattern, Point

Edge = tuple[int, int]


@dataclass(frozen=True)
class Mesh:
    """A cut pattern.

    points : of the vertices (m), in the flat state; those on slits stand there once for each side.
    faces : vertices of each facet, counterclockwise.
    edges : first the creases, in the pattern's order, with their first facet on the left; then the borders, with their
        facet on the left. The ends of an edge are those of no other one.
    creases : the pair of facets of each crease.
    """

    points: tuple[Point, ...]
    faces: tuple[tuple[int, ...], ...]
    edges: tuple[Edge, ...]
    creases: tuple[Pair, ...]


def mesh_of(pattern: Pattern) -> Mesh:
    """The mesh of a pattern.

    Corners of facets are one vertex where a chain of creases joins them. A slit whose ends both lie inside gets a
    vertex in its middle on each side: its sides would have the same two ends.
    """
    corners = [[(f, k) for k in range(len(facet))] for f, facet in enumerate(pattern.facets)]
    joined = _Classes()
    sides: dict[tuple[int, int], Pair] = {}
    for pair in pattern.creases:
        (i, a), (j, b) = _sides(pattern, pair)
        sides[i, a] = sides[j, b] = pair
        joined.join((i, a), (j, (b + 1) % len(pattern.facets[j])))
        joined.join((i, (a + 1) % len(pattern.facets[i])), (j, b))
    number: dict[tuple[int, int], int] = {}
    points: list[Point] = []
    faces: list[list[int]] = []
    for f, own in enumerate(corners):
        face = []
        for corner in own:
            root = joined.root(corner)
            if root not in number:
                number[root] = len(points)
                points.append(pattern.facets[f][corner[1]])
            face.append(number[root])
        faces.append(face)
    edges: list[Edge] = []
    for pair in pattern.creases:
        (i, a), _ = _sides(pattern, pair)
        edges.append((faces[i][a], faces[i][(a + 1) % len(faces[i])]))
    twice = _twice(faces, sides)
    outlines: list[tuple[int, ...]] = []
    for f, face in enumerate(faces):
        whole: list[int] = []
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            whole.append(start)
            if (f, k) in sides:
                continue
            if (min(start, end), max(start, end)) in twice:
                (x, y), (to_x, to_y) = points[start], points[end]
                whole.append(len(points))
                points.append((0.5 * (x + to_x), 0.5 * (y + to_y)))
                edges.append((start, whole[-1]))
                start = whole[-1]  # noqa: PLW2901 - the second half begins there
            edges.append((start, end))
        outlines.append(tuple(whole))
    return Mesh(tuple(points), tuple(outlines), tuple(edges), tuple(pattern.creases))


def _sides(pattern: Pattern, pair: Pair) -> tuple[tuple[int, int], tuple[int, int]]:
    """The side of each of two facets along their shared edge, by the corner where it starts."""
    start, end = pattern.edges[pair]

    def begins(facet: int, at: Point) -> tuple[int, int]:
        corners = pattern.facets[facet]
        return facet, min(range(len(corners)), key=lambda k: math.dist(corners[k], at))

    return begins(pair[0], start), begins(pair[1], end)


def _twice(faces: list[list[int]], sides: dict[tuple[int, int], Pair]) -> set[Edge]:
    """Ends that two sides along borders have in common."""
    seen: set[Edge] = set()
    twice: set[Edge] = set()
    for f, face in enumerate(faces):
        for k, start in enumerate(face):
            end = face[(k + 1) % len(face)]
            ends = (min(start, end), max(start, end))
            if (f, k) not in sides:
                (twice if ends in seen else seen).add(ends)
    return twice


class _Classes:
    """Classes of corners that are joined."""

    def __init__(self) -> None:
        self._above: dict[tuple[int, int], tuple[int, int]] = {}

    def root(self, corner: tuple[int, int]) -> tuple[int, int]:
        """The corner that stands for its class."""
        while (above := self._above.get(corner, corner)) != corner:
            self._above[corner] = self._above.get(above, above)
            corner = above
        return corner

    def join(self, one: tuple[int, int], two: tuple[int, int]) -> None:
        """Make the classes of two corners one."""
        one, two = self.root(one), self.root(two)
        self._above[max(one, two)] = min(one, two)
