"""Indexed meshes in the plane, and outlines in planar drawings: faces between edges, unions of faces, corners.

Only this module decides whether two points coincide, when it makes a mesh of polygons; grids decide it in integers
(`Grid.mesh`). Readers of a mesh compare vertex numbers.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Collection, Hashable, Iterable, Iterator, Sequence
from itertools import islice
from typing import TypeVar

import numpy as np

from hcsearch.basics.array_values import Reals

PlanePoint = tuple[float, float]
Facet = tuple[PlanePoint, ...]
"""A polygon whose corners run counterclockwise."""
Edge = tuple[int, int]
"""Two vertices, from start to end."""

SAME_POINT_SHARE = 1e-7
"""Points nearer than this share of the smallest facet's size are the same."""

_Node = TypeVar("_Node", bound=Hashable)
_Corner = TypeVar("_Corner")


def polygon_mesh(polygons: Sequence[Facet]) -> tuple[tuple[PlanePoint, ...], tuple[tuple[int, ...], ...]]:
    """Index the vertices of polygons: the list of vertices, and the vertex numbers of each polygon.

    Vertices are numbered by their first occurrence, and have the coordinates of that corner.
    """
    corners = [corner for polygon in polygons for corner in polygon]
    vertices, numbers = distinct_points(corners, same_point_distance(polygons))
    number = iter(numbers)
    return vertices, tuple(tuple(islice(number, len(polygon))) for polygon in polygons)


def same_point_distance(polygons: Iterable[Facet]) -> float:
    """The distance below which corners of polygons coincide, in their unit."""
    return SAME_POINT_SHARE * math.sqrt(min(map(facet_area, polygons)))


def distinct_points(points: Sequence[PlanePoint], tolerance: float) -> tuple[tuple[PlanePoint, ...], list[int]]:
    """Find the distinct points, in the order of first occurrence, and the number of each point among them.

    Points coincide where both coordinates are in the same cluster of sorted values no further apart than the tolerance.
    """
    levels = zip(*(_levels(values, tolerance) for values in np.array(points).T), strict=True)
    known: dict[tuple[int, ...], int] = {}
    numbers = [known.setdefault(level, len(known)) for level in levels]
    first = dict(zip(reversed(numbers), reversed(points), strict=True))
    return tuple(first[number] for number in range(len(known))), numbers


def _levels(values: Reals, tolerance: float) -> list[int]:
    """Cluster values: ranks in rising order, with one rank for consecutive values within a tolerance."""
    order = np.argsort(values)
    levels = np.empty(len(values), np.int64)
    levels[order] = np.cumsum(np.diff(values[order], prepend=values[order[0]]) > tolerance)
    ranks: list[int] = levels.tolist()
    return ranks


def sides_of(walk: Sequence[_Corner]) -> Iterator[tuple[_Corner, _Corner]]:
    """The sides of a closed walk, such as the vertices or the corners of a face: each of them with the next."""
    return zip(walk, (*walk[1:], *walk[:1]), strict=True)


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
    """The connected components of a graph, in the order of their first nodes; pairs are its edges.

    networkx has the same, but takes longer to load than a command spends on all its patterns.
    """
    around: dict[_Node, list[_Node]] = {node: [] for node in nodes}
    for a, b in pairs:
        around[a].append(b)
        around[b].append(a)
    parts: list[set[_Node]] = []
    reached: set[_Node] = set()
    for start in around:
        if start in reached:
            continue
        part, waiting = {start}, [start]
        while waiting:
            new = set(around[waiting.pop()]) - part
            part |= new
            waiting += new
        reached |= part
        parts.append(part)
    return parts


def facet_area(facet: Sequence[PlanePoint]) -> float:
    """Area of a polygon whose corners run counterclockwise."""
    sides = zip(facet, (*facet[1:], facet[0]), strict=True)
    return 0.5 * sum(x * to_y - y * to_x for (x, y), (to_x, to_y) in sides)


def without_dead_ends(edges: Iterable[Edge]) -> list[Edge]:
    """Remove dead ends: drop edges with an end of degree one until there are none."""
    edges = list(edges)
    around: dict[int, set[int]] = defaultdict(set)
    for a, b in edges:
        around[a].add(b)
        around[b].add(a)
    ends = [v for v, neighbours in around.items() if len(neighbours) == 1]
    while ends:
        v = ends.pop()
        for other in around.pop(v, set()):
            around[other].discard(v)
            if len(around[other]) == 1:
                ends.append(other)
    return [(a, b) for a, b in edges if a in around and b in around[a]]


