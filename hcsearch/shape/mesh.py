"""Indexed meshes in the plane: a table of vertices, and faces that name theirs by number.

Whether two points are the same is decided here alone, when a mesh is made of polygons. Grids know it in integers
(`Grid.mesh`). Readers of a mesh compare numbers.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Sequence
from itertools import islice
from typing import TypeVar

import numpy as np

from hcsearch.basics.arrays import Reals

PlanePoint = tuple[float, float]
Facet = tuple[PlanePoint, ...]
"""A polygon whose corners run counterclockwise."""
Edge = tuple[int, int]
"""Two vertices, from start to end."""

SAME_POINT_SHARE = 1e-7
"""Points nearer than this share of the smallest facet's size are the same."""

_Node = TypeVar("_Node", bound=Hashable)


def polygon_mesh(polygons: Sequence[Facet]) -> tuple[tuple[PlanePoint, ...], tuple[tuple[int, ...], ...]]:
    """Find the vertices of polygons, and those of each polygon by number.

    Vertices are numbered in the order in which polygons name them, and are where the first of these has its corner.
    """
    corners = [corner for polygon in polygons for corner in polygon]
    vertices, numbers = distinct_points(corners, same_point_distance(polygons))
    number = iter(numbers)
    return vertices, tuple(tuple(islice(number, len(polygon))) for polygon in polygons)


def same_point_distance(polygons: Iterable[Facet]) -> float:
    """The distance below which corners of polygons are the same, in their unit."""
    return SAME_POINT_SHARE * math.sqrt(min(map(facet_area, polygons)))


def distinct_points(points: Sequence[PlanePoint], tolerance: float) -> tuple[tuple[PlanePoint, ...], list[int]]:
    """Find the distinct points, in the order in which they come, and the number of each point among them.

    Points are the same where both coordinates have neighbours in rising order no further apart than the tolerance.
    """
    levels = zip(*(_levels(values, tolerance) for values in np.array(points).T), strict=True)
    known: dict[tuple[int, ...], int] = {}
    numbers = [known.setdefault(level, len(known)) for level in levels]
    first = dict(zip(reversed(numbers), reversed(points), strict=True))
    return tuple(first[number] for number in range(len(known))), numbers


def _levels(values: Reals, tolerance: float) -> list[int]:
    """Rank numbers; those that follow each other within a tolerance have one rank."""
    order = np.argsort(values)
    levels = np.empty(len(values), np.int64)
    levels[order] = np.cumsum(np.diff(values[order], prepend=values[order[0]]) > tolerance)
    ranks: list[int] = levels.tolist()
    return ranks


def sides_of(face: Sequence[int]) -> Iterable[Edge]:
    """The sides of a face, or of any closed walk."""
    return zip(face, (*face[1:], face[0]), strict=True)


def outline_of(faces: Iterable[Sequence[int]], vertices: Sequence[PlanePoint]) -> tuple[tuple[int, ...], ...]:
    """The boundary of a union of faces as closed walks of vertices, with the faces on the left.

    The outer walk comes first, counterclockwise; walks around holes are clockwise.
    """
    sides = dict.fromkeys(side for face in faces for side in sides_of(face))
    after: dict[int, list[int]] = {}
    for start, end in sides:
        if (end, start) not in sides:
            after.setdefault(start, []).append(end)
    walks = []
    for start, ends in after.items():
        while ends:
            walk, here = [], start
            while after[here]:
                walk.append(here)
                here = after[here].pop(0)
            walks.append(tuple(walk))
    return tuple(sorted(walks, key=lambda walk: -facet_area([vertices[v] for v in walk])))


def components(nodes: Iterable[_Node], pairs: Iterable[tuple[_Node, _Node]]) -> list[set[_Node]]:
    """The connected components of a graph, in the order of their first nodes."""
    import networkx as nx  # noqa: PLC0415 - most of what imports this module makes no mesh

    graph = nx.Graph()
    graph.add_nodes_from(nodes)
    graph.add_edges_from(pairs)
    return list(nx.connected_components(graph))


def facet_area(facet: Sequence[PlanePoint]) -> float:
    """Area of a polygon whose corners run counterclockwise."""
    sides = zip(facet, (*facet[1:], facet[0]), strict=True)
    return 0.5 * sum(x * to_y - y * to_x for (x, y), (to_x, to_y) in sides)
