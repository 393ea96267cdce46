"""Whether panels cut through each other on a motion: penetration of their prisms at its states.

Two convex prisms are apart, or only touch, where some direction separates them: the normal of a face of either or the
cross product of two edges. Otherwise the least overlap along these directions is how deep they cut into each other.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.collision.overlaps import deepest_overlap, first_overlap
from hcsearch.motion.collision.prisms import facet_pairs, prisms_of
from hcsearch.shape.linkage import Linkage

TOUCHING_DEPTH_SHARE = 1e-6
"""Prisms that cut into each other by no more than this share of the pattern's size only touch."""


@dataclass(frozen=True)
class PanelCut:
    """Two panels that cut into each other at a state, given by its number, and how deep (m)."""

    state: int
    panels: tuple[int, int]
    depth: float


def first_cut(
    linkage: Linkage, states: Reals, allowed: float, apart: Collection[tuple[int, int]] = ()
) -> PanelCut | None:
    """The first of some states, shape (n_states, n_hinges), at which panels cut deeper than allowed (m): the deepest.

    apart : pairs of panels, the lower number first, that are left out, as their stops keep them apart.
    """
    pairs = facet_pairs(linkage, apart)
    depths = np.zeros(len(pairs))
    states = np.ascontiguousarray(states, float)
    state = first_overlap(linkage.chain, prisms_of(linkage), pairs, states, float(allowed), depths)
    if state < 0:
        return None
    worst = int(depths.argmax())
    one, two = sorted(linkage.pattern.panel_of[facet] for facet in pairs[worst])
    return PanelCut(state, (one, two), float(depths[worst]))


def deepest_cut(linkage: Linkage, states: Reals, apart: Collection[tuple[int, int]] = ()) -> float:
    """How deep panels cut into each other at the worst of some states, shape (n_states, n_hinges), in metres."""
    states = np.ascontiguousarray(states, float)
    return float(deepest_overlap(linkage.chain, prisms_of(linkage), facet_pairs(linkage, apart), states))


def penetration(linkage: Linkage, angles: Reals) -> float:
    """How deep facets of different panels cut into each other at one state, in metres; 0 where they only touch."""
    cut = first_cut(linkage, np.asarray(angles, float)[None], 0.0)
    return 0.0 if cut is None else cut.depth


def cuts_through(linkage: Linkage, states: Reals) -> bool:
    """Whether panels cut through each other at any of some states, shape (n_states, n_hinges)."""
    return first_cut(linkage, states, TOUCHING_DEPTH_SHARE * linkage.pattern.size) is not None
