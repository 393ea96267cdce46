"""Right prisms over convex facets, and where they are once their panels have moved."""

from __future__ import annotations

import math
from typing import NamedTuple

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled, inlined, lean


class Prisms(NamedTuple):
    """Right prisms over convex facets, in the flat state; tables are as wide as the largest facet needs.

    panels : (f,), which panel each belongs to. counts : (f, 2), number of vertices, and of axes.
    vertices : (f, m, 3), those of the bottom, then in the same order those above. middles : (f, 3).
    reaches : (f,), greatest distance of a vertex from the middle.
    normals, edges : (f, a, 3), unit vectors, one of each parallel class: of faces and of edges, the upright one among
        both.
    """

    panels: WholeNumbers
    counts: WholeNumbers
    vertices: Reals
    middles: Reals
    reaches: Reals
    normals: Reals
    edges: Reals


@compiled
def copy_prisms(prisms: Prisms) -> Prisms:
    """The same prisms with tables of their own for what moves."""
    return Prisms(
        prisms.panels,
        prisms.counts,
        prisms.vertices.copy(),
        prisms.middles.copy(),
        prisms.reaches,
        prisms.normals.copy(),
        prisms.edges.copy(),
    )


@lean
def place_prisms(prisms: Prisms, poses: Reals, placed: Prisms) -> None:
    """Move the vertices and middles of all prisms with their panels."""
    for f in range(len(prisms.panels)):
        pose = poses[prisms.panels[f]]
        for j in range(prisms.counts[f, 0]):
            _move(pose, 1.0, prisms.vertices[f, j], placed.vertices[f, j])
        _move(pose, 1.0, prisms.middles[f], placed.middles[f])


@lean
def turn_axes(prisms: Prisms, poses: Reals, placed: Prisms, f: int) -> None:
    """Turn the normals and edges of a prism with its panel."""
    pose = poses[prisms.panels[f]]
    for j in range(prisms.counts[f, 1]):
        _move(pose, 0.0, prisms.normals[f, j], placed.normals[f, j])
        _move(pose, 0.0, prisms.edges[f, j], placed.edges[f, j])


@inlined
def sphere_distance(prisms: Prisms, one: int, two: int) -> float:
    """The distance of the spheres about two prisms, below 0 where they overlap."""
    x = prisms.middles[one, 0] - prisms.middles[two, 0]
    y = prisms.middles[one, 1] - prisms.middles[two, 1]
    z = prisms.middles[one, 2] - prisms.middles[two, 2]
    between: float = math.sqrt(x * x + y * y + z * z)
    return between - float(prisms.reaches[one] + prisms.reaches[two])


@inlined
def _move(pose: Reals, shift: float, vector: Reals, moved: Reals) -> None:
    for i in range(3):
        moved[i] = pose[i, 0] * vector[0] + pose[i, 1] * vector[1] + pose[i, 2] * vector[2] + shift * pose[i, 3]
