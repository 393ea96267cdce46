"""The facets of a linkage as right prisms, less a margin or as they are, and pairs of them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import Facet

PrismCorner = tuple[float, float, float]
TableEntry = TypeVar("TableEntry", bound=np.generic)

PARALLEL_SIDES_SINE = 1e-9
"""Sine of the angle between directions that count as one."""
FACET_CACHE_SIZE = 4096
"""Facets whose sides and insets are kept: arrays of one size share their cells."""


def prisms_of(linkage: Linkage, margin: float = 0.0) -> Prisms:
    """The prisms of all facets in the flat state, shrunk by a margin (m) on every face."""
    pattern = linkage.pattern
    upright = (0.0, 0.0, 1.0)
    solids: list[list[PrismCorner]] = []
    edges: list[list[PrismCorner]] = []
    normals: list[list[PrismCorner]] = []
    for facet in pattern.facets:
        sides = _classes(facet)
        faces = (margin, pattern.thickness - margin)
        solids.append([(x, y, z) for z in faces for x, y in _inset(facet, margin)])
        edges.append([*((x, y, 0.0) for x, y in sides), upright])
        normals.append([*((-y, x, 0.0) for x, y in sides), upright])
    counts = np.array([(len(solid), len(axes)) for solid, axes in zip(solids, edges, strict=True)], np.int64)
    vertices = padded_table([np.array(solid) for solid in solids])
    real = (np.arange(vertices.shape[1]) < counts[:, :1])[..., None]
    middles = vertices.sum(axis=1) / counts[:, :1]
    return Prisms(
        panels=np.array(pattern.panel_of, np.int64),
        counts=counts,
        vertices=vertices,
        middles=middles,
        reaches=np.linalg.norm((vertices - middles[:, None]) * real, axis=2).max(axis=1),
        normals=padded_table([np.array(own) for own in normals]),
        edges=padded_table([np.array(own) for own in edges]),
    )


def deepest_margin(linkage: Linkage) -> float:
    """The margin (m) by which prisms would be shrunk to nothing, or a side of one would be gone."""
    least = 0.5 * linkage.pattern.thickness
    for facet in linkage.pattern.facets:
        inside = _inset(facet, 1.0)
        for k in range(len(facet)):
            length = math.dist(facet[k], facet[k - 1])
            across = ((facet[k][c] - facet[k - 1][c]) * (inside[k][c] - inside[k - 1][c]) for c in (0, 1))
            lost = length - sum(across) / length
            if lost > 0.0:
                least = min(least, length / lost)
    return least


def facet_pairs(linkage: Linkage, apart: Collection[tuple[int, int]] = ()) -> NDArray[np.int64]:
    """Pairs of facets of different panels, but of those that are kept apart, shape (n_pairs, 2)."""
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    wanted = low != high
    if apart:
        n = linkage.n_panels
        wanted &= ~np.isin(low * n + high, [one * n + two for one, two in apart])
    return np.column_stack([first[wanted], second[wanted]])


@lru_cache(FACET_CACHE_SIZE)
def _inset(facet: Facet, margin: float) -> tuple[tuple[float, float], ...]:
    """Corners of a convex polygon, counterclockwise, with every side moved inwards."""
    corners = []
    for before, (x, y), after in zip((facet[-1], *facet[:-1]), facet, (*facet[1:], facet[0]), strict=True):
        first, second = math.dist(before, (x, y)), math.dist((x, y), after)
        a, b = (before[1] - y) / first, (x - before[0]) / first  # normals of both sides
        c, d = (y - after[1]) / second, (after[0] - x) / second
        share = margin / (1.0 + a * c + b * d)
        corners.append((x + share * (a + c), y + share * (b + d)))
    return tuple(corners)


@lru_cache(FACET_CACHE_SIZE)
def _classes(facet: Facet) -> tuple[tuple[float, float], ...]:
    """Unit vectors of the sides of a facet, one of those that are parallel."""
    directions: list[tuple[float, float]] = []
    for (x, y), (to_x, to_y) in zip(facet, (*facet[1:], facet[0]), strict=True):
        long = math.hypot(to_x - x, to_y - y)
        u, v = (to_x - x) / long, (to_y - y) / long
        if all(abs(u * b - v * a) > PARALLEL_SIDES_SINE for a, b in directions):
            directions.append((u, v))
    return tuple(directions)


def padded_table(rows: Sequence[NDArray[TableEntry]]) -> NDArray[TableEntry]:
    """Tables of different lengths as one, filled with zeros."""
    table = np.zeros((len(rows), max(map(len, rows)), rows[0].shape[1]), rows[0].dtype)
    for row, own in zip(table, rows, strict=True):
        row[: len(own)] = own
    return table
