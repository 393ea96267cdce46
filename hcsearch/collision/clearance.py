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

from hcsearch.collision.penetration import deepest_margin, prisms_of
from hcsearch.errors import HcsearchError
from hcsearch.kernels.clearance import CLEAR, COLLIDES, Answer, Search, judge
from hcsearch.kernels.intervals import Course
from hcsearch.kernels.paths import Pairs, pairs_between
from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

MARGIN = 1e-4
"""Panels are shrunk by this on every face (m), unless another margin is given."""
RESOLUTION = 5e-5
"""A smallest gap is known to this (m)."""


@dataclass(frozen=True)
class Clearance:
    """The verdict on a motion.

    kind : `clear` at all times, with the margin; `collides`, for sure, at a time; `undecided`, nearer than the slack at
        a time, but overlapping by more at none. time : s, of what is not clear; panels : which two, the lower first.
    gap : of a clear motion, what no two panels come nearer than where they come near and part again, in m; None where
        none do. A gap counts that lies between two states at which the pair is further apart by two margins more:
        neighbours touch in the packed and in the flat state, so without this it would be 0. The least gap itself is
        within `RESOLUTION`, and the slack, of it.
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
    check_margin(linkage, margin)
    pairs = pairs_of(linkage, apart)
    if not len(pairs.prisms) or len(course.times) < 2:
        return Clearance("clear", margin, None, None, None, 0)
    answer = Answer(np.zeros(1), np.zeros(1, np.int64), np.zeros(1), np.zeros(1, np.int64))
    wanted = Search(float(slack), float(margin), deepest_margin(linkage), RESOLUTION)
    prisms, shrunk = prisms_of(linkage), prisms_of(linkage, margin)
    verdict = judge(linkage.chain, prisms, shrunk, pairs, course, wanted, measured, answer)
    looks, gap = int(answer.looks[0]), float(answer.gaps[0])
    if verdict == CLEAR:
        return Clearance("clear", margin, None, None, gap if math.isfinite(gap) else None, looks)
    one, two = sorted(linkage.pattern.panel_of[facet] for facet in pairs.prisms[answer.pairs[0]])
    kind: Literal["collides", "undecided"] = "collides" if verdict == COLLIDES else "undecided"
    return Clearance(kind, margin, float(answer.times[0]), (one, two), None, looks)


def pairs_of(linkage: Linkage, apart: Collection[tuple[int, int]] = ()) -> Pairs:
    """The pairs of facets of different panels but those left out, and the hinges between their panels."""
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    n = linkage.n_panels
    wanted = (low != high) & ~np.isin(low * n + high, [one * n + two for one, two in apart])
    return pairs_between(linkage.chain, prisms_of(linkage), np.column_stack([first[wanted], second[wanted]]))


def slack_of(linkage: Linkage, gap: float) -> float:
    """What panels may be elsewhere (m) where loops are open by a gap (rad, or over the pattern's size).

    A panel that is reached the other way around a loop is turned by up to sqrt(3) gaps about a point of the loop, from
    which no panel is further than half of all are wide, and moved by as much times the size. The rest of the factor is
    for what lies between the places at which gaps are looked for.
    """
    pattern = linkage.pattern
    widths = []
    for facets in pattern.panels:
        corners = np.concatenate([np.array(pattern.facets[facet]) for facet in facets])
        across = np.linalg.norm(corners[:, None] - corners, axis=2).max()
        widths.append(math.hypot(float(across), pattern.thickness))
    reach = 0.5 * (sum(widths) + max(widths)) + pattern.size
    return 2.0 * len(linkage.loops) * reach * gap


def check_margin(linkage: Linkage, margin: float) -> None:
    """Refuse a margin that leaves nothing of a panel, or with which what touches could never be clear."""
    most = deepest_margin(linkage)
    if not 0.0 < margin < most:
        raise HcsearchError(
            f"a margin of {1e3 * margin:g} mm is none or leaves nothing of a panel: "
            f"give more than 0 and less than {1e3 * most:.4g} mm"
        )
