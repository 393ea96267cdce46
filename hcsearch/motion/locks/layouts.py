"""Boxes around one part of the closed states that leave out others, as far as each is known by some of its states."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.motion.locks.boxes import Box, boxes_outside, excess_over_box, states_in, whole_box

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
