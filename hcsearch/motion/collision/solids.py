"""The panels of a linkage as solids: prisms, the same less a margin, and the pairs that can meet."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.linkage.reaches import PrismPairs, pairs_between
from hcsearch.motion.collision.margins import check_margin
from hcsearch.motion.collision.prisms import facet_pairs, prisms_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import SAME_POINT_SHARE
from hcsearch.shape.pattern import Hinge


class Solids(NamedTuple):
    """The panels of a linkage as the kernels take them: prisms, those with the margin taken off, and pairs.

    margin : by which panels are shrunk on every face, m. deepest : the margin that would leave nothing of a panel, m.
    """

    prisms: Prisms
    shrunk: Prisms
    pairs: PrismPairs
    margin: float
    deepest: float


def collision_solids(linkage: Linkage, margin: float, apart: Collection[tuple[int, int]] = ()) -> Solids:
    """The solids of a linkage; apart : pairs of panels, the lower number first, that are left out."""
    deepest = check_margin(linkage, margin)
    prisms = prisms_of(linkage)
    return Solids(prisms, prisms_of(linkage, margin), solid_pairs(linkage, prisms, apart), float(margin), deepest)


def solid_pairs(linkage: Linkage, prisms: Prisms, apart: Collection[tuple[int, int]] = ()) -> PrismPairs:
    """The pairs of facets of different panels but those left out, and the hinges between their panels.

    prisms : of all facets, not shrunk.
    """
    return pairs_between(linkage.chain, prisms, facet_pairs(linkage, apart))


def kept_apart(linkage: Linkage) -> frozenset[tuple[int, int]]:
    """Pairs of panels, the lower first, that cannot overlap while a hinge between them is within its stops.

    Each lies on one side of the hinge's line in the flat pattern, so that both lie in quarters about that line, which
    only touch at fold angles from 0 to pi (docs/explanation/collision.md). Panels that
    reach across the line are not among them.
    """
    pattern, pairs = linkage.pattern, set()
    same = SAME_POINT_SHARE * pattern.size

    def beside(panel: int, hinge: Hinge) -> Reals:
        """How far to the left of a hinge's line the corners of a panel are."""
        start = np.array(hinge.start)
        along = (np.array(hinge.end) - start) / math.dist(hinge.start, hinge.end)
        corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]]) - start
        left: Reals = along[0] * corners[:, 1] - along[1] * corners[:, 0]
        return left

    for hinge in pattern.hinges:
        if beside(hinge.first, hinge).min() >= -same and beside(hinge.second, hinge).max() <= same:
            pairs.add((min(hinge.first, hinge.second), max(hinge.first, hinge.second)))
    return frozenset(pairs)
