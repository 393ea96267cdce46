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

    part, other_part : (m, n), states of walks from both ends. seed : of further walks. tables : of the kernels.
    steps : total number of steps of walks, counted like boxes of the search.
    """

    def __init__(self, rings: HingeRings, part: Reals, other_part: Reals, seed: int, tables: Refutation) -> None:
        self.rings, self.seed, self.tables = rings, seed, tables
        self.states = [part, other_part]
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
        inside = states_in(box, walked)
        new_states = [walked, self.climb_within(inside, box, PART_CLIMB_STEPS)[len(inside) :]]
        for start in (state, *walked[:: len(walked) // APPROACH_START_COUNT + 1][1:]):
            number = self._reached_part(start, new_states)
            if number is not None:
                self.states[number] = np.concatenate([self.states[number], *new_states])
                return number
        self.states.append(np.concatenate(new_states))
        return len(self.states) - 1

    def _reached_part(self, state: Reals, new_states: list[Reals]) -> int | None:
        """The part that small steps from a state reach, or None; append the states on the way to `passed`."""
        order = np.argsort([_nearest(part, state)[1] for part in self.states], kind="stable")
        for number in order[:NEAREST_PART_COUNT].tolist():
            position = state
            for attempt in range(APPROACH_ROUNDS):
                goal = self.states[number][_nearest(self.states[number], position)[0]]
                states, steps = approach_goal(
                    self.rings, position, goal, MAX_APPROACH_STEPS, self.seed + attempt, self.tables
                )
                self.steps += steps
                new_states.append(states)
                position = states[-1]
                if float(((position - goal) ** 2).sum()) < ARRIVED_DISTANCE**2:
                    return int(number)
        return None


def _nearest(states: Reals, state: Reals) -> tuple[int, float]:
    """The number of the nearest neighbour of a state, (n,), among others, (m, n), and its squared distance."""
    squares = ((states - state) ** 2).sum(axis=1)
    number = int(squares.argmin())
    return number, float(squares[number])


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

    def boxes_around(self, part: Reals, others: Reals) -> list[Box] | None:
        """Boxes that hold the states of a part, (m, n), and no others, (k, n); None where `leaves_around` has none."""
        leaves = leaves_around(part, others) if self._recuts_left else divided_leaves(self._leaves, part, others)
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


def leaves_around(part: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut all angles into boxes: those inside hold the states of a part, (m, n), the rest all others, (k, n).

    None where there would be too many, or where states of both kinds nearly coincide.
    """
    bounding_box = _bounding_box(part)
    beside = [CutLeaf(box, inside=False) for box in boxes_outside([whole_box(part.shape[1])], [bounding_box])]
    return divided_leaves([CutLeaf(bounding_box, inside=True), *beside], part, others)


def divided_leaves(leaves: list[CutLeaf], part: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut the leaves that hold states of both kinds; None as for `leaves_around`."""
    divided: list[CutLeaf] = []
    for leaf in leaves:
        part_inside, others_inside = states_in(leaf.box, part), states_in(leaf.box, others)
        if len(part_inside) and len(others_inside):
            cut = _cut_apart(leaf.box, part_inside, others_inside)
            if cut is None:
                return None
            divided += cut
        else:
            divided.append(CutLeaf(leaf.box, bool(len(part_inside)) or (leaf.inside and not len(others_inside))))
        if len(divided) > MAX_CUT_BOXES:
            return None
    return divided


def _cut_apart(box: Box, part: Reals, others: Reals) -> list[CutLeaf] | None:
    """Cut a box recursively until each leaf holds states of one kind only; None as for `leaves_around`."""
    leaves: list[CutLeaf] = []
    pending = [(box, part, others)]
    while pending:
        box, part, others = pending.pop()
        if not (len(part) and len(others)):
            leaves.append(CutLeaf(box, bool(len(part))))
            continue
        cut = _best_cut(part, others)
        if cut is None or len(leaves) + len(pending) > MAX_CUT_BOXES:
            return None
        hinge, level = cut
        lower_high, upper_low = box[1].copy(), box[0].copy()
        lower_high[hinge] = upper_low[hinge] = level
        below = part[:, hinge] <= level, others[:, hinge] <= level
        pending.append(((upper_low, box[1]), part[~below[0]], others[~below[1]]))
        pending.append(((box[0], lower_high), part[below[0]], others[below[1]]))
    return leaves


def _best_cut(part: Reals, others: Reals) -> tuple[int, float] | None:
    """The hinge and the angle of the cut that leaves the least impurity of two kinds of states, (m, n); None for none.

    The measure is Gini's impurity, with the same weight for both kinds (Breiman et al., Classification and Regression
    Trees, 1984).
    """
    part, others = part[:: len(part) // MAX_CUT_SAMPLES + 1], others[:: len(others) // MAX_CUT_SAMPLES + 1]
    best, cut = np.inf, None
    for hinge in range(part.shape[1]):
        angles = np.concatenate([part[:, hinge], others[:, hinge]])
        order = np.argsort(angles, kind="stable")
        angles, part_counts = angles[order], np.cumsum(order < len(part))
        last = np.flatnonzero(np.diff(angles) > MIN_CUT_WIDTH)
        if not len(last):
            continue
        # shares of both kinds below each cut
        p, q = part_counts[last] / len(part), (last + 1 - part_counts[last]) / len(others)
        impurity = p * q / (p + q) + (1.0 - p) * (1.0 - q) / (2.0 - p - q)
        score = 2.0 * impurity - VOID_WIDTH_WEIGHT * np.minimum(angles[last + 1] - angles[last], MAX_VOID_WIDTH)
        k = int(score.argmin())
        if score[k] < best:
            best, cut = float(score[k]), (hinge, float(0.5 * (angles[last[k]] + angles[last[k] + 1])))
    return cut


def _bounding_box(states: Reals) -> Box:
    """A box around states, with faces at `CUT_FACE_OFFSET` from them, or at the stops."""
    lowest, highest = states.min(axis=0), states.max(axis=0)
    low = np.where(lowest < CUT_STOP_DISTANCE, 0.0, np.maximum(lowest - CUT_FACE_OFFSET, 0.0))
    high = np.where(
        highest > MAX_BOX_ANGLE - CUT_STOP_DISTANCE, MAX_BOX_ANGLE, np.minimum(highest + CUT_FACE_OFFSET, MAX_BOX_ANGLE)
    )
    return low, high
