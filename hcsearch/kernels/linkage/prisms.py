"""Right prisms over convex facets on moving panels, and ways between panels through a tree of hinges."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, cross, dot, vector_at, vector_difference
from hcsearch.kernels.compiling.compiled import compiled, inlined, lean
from hcsearch.kernels.linkage.loops import Chain


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


class PrismPairs(NamedTuple):
    """Pairs of prisms, and the ways between their panels through the tree of the chain.

    A way is walked by its next hinge, so that tables grow with the square of the panels: written out, ways of all
    pairs grow with the cube.

    prisms : (p, 2). hinges, nexts : (n, n), the first hinge on the way to a panel (row) from another one (column), and
        the panel beyond it; the first panels of parts that no hinge joins are beside each other, with hinge -1, as they
        stand still. reaches : (f, m), greatest distance (m) of points of each prism from the line of each hinge
        of the tree, however it folds; 0 of hinges that it leaves out.
    """

    prisms: WholeNumbers
    hinges: NDArray[np.int32]
    nexts: NDArray[np.int32]
    reaches: Reals


@compiled
def pairs_between(chain: Chain, prisms: Prisms, wanted: WholeNumbers) -> PrismPairs:
    """The ways between the panels of some pairs of prisms, shape (p, 2)."""
    n, parents = len(chain.order), chain.parents.copy()
    for panel in chain.order[1:]:
        if parents[panel] < 0:
            parents[panel] = chain.order[0]
    hinges, nexts = np.full((n, n), np.int32(-1)), np.full((n, n), np.int32(-1))
    for panel in chain.order:
        parent, hinge = parents[panel], chain.hinges[panel]
        if parent < 0:
            continue
        for other in range(n):  # those that the tree came to before are beyond the parent
            if nexts[other, parent] >= 0 or other == parent:
                hinges[other, panel], nexts[other, panel] = hinge, parent
        for other in range(n):
            if nexts[parent, other] >= 0:
                hinges[panel, other], nexts[panel, other] = hinges[parent, other], nexts[parent, other]
        hinges[panel, parent], nexts[panel, parent] = hinge, panel
    reaches = np.zeros((len(prisms.panels), len(chain.points)))
    lengths = np.zeros(n)
    for f in range(len(prisms.panels)):
        _reach(chain, prisms, parents, hinges, nexts, f, lengths, reaches[f])
    return PrismPairs(wanted, hinges, nexts, reaches)


@lean
def _reach(
    chain: Chain,
    prisms: Prisms,
    parents: WholeNumbers,
    hinges: NDArray[np.int32],
    nexts: NDArray[np.int32],
    f: int,
    lengths: Reals,
    reaches: Reals,
) -> None:
    """Write the greatest distance of the corners of a prism from the line of each hinge, however those between fold.

    lengths : room for each panel, of the way from the corners to the hinge that leads to it.
    """
    own = prisms.panels[f]
    # down from the panel to the root first, then up: a panel comes after the next one on its way to the prism
    panel = own
    while parents[panel] >= 0:
        _pass(chain, prisms, hinges, nexts, f, parents[panel], lengths, reaches)
        panel = parents[panel]
    for panel in chain.order:
        if panel != own and nexts[own, panel] >= 0 and nexts[own, panel] == parents[panel]:
            _pass(chain, prisms, hinges, nexts, f, panel, lengths, reaches)


@lean
def _pass(
    chain: Chain,
    prisms: Prisms,
    hinges: NDArray[np.int32],
    nexts: NDArray[np.int32],
    f: int,
    panel: int,
    lengths: Reals,
    reaches: Reals,
) -> None:
    """Write the reach of a prism beyond the hinge that leads from a panel to it, by that of the hinge after."""
    own = prisms.panels[f]
    hinge, after = hinges[own, panel], nexts[own, panel]
    point, line = _point(chain, hinge), (0.0, 0.0, 0.0) if hinge < 0 else vector_at(chain.directions, hinge, 0)
    if after == own:
        length = 0.0
        for c in range(prisms.counts[f, 0]):
            arm = vector_difference(vector_at(prisms.vertices[f], c, 0), point)
            across = cross(arm, line)
            if hinge >= 0:
                reaches[hinge] = max(reaches[hinge], math.sqrt(dot(across, across)))
            length = max(length, math.sqrt(dot(arm, arm)))
        lengths[panel] = length
    else:
        arm = vector_difference(_point(chain, hinges[own, after]), point)
        across = cross(arm, line)
        if hinge >= 0:
            reaches[hinge] = math.sqrt(dot(across, across)) + lengths[after]
        lengths[panel] = lengths[after] + math.sqrt(dot(arm, arm))


@lean
def _point(chain: Chain, hinge: int) -> Vector3:
    """A point of the line of a hinge; the origin, which is at rest in both, between panels that stand still."""
    return (0.0, 0.0, 0.0) if hinge < 0 else vector_at(chain.points, hinge, 0)
