"""Distances between panels on a motion, approach speeds, and depths of penetration (thesis 4.3, 4.4).

Two convex prisms are apart, or only touch, where some direction separates them: the normal of a face of either or the
cross product of two edges. Otherwise their depth of penetration is the least overlap along these directions.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.gaps import PanelPairs, deepest_overlap, first_overlap, gaps_at
from hcsearch.motion.collision.panel_prisms import facet_pairs, prisms_of
from hcsearch.shape.linkage import Linkage

TOUCHING_DEPTH_SHARE = 1e-6
"""Prisms that penetrate each other by no more than this share of the pattern's size only touch."""


@dataclass(frozen=True)
class PanelCut:
    """Two panels that penetrate each other at a state, the number of the state, and the depth (m)."""

    state: int
    panels: tuple[int, int]
    depth: float


def first_cut(
    linkage: Linkage, states: Reals, allowed: float, apart: Collection[tuple[int, int]] = ()
) -> PanelCut | None:
    """The deepest cut at the first of some states where panels penetrate deeper than allowed (m); None without one.

    states : shape (n_states, n_hinges). apart : pairs of panels, the lower number first, that are left out, as their
    stops keep them apart.
    """
    pairs = facet_pairs(linkage, apart)
    depths = np.zeros(len(pairs))
    states = np.ascontiguousarray(states, float)
    state = first_overlap(linkage.chain, prisms_of(linkage), pairs, states, float(allowed), depths)
    if state < 0:
        return None
    worst = int(depths.argmax())
    first, second = sorted(linkage.pattern.panel_of[facet] for facet in pairs[worst])
    return PanelCut(state, (first, second), float(depths[worst]))


def deepest_cut(linkage: Linkage, states: Reals, apart: Collection[tuple[int, int]] = ()) -> float:
    """The greatest depth of penetration of panels at some states, shape (n_states, n_hinges), in metres."""
    states = np.ascontiguousarray(states, float)
    return float(deepest_overlap(linkage.chain, prisms_of(linkage), facet_pairs(linkage, apart), states))


def cuts_through(linkage: Linkage, states: Reals) -> bool:
    """Whether panels penetrate each other at any of some states, shape (n_states, n_hinges)."""
    return first_cut(linkage, states, TOUCHING_DEPTH_SHARE * linkage.pattern.size) is not None


CONTACT_GAP_SHARE = 2e-5
"""Panels nearer than this share of their size touch: 1 um for panels of 50 mm; simulations close loops more tightly."""


@dataclass(frozen=True, eq=False)
class Proximity(ByValue):
    """Distances between panels at some states.

    pairs : (p, 2), panels, the lower number first. gaps : (p, k), m: the distance of two panels, 0 where they touch,
    minus the depth of penetration where they collide.
    """

    pairs: WholeNumbers
    gaps: Reals

    @property
    def distances(self) -> Reals:
        """The dataset D of thesis 4.3, shape (p, k), m: 0 for panels that touch or collide."""
        return np.maximum(self.gaps, 0.0)

    @property
    def collision(self) -> int | None:
        """The first state at which panels collide, None without one. The thesis counts panels that touch, too."""
        states = np.flatnonzero((self.gaps < 0.0).any(axis=0))
        return int(states[0]) if len(states) else None


def proximal_distances(
    linkage: Linkage,
    states: Reals,
    apart: Collection[tuple[int, int]] = (),
    *,
    allowed: float | None = None,
    reach: float = math.inf,
) -> Proximity:
    """Distances of all pairs of panels that no hinge joins, at states of shape (k, n_hinges).

    The distance of a pair is the least between their facets. apart : more pairs to leave out, the lower number first.
    allowed : panels that penetrate no deeper (m) only touch; by default a millionth of the pattern's size.
    reach : distances beyond it (m) are replaced by a lower bound beyond it, which is faster.
    """
    states = np.ascontiguousarray(states, float)
    if states.ndim != 2 or states.shape[1] != linkage.n_hinges:
        raise HcsearchError(
            f"states cannot have the shape {states.shape}: give (number, {linkage.n_hinges}) fold angles"
        )
    if not reach > 0.0:
        raise HcsearchError(f"a reach of {reach:g} m is out of range: give a positive length")
    allowed = TOUCHING_DEPTH_SHARE * linkage.pattern.size if allowed is None else allowed
    if not 0.0 <= allowed < math.inf:
        raise HcsearchError(f"a depth of {allowed:g} m cannot be allowed: give 0 or more")
    panels = panel_pairs(linkage, apart)
    gaps = np.empty((len(states), len(panels)))
    facets = _facets_of(linkage, panels)
    gaps_at(linkage.chain, prisms_of(linkage), facets, states, float(reach), float(allowed), gaps)
    return Proximity(panels, gaps.T)


