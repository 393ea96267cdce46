"""How far panels reach: beyond their hinges, by way of others, and elsewhere where loops are open."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.linkage import Linkage
from hcsearch.typing import Reals


def slack_of(linkage: Linkage, gap: float) -> float:
    """What panels may be elsewhere (m) where loops are open by a gap (rad, or over the pattern's size).

    A panel that is reached the other way around a loop is turned by up to sqrt(3) gaps about a point of the loop, from
    which no panel is further than the longest way, and moved by as much times the size. The rest of the factor is for
    what lies between the places at which gaps are computed.
    """
    if not linkage.loops:
        return 0.0
    return 2.0 * len(linkage.loops) * (longest_way(linkage) + linkage.pattern.size) * gap


def longest_way(linkage: Linkage) -> float:
    """What no two corners are further apart, however the hinges are folded (m).

    The greatest length of the shortest ways from corner to corner that are straight in each panel and go over from one
    to the next at an end of their hinge: panels are rigid, so such a way keeps its length.
    """
    pattern = linkage.pattern
    ends, panels = [], []
    for own, point in zip(pattern.hinges, linkage.points, strict=True):
        ends += [(*own.start, point[2]), (*own.end, point[2])]
        panels += 2 * [(own.first, own.second)]
    points, sides = np.array(ends), np.array(panels)
    shared = (sides[:, None, :, None] == sides[None, :, None, :]).any(axis=(2, 3))
    ways = np.where(shared, np.linalg.norm(points[:, None] - points, axis=2), np.inf)
    for k in range(len(points)):  # Floyd and Warshall's shortest paths
        ways = np.minimum(ways, ways[:, k, None] + ways[k])
    corners, owners = [], []
    for panel, facets in enumerate(pattern.panels):
        for x, y in (corner for facet in facets for corner in pattern.facets[facet]):
            corners += [(x, y, 0.0), (x, y, pattern.thickness)]
            owners += 2 * [panel]
    own_ends = (sides[None] == np.array(owners)[:, None, None]).any(axis=2)
    first = np.where(own_ends, np.linalg.norm(np.array(corners)[:, None] - points, axis=2), np.inf)
    return float(_by_way_of(_by_way_of(first, ways), first.T).max())


def reaches(linkage: Linkage) -> Reals:
    """How far corners of the two panels of each hinge are from its line at most (m), (n_hinges,)."""
    pattern, farthest = linkage.pattern, np.zeros(linkage.n_hinges)
    for k, hinge in enumerate(pattern.hinges):
        for panel in (hinge.first, hinge.second):
            corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]])
            ways = corners - linkage.points[k, :2]
            across = linkage.directions[k, 0] * ways[:, 1] - linkage.directions[k, 1] * ways[:, 0]
            farthest[k] = max(farthest[k], math.hypot(float(np.abs(across).max()), pattern.thickness))
    return farthest


def _by_way_of(before: Reals, after: Reals) -> Reals:
    """Shortest ways in two parts, shape (i, j), from those to places, (i, k), and those from the places, (k, j)."""
    shortest = np.full((len(before), after.shape[1]), np.inf)
    for k in range(len(after)):
        np.minimum(shortest, before[:, k, None] + after[k], out=shortest)
    return shortest
