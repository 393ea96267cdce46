"""Boxes of fold angles: faces, differences, and boxes around one part of the closed states.

A box is its lowest and its highest angles, (n,) each; a face is one that has no width along a hinge.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals

Box = tuple[Reals, Reals]

MAX_BOX_ANGLE = float(np.nextafter(math.pi, 4.0))
"""The double above pi, at which boxes end that hold states with closed hinges."""


def whole_box(n: int) -> Box:
    """The box of all fold angles of n hinges."""
    return np.zeros(n), np.full(n, MAX_BOX_ANGLE)


@dataclass(frozen=True, eq=False)
class BoxFace(ByValue):
    """A face, or a part of one, across a hinge. Its `low` and `high` are equal there."""

    hinge: int
    low: Reals
    high: Reals

    @property
    def level(self) -> float:
        """The angle of its hinge."""
        return float(self.low[self.hinge])

    def halves(self) -> tuple[BoxFace, BoxFace]:
        """Its halves across its longest side."""
        side = int((self.high - self.low).argmax())
        middle = 0.5 * (self.low[side] + self.high[side])
        most, least = self.high.copy(), self.low.copy()
        most[side] = least[side] = middle
        return BoxFace(self.hinge, self.low, most), BoxFace(self.hinge, least, self.high)


def boxes_outside(boxes: Sequence[Box], others: Sequence[Box]) -> list[Box]:
    """Boxes that cover what others do not cover, and share no inner points if these boxes share none."""
    left = list(boxes)
    for other in others:
        left = [part for box in left for part in _outside(box, other)]
    return left


def _outside(box: Box, other: Box) -> list[Box]:
    """What another box leaves of one: slabs, the widest first, so that few of them are long and thin."""
    (low, high), (least, most) = box, other
    common = np.minimum(high, most) - np.maximum(low, least)
    wide = high > low
    if not ((common > 0.0) | ((common == 0.0) & ~wide)).all():
        return [box]
    low, high, slabs = low.copy(), high.copy(), []
    shares = np.array([least - low, high - most]) / np.where(wide, high - low, 1.0)
    for number in np.argsort(-shares, axis=None, kind="stable"):
        side, hinge = np.unravel_index(number, shares.shape)
        if not (shares[side, hinge] > 0.0 and wide[hinge]):
            continue
        below, above = low.copy(), high.copy()
        if side == 0:
            above[hinge] = low[hinge] = least[hinge]
        else:
            below[hinge] = high[hinge] = most[hinge]
        slabs.append((below, above))
    return slabs


def box_faces(boxes: Sequence[Box], top: float) -> list[BoxFace]:
    """Faces between what boxes cover, which share no inner points, and what they do not, from 0 to a top."""
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
    """A box without width along a hinge."""
    low, high = low.copy(), high.copy()
    low[hinge] = high[hinge] = level
    return low, high


def excess_over_box(box: Box, states: Reals) -> Reals:
    """By how much angles of states, (m, n), are outside a box, below 0 for those inside."""
    low, high = box
    away: Reals = np.maximum(low - states, states - high)
    return away


def states_in(box: Box, states: Reals) -> Reals:
    """Which of the states, (m, n), a box holds."""
    low, high = box
    held: Reals = states[((low <= states) & (states <= high)).all(axis=1)]
    return held


LAYOUT_FACE_OFFSET = 0.1
"""How far faces are from the states of a part (rad)."""
LAYOUT_STOP_DISTANCE = 0.05
"""A part that comes so near to a stop, or to a face of the box that it lies in (rad), counts as reaching it."""
MIN_LAYOUT_SPACE = 0.05
"""Faces are not moved inward where less than this is between the states on either side of them (rad)."""
MAX_LAYOUT_DEPTH, MAX_LAYOUT_BOXES = 6, 300
"""Boxes within boxes, and boxes in all, at most."""

ReachFunction = Callable[[Reals, Box], Reals]
"""States of a part, (m, n), within a box, and those to which they lead in it."""


def region_around(own: Reals, others: Sequence[Reals], reach: ReachFunction) -> list[Box] | None:
    """Boxes without common inner points that hold states of one part, (m, n), and none of others; None without any.

    One box around the part, less one around what it holds of each other part; less one in that, around what it holds of
    the first part, and so on.
    """
    outer = _box_around(own, np.concatenate(others), whole_box(own.shape[1]))
    region = [outer]
    for other in others:
        held = states_in(outer, other)
        if len(held):
            hole = _within(held, own, outer, reach, MAX_LAYOUT_DEPTH)
            if hole is None:
                return None
            region = boxes_outside(region, hole)
            if len(region) > MAX_LAYOUT_BOXES:
                return None
    return region


def _within(states: Reals, others: Reals, box: Box, reach: ReachFunction, deepest: int) -> list[Box] | None:
    """Boxes around states in a box, less others in these; None where there would be too many."""
    states = reach(states, box)
    around = _box_around(states, others, box)
    held = states_in(around, others)
    if not len(held):
        return [around]
    inner = None if deepest == 0 else _within(held, states_in(around, states), around, reach, deepest - 1)
    if inner is None or len(inner) > MAX_LAYOUT_BOXES:
        return None
    return boxes_outside([around], inner)


def _box_around(states: Reals, others: Reals, within: Box) -> Box:
    """A box around states which holds none of the others that lie beside the least box around these."""
    least, most = states.min(axis=0), states.max(axis=0)
    low = np.where(
        least < within[0] + LAYOUT_STOP_DISTANCE, within[0], np.maximum(least - LAYOUT_FACE_OFFSET, within[0])
    )
    high = np.where(
        most > within[1] - LAYOUT_STOP_DISTANCE, within[1], np.minimum(most + LAYOUT_FACE_OFFSET, within[1])
    )
    held = states_in((low, high), others)
    held = held[excess_over_box((least, most), held).max(axis=1) > MIN_LAYOUT_SPACE]
    while len(held):
        away = excess_over_box((least, most), held)
        nearest = int(away.max(axis=1).argmin())
        hinge = int(away[nearest].argmax())
        other = held[nearest, hinge]
        if other < least[hinge]:
            low[hinge] = 0.5 * (other + least[hinge])
        else:
            high[hinge] = 0.5 * (other + most[hinge])
        held = states_in((low, high), held)
    return low, high
