"""Parts of the closed states, and cuts of all fold angles into boxes that separate one part from the others.

Parts are far apart, but a hundred thousand states sample a part of six degrees of freedom so sparsely that the nearest
state may be of another part. So a state belongs to a part if small steps lead from it to a state of that part.

Nested boxes (`boxes.region_around`) need fewer faces than cuts, but do not exist for parts that wind about each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import Refutation
from hcsearch.kernels.enclosure.wandering import approach_goal, climb_angles, random_walk
from hcsearch.motion.locks.boxes import MAX_BOX_ANGLE, Box, boxes_outside, states_in, whole_box

PART_WALK_STEPS, PART_CLIMB_STEPS = 2000, 200
"""Steps of the walk from a state, and of each climb from there."""
MAX_APPROACH_STEPS, APPROACH_ROUNDS = 1000, 3
"""Maximum number of steps towards the nearest state of a part, and number of times that it is chosen anew."""
NEAREST_PART_COUNT = 3
"""Number of parts that are approached: those with the nearest states."""
ARRIVED_DISTANCE = 0.05
"""A state is reached from within this distance (rad, root of the sum of squares)."""
APPROACH_START_COUNT = 3
"""Number of starts of an approach: the new state first, then states of the walk from it."""


class StateParts:
    """Parts of the closed states: the first holds the end that is to be enclosed, the second the other end.

    own, others : (m, n), states of walks from both ends. seed : of further walks. tables : of the kernels.
    steps : total number of steps of walks, counted like boxes of the search.
    """

    def __init__(self, rings: HingeRings, own: Reals, others: Reals, seed: int, tables: Refutation) -> None:
        self.rings, self.seed, self.tables = rings, seed, tables
        self.states = [own, others]
        self.steps = 0

    def climb_within(self, states: Reals, box: Box, steps: int) -> Reals:
        """Extend states by climbs from them within a box."""
        climbed: Reals = climb_angles(self.rings, states, *box, steps, self.seed, self.tables)
        self.steps += len(climbed) - len(states)
        return climbed

    def add_state(self, state: Reals, box: Box) -> int:
        """Add a closed state, (n,), and states of a walk and of climbs in a box from it; return the number of its part.

        It is a new part where no approach reaches a known one, from `APPROACH_START_COUNT` starts to
        `NEAREST_PART_COUNT` parts in `APPROACH_ROUNDS` rounds of `MAX_APPROACH_STEPS`.
        """
        walked = random_walk(self.rings, state, PART_WALK_STEPS, self.seed, self.tables)
        self.steps += PART_WALK_STEPS
        held = states_in(box, walked)
        passed = [walked, self.climb_within(held, box, PART_CLIMB_STEPS)[len(held) :]]
        for start in (state, *walked[:: len(walked) // APPROACH_START_COUNT + 1][1:]):
            number = self._leads_to(start, passed)
            if number is not None:
                self.states[number] = np.concatenate([self.states[number], *passed])
                return number
        self.states.append(np.concatenate(passed))
        return len(self.states) - 1

    def _leads_to(self, state: Reals, passed: list[Reals]) -> int | None:
        """The part that small steps from a state reach, or None; append the states on the way to `passed`."""
        order = np.argsort([_nearest(part, state)[1] for part in self.states], kind="stable")
        for number in order[:NEAREST_PART_COUNT].tolist():
            here = state
            for again in range(APPROACH_ROUNDS):
                goal = self.states[number][_nearest(self.states[number], here)[0]]
                states, steps = approach_goal(
                    self.rings, here, goal, MAX_APPROACH_STEPS, self.seed + again, self.tables
                )
                self.steps += steps
                passed.append(states)
                here = states[-1]
                if float(((here - goal) ** 2).sum()) < ARRIVED_DISTANCE**2:
                    return int(number)
        return None


def _nearest(states: Reals, state: Reals) -> tuple[int, float]:
    """The number of the nearest neighbour of a state, (n,), among others, (m, n), and its squared distance."""
    away = ((states - state) ** 2).sum(axis=1)
    number = int(away.argmin())
    return number, float(away[number])


CUT_FACE_OFFSET = 0.1
"""Distance of the outermost faces from the states of the part (rad)."""
CUT_STOP_DISTANCE = 0.05
"""A part that is nearer than this to a stop (rad) counts as reaching it."""
MAX_VOID_WIDTH, VOID_WIDTH_WEIGHT = 0.3, 0.15
"""Of cuts of equal impurity, one through a wider void is better: its score falls by `VOID_WIDTH_WEIGHT` for each radian
of the void's width, up to `MAX_VOID_WIDTH` (rad)."""
MIN_CUT_WIDTH = 1e-9
"""States are not separated along an angle in which they differ by less than this (rad)."""
MAX_CUT_SAMPLES = 100_000
"""Maximum number of states of each kind from which a cut is chosen."""
MAX_CUT_BOXES = 1000
"""Maximum number of boxes."""
MAX_RECUTS = 8
"""Number of complete recuts; after them only boxes that hold states of both kinds are cut further."""


