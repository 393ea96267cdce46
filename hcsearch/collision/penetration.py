"""Whether panels cut through each other on a motion: penetration of their prisms at its states.

Two convex prisms are apart, or only touch, where some direction separates them: the normal of a face of either or the
cross product of two edges. Otherwise the least overlap along these directions is how deep they cut into each other.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.overlaps import first_overlap
from hcsearch.kernels.prisms import Prisms
from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

TOUCH = 1e-6
"""Prisms that cut into each other by no more than this share of the pattern's size only touch."""
SAME = 1e-9
"""Sine of the angle between directions that count as one."""


@dataclass(frozen=True)
class Cut:
    """Two panels that cut into each other at a state, given by its number, and how deep (m)."""

    state: int
    panels: tuple[int, int]
    depth: float


def first_cut(linkage: Linkage, states: Reals, allowed: float, apart: Collection[tuple[int, int]] = ()) -> Cut | None:
    """The first of some states, shape (n_states, n_hinges), at which panels cut deeper than allowed (m): the deepest.

    apart : pairs of panels, the lower number first, that are not looked at, as their stops keep them apart.
    """
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    wanted = low != high
    if apart:
        n = linkage.n_panels
        wanted &= ~np.isin(low * n + high, [one * n + two for one, two in apart])
    pairs = np.column_stack([first[wanted], second[wanted]])
    depths = np.zeros(len(pairs))
    states = np.ascontiguousarray(states, float)
    state = first_overlap(linkage.chain, prisms_of(linkage), pairs, states, float(allowed), depths)
    if state < 0:
        return None
    worst = int(depths.argmax())
    return Cut(state, (int(low[wanted][worst]), int(high[wanted][worst])), float(depths[worst]))


def penetration(linkage: Linkage, angles: Reals) -> float:
    """How deep facets of different panels cut into each other at one state, in metres; 0 where they only touch."""
    found = first_cut(linkage, np.asarray(angles, float)[None], 0.0)
    return 0.0 if found is None else found.depth


def cuts_through(linkage: Linkage, states: Reals) -> bool:
    """Whether panels cut through each other at any of some states, shape (n_states, n_hinges)."""
    return first_cut(linkage, states, TOUCH * linkage.pattern.size) is not None


def prisms_of(linkage: Linkage) -> Prisms:
    """The prisms of all facets in the flat state."""
    pattern = linkage.pattern
    upright = np.array([0.0, 0.0, 1.0])
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    solids, edges, normals = [], [], []
    for facet in pattern.facets:
        flat = np.array([[*corner, 0.0] for corner in facet])
        solids.append(np.concatenate([flat, flat + pattern.thickness * upright]))
        sides = _classes(np.roll(flat, -1, axis=0) - flat)
        edges.append(np.concatenate([sides, upright[None]]))
        normals.append(np.concatenate([sides @ quarter, upright[None]]))
    middles = np.array([solid.mean(axis=0) for solid in solids])
    reaches = [np.linalg.norm(solid - middle, axis=1).max() for solid, middle in zip(solids, middles, strict=True)]
    return Prisms(
        panels=np.array(pattern.panel_of, np.int64),
        counts=np.array([(len(solid), len(axes)) for solid, axes in zip(solids, edges, strict=True)], np.int64),
        vertices=_table(solids),
        middles=middles,
        reaches=np.array(reaches),
        normals=_table(normals),
        edges=_table(edges),
    )


def _classes(sides: Reals) -> Reals:
    """Unit vectors of the sides of a facet, one of those that are parallel."""
    units: Reals = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    across = np.abs(np.outer(units[:, 0], units[:, 1]) - np.outer(units[:, 1], units[:, 0]))
    return units[~np.tril(across <= SAME, -1).any(axis=1)]


def _table(rows: list[Reals]) -> Reals:
    """Arrays of different lengths, (n, 3), as one."""
    found = np.zeros((len(rows), max(map(len, rows)), 3))
    for k, row in enumerate(rows):
        found[k, : len(row)] = row
    return found
