"""Convex solids in the order in which a painter draws them: those behind first."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from hcsearch.basics.arrays import Reals

FLAT = 1e-9
"""Directions are along a face of a solid where their dot product with its unit normal is below this."""


def painters_order(prisms: Sequence[Reals], towards: Reals) -> list[int]:
    """Numbers of prisms, each (2, n_corners, 3), such that none hides one that comes after it.

    towards : unit vector to the viewer, who is far away. Of two prisms that do not overlap, the one on the viewer's
    side of a plane between them is in front. Where some hide each other in a ring, the farthest one is drawn first.
    """
    n = len(prisms)
    points = [prism.reshape(-1, 3) for prism in prisms]
    axes = [_axes(prism) for prism in prisms]
    across = np.linalg.svd(towards[None])[2][1:]  # two directions across the view
    boxes = [(corners @ across.T) for corners in points]
    low, high = np.array([box.min(axis=0) for box in boxes]), np.array([box.max(axis=0) for box in boxes])
    before: list[set[int]] = [set() for _ in range(n)]
    for i, j in combinations(range(n), 2):
        if (low[i] < high[j]).all() and (low[j] < high[i]).all():
            side = _in_front(points[i], points[j], _between(axes[i], axes[j]), towards)
            if side > 0:
                before[i].add(j)
            elif side < 0:
                before[j].add(i)
    depth = [float(corners.mean(axis=0) @ towards) for corners in points]
    return _sorted(before, depth)


def _axes(prism: Reals) -> tuple[Reals, Reals]:
    """Unit normals of a prism's faces, and unit directions of its edges."""
    bottom, top = prism
    up = (top - bottom)[0] / np.linalg.norm((top - bottom)[0])
    edges = np.roll(bottom, -1, axis=0) - bottom
    edges /= np.linalg.norm(edges, axis=1)[:, None]
    return np.vstack([up, np.cross(edges, up)]), np.vstack([up, edges])


def _between(first: tuple[Reals, Reals], second: tuple[Reals, Reals]) -> Reals:
    """Unit normals of the planes of which one separates two prisms, where any does (separating axis theorem)."""
    crossed = np.cross(first[1][:, None], second[1][None]).reshape(-1, 3)
    lengths = np.linalg.norm(crossed, axis=1)
    normals: Reals = np.vstack([first[0], second[0], crossed[lengths > 1e-6] / lengths[lengths > 1e-6][:, None]])
    return normals


def _in_front(one: Reals, other: Reals, normals: Reals, towards: Reals) -> int:
    """1 where the first of two solids may hide the second, -1 where the second may hide the first, else 0."""
    a, b = one @ normals.T, other @ normals.T
    above, below = a.min(axis=0) - b.max(axis=0), b.min(axis=0) - a.max(axis=0)
    facing = normals @ towards
    best = int(np.maximum(above, below).argmax())
    if abs(facing[best]) < FLAT:
        return 0
    return 1 if (facing[best] > 0) == (above[best] > below[best]) else -1


def _sorted(before: list[set[int]], depth: Sequence[float]) -> list[int]:
    """An order in which each comes after those that are before it, the deepest first among those that are free."""
    waiting = [set(own) for own in before]
    ready = [(depth[k], k) for k, own in enumerate(waiting) if not own]
    heapq.heapify(ready)
    left, order = set(range(len(depth))), []
    while left:
        k = heapq.heappop(ready)[1] if ready else min(left, key=lambda k: depth[k])
        if k not in left:
            continue
        left.discard(k)
        order.append(k)
        for other in left:
            if k in waiting[other]:
                waiting[other].discard(k)
                if not waiting[other]:
                    heapq.heappush(ready, (depth[other], other))
    return order
