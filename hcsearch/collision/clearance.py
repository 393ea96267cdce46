"""Whether a motion is clear of collisions at all of its times, certified, and its smallest gap.

Clear means: panels shrunk by a margin on every face do not overlap at any time; pairs joined by a hinge are left out,
as their stops keep them apart. Between the states of a motion fold angles are polynomials, and panels are placed
by a tree of hinges; what that leaves open of the loops is asked for as slack (docs/collision.md).
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcsearch.collision.penetration import prisms_of
from hcsearch.errors import HcsearchError
from hcsearch.kernels.clearance import CLEAR, COLLIDES, Answer, Course, Search, search
from hcsearch.kernels.paths import Pairs, pairs_between
from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

MARGIN = 1e-4
"""Panels are shrunk by this on every face (m), unless another margin is given."""
RESOLUTION = 5e-5
"""A smallest gap is known to this (m)."""
NEAR = 0.1
"""Shrunk panels that are no further apart than what is left open of the loops collide, if that is no more than this
share of the margin; where more is left open, they may or may not."""


@dataclass(frozen=True)
class Clearance:
    """The verdict on a motion.

    kind : `clear` at all times, with the margin; `collides` at a time; `undecided`, so near that no interval is short
        enough to tell. time : s, of what is not clear; panels : which two, the lower number first.
    gap : of a clear motion, what no pair of panels comes nearer than between the time it is first further apart than
        two margins and the time it last is, in m; None where no pair counts. Neighbours touch in the packed and in the
        flat state, so without this it would be 0. The least gap itself is within `RESOLUTION` of it.
    looks : how often a pair was looked at.
    """

    kind: Literal["clear", "collides", "undecided"]
    margin: float
    time: float | None
    panels: tuple[int, int] | None
    gap: float | None
    looks: int


def certify(
    linkage: Linkage,
    course: Course,
    *,
    margin: float = MARGIN,
    slack: float = 0.0,
    apart: Collection[tuple[int, int]] = (),
    measured: bool = True,
) -> Clearance:
    """Certify a motion of the fold angles of a linkage.

    slack : what panels may be elsewhere than the tree of hinges places them, m. apart : pairs of panels, the lower
    number first, that are left out. measured : whether the smallest gap of a clear motion is wanted.
    """
    pairs = pairs_of(linkage, apart)
    answer = Answer(np.zeros(1), np.zeros(1, np.int64), np.full(1, math.inf), np.zeros(1, np.int64))
    if not len(pairs.prisms) or len(course.times) < 2:
        return Clearance("clear", margin, None, None, None, 0)
    verdict = search(linkage.chain, prisms_of(linkage, margin), pairs, course, search_for(margin, slack), answer)
    looks = int(answer.looks[0])
    if verdict != CLEAR:
        one, two = (linkage.pattern.panel_of[facet] for facet in pairs.prisms[answer.pairs[0]])
        kind: Literal["collides", "undecided"] = "collides" if verdict == COLLIDES else "undecided"
        return Clearance(kind, margin, float(answer.times[0]), (min(one, two), max(one, two)), None, looks)
    if not measured:
        return Clearance("clear", margin, None, None, None, looks)
    search(linkage.chain, prisms_of(linkage), pairs, course, search_for(margin, slack, measuring=True), answer)
    gap = float(answer.gaps[0])
    return Clearance("clear", margin, None, None, None if math.isinf(gap) else gap, looks + int(answer.looks[0]))


def pairs_of(linkage: Linkage, apart: Collection[tuple[int, int]] = ()) -> Pairs:
    """The pairs of facets of different panels but those left out, and the hinges between their panels."""
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    n = linkage.n_panels
    wanted = (low != high) & ~np.isin(low * n + high, [one * n + two for one, two in apart])
    return pairs_between(linkage.chain, prisms_of(linkage), np.column_stack([first[wanted], second[wanted]]))


def search_for(margin: float, slack: float, *, measuring: bool = False) -> Search:
    """What the kernel is asked: whether panels come together, or how near they come."""
    return Search(float(slack), min(float(slack), NEAR * margin), measuring, 2.0 * margin, RESOLUTION)


def check_margin(linkage: Linkage, margin: float) -> None:
    """Refuse a margin that leaves nothing of a panel."""
    pattern = linkage.pattern
    if not 0.0 <= margin < 0.5 * pattern.thickness:
        raise HcsearchError(
            f"a margin of {1e3 * margin:g} mm leaves nothing of panels {1e3 * pattern.thickness:g} mm thick: "
            "give less than half of that"
        )
