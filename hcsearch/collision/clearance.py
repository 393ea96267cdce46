"""Whether a motion is clear of collisions at all of its times, certified, and its smallest gap.

Clear means: panels shrunk by a margin on every face do not overlap at any time; pairs that the stops of their hinge
keep apart (`kept_apart`) may be left out. Between the states of a motion fold angles are polynomials, and panels are
placed by a tree of hinges; what that leaves open of the loops is asked for as slack (docs/collision.md).
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcsearch.collision.penetration import deepest_margin, prisms_of
from hcsearch.errors import HcsearchError
from hcsearch.kernels.collision.clearance import CLEAR, COLLIDES, Answer, Search, judge
from hcsearch.kernels.collision.dips import smallest_dip
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.linkage.prisms import Prisms
from hcsearch.kernels.linkage.reaches import Pairs, pairs_between
from hcsearch.linkage import Linkage
from hcsearch.pattern import SAME, Hinge

Reals = NDArray[np.float64]

EDGE = 0.05
"""Longest edge of the panels that `MARGIN` and `RESOLUTION` are of, m; for others they are in proportion."""
MARGIN = 1e-4
"""Panels are shrunk by this on every face (m), unless another margin is given."""
RESOLUTION = 5e-5
"""A smallest gap is known to this (m)."""


def scale_of(linkage: Linkage) -> float:
    """The longest edge of a linkage's facets over `EDGE`, to ten digits: rounding of corners is no other size."""
    facets = linkage.pattern.facets
    longest = max(math.dist(start, end) for facet in facets for start, end in pairwise((*facet, facet[0])))
    return float(f"{longest / EDGE:.10g}")


def margin_of(linkage: Linkage) -> float:
    """The margin in proportion to the panels, m."""
    return MARGIN * scale_of(linkage)


def resolution_of(linkage: Linkage) -> float:
    """The resolution of a smallest gap in proportion to the panels, m."""
    return RESOLUTION * scale_of(linkage)


@dataclass(frozen=True)
class Clearance:
    """The verdict on a motion.

    kind : `clear` at all times, with the margin; `collides`, for sure, at a time; `undecided`, nearer than the slack at
        a time, but overlapping by more at none. time : s, of what is not clear; panels : which two, the lower first.
    gap : of a clear motion, what no two panels come nearer than where they come near and part again, in m; None where
        none do. A gap counts that lies between two states at which the pair is further apart by two margins more:
        neighbours touch in the packed and in the flat state, so without this it would be 0. The least gap itself is
        within the resolution, and the slack, of it.
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
    resolution: float = RESOLUTION,
    slack: float | Reals = 0.0,
    apart: Collection[tuple[int, int]] = (),
    measured: bool = True,
) -> Clearance:
    """Certify a motion of the fold angles of a linkage.

    margin : by which panels are shrunk on every face, m. resolution : to which the smallest gap is known, m.
    slack : what panels may be elsewhere than the tree of hinges places them, m, at all times or in each step, (k - 1,).
    apart : pairs of panels, the lower number first, that are left out. measured : whether the smallest gap of a clear
    motion is wanted.
    """
    certificate = _Certificate(linkage, margin, resolution, apart)
    if not len(certificate.pairs.prisms) or len(course.times) < 2:
        return Clearance("clear", margin, None, None, None, 0)
    return certificate.of(course, slack, measured)


class _Certificate:
    """The search of one motion for collisions."""

    def __init__(self, linkage: Linkage, margin: float, resolution: float, apart: Collection[tuple[int, int]]) -> None:
        self.linkage, self.margin, self.resolution = linkage, margin, resolution
        self.deepest = check_margin(linkage, margin)
        self.prisms, self.shrunk = prisms_of(linkage), prisms_of(linkage, margin)
        self.pairs = pairs_of(linkage, self.prisms, apart)

    def of(self, course: Course, slack: float | Reals, measured: bool) -> Clearance:
        """As `certify`."""
        if np.ndim(slack) == 0:
            return self._judged(course, float(slack), measured)
        own, looks, undecided = np.asarray(slack), 0, None
        changes = np.flatnonzero(np.diff(own)) + 1
        for first, last in pairwise([0, *changes.tolist(), len(own)]):
            times, angles, rates, accelerations = (part[first : last + 1] for part in course[:4])
            piece = Course(times, angles, rates, accelerations, course.cubic)
            found = self._judged(piece, float(own[first]), False)
            looks += found.looks
            if found.kind == "collides":
                return replace(found, looks=looks)
            undecided = undecided or (found if found.kind == "undecided" else None)
        if undecided is not None:
            return replace(undecided, looks=looks)
        gap = math.inf
        if measured:  # where pairs come back to shows in the whole motion only
            chain, threshold = self.linkage.chain, 2.0 * float(self.margin)
            gap, more = smallest_dip(chain, self.prisms, self.pairs, course, threshold, self.resolution)
            gap, looks = max(gap - float(own.max()), 0.0), looks + more
        return Clearance("clear", self.margin, None, None, gap if math.isfinite(gap) else None, looks)

    def _judged(self, course: Course, slack: float, measured: bool) -> Clearance:
        answer = Answer(np.zeros(1), np.zeros(1, np.int64), np.zeros(1), np.zeros(1, np.int64))
        wanted = Search(slack, float(self.margin), self.deepest, self.resolution)
        verdict = judge(self.linkage.chain, self.prisms, self.shrunk, self.pairs, course, wanted, measured, answer)
        looks, gap = int(answer.looks[0]), float(answer.gaps[0])
        if verdict == CLEAR:
            return Clearance("clear", self.margin, None, None, gap if math.isfinite(gap) else None, looks)
        one, two = sorted(self.linkage.pattern.panel_of[facet] for facet in self.pairs.prisms[answer.pairs[0]])
        kind: Literal["collides", "undecided"] = "collides" if verdict == COLLIDES else "undecided"
        return Clearance(kind, self.margin, float(answer.times[0]), (one, two), None, looks)


def pairs_of(linkage: Linkage, prisms: Prisms, apart: Collection[tuple[int, int]] = ()) -> Pairs:
    """The pairs of facets of different panels but those left out, and the hinges between their panels.

    prisms : of all facets, not shrunk.
    """
    panels = np.array(linkage.pattern.panel_of)
    first, second = np.triu_indices(len(panels), 1)
    low, high = np.minimum(panels[first], panels[second]), np.maximum(panels[first], panels[second])
    n = linkage.n_panels
    wanted = (low != high) & ~np.isin(low * n + high, [one * n + two for one, two in apart])
    return pairs_between(linkage.chain, prisms, np.column_stack([first[wanted], second[wanted]]))


def kept_apart(linkage: Linkage) -> frozenset[tuple[int, int]]:
    """Pairs of panels, the lower first, that cannot overlap while a hinge between them is within its stops.

    Each lies on one side of the hinge's line in the flat pattern, so that both lie in quarters about that line, which
    only touch at fold angles from 0 to pi (docs/collision.md). Panels that reach across the line are not among them.
    """
    pattern, found = linkage.pattern, set()
    same = SAME * pattern.size

    def beside(panel: int, hinge: Hinge) -> Reals:
        """How far to the left of a hinge's line the corners of a panel are."""
        start = np.array(hinge.start)
        along = (np.array(hinge.end) - start) / math.dist(hinge.start, hinge.end)
        corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]]) - start
        left: Reals = along[0] * corners[:, 1] - along[1] * corners[:, 0]
        return left

    for hinge in pattern.hinges:
        if beside(hinge.first, hinge).min() >= -same and beside(hinge.second, hinge).max() <= same:
            found.add((min(hinge.first, hinge.second), max(hinge.first, hinge.second)))
    return frozenset(found)


