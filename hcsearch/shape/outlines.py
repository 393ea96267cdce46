"""Outlines in planar drawings: faces between edges, unions of faces, corners."""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence

from hcsearch.shape.mesh import Edge, PlanePoint, components, facet_area, sides_of


def without_dead_ends(edges: Iterable[Edge]) -> list[Edge]:
    """Edges without those, one after the other, at an end of which no other one is."""
    edges = list(edges)
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
    return [(a, b) for a, b in edges if a in around and b in around[a]]


def faces_between(edges: Iterable[Edge], points: Sequence[PlanePoint]) -> list[list[int]]:
    """The bounded faces of a plane graph, corners counterclockwise; dead ends are left out.

    edges : pairs of numbers of points, which meet at their ends only.
    """
    around: dict[int, set[int]] = defaultdict(set)
    for a, b in without_dead_ends(edges):
        around[a].add(b)
        around[b].add(a)
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
    """A ring without corners that stand there twice in a row, and without ways that lead out and back the same way."""
    own: list[int] = []
    for v in ring:
        if own and own[-1] == v:
            continue
        if len(own) > 1 and own[-2] == v:
            own.pop()
            continue
        own.append(v)
    low, high = 0, len(own) - 1
    while high - low > 1 and (own[low] == own[high] or own[low + 1] == own[high] or own[low] == own[high - 1]):
        if own[low] == own[high]:
            high -= 1
        elif own[low + 1] == own[high]:
            low += 1
        else:
            high -= 1
    return own[low : high + 1]


def without_straight_corners(face: Sequence[int], points: Sequence[PlanePoint], same: float) -> list[int]:
    """A face without the corners in the middle of its sides, the straightest one first.

    same : how far a corner may be off the line between those before and after it, over the root of the face's area.
    """
    n = len(face)
    limit = same * math.sqrt(abs(facet_area([points[v] for v in face])))
    before, after = [(k - 1) % n for k in range(n)], [(k + 1) % n for k in range(n)]

    def off(k: int) -> float:
        (ax, ay), (x, y), (bx, by) = (points[face[i]] for i in (before[k], k, after[k]))
        long = math.dist((ax, ay), (bx, by))
        return abs((x - ax) * (by - ay) - (y - ay) * (bx - ax)) / long if long > 0.0 else math.inf

    offs = [off(k) for k in range(n)]
    waiting = [(offs[k], k) for k in range(n)]
    heapq.heapify(waiting)
    left = n
    while waiting and waiting[0][0] <= limit and left > 3:
        far, k = heapq.heappop(waiting)
        if far != offs[k]:
            continue
        offs[k], left = -1.0, left - 1
        after[before[k]], before[after[k]] = after[k], before[k]
        for i in (before[k], after[k]):
            offs[i] = off(i)
            heapq.heappush(waiting, (offs[i], i))
    return [face[k] for k in range(n) if offs[k] >= 0.0]
