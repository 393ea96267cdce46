"""Boxes of fold angles: faces, differences, and boxes around one part of the closed states.

Nested boxes (`region_around`) need fewer faces than cuts of all angles (`BoxCuts`), but do not exist for parts that
wind about each other.

A box is a pair of its lowest and its highest angles, (n,) each; a face has no width along one hinge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals

Box = tuple[Reals, Reals]

MAX_BOX_ANGLE = float(np.nextafter(math.pi, 4.0))
"""The next double above pi, the upper end of boxes that hold states with closed hinges."""


def whole_box(n: int) -> Box:
    """The box of all fold angles of n hinges."""
    return np.zeros(n), np.full(n, MAX_BOX_ANGLE)


@dataclass(frozen=True, eq=False)
class BoxFace(ByValue):
    """A face of a box, or a part of one, across a hinge, along which `low` and `high` are equal."""

    hinge: int
    low: Reals
    high: Reals

    @property
    def level(self) -> float:
        """The angle of the hinge on the face."""
        return float(self.low[self.hinge])

    def halves(self) -> tuple[BoxFace, BoxFace]:
        """The halves of the face, cut across its longest side."""
        side = int((self.high - self.low).argmax())
        middle = 0.5 * (self.low[side] + self.high[side])
        lower_high, upper_low = self.high.copy(), self.low.copy()
        lower_high[side] = upper_low[side] = middle
        return BoxFace(self.hinge, self.low, lower_high), BoxFace(self.hinge, upper_low, self.high)


def boxes_outside(boxes: Sequence[Box], others: Sequence[Box]) -> list[Box]:
    """Cover the difference of two unions of boxes by boxes, without common inner points if the first have none."""
    remaining = list(boxes)
    for other in others:
        remaining = [part for box in remaining for part in _outside(box, other)]
    return remaining


def _outside(box: Box, other: Box) -> list[Box]:
    """Subtract a box from one: slabs that cover the difference, the widest first, so that few are long and thin."""
    (low, high), (other_low, other_high) = box, other
    common = np.minimum(high, other_high) - np.maximum(low, other_low)
    wide = high > low
    if not ((common > 0.0) | ((common == 0.0) & ~wide)).all():
        return [box]
    low, high, slabs = low.copy(), high.copy(), []
    shares = np.array([other_low - low, high - other_high]) / np.where(wide, high - low, 1.0)
    for number in np.argsort(-shares, axis=None, kind="stable"):
        side, hinge = np.unravel_index(number, shares.shape)
        if not (shares[side, hinge] > 0.0 and wide[hinge]):
            continue
        below, above = low.copy(), high.copy()
        if side == 0:
            above[hinge] = low[hinge] = other_low[hinge]
        else:
            below[hinge] = high[hinge] = other_high[hinge]
        slabs.append((below, above))
    return slabs


def box_faces(boxes: Sequence[Box], top: float) -> list[BoxFace]:
    """The boundary faces of a union of boxes without common inner points, at angles between 0 and a top."""
    lows, highs = np.array([low for low, _ in boxes]), np.array([high for _, high in boxes])
    faces = []
    for low, high in boxes:
        for hinge in range(len(low)):
            for level, levels in ((low[hinge], highs[:, hinge]), (high[hinge], lows[:, hinge])):
                if 0.0 < level < top:
                    behind = [_across(lows[k], highs[k], hinge, level) for k in np.flatnonzero(levels == level)]
                    parts = boxes_outside([_across(low, high, hinge, level)], behind)
                    faces += [BoxFace(hinge, *part) for part in parts]
    return faces


def _across(low: Reals, high: Reals, hinge: int, level: float) -> Box:
    """The section of a box at an angle of a hinge."""
    low, high = low.copy(), high.copy()
    low[hinge] = high[hinge] = level
    return low, high


def excess_over_box(box: Box, states: Reals) -> Reals:
    """The distance of each angle of some states, (m, n), from a box, negative inside."""
    low, high = box
    excess: Reals = np.maximum(low - states, states - high)
    return excess


def states_in(box: Box, states: Reals) -> Reals:
    """The states, of shape (m, n), that lie in a box."""
    low, high = box
    inside: Reals = states[((low <= states) & (states <= high)).all(axis=1)]
    return inside


LAYOUT_FACE_OFFSET = 0.1
"""Distance of faces from the states of a part (rad)."""
LAYOUT_STOP_DISTANCE = 0.05
"""A part that is nearer than this (rad) to a stop, or to a face of the enclosing box, counts as reaching it."""
MIN_LAYOUT_SPACE = 0.05
"""Faces are not moved inward between states that are nearer than this (rad)."""
MAX_LAYOUT_DEPTH, MAX_LAYOUT_BOXES = 6, 300
"""Maximum depth of nesting, and maximum number of boxes."""

ReachFunction = Callable[[Reals, Box], Reals]
"""A function that adds to states of a part, (m, n), others in a box that can be reached from them."""


def region_around(part: Reals, other_parts: Sequence[Reals], reach: ReachFunction) -> list[Box] | None:
    """Enclose one part, (m, n), but no state of others, in boxes without common inner points; None if that fails.

    The region is one box around the part, without a box around the states of each other part in it; that box in turn
    leaves out a box around the states of the first part in it, and so on.
    """
    outer = _box_around(part, np.concatenate(other_parts), whole_box(part.shape[1]))
    region = [outer]
    for other in other_parts:
        inside = states_in(outer, other)
        if len(inside):
            hole = _nested_boxes(inside, part, outer, reach, MAX_LAYOUT_DEPTH)
            if hole is None:
                return None
            region = boxes_outside(region, hole)
            if len(region) > MAX_LAYOUT_BOXES:
                return None
    return region


def _nested_boxes(states: Reals, others: Reals, box: Box, reach: ReachFunction, max_depth: int) -> list[Box] | None:
    """Enclose states in boxes within a box, without others, by nesting; None where there would be too many boxes."""
    states = reach(states, box)
    around = _box_around(states, others, box)
    inside = states_in(around, others)
    if not len(inside):
        return [around]
    inner = None if max_depth == 0 else _nested_boxes(inside, states_in(around, states), around, reach, max_depth - 1)
    if inner is None or len(inner) > MAX_LAYOUT_BOXES:
        return None
    return boxes_outside([around], inner)


def _box_around(states: Reals, others: Reals, within: Box) -> Box:
    """A box around states, with faces moved inward to exclude others that lie outside the states' bounding box."""
    lowest, highest = states.min(axis=0), states.max(axis=0)
    low = np.where(
        lowest < within[0] + LAYOUT_STOP_DISTANCE, within[0], np.maximum(lowest - LAYOUT_FACE_OFFSET, within[0])
    )
    high = np.where(
        highest > within[1] - LAYOUT_STOP_DISTANCE, within[1], np.minimum(highest + LAYOUT_FACE_OFFSET, within[1])
    )
    intruders = states_in((low, high), others)
    intruders = intruders[excess_over_box((lowest, highest), intruders).max(axis=1) > MIN_LAYOUT_SPACE]
    while len(intruders):
        excess = excess_over_box((lowest, highest), intruders)
        nearest = int(excess.max(axis=1).argmin())
        hinge = int(excess[nearest].argmax())
        other = intruders[nearest, hinge]
        if other < lowest[hinge]:
            low[hinge] = 0.5 * (other + lowest[hinge])
        else:
            high[hinge] = 0.5 * (other + highest[hinge])
        intruders = states_in((low, high), intruders)
    return low, high


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
    """The hinge and angle of the cut that leaves the least impurity of two kinds of states, (m, n); None without one.

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
