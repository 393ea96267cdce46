"""Boxes of fold angles: what is left of them outside others, and the faces of what several cover together.

A box is its lowest and its highest angles, (n,) each; a face is one that has no width along a hinge.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.equality import ByValue

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
