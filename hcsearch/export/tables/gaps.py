"""How near panels are at states of a motion."""

from __future__ import annotations

import numpy as np

from hcsearch.collision.penetration import first_cut
from hcsearch.collision.prisms import facet_pairs
from hcsearch.collision.solids import kept_apart
from hcsearch.kernels.collision.distances import closest_of_pairs
from hcsearch.linkage import Linkage
from hcsearch.typing import Reals, Whole

SAME = 1e-9
"""Panels that cut into each other by no more than this share of the pattern's size touch."""


def gaps_at(linkage: Linkage, states: Reals) -> tuple[Reals, Whole]:
    """The least gap of two panels at each state (k, n_hinges), in m, (k,), and which two, the lower first, (k, 2).

    Pairs that the stops of a hinge keep apart are left out; where none are left the gap is inf, and the pair -1.
    Panels that overlap have a gap below 0: less how deep.
    """
    apart = kept_apart(linkage)
    pairs = facet_pairs(linkage, apart)
    gaps, nearest = np.full(len(states), np.inf), np.full((len(states), 2), -1)
    if not len(pairs):
        return gaps, nearest
    panel_of = np.array(linkage.pattern.panel_of)
    counts = np.array([2 * len(facet) for facet in linkage.pattern.facets])
    solids = np.zeros((len(counts), counts.max(), 3))
    ways, corners, distances = np.zeros((len(pairs), 3)), np.full((len(pairs), 4), -1), np.empty(len(pairs))
    first, second = pairs.T
    for k, angles in enumerate(states):
        for own, solid in zip(solids, linkage.solids(angles), strict=True):
            own[: solid.shape[0] * solid.shape[1]] = solid.reshape(-1, 3)
        # each search begins where that of the state before ended
        closest_of_pairs(solids[first], counts[first], solids[second], counts[second], ways, corners, distances)
        least = int(distances.argmin())
        gaps[k], nearest[k] = max(distances[least], 0.0), np.sort(panel_of[pairs[least]])
        cut = None if gaps[k] > 0.0 else first_cut(linkage, angles[None], SAME * linkage.pattern.size, apart)
        if cut is not None:
            gaps[k], nearest[k] = -cut.depth, cut.panels
    return gaps, nearest
