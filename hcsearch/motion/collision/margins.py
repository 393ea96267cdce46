"""Margins by which panels are shrunk, and how exactly gaps are known, in proportion to the panels."""

from __future__ import annotations

import math
from itertools import pairwise

from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.collision.prisms import deepest_margin
from hcsearch.shape.linkage import Linkage

REFERENCE_EDGE_LENGTH = 0.05
"""Longest edge (m) at which `DEFAULT_PANEL_MARGIN` and `GAP_RESOLUTION` hold; for others they are in proportion."""
DEFAULT_PANEL_MARGIN = 1e-4
"""Panels are shrunk by this on every face (m), unless another margin is given."""
MAX_MARGIN_SHARE = 0.2
"""A margin is no more than this share of the thickness: the middle of thin panels is left, too."""
GAP_RESOLUTION = 5e-5
"""A smallest gap is known to this (m)."""
MIN_PANEL_MARGIN = 1e-5
"""The least margin of which it is asked whether it is enough (m)."""
TOUCHING_DISTANCE = 1e-6
"""Panels nearer to each other than this, or overlapping by less, touch (m): loops are closed to about as much."""


def scale_of(linkage: Linkage) -> float:
    """The longest edge of a linkage's facets over `REFERENCE_EDGE_LENGTH`, to ten digits, past which is rounding."""
    facets = linkage.pattern.facets
    longest = max(math.dist(start, end) for facet in facets for start, end in pairwise((*facet, facet[0])))
    return float(f"{longest / REFERENCE_EDGE_LENGTH:.10g}")


def margin_of(linkage: Linkage) -> float:
    """The margin in proportion to the panels, m: to their edges, but no more than a share of their thickness."""
    return min(DEFAULT_PANEL_MARGIN * scale_of(linkage), MAX_MARGIN_SHARE * linkage.pattern.thickness)


def resolution_of(linkage: Linkage) -> float:
    """The resolution of a smallest gap in proportion to the panels, m."""
    return GAP_RESOLUTION * scale_of(linkage)


def check_margin(linkage: Linkage, margin: float) -> float:
    """Refuse a margin that leaves nothing of a panel, or none between panels that touch; the least that is too much."""
    most = deepest_margin(linkage)
    if not 0.0 < margin < most:
        raise HcsearchError(
            f"a margin of {1e3 * margin:g} mm is not positive or leaves nothing of a panel: "
            f"give more than 0 and less than {1e3 * most:.4g} mm as margin_mm of a scene file, or thicker panels"
        )
    return most
