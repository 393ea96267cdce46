"""A flat pattern as a mesh that is cut along its slits: one surface whose faces meet along creases alone."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import chain

from hcsearch.shape.mesh import Edge, PlanePoint, components
from hcsearch.shape.pattern import FacetPair, Pattern

Corner = tuple[int, int]
"""A facet, and the place of a corner in it; also the side that begins there."""


@dataclass(frozen=True)
class Mesh:
    """A cut pattern.

    points : of the vertices (m), in the flat state; those on slits stand there once for each side.
    faces : vertices of each facet, counterclockwise.
    edges : first the creases, in the pattern's order, with their first facet on the left; then the borders, with their
        facet on the left. The ends of an edge are those of no other one.
    creases : the pair of facets of each crease.
    """

    points: tuple[PlanePoint, ...]
    faces: tuple[tuple[int, ...], ...]
    edges: tuple[Edge, ...]
    creases: tuple[FacetPair, ...]


def mesh_of(pattern: Pattern) -> Mesh:
    """The mesh of a pattern.

    Corners of facets are one vertex where a chain of creases joins them. A slit whose ends both lie inside gets a
    vertex in its middle on each side: its sides would have the same two ends.
    """
    creased = [_sides(pattern, pair) for pair in pattern.creases]
    sides = {side for both in creased for side in both}
    joined: list[tuple[Corner, Corner]] = []
    for (i, a), (j, b) in creased:
        joined += [((i, a), (j, (b + 1) % len(pattern.faces[j]))), ((i, (a + 1) % len(pattern.faces[i])), (j, b))]
    corners = [[(f, k) for k in range(len(face))] for f, face in enumerate(pattern.faces)]
    parts = components(chain.from_iterable(corners), joined)
    number = {corner: k for k, part in enumerate(parts) for corner in part}
    faces = [[number[corner] for corner in own] for own in corners]
    points = [pattern.facets[f][k] for f, k in map(min, parts)]
    edges = [(faces[i][a], faces[i][(a + 1) % len(faces[i])]) for (i, a), _ in creased]
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


def _sides(pattern: Pattern, pair: FacetPair) -> tuple[Corner, Corner]:
    """The sides of two facets along their shared edge."""
    (first, second), (start, end) = pair, pattern.edges[pair]
    return (first, pattern.faces[first].index(start)), (second, pattern.faces[second].index(end))


def _twice(faces: Sequence[Sequence[int]], sides: Collection[Corner]) -> set[Edge]:
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
