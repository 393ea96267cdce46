"""Outlines in planar drawings: faces between edges, unions of faces, corners."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence

from hcsearch.pattern import Places, Point, facet_area

Edge = tuple[int, int]


def same_places(points: Sequence[Point], tolerance: float) -> list[int]:
    """For each point the first one that is the same, nearer than a tolerance."""
    places = Places(tolerance)
    first: list[int] = []
    representatives = []
    for k, point in enumerate(points):
        number = places.number(point)
        if number == len(first):
            first.append(k)
        representatives.append(first[number])
    return representatives


def faces_between(edges: Iterable[Edge], points: Sequence[Point]) -> list[list[int]]:
    """The bounded faces of a plane graph, corners counterclockwise; dead ends are left out.

    edges : pairs of numbers of points, which meet at their ends only.
    """
    around: dict[int, set[int]] = defaultdict(set)
    for a, b in edges:
        around[a].add(b)
        around[b].add(a)
    ends = [v for v, near in around.items() if len(near) == 1]
    while ends:
        v = ends.pop()
        for other in around.pop(v, set()):
            around[other].discard(v)
            if len(around[other]) == 1:
                ends.append(other)
    turn = {
        v: sorted(near, key=lambda w, v=v: math.atan2(points[w][1] - points[v][1], points[w][0] - points[v][0]))  # type: ignore[misc]
        for v, near in around.items()
    }
    sides = [(v, w) for v, near in sorted(turn.items()) for w in near]
    seen: set[Edge] = set()
    faces = []
    for start in sides:
        if start in seen:
            continue
        side, face = start, []
        while True:
            seen.add(side)
            face.append(side[0])
            a, b = side
            near = turn[b]
            side = (b, near[near.index(a) - 1])  # the next edge clockwise keeps the face on the left
            if side == start:
                break
        if facet_area([points[v] for v in face]) > 0.0:
            faces.append(face)
    return faces


def joined_faces(faces: Sequence[Sequence[int]], within: Collection[Edge]) -> list[list[int]]:
    """Faces with those made one that share an edge of some; edges : the lower point first."""
    if not within:
        return [list(face) for face in faces]
    group = list(range(len(faces)))

    def root(f: int) -> int:
        while group[f] != f:
            f = group[f]
        return f

    beside: dict[Edge, int] = {}
    for f, face in enumerate(faces):
        for a, b in _sides(face):
            edge = (min(a, b), max(a, b))
            if edge in within and beside.setdefault(edge, f) != f:
                one, two = sorted((root(f), root(beside[edge])))
                group[two] = one
    rings: dict[int, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for f, face in enumerate(faces):
        for a, b in _sides(face):
            if (min(a, b), max(a, b)) not in within:
                rings[root(f)][a].append(b)
    joined = []
    for f in sorted(rings):
        after = rings[f]
        here = start = min(after)
        ring = []
        while after.get(here):
            ring.append(here)
            here = after[here].pop()
        # a face with a hole, or that touches itself, is left as it is: it is no panel
        joined.append(ring if here == start and not any(after.values()) else list(faces[f]))
    return joined


def without_straight_corners(face: Sequence[int], points: Sequence[Point], same: float) -> list[int]:
    """A face without the corners in the middle of its sides.

    same : by which share of a side a corner may be off it.
    """
    corners = []
    for k, v in enumerate(face):
        (ax, ay), (x, y), (bx, by) = points[face[k - 1]], points[v], points[face[(k + 1) % len(face)]]
        off = abs((x - ax) * (by - ay) - (y - ay) * (bx - ax))
        if off > same * math.dist((ax, ay), (bx, by)) ** 2:
            corners.append(v)
    return corners


def _sides(face: Sequence[int]) -> Iterable[Edge]:
    return zip(face, [*face[1:], face[0]], strict=True)
