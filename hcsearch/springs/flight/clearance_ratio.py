"""Certified gaps of a motion over the stack of tolerances by which panels may come nearer.

Panels are smaller by a margin on every face, which is the play to be built in: panels that would touch are two margins
apart. Pairs that are joined, or that lie face to face in the packed stack, touch on purpose and are exempt; all others
count at all times. Proofs: docs/explanation/flight.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.collision.least_gaps import least_pair_gap
from hcsearch.kernels.linkage.prisms import pairs_between
from hcsearch.motion.collision.distances import panel_pairs
from hcsearch.motion.collision.panel_prisms import TOUCHING_DISTANCE, check_margin, facet_pairs, prisms_of, scale_of
from hcsearch.motion.locks.end_locks import layer_contacts
from hcsearch.shape.linkage import HingeTree, Linkage, hinge_tree
from hcsearch.springs.flight.build_errors import BuildTolerances


@dataclass(frozen=True)
class ClearanceRatio:
    """The least gap of a motion over the stack of tolerances, and the group of pairs where it is least.

    ratio : never above the true one. gap : m, certified at all times, of the compared pairs with `hinges` hinges in a
    row between them; 0 where panels may touch. stack : m, how much nearer such a pair may come as built.
    """

    ratio: float
    gap: float
    stack: float
    hinges: int


def clearance_ratio(
    linkage: Linkage, motion: Course, slack: float, tolerances: BuildTolerances, margin: float
) -> ClearanceRatio | None:
    """Return the least gap of a motion over the stack of tolerances; None without a tolerance, or a pair that counts.

    slack : m, by which panels may be off their places on the motion, as in `PathProof`. margin : m, by which panels are
    smaller on every face; HcsearchError where it leaves nothing of a panel.
    """
    check_margin(linkage, margin)
    prisms, resolution = prisms_of(linkage, margin), TOUCHING_DISTANCE * scale_of(linkage)
    pairs = _compared_pairs(linkage)
    stacks, hinges = tolerance_stacks(linkage, tolerances, pairs)
    facets = facet_pairs(linkage)
    panels = np.sort(np.array(linkage.pattern.panel_of)[facets], axis=1) @ [linkage.n_panels, 1]
    best = None
    for count in np.unique(hinges).tolist():
        members = hinges == count
        stack = float(stacks[members].max())
        chosen = facets[np.isin(panels, pairs[members] @ [linkage.n_panels, 1])]
        solids = pairs_between(linkage.chain, prisms, chosen)
        least = float(least_pair_gap(linkage.chain, prisms, solids, motion, resolution))
        gap = max(least - resolution - slack, 0.0)
        if stack > 0.0 and (best is None or gap / stack < best.ratio):
            best = ClearanceRatio(gap / stack, gap, stack, count)
    return best


def tolerance_stacks(linkage: Linkage, tolerances: BuildTolerances, pairs: WholeNumbers) -> tuple[Reals, WholeNumbers]:
    """Return by how much the panels of each pair may come nearer as built (m), and the hinges in a row between them.

    It holds in every state whose hinges are within `BuildTolerances.angles` of a state of the motion. pairs : (k, 2).
    Errors add up along the shortest row of hinges, each with the longest lever arm to a point of the second panel,
    however the hinges between are folded.
    """
    arms = _Arms(linkage, tolerances)
    trees = [hinge_tree(linkage.pattern, panel) for panel in range(linkage.n_panels)]
    ways = [(arms.stack(trees[one], two), arms.stack(trees[two], one)) for one, two in pairs.tolist()]
    counts = [len(trees[one].way(two)) for one, two in pairs.tolist()]
    return np.array([min(both) for both in ways]), np.array(counts, np.int64)


class _Arms:
    """Lever arms of the errors of hinges."""

    def __init__(self, linkage: Linkage, tolerances: BuildTolerances) -> None:
        pattern, points = linkage.pattern, linkage.points
        self.angles, self.offset = tolerances.angles, math.sqrt(2.0) * tolerances.offset
        self.thickness = tolerances.thickness
        lengths = np.array([math.dist(hinge.start, hinge.end) for hinge in pattern.hinges])
        self.turns = np.arcsin(np.minimum(2.0 * self.offset / lengths, 1.0))
        # from the middle of each hinge, and from its axis, to the middles of all others and to the corners of panels
        self.between, self.across = _distances(linkage, points)
        faces = (0.0, pattern.thickness)
        corners = [
            np.array([(*corner, z) for facet in facets for corner in pattern.facets[facet] for z in faces])
            for facets in pattern.panels
        ]
        most = [[part.max(axis=1) for part in _distances(linkage, of_panel)] for of_panel in corners]
        self.reaches, self.arms = (np.stack(parts, axis=1) for parts in zip(*most, strict=True))

    def stack(self, tree: HingeTree, panel: int) -> float:
        """Return the greatest shift of a point of a panel, seen from the root of a tree, by all errors between (m)."""
        total, reach, before = self.thickness, 0.0, -1
        for hinge, _ in reversed(tree.way(panel)):
            if before < 0:
                reach, arm = self.reaches[hinge, panel], self.arms[hinge, panel]
            else:  # by way of the middle of the hinge before, which is fixed in the panel between both
                reach, arm = self.between[hinge, before] + reach, self.across[hinge, before] + reach
            # the axis may be off on either panel; a turn about it has an arm that is shorter than the reach
            total += self.angles[hinge] * arm + 2.0 * (self.offset + self.turns[hinge] * reach) + self.thickness
            before = hinge
        return float(total)


def _distances(linkage: Linkage, points: Reals) -> tuple[Reals, Reals]:
    """Return the distances of points, when flat, from the middle of each hinge and from its axis, (n_hinges, k)."""
    apart = points - linkage.points[:, None]
    along = np.einsum("hki,hi->hk", apart, linkage.directions)
    return np.linalg.norm(apart, axis=2), np.linalg.norm(apart - along[..., None] * linkage.directions[:, None], axis=2)


def _compared_pairs(linkage: Linkage) -> WholeNumbers:
    """Return the pairs of panels that are neither joined nor face to face in the packed state, (k, 2)."""
    panel = linkage.pattern.panel_of
    stacked = [(panel[contact.below], panel[contact.above]) for contact in layer_contacts(linkage)]
    return panel_pairs(linkage, [(min(pair), max(pair)) for pair in stacked])
