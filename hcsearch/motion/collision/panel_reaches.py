"""Bounds of the extent of panels: from their hinges, across the linkage, and by the error of open loops."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.linkage import Linkage


def slack_of(linkage: Linkage, gap: float) -> float:
    """Bound of the displacement of panels (m) by a closure residual (rad, or gap over the pattern's size).

    A panel that is reached the other way around a loop is rotated by up to sqrt(3) residuals about a point of the loop,
    from which no panel is further than the longest way, and translated by as much times the size. The rest of the
    factor covers panels between the places at which residuals are computed.
    """
    if not linkage.loops:
        return 0.0
    return 2.0 * len(linkage.loops) * (longest_way(linkage) + linkage.pattern.size) * gap


def longest_way(linkage: Linkage) -> float:
    """An upper bound (m) of the distance between any two corners, however the hinges are folded.

    It is the greatest of the shortest paths between corners that are straight in each panel and pass from one panel to
    the next at an end of their hinge: panels are rigid, so such a path keeps its length.
    """
    pattern = linkage.pattern
    ends, panels = [], []
    for hinge, point in zip(pattern.hinges, linkage.points, strict=True):
        ends += [(*hinge.start, point[2]), (*hinge.end, point[2])]
        panels += 2 * [(hinge.first, hinge.second)]
    points = np.array(ends)
    distances = np.full((len(points), len(points)), np.inf)
    ends_of: list[list[int]] = [[] for _ in pattern.panels]  # ends of the hinges of each panel
    for k, pair in enumerate(panels):
        for panel in set(pair):
            ends_of[panel].append(k)
    for k, pair in enumerate(panels):
        neighbours = sorted({end for panel in pair for end in ends_of[panel]})
        distances[k, neighbours] = np.linalg.norm(points[k] - points[neighbours], axis=1)
    detours = np.empty_like(distances)
    for k in range(len(points)):  # Floyd and Warshall's shortest paths
        np.add(distances[:, k, None], distances[k], out=detours)
        np.minimum(distances, detours, out=distances)
    corners, owners = [], []
    for panel, facets in enumerate(pattern.panels):
        for x, y in (corner for facet in facets for corner in pattern.facets[facet]):
            corners += [(x, y, 0.0), (x, y, pattern.thickness)]
            owners += 2 * [panel]
    # from each corner to the ends of its panel's hinges, of which most panels have four
    max_ends = max(map(len, ends_of))
    end_indices = np.array([[*ends_of[panel], *[0] * (max_ends - len(ends_of[panel]))] for panel in owners])
    is_end = np.arange(max_ends) < np.array([[len(ends_of[panel])] for panel in owners])
    to_ends = np.where(is_end, np.linalg.norm(np.array(corners)[:, None] - points[end_indices], axis=2), np.inf)
    longest = 0.0
    for k in range(len(corners)):  # a corner at a time: all pairs at once would take gigabytes
        from_corner = (to_ends[k][:, None] + distances[end_indices[k]]).min(axis=0)
        longest = max(longest, float((from_corner[end_indices] + to_ends).min(axis=1).max()))
    return longest


def reaches(linkage: Linkage) -> Reals:
    """The greatest distance of the corners of a hinge's two panels from its line (m), for each hinge, (n_hinges,)."""
    pattern, farthest = linkage.pattern, np.zeros(linkage.n_hinges)
    for k, hinge in enumerate(pattern.hinges):
        for panel in (hinge.first, hinge.second):
            corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]])
            offsets = corners - linkage.points[k, :2]
            across = linkage.directions[k, 0] * offsets[:, 1] - linkage.directions[k, 1] * offsets[:, 0]
            farthest[k] = max(farthest[k], math.hypot(float(np.abs(across).max()), pattern.thickness))
    return farthest
