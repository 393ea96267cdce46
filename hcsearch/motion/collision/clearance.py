"""Certified clearance of motions: whether panels collide at any time, and the smallest gap.

A motion is clear if panels shrunk by a margin on every face never overlap; pairs that the stops of their hinge keep
apart (`panel_prisms.kept_apart`) may be left out. Between the states of a motion the fold angles are polynomials, and
panels are placed by a tree of hinges; the error of closed loops that this leaves is given as slack
(docs/explanation/collision.md).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.kernels.collision.clearance_search import (
    MOTION_CLEAR,
    MOTION_COLLIDES,
    ClearanceReport,
    ClearanceTolerances,
    judge_clearance,
)
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.collision.least_gaps import approach_speed, least_pair_gap
from hcsearch.motion.collision.panel_prisms import (
    DEFAULT_PANEL_MARGIN,
    GAP_RESOLUTION,
    TOUCHING_DISTANCE,
    Solids,
    collision_solids,
    prisms_of,
    solid_pairs,
)
from hcsearch.shape.linkage import Linkage


@dataclass(frozen=True)
class Clearance:
    """The verdict on the collisions of a motion.

    kind : `clear` at all times, with the margin; `collides`, for certain, at some time; `undecided`: nearer than the
        slack at some time, but never overlapping by more. time : of the contact, s; panels : the two that touch, the
        lower number first.
    gap : for a clear motion, the smallest gap (m) at which two panels approach each other and part again; None where
        none do. Only gaps between two states at which the pair is further apart by two margins more count, as
        neighbours touch in the packed and in the flat state. The gap differs from the true least one by at
        most the resolution and the slack.
    bound_count : number of times that the gap of a pair was bounded in an interval. speed : approach speed of the
        panels where the motion is not clear, m/s.
    """

    kind: Literal["clear", "collides", "undecided"]
    margin: float
    time: float | None
    panels: tuple[int, int] | None
    gap: float | None
    bound_count: int
    speed: float = 0.0


def certify_clearance(
    linkage: Linkage,
    course: Course,
    *,
    margin: float = DEFAULT_PANEL_MARGIN,
    resolution: float = GAP_RESOLUTION,
    slack: float | Reals = 0.0,
    apart: Collection[tuple[int, int]] = (),
    measured: bool = True,
) -> Clearance:
    """Certify that a motion of the fold angles of a linkage is clear of collisions, or find one.

    margin : panels are shrunk by it on every face, m. resolution : of the smallest gap, m.
    slack : bound of the placement error of panels by the tree of hinges, m, for all times or for each step, (k - 1,).
    apart : pairs of panels, the lower number first, that are left out. measured : whether to compute the smallest gap
    of a clear motion.
    """
    solids = collision_solids(linkage, margin, apart)
    if not len(solids.pairs.prisms) or len(course.times) < 2:
        return Clearance("clear", margin, None, None, None, 0)
    return _Certificate(linkage, solids, resolution).certify(course, slack, measured)


def least_gap_of_motion(
    linkage: Linkage, course: Course, *, resolution: float = TOUCHING_DISTANCE, apart: Collection[tuple[int, int]] = ()
) -> float | None:
    """The least gap (m) between two panels as built over all times of a motion; negative where they overlap.

    The depth of an overlap is the shortest translation that separates the panels. The true least gap is lower by no
    more than the resolution (m). apart : pairs of panels, the lower number first, that are left out. None without a
    pair.
    """
    prisms = prisms_of(linkage)
    pairs = solid_pairs(linkage, prisms, apart)
    gap: float | None = finite_or_none(float(least_pair_gap(linkage.chain, prisms, pairs, course, resolution)))
    return gap


class _Certificate:
    """Search for collisions in one motion."""

    def __init__(self, linkage: Linkage, solids: Solids, resolution: float) -> None:
        self.linkage, self.solids, self.resolution = linkage, solids, resolution

    def certify(self, course: Course, slack: float | Reals, measured: bool) -> Clearance:
        """As `certify_clearance`."""
        report = ClearanceReport(np.zeros(1), np.zeros(1, np.int64), np.zeros(1), np.zeros(1, np.int64))
        solids = self.solids
        slacks = np.broadcast_to(slack, len(course.times) - 1).astype(float)
        tolerances = ClearanceTolerances(slacks, solids.margin, solids.max_margin, self.resolution)
        verdict = judge_clearance(
            self.linkage.chain, solids.prisms, solids.shrunk, solids.pairs, course, tolerances, measured, report
        )
        bound_count, gap = int(report.bound_counts[0]), float(report.gaps[0])
        if verdict == MOTION_CLEAR:
            return Clearance("clear", self.solids.margin, None, None, finite_or_none(gap), bound_count)
        first, second = sorted(self.linkage.pattern.panel_of[facet] for facet in solids.pairs.prisms[report.pairs[0]])
        kind: Literal["collides", "undecided"] = "collides" if verdict == MOTION_COLLIDES else "undecided"
        pair, time = int(report.pairs[0]), float(report.times[0])
        speed = approach_speed(self.linkage.chain, solids.shrunk, solids.pairs, pair, course, time)
        return Clearance(kind, self.solids.margin, time, (first, second), None, bound_count, speed)
