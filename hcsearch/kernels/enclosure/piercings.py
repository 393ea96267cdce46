"""Segments of panels that pierce other panels at a state, and how deep.

A segment pierces a prism where its ends are above and below the outline of the prism at some height, and it passes
through that outline. Two convex prisms that overlap nearly always are pierced by some segment between a few points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals, WholeNumbers
from hcsearch.kernels.algebra.vectors import dot, put_vector, vector_at, vector_difference
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.plates import FacetView, Plates, view_facet, viewed_point


class Piercings(NamedTuple):
    """The deepest piercings at a state.

    Row 2 p is of the first facet of pair p by a segment of the second, row 2 p + 1 of the second by the first.
    depths : (2 p,), 0 without. ends : (2 p, 2), samples, the upper one first. heights : (2 p,), of the outline.
    places : (s, 3), samples as they are seen, and within : (s, k), how far each is inside of each side.
    """

    depths: Reals
    ends: WholeNumbers
    heights: Reals
    places: Reals
    within: Reals


@compiled
def new_piercings(plates: Plates) -> Piercings:
    """Empty tables."""
    rows, s, k = 2 * len(plates.pairs), plates.samples.shape[1], plates.sides.shape[1]
    return Piercings(np.zeros(rows), np.zeros((rows, 2), np.int64), np.zeros(rows), np.zeros((s, 3)), np.zeros((s, k)))


@lean
def write_piercings(plates: Plates, angles: Reals, radii: Reals, sight: FacetView, work: Piercings) -> float:
    """Write the deepest piercing of each pair at a state, (n,); the depth of the deepest.

    radii : (n,), of a box about the state, by which the ways between panels are chosen.
    """
    deepest = 0.0
    for p in range(len(plates.pairs)):
        work.depths[2 * p] = work.depths[2 * p + 1] = 0.0
        for order in range(2):
            view_facet(plates, p, order, angles, radii, sight)
            own, other = plates.pairs[p, order], plates.pairs[p, 1 - order]
            if not _near(plates, own, other, sight, work):
                break
            row = 2 * p + order
            work.depths[row] = _deepest(plates, own, other, row, work)
            deepest = max(deepest, work.depths[row])
    return deepest


@lean
def _near(plates: Plates, own: int, other: int, sight: FacetView, work: Piercings) -> bool:
    """Whether balls about two facets meet, and one reaches into the heights of the other; its samples are written."""
    away = vector_difference(viewed_point(sight, plates.middles, other), vector_at(plates.middles, own, 0))
    reach = plates.reaches[own] + plates.reaches[other]
    if dot(away, away) > reach * reach:
        return False
    lowest, highest = math.inf, -math.inf
    for i in range(plates.counts[other, 0]):
        place = viewed_point(sight, plates.samples[other], i)
        put_vector(work.places, i, 0, place)
        lowest, highest = min(lowest, place[2]), max(highest, place[2])
    low, high = plates.levels[own]
    meets: bool = lowest < high and highest > low
    return meets


@lean
def _deepest(plates: Plates, own: int, other: int, row: int, work: Piercings) -> float:
    """Write the deepest piercing of a facet by segments of another one; its depth, 0 without.

    The depth is what either may be moved by along the normals of the outline, or upright, so that it still pierces.
    """
    low, high = plates.levels[own]
    sides = plates.counts[own, 2]
    for i in range(plates.counts[other, 0]):
        x, y = work.places[i, 0], work.places[i, 1]
        for k in range(sides):
            work.within[i, k] = plates.sides[own, k, 2] - plates.sides[own, k, 0] * x - plates.sides[own, k, 1] * y
    best = 0.0
    for q in range(plates.counts[other, 1]):
        i, j = plates.segments[other, q]
        if work.places[i, 2] < work.places[j, 2]:
            i, j = j, i
        up, down = work.places[i, 2], work.places[j, 2]
        height = min(max(0.5 * (up + down), low), high)
        above, below = up - height, height - down
        depth = min(above, below)
        if depth <= best:
            continue
        along = vector_difference(vector_at(work.places, i, 0), vector_at(work.places, j, 0))
        factor = 1.0 / math.sqrt(dot(along, along))
        for k in range(sides):
            depth = min(depth, factor * (below * work.within[i, k] + above * work.within[j, k]))
            if depth <= best:
                break
        if depth > best:
            best = depth
            work.ends[row, 0], work.ends[row, 1], work.heights[row] = i, j, height
    return best
