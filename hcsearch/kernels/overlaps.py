"""How deep prisms cut into each other: separating directions, the last one of each pair first."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.loops import Chain, place_panels

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]

PARALLEL = 1e-6
"""Edges whose directions differ by less (rad) have no direction across both."""


class Prisms(NamedTuple):
    """Right prisms over convex facets, in the flat state; tables are as wide as the largest facet needs.

    panels : (f,), which panel each belongs to. counts : (f, 2), number of vertices, and of axes.
    vertices : (f, m, 3). middles : (f, 3). reaches : (f,), greatest distance of a vertex from the middle.
    normals, edges : (f, a, 3), unit vectors, one of each parallel class: of faces and of edges, the upright one among
        both.
    """

    panels: Whole
    counts: Whole
    vertices: Reals
    middles: Reals
    reaches: Reals
    normals: Reals
    edges: Reals


@compiled
def first_overlap(chain: Chain, prisms: Prisms, pairs: Whole, states: Reals, allowed: float, depths: Reals) -> int:
    """The first state at which prisms of some pairs cut deeper than allowed into each other; -1 without.

    pairs : (p, 2), prisms. states : (k, n_hinges), fold angles. depths : (p,), written for that state, 0 of pairs that
        are further apart than their spheres.
    """
    placed = Prisms(
        prisms.panels,
        prisms.counts,
        prisms.vertices.copy(),
        prisms.middles.copy(),
        prisms.reaches,
        prisms.normals.copy(),
        prisms.edges.copy(),
    )
    poses = np.empty((len(chain.order), 3, 4))
    last = np.zeros(len(pairs), np.int64)
    for k in range(len(states)):
        place_panels(chain, states[k], poses)
        _place(prisms, poses, placed)
        for p in range(len(pairs)):
            if _depth(placed, pairs[p, 0], pairs[p, 1], allowed, last, p) > allowed:
                for r in range(len(pairs)):
                    depths[r] = max(0.0, _depth(placed, pairs[r, 0], pairs[r, 1], -math.inf, last, r))
                return k
    return -1


@compiled
def _place(prisms: Prisms, poses: Reals, placed: Prisms) -> None:
    """Move all prisms with their panels."""
    for f in range(len(prisms.panels)):
        pose = poses[prisms.panels[f]]
        for j in range(prisms.counts[f, 0]):
            _move(pose, 1.0, prisms.vertices[f, j], placed.vertices[f, j])
        for j in range(prisms.counts[f, 1]):
            _move(pose, 0.0, prisms.normals[f, j], placed.normals[f, j])
            _move(pose, 0.0, prisms.edges[f, j], placed.edges[f, j])
        _move(pose, 1.0, prisms.middles[f], placed.middles[f])


@compiled
def _move(pose: Reals, shift: float, vector: Reals, found: Reals) -> None:
    for i in range(3):
        found[i] = pose[i, 0] * vector[0] + pose[i, 1] * vector[1] + pose[i, 2] * vector[2] + shift * pose[i, 3]


@compiled
def _depth(prisms: Prisms, one: int, two: int, enough: float, last: Whole, pair: int) -> float:
    """Least overlap along all directions, or one that is at most `enough`, which is all that is asked for.

    last : direction that did so before, of each pair; written where one does now.
    """
    x = prisms.middles[one, 0] - prisms.middles[two, 0]
    y = prisms.middles[one, 1] - prisms.middles[two, 1]
    z = prisms.middles[one, 2] - prisms.middles[two, 2]
    reach = prisms.reaches[one] + prisms.reaches[two]
    if x * x + y * y + z * z >= reach * reach:
        return 0.0
    least = _along(prisms, one, two, last[pair])
    if least <= enough:
        return least
    a, b = prisms.counts[one, 1], prisms.counts[two, 1]
    for number in range(a + b + a * b):
        found = _along(prisms, one, two, number)
        least = min(least, found)
        if least <= enough:
            last[pair] = number
            return least
    return least


@compiled
def _along(prisms: Prisms, one: int, two: int, number: int) -> float:
    """Overlap of two prisms along a direction: normals of the first, of the second, then across edges of both."""
    a, b = prisms.counts[one, 1], prisms.counts[two, 1]
    if number < a:
        x, y, z = prisms.normals[one, number]
    elif number < a + b:
        x, y, z = prisms.normals[two, number - a]
    else:
        s, t, u = prisms.edges[one, (number - a - b) // b]
        e, f, g = prisms.edges[two, (number - a - b) % b]
        x, y, z = t * g - u * f, u * e - s * g, s * f - t * e
        length = math.sqrt(x * x + y * y + z * z)
        if length < PARALLEL:
            return math.inf
        x, y, z = x / length, y / length, z / length
    low = low_two = math.inf
    high = high_two = -math.inf
    for k in range(prisms.counts[one, 0]):
        way = x * prisms.vertices[one, k, 0] + y * prisms.vertices[one, k, 1] + z * prisms.vertices[one, k, 2]
        low, high = min(low, way), max(high, way)
    for k in range(prisms.counts[two, 0]):
        way = x * prisms.vertices[two, k, 0] + y * prisms.vertices[two, k, 1] + z * prisms.vertices[two, k, 2]
        low_two, high_two = min(low_two, way), max(high_two, way)
    return min(high - low_two, high_two - low)
