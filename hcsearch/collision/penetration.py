"""Whether panels cut through each other on a motion: penetration of their prisms at its states.

Two convex prisms are apart, or only touch, where some direction separates them: the normal of a face of either or the
cross product of two edges. Otherwise the least overlap along these directions is how deep they cut into each other.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

TOUCH = 1e-6
"""Prisms that cut into each other by no more than this share of the pattern's size only touch."""


def penetration(linkage: Linkage, angles: Reals) -> float:
    """How deep facets of different panels cut into each other at one state, in metres; 0 where they only touch."""
    return deepest(linkage, angles)[0]


def deepest(linkage: Linkage, angles: Reals, apart: Collection[tuple[int, int]] = ()) -> tuple[float, tuple[int, int]]:
    """The deepest cut at one state (m), and its two panels; 0 where they only touch.

    apart : pairs of panels, the lower number first, that are not looked at, as their stops keep them apart.
    """
    solids = np.array(linkage.solids(angles))  # all facets have the same number of corners
    corners = solids.reshape(len(solids), -1, 3)
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    panels = np.array(linkage.pattern.panel_of)
    i, j = np.triu_indices(len(solids), 1)
    near = (np.linalg.norm(middles[i] - middles[j], axis=1) < reach[i] + reach[j]) & (panels[i] != panels[j])
    if apart:
        n = linkage.n_panels
        codes = np.minimum(panels[i], panels[j]) * n + np.maximum(panels[i], panels[j])
        near &= ~np.isin(codes, [first * n + second for first, second in apart])
    i, j = i[near], j[near]
    if not len(i):
        return 0.0, (0, 0)
    normals, edges = _directions(solids)
    depth = np.full(len(i), np.inf)
    for axes in (normals[i], normals[j], _crossed(edges[i], edges[j])):
        depth = np.minimum(depth, _overlap(axes, corners[i], corners[j]))
    worst = int(depth.argmax())
    return max(0.0, float(depth[worst])), (int(panels[i[worst]]), int(panels[j[worst]]))


def cuts_through(linkage: Linkage, states: Reals) -> bool:
    """Whether panels cut through each other at any of some states, shape (n_states, n_hinges)."""
    allowed = TOUCH * linkage.pattern.size
    return any(penetration(linkage, angles) > allowed for angles in states)


def _directions(solids: Reals) -> tuple[Reals, Reals]:
    """Normals of the faces and directions of the edges of prisms, shape (n, k + 1, 3) each."""
    bottom, top = solids[:, 0], solids[:, 1]
    edges = np.roll(bottom, -1, axis=1) - bottom
    upright = (top - bottom)[:, :1]
    normals = np.concatenate([np.cross(edges, upright), upright], axis=1)
    return normals, np.concatenate([edges, upright], axis=1)


def _crossed(one: Reals, two: Reals) -> Reals:
    found: Reals = np.cross(one[:, :, None], two[:, None]).reshape(len(one), -1, 3)
    return found


def _overlap(axes: Reals, one: Reals, two: Reals) -> Reals:
    """Least overlap of pairs of prisms along some directions each, shape (n,); parallel edges give no direction."""
    lengths = np.linalg.norm(axes, axis=2)
    largest = lengths.max(axis=1, keepdims=True)
    good = lengths > 1e-6 * largest
    unit = axes / np.where(good, lengths, 1.0)[:, :, None]
    a, b = np.einsum("nak,nck->nac", unit, one), np.einsum("nak,nck->nac", unit, two)
    shared = np.minimum(a.max(axis=2) - b.min(axis=2), b.max(axis=2) - a.min(axis=2))
    found: Reals = np.where(good, shared, np.inf).min(axis=1)
    return found
