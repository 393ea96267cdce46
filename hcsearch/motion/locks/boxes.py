"""Boxes of fold angles: faces, differences, and boxes around one part of the closed states.

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
"""From states of a part, (m, n), in a box: these states, and others in the box that can be reached from them."""


def region_around(part: Reals, other_parts: Sequence[Reals], reach: ReachFunction) -> list[Box] | None:
    """Enclose one part, (m, n), but no state of others, in boxes without common inner points; None if that fails.

    One box around the part, minus a box around the states of each other part in it, minus a box in that around the
    states of the first part in it, and so on.
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