def slack_of(linkage: Linkage, gap: float) -> float:
    """What panels may be elsewhere (m) where loops are open by a gap (rad, or over the pattern's size).

    A panel that is reached the other way around a loop is turned by up to sqrt(3) gaps about a point of the loop, from
    which no panel is further than the longest way, and moved by as much times the size. The rest of the factor is for
    what lies between the places at which gaps are looked for.
    """
    if not linkage.loops:
        return 0.0
    return 2.0 * len(linkage.loops) * (longest_way(linkage) + linkage.pattern.size) * gap


def longest_way(linkage: Linkage) -> float:
    """What no two corners are further apart, however the hinges are folded (m).

    The greatest length of the shortest ways from corner to corner that are straight in each panel and go over from one
    to the next at an end of their hinge: panels are rigid, so such a way keeps its length.
    """
    pattern = linkage.pattern
    ends, panels = [], []
    for own, point in zip(pattern.hinges, linkage.points, strict=True):
        ends += [(*own.start, point[2]), (*own.end, point[2])]
        panels += 2 * [(own.first, own.second)]
    points, sides = np.array(ends), np.array(panels)
    shared = (sides[:, None, :, None] == sides[None, :, None, :]).any(axis=(2, 3))
    ways = np.where(shared, np.linalg.norm(points[:, None] - points, axis=2), np.inf)
    for k in range(len(points)):  # Floyd and Warshall's shortest paths
        ways = np.minimum(ways, ways[:, k, None] + ways[k])
    corners, owners = [], []
    for panel, facets in enumerate(pattern.panels):
        for x, y in (corner for facet in facets for corner in pattern.facets[facet]):
            corners += [(x, y, 0.0), (x, y, pattern.thickness)]
            owners += 2 * [panel]
    own_ends = (sides[None] == np.array(owners)[:, None, None]).any(axis=2)
    first = np.where(own_ends, np.linalg.norm(np.array(corners)[:, None] - points, axis=2), np.inf)
    return float(_by_way_of(_by_way_of(first, ways), first.T).max())


def reaches(linkage: Linkage) -> Reals:
    """How far corners of the two panels of each hinge are from its line at most (m), (n_hinges,)."""
    pattern, found = linkage.pattern, np.zeros(linkage.n_hinges)
    for k, hinge in enumerate(pattern.hinges):
        for panel in (hinge.first, hinge.second):
            corners = np.array([corner for facet in pattern.panels[panel] for corner in pattern.facets[facet]])
            ways = corners - linkage.points[k, :2]
            across = linkage.directions[k, 0] * ways[:, 1] - linkage.directions[k, 1] * ways[:, 0]
            found[k] = max(found[k], math.hypot(float(np.abs(across).max()), pattern.thickness))
    return found


def _by_way_of(before: Reals, after: Reals) -> Reals:
    """Shortest ways in two parts, shape (i, j), from those to places, (i, k), and those from the places, (k, j)."""
    shortest = np.full((len(before), after.shape[1]), np.inf)
    for k in range(len(after)):
        np.minimum(shortest, before[:, k, None] + after[k], out=shortest)
    return shortest


def check_margin(linkage: Linkage, margin: float) -> float:
    """Refuse a margin that leaves nothing of a panel, or none between panels that touch; the least that is too much."""
    most = deepest_margin(linkage)
    if not 0.0 < margin < most:
        raise HcsearchError(
            f"a margin of {1e3 * margin:g} mm is none or leaves nothing of a panel: "
            f"give more than 0 and less than {1e3 * most:.4g} mm as margin_mm of a scene file, or thicker panels"
        )
    return most
