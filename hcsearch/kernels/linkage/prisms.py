"""Right prisms over convex facets of moving panels, and paths between panels through a tree of hinges."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Integers32, Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, cross, dot, vector_at, vector_difference
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import Chain


class Prisms(NamedTuple):
    """Right prisms over convex facets, in the flat state; tables are as wide as the largest facet needs.

    panels : (f,), panel of each prism. counts : (f, 2), number of vertices, and of axes.
    vertices : (f, m, 3), those of the bottom, then those of the top in the same order. middles : (f, 3).
    reaches : (f,), greatest distance of a vertex from the middle.
    normals, edges : (f, a, 3), unit normals of faces and unit directions of edges, one for each parallel class, both
        including the vertical one.
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
    """Copy prisms; only the tables that change with the pose are duplicated."""
    p = prisms
    vertices, middles, normals, edges = p.vertices.copy(), p.middles.copy(), p.normals.copy(), p.edges.copy()
    return Prisms(p.panels, p.counts, vertices, middles, p.reaches, normals, edges)


@compiled
def place_prisms(prisms: Prisms, poses: Reals, placed: Prisms) -> None:
    """Write the vertices and middles of all prisms for given poses of their panels."""
    for f in range(len(prisms.panels)):
        pose = poses[prisms.panels[f]]
        for j in range(prisms.counts[f, 0]):
            _move(pose, 1.0, prisms.vertices[f, j], placed.vertices[f, j])
        _move(pose, 1.0, prisms.middles[f], placed.middles[f])


@compiled
def turn_axes(prisms: Prisms, poses: Reals, placed: Prisms, f: int) -> None:
    """Write the normals and edges of a prism for the pose of its panel."""
    pose = poses[prisms.panels[f]]
    for j in range(prisms.counts[f, 1]):
        _move(pose, 0.0, prisms.normals[f, j], placed.normals[f, j])
        _move(pose, 0.0, prisms.edges[f, j], placed.edges[f, j])


@compiled
def sphere_distance(prisms: Prisms, first: int, second: int) -> float:
    """Return the distance of the enclosing spheres of two prisms, negative where they overlap."""
    x = prisms.middles[first, 0] - prisms.middles[second, 0]
    y = prisms.middles[first, 1] - prisms.middles[second, 1]
    z = prisms.middles[first, 2] - prisms.middles[second, 2]
    middle_distance: float = math.sqrt(x * x + y * y + z * z)
    return middle_distance - float(prisms.reaches[first] + prisms.reaches[second])


@compiled
def _move(pose: Reals, shift: float, vector: Reals, moved: Reals) -> None:
    for i in range(3):
        moved[i] = pose[i, 0] * vector[0] + pose[i, 1] * vector[1] + pose[i, 2] * vector[2] + shift * pose[i, 3]


class PrismPairs(NamedTuple):
    """Pairs of prisms, and the paths between their panels through the tree of the chain.

    Each table entry gives the next hinge of a path, so that tables grow with the square of the number of panels; full
    paths of all pairs would grow with the cube.

    prisms : (p, 2). hinges, nexts : (n, n), the first hinge on the path to a panel (row) from another one (column), and
        the panel beyond it. The root panels of parts that no hinge connects stand still, and count as neighbours with
        hinge -1. reaches : (f, m), greatest distance (m) of points of each prism from the line of each hinge in any
        folded state; 0 for hinges that do not belong to the tree.
    """

    prisms: WholeNumbers
    hinges: Integers32
    nexts: Integers32
    reaches: Reals


@compiled
def pairs_between(chain: Chain, prisms: Prisms, prism_pairs: WholeNumbers) -> PrismPairs:
    """Return the paths between the panels of given pairs of prisms, shape (p, 2)."""
    n, parents = len(chain.order), chain.parents.copy()
    for panel in chain.order[1:]:
        if parents[panel] < 0:
            parents[panel] = chain.order[0]
    hinges, nexts = np.full((n, n), np.int32(-1)), np.full((n, n), np.int32(-1))
    for panel in chain.order:
        parent, hinge = parents[panel], chain.hinges[panel]
        if parent < 0:
            continue
        for other in range(n):  # panels visited before lie beyond the parent
            if nexts[other, parent] >= 0 or other == parent:
                hinges[other, panel], nexts[other, panel] = hinge, parent
        for other in range(n):
            if nexts[parent, other] >= 0:
                hinges[panel, other], nexts[panel, other] = hinges[parent, other], nexts[parent, other]
        hinges[panel, parent], nexts[panel, parent] = hinge, panel
    reaches = np.zeros((len(prisms.panels), len(chain.points)))
    lengths = np.zeros(n)
    for f in range(len(prisms.panels)):
        _write_reaches(chain, prisms, parents, hinges, nexts, f, lengths, reaches[f])
    return PrismPairs(prism_pairs, hinges, nexts, reaches)


@compiled
def _write_reaches(
    chain: Chain,
    prisms: Prisms,
    parents: WholeNumbers,
    hinges: Integers32,
    nexts: Integers32,
    f: int,
    lengths: Reals,
    reaches: Reals,
) -> None:
    """Write the greatest distance of a prism's corners from the line of each hinge, over all fold angles.

    lengths : work table with an entry per panel: length of the path from the corners to the hinge that leads there.
    """
    prism_panel = prisms.panels[f]
    # from the panel to the root first, then outward: a panel comes after the next one on its path to the prism
    panel = prism_panel
    while parents[panel] >= 0:
        _write_reach(chain, prisms, hinges, nexts, f, parents[panel], lengths, reaches)
        panel = parents[panel]
    for panel in chain.order:
        if panel != prism_panel and nexts[prism_panel, panel] >= 0 and nexts[prism_panel, panel] == parents[panel]:
            _write_reach(chain, prisms, hinges, nexts, f, panel, lengths, reaches)


@compiled
def _write_reach(
    chain: Chain, prisms: Prisms, hinges: Integers32, nexts: Integers32, f: int, p: int, lengths: Reals, reaches: Reals
) -> None:
    """Write the reach of a prism from the hinge that leads towards it from a panel, by that of the next hinge."""
    prism_panel = prisms.panels[f]
    hinge, after = hinges[prism_panel, p], nexts[prism_panel, p]
    point, line = _point(chain, hinge), (0.0, 0.0, 0.0) if hinge < 0 else vector_at(chain.directions, hinge, 0)
    if after == prism_panel:
        length = 0.0
        for c in range(prisms.counts[f, 0]):
            arm = vector_difference(vector_at(prisms.vertices[f], c, 0), point)
            across = cross(arm, line)
            if hinge >= 0:
                reaches[hinge] = max(reaches[hinge], math.sqrt(dot(across, across)))
            length = max(length, math.sqrt(dot(arm, arm)))
        lengths[p] = length
    else:
        arm = vector_difference(_point(chain, hinges[prism_panel, after]), point)
        across = cross(arm, line)
        if hinge >= 0:
            reaches[hinge] = math.sqrt(dot(across, across)) + lengths[after]
        lengths[p] = lengths[after] + math.sqrt(dot(arm, arm))


@compiled
def _point(chain: Chain, hinge: int) -> Vector3:
    """Return a point on the line of a hinge; the origin for hinge -1, between panels that stand still."""
    return (0.0, 0.0, 0.0) if hinge < 0 else vector_at(chain.points, hinge, 0)