class BoxCuts:
    """The current cuts of all angles, which are updated as states are added."""

    def __init__(self) -> None:
        self._leaves: list[CutLeaf] = []
        self._recuts_left = MAX_RECUTS

    def boxes_around(self, own: Reals, others: Reals) -> list[Box] | None:
        """Boxes that hold the states of a part, (m, n), and no others, (k, n); None where `leaves_around` has none."""
        leaves = leaves_around(own, others) if self._recuts_left else divided_leaves(self._leaves, own, others)
        self._recuts_left = max(self._recuts_left - 1, 0)
        self._leaves = leaves or []
        return None if leaves is None else [leaf.box for leaf in leaves if leaf.inside]

    def freeze(self) -> None:
        """Allow no more complete recuts, which would discard proofs of faces."""
        self._recuts_left = 0


@dataclass(frozen=True, eq=False)
class CutLeaf(ByValue):
    """A box, and whether it belongs to the region."""

    box: Box
    inside: bool


def leaves_around(own: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut all angles into boxes: those inside hold the states of a part, (m, n), the rest all others, (k, n).

    None where there would be too many, or where states of both kinds nearly coincide.
    """
    around = _around(own)
    beside = [CutLeaf(box, inside=False) for box in boxes_outside([whole_box(own.shape[1])], [around])]
    return divided_leaves([CutLeaf(around, inside=True), *beside], own, others)


def divided_leaves(leaves: list[CutLeaf], own: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut the leaves that hold states of both kinds; None as for `leaves_around`."""
    parts: list[CutLeaf] = []
    for leaf in leaves:
        mine, rest = states_in(leaf.box, own), states_in(leaf.box, others)
        if len(mine) and len(rest):
            cut = _cut_apart(leaf.box, mine, rest)
            if cut is None:
                return None
            parts += cut
        else:
            parts.append(CutLeaf(leaf.box, bool(len(mine)) or (leaf.inside and not len(rest))))
        if len(parts) > MAX_CUT_BOXES:
            return None
    return parts


def _cut_apart(box: Box, own: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut a box recursively until each leaf holds states of one kind only; None as for `leaves_around`."""
    leaves: list[CutLeaf] = []
    left = [(box, own, others)]
    while left:
        box, own, others = left.pop()
        if not (len(own) and len(others)):
            leaves.append(CutLeaf(box, bool(len(own))))
            continue
        cut = _best_cut(own, others)
        if cut is None or len(leaves) + len(left) > MAX_CUT_BOXES:
            return None
        hinge, level = cut
        most, least = box[1].copy(), box[0].copy()
        most[hinge] = least[hinge] = level
        below = own[:, hinge] <= level, others[:, hinge] <= level
        left.append(((least, box[1]), own[~below[0]], others[~below[1]]))
        left.append(((box[0], most), own[below[0]], others[below[1]]))
    return leaves


def _best_cut(own: Reals, others: Reals) -> tuple[int, float] | None:
    """The hinge and the angle of the cut that leaves the least impurity of two kinds of states, (m, n); None for none.

    The measure is Gini's impurity, with the same weight for both kinds (Breiman et al., Classification and Regression
    Trees, 1984).
    """
    own, others = own[:: len(own) // MAX_CUT_SAMPLES + 1], others[:: len(others) // MAX_CUT_SAMPLES + 1]
    best, cut = np.inf, None
    for hinge in range(own.shape[1]):
        angles = np.concatenate([own[:, hinge], others[:, hinge]])
        order = np.argsort(angles, kind="stable")
        angles, mine = angles[order], np.cumsum(order < len(own))
        last = np.flatnonzero(np.diff(angles) > MIN_CUT_WIDTH)
        if not len(last):
            continue
        ones, rest = mine[last] / len(own), (last + 1 - mine[last]) / len(others)
        mixed = ones * rest / (ones + rest) + (1.0 - ones) * (1.0 - rest) / (2.0 - ones - rest)
        score = 2.0 * mixed - VOID_WIDTH_WEIGHT * np.minimum(angles[last + 1] - angles[last], MAX_VOID_WIDTH)
        k = int(score.argmin())
        if score[k] < best:
            best, cut = float(score[k]), (hinge, float(0.5 * (angles[last[k]] + angles[last[k] + 1])))
    return cut


def _around(states: Reals) -> Box:
    """A box around states, with faces at `CUT_FACE_OFFSET` from them, or at the stops."""
    least, most = states.min(axis=0), states.max(axis=0)
    low = np.where(least < CUT_STOP_DISTANCE, 0.0, np.maximum(least - CUT_FACE_OFFSET, 0.0))
    high = np.where(
        most > MAX_BOX_ANGLE - CUT_STOP_DISTANCE, MAX_BOX_ANGLE, np.minimum(most + CUT_FACE_OFFSET, MAX_BOX_ANGLE)
    )
    return low, high