def faces_between(edges: Iterable[Edge], points: Sequence[PlanePoint]) -> list[list[int]]:
    """The bounded faces of a plane graph, corners counterclockwise; dead ends are left out.

    edges : pairs of numbers of points, which meet at their ends only.
    """
    around: dict[int, set[int]] = defaultdict(set)
    for a, b in without_dead_ends(edges):
        around[a].add(b)
        around[b].add(a)
    cyclic_order = {
        v: sorted(neighbours, key=lambda w, v=v: math.atan2(points[w][1] - points[v][1], points[w][0] - points[v][0]))  # type: ignore[misc]
        for v, neighbours in around.items()
    }
    sides = [(v, w) for v, neighbours in sorted(cyclic_order.items()) for w in neighbours]
    visited: set[Edge] = set()
    faces = []
    for start in sides:
        if start in visited:
            continue
        side, face = start, []
        while True:
            visited.add(side)
            face.append(side[0])
            a, b = side
            neighbours = cyclic_order[b]
            side = (b, neighbours[neighbours.index(a) - 1])  # the next edge clockwise keeps the face on the left
            if side == start:
                break
        if facet_area([points[v] for v in face]) > 0.0:
            faces.append(face)
    return faces


def joined_faces(faces: Sequence[Sequence[int]], within: Collection[Edge]) -> list[list[int]]:
    """Merge faces that share one of some edges, each given as a pair with the lower point first."""
    if not within:
        return [list(face) for face in faces]
    beside: dict[Edge, list[int]] = defaultdict(list)
    for f, face in enumerate(faces):
        for a, b in sides_of(face):
            beside[min(a, b), max(a, b)].append(f)
    shared = ((around[0], f) for edge, around in beside.items() if edge in within for f in around[1:])
    joined = []
    for part in components(range(len(faces)), shared):
        after: dict[int, list[int]] = defaultdict(list)
        for f in sorted(part):
            for a, b in sides_of(faces[f]):
                if (min(a, b), max(a, b)) not in within:
                    after[a].append(b)
        if not after:
            continue
        here = start = min(after)
        ring = []
        while after.get(here):
            ring.append(here)
            here = after[here].pop()
        # a face with a hole, or that touches itself, is left as it is: it is no panel
        joined.append(ring if here == start and not any(after.values()) else list(faces[min(part)]))
    return joined


def without_spurs(ring: Sequence[int]) -> list[int]:
    """Remove repeated corners and spurs, which lead out and back along the same edges, from a ring."""
    path: list[int] = []
    for v in ring:
        if path and path[-1] == v:
            continue
        if len(path) > 1 and path[-2] == v:
            path.pop()
            continue
        path.append(v)
    low, high = 0, len(path) - 1
    while high - low > 1 and (path[low] == path[high] or path[low + 1] == path[high] or path[low] == path[high - 1]):
        if path[low] == path[high]:
            high -= 1
        elif path[low + 1] == path[high]:
            low += 1
        else:
            high -= 1
    return path[low : high + 1]


def without_straight_corners(face: Sequence[int], points: Sequence[PlanePoint], same: float) -> list[int]:
    """Remove corners in the middle of straight sides of a face, the straightest one first.

    same : tolerance of a corner's distance from the line between its neighbours, over the root of the face's area.
    """
    n = len(face)
    limit = same * math.sqrt(abs(facet_area([points[v] for v in face])))
    before, after = [(k - 1) % n for k in range(n)], [(k + 1) % n for k in range(n)]

    def off(k: int) -> float:
        (ax, ay), (x, y), (bx, by) = (points[face[i]] for i in (before[k], k, after[k]))
        length = math.dist((ax, ay), (bx, by))
        return abs((x - ax) * (by - ay) - (y - ay) * (bx - ax)) / length if length > 0.0 else math.inf

    distances = [off(k) for k in range(n)]
    waiting = [(distances[k], k) for k in range(n)]
    heapq.heapify(waiting)
    remaining = n
    while waiting and waiting[0][0] <= limit and remaining > 3:
        distance, k = heapq.heappop(waiting)
        if distance != distances[k]:
            continue
        distances[k], remaining = -1.0, remaining - 1
        after[before[k]], before[after[k]] = after[k], before[k]
        for i in (before[k], after[k]):
            distances[i] = off(i)
            heapq.heappush(waiting, (distances[i], i))
    return [face[k] for k in range(n) if distances[k] >= 0.0]
