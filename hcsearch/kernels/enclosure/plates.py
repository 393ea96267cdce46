"""Panels less a margin as prisms, pairs of them, and the two paths from one to the other through a linkage.

Where loops are closed both paths place one panel alike in the frame of the other, so that either may be used.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, put_vector, vector_at
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import moved_point
from hcsearch.kernels.linkage.loops import fold_on


class Plates(NamedTuple):
    """Facets of panels in the flat state, shrunk by a margin, and pairs of them; lengths in sizes of the pattern.

    pairs : (p, 2), facets whose panels no hinge joins. starts : (2 p + 1,), where each path begins, two of each pair
    from the first facet to the second, which have no hinge in common; an empty path stands for none. hinges : (w,),
    directions, points : (w, 3), lines of the paths, in the sense in which they are crossed. samples : (f, s, 3), points
    of each facet, and segments : (f, t, 2), between two of these. sides : (f, k, 3), of the outline: the outward
    normal, and the distance of the side along it. counts : (f, 3), samples, segments and sides. levels : (f, 2),
    heights of bottom and top. middles : (f, 3), reaches : (f,), of balls about the facets. margin : m, by which they
    are shrunk on every face.
    """

    pairs: WholeNumbers
    starts: WholeNumbers
    hinges: WholeNumbers
    directions: Reals
    points: Reals
    samples: Reals
    segments: WholeNumbers
    sides: Reals
    counts: WholeNumbers
    levels: Reals
    middles: Reals
    reaches: Reals
    margin: float


class FacetView(NamedTuple):
    """One facet in the frame of another.

    pose : (3, 4). steps : (n,), the hinges from the viewing facet to the viewed one. axes, places : (n, 3), their axes,
    and points on them. length : (1,), number of hinges.
    """

    pose: Reals
    steps: WholeNumbers
    axes: Reals
    places: Reals
    length: WholeNumbers


@compiled
def no_plates() -> Plates:
    """Return empty plates, for panels that pass through each other."""
    return Plates(
        np.zeros((0, 2), np.int64),
        np.zeros(1, np.int64),
        np.zeros(0, np.int64),
        np.zeros((0, 3)),
        np.zeros((0, 3)),
        np.zeros((0, 0, 3)),
        np.zeros((0, 0, 2), np.int64),
        np.zeros((0, 0, 3)),
        np.zeros((0, 3), np.int64),
        np.zeros((0, 2)),
        np.zeros((0, 3)),
        np.zeros(0),
        0.0,
    )


@compiled
def new_facet_view(folds: int) -> FacetView:
    """Return empty tables."""
    return FacetView(
        np.zeros((3, 4)), np.zeros(folds, np.int64), np.zeros((folds, 3)), np.zeros((folds, 3)), np.zeros(1, np.int64)
    )


@compiled
def view_facet(plates: Plates, pair: int, order: int, angles: Reals, radii: Reals, sight: FacetView) -> None:
    """Write the view of the second facet of a pair from the first (order 0), or the reverse (1), at a state, (n,).

    The path whose radii, (n,), have the smaller sum is used.
    """
    path, least_sum = 2 * pair, math.inf
    for candidate in (2 * pair, 2 * pair + 1):
        total = 0.0
        for k in range(plates.starts[candidate], plates.starts[candidate + 1]):
            total += radii[plates.hinges[k]]
        if plates.starts[candidate + 1] > plates.starts[candidate] and total < least_sum:
            path, least_sum = candidate, total
    pose, sense = sight.pose, 1.0 if order == 0 else -1.0
    for i in range(3):
        for j in range(4):
            pose[i, j] = 1.0 if i == j else 0.0
    start, end = plates.starts[path], plates.starts[path + 1]
    for place in range(end - start):
        k = start + place if order == 0 else end - 1 - place
        u, p = vector_at(plates.directions, k, 0), vector_at(plates.points, k, 0)
        for i in range(3):
            sight.axes[place, i] = sense * (pose[i, 0] * u[0] + pose[i, 1] * u[1] + pose[i, 2] * u[2])
        put_vector(sight.places, place, 0, moved_point(pose, p))
        sight.steps[place] = plates.hinges[k]
        fold_on(pose, plates.directions[k], plates.points[k], sense * angles[plates.hinges[k]])
    sight.length[0] = end - start


@compiled
def viewed_point(sight: FacetView, points: Reals, k: int) -> Vector3:
    """The place of a point of the viewed facet, from a table, (m, 3)."""
    return moved_point(sight.pose, vector_at(points, k, 0))