class NearestPanels(NamedTuple):
    """The nearest panels at some states.

    pairs : (k, 2), panels, the lower number first: the pair with the deepest overlap, else the one with the least gap
    among pairs that do not touch; -1 without one. gaps : (k,), m, of these pairs, negative where they overlap; nan
    without one.
    touching : (k,), number of pairs that touch.
    """

    pairs: WholeNumbers
    gaps: Reals
    touching: WholeNumbers


def nearest_panels(linkage: Linkage, states: Reals) -> NearestPanels:
    """The nearest panels that no hinge joins, at states of shape (k, n_hinges).

    Pairs that touch, to within `CONTACT_GAP_SHARE`, are only counted: packed and flat panels touch, and some pairs meet
    in a corner all the time, so they do not show which panels are near.
    """
    distances = proximal_distances(linkage, states)
    touching = np.abs(distances.gaps) <= CONTACT_GAP_SHARE * linkage.pattern.size
    gaps = np.where(touching, math.inf, distances.gaps)
    pairs, least_gaps = np.full((len(states), 2), -1), np.full(len(states), math.nan)
    if len(gaps):
        nearest = gaps.argmin(axis=0)
        found = np.isfinite(gaps[nearest, np.arange(len(states))])
        pairs[found] = distances.pairs[nearest[found]]
        least_gaps[found] = gaps[nearest[found], np.flatnonzero(found)]
    return NearestPanels(pairs, least_gaps, touching.sum(axis=0))


def approach_speeds(proximity: Proximity, times: Reals) -> Reals:
    """Approach speeds of the panels that collide, the dataset V of thesis eq. 4.25, shape (p,), m/s.

    Computed from the two states before the first collision; 0 for pairs that do not collide there, and without a
    collision.
    times : times of the states, (k,), s.
    """
    state = proximity.collision
    speeds = np.zeros(len(proximity.pairs))
    if state is None:
        return speeds
    if state < 2:
        raise HcsearchError(f"panels collide at state {state} already: give two states before the first collision")
    before, last = proximity.distances[:, state - 2 : state].T
    hit = proximity.gaps[:, state] < 0.0
    speeds[hit] = ((before - last) / (times[state - 1] - times[state - 2]))[hit]
    return speeds


def panel_pairs(linkage: Linkage, apart: Collection[tuple[int, int]] = ()) -> WholeNumbers:
    """All pairs of panels that no hinge joins, except those in `apart`, shape (p, 2)."""
    excluded = {(min(hinge.first, hinge.second), max(hinge.first, hinge.second)) for hinge in linkage.pattern.hinges}
    excluded |= set(apart)
    n = linkage.n_panels
    pairs = [(i, j) for i in range(n) for j in range(i + 1, n) if (i, j) not in excluded]
    return np.array(pairs, np.int64).reshape(-1, 2)


def _facets_of(linkage: Linkage, panels: WholeNumbers) -> PanelPairs:
    """The pairs of facets of each pair of panels."""
    facets: list[list[int]] = [[] for _ in range(linkage.n_panels)]
    for facet, panel in enumerate(linkage.pattern.panel_of):
        facets[panel].append(facet)
    pairs_by_panels = [[(one, two) for one in facets[i] for two in facets[j]] for i, j in panels]
    starts = np.cumsum([0, *map(len, pairs_by_panels)])
    return PanelPairs(np.array([pair for pairs in pairs_by_panels for pair in pairs], np.int64).reshape(-1, 2), starts)
