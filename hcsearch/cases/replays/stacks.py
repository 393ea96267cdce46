"""The two stacks of a folded linkage."""

from __future__ import annotations

import numpy as np

from hcsearch.shape.linkage import Linkage


def stacks_of(linkage: Linkage) -> list[int] | None:
    """Stack of each facet in the folded state, 0 for that of facet 0; None where facets lie over more than two places.

    Panels of a flat pair that is rigid, and mirror panels that are one, belong to both stacks, so facets are asked.
    """
    middles = np.array([solid.mean(axis=(0, 1))[:2] for solid in linkage.solids(linkage.folded)])
    near = 1e-3 * linkage.pattern.size
    first = np.linalg.norm(middles - middles[0], axis=1) < near
    if first.all():
        return None
    second = np.linalg.norm(middles - middles[np.flatnonzero(~first)[0]], axis=1) < near
    return (~first).astype(int).tolist() if (first | second).all() else None
