"""Whether convex facets on one plane overlap in part: laid on each other, neither apart nor the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import Reals
from hcsearch.shape.mesh import Facet


def clash(still: Sequence[Facet], moved: Sequence[Facet], tolerance: float) -> bool:
    """Whether facets of two patterns overlap without being the same; by no more than the tolerance is not at all."""
    one, two = _padded(still), _padded(moved)
    centres, others = one.mean(axis=1), two.mean(axis=1)
    reach, other = (np.linalg.norm(x - c[:, None], axis=2).max(axis=1) for x, c in ((one, centres), (two, others)))
    distance = np.linalg.norm(centres[:, None] - others, axis=2)
    i, j = np.nonzero(distance < reach[:, None] + other)
    gaps = np.linalg.norm(one[i, :, None] - two[j, None], axis=3) if one.shape[1] == two.shape[1] else None
    overlapping = ~(_outside(one[i], two[j], tolerance) | _outside(two[j], one[i], tolerance))
    if gaps is not None:
        overlapping &= np.maximum(gaps.min(axis=2).max(axis=1), gaps.min(axis=1).max(axis=1)) > tolerance
    return bool(overlapping.any())


def _padded(facets: Sequence[Facet]) -> Reals:
    """Corners of all facets, counterclockwise, with the last one repeated where others have more."""
    most = max(map(len, facets))
    corners = np.array([[*facet, *[facet[-1]] * (most - len(facet))] for facet in facets])
    x, y = corners[..., 0], corners[..., 1]
    turned = np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1) < 0
    corners[turned] = corners[turned, ::-1]
    return corners


def _outside(one: Reals, two: Reals, tolerance: float) -> NDArray[np.bool_]:
    """Of pairs of convex polygons, shape (k, n, 2), whether an edge of the first has the second on its other side."""
    edges = np.roll(one, -1, axis=1) - one
    lengths = np.linalg.norm(edges, axis=2)
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=2) / np.where(lengths > 0, lengths, 1.0)[..., None]
    heights = np.einsum("kaj,kbj->kab", normals, two) - np.einsum("kaj,kaj->ka", normals, one)[..., None]
    beyond = heights.min(axis=2) > -tolerance
    return np.asarray((beyond & (lengths > 0)).any(axis=1))
