"""Proofs that a box of fold angles holds no closed state, by branch and bound; closed states by Newton's method.

With panels that do not pass through each other: none at which they are clear.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.contraction import Contraction, contract, new_contraction
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.newton import RESIDUAL, Newton, close_within, new_newton
from hcsearch.kernels.enclosure.overlaps import MET, THROUGHOUT, Overlaps, clear_at, new_overlaps, overlapping
from hcsearch.kernels.enclosure.plates import Plates, no_plates
from hcsearch.typing import Reals

EMPTY, CLOSED, OPEN = 0, 1, 2
"""A box holds no closed and clear state: proved; holds one, by Newton's method; neither is known."""
AGAIN = 64
"""After how many boxes Newton's method is tried again."""
NARROW = 1e-5
"""A box that is no wider (rad) is not split."""
SLIDING = 0.01
"""Newton's method is tried in each box that is no wider (rad), with panels: it may hold states at which these slide."""
DEPTH = 400
"""Boxes that wait, at most."""
WIDE = 0.2
"""Sides shorter than this share of the longest are not split."""


class Refutation(NamedTuple):
    """Tables: boxes that wait, (DEPTH, n) each; a state, (n,)."""

    contraction: Contraction
    overlaps: Overlaps
    newton: Newton
    lows: Reals
    highs: Reals
    state: Reals


@compiled
def refutation_with(rings: Rings, plates: Plates) -> Refutation:
    """Empty tables for panels that do not pass through each other."""
    n = rings.folds
    return Refutation(
        new_contraction(rings),
        new_overlaps(rings, plates),
        new_newton(rings),
        np.zeros((DEPTH, n)),
        np.zeros((DEPTH, n)),
        np.zeros(n),
    )


@compiled
def new_refutation(rings: Rings) -> Refutation:
    """Empty tables for panels that pass through each other."""
    return refutation_with(rings, no_plates())


@lean
def meets(rings: Rings, low: Reals, high: Reals, state: Reals, work: Refutation) -> bool:
    """Move a state to a closed one within a box, (n,) each; whether it comes to one at which panels are clear."""
    if close_within(rings, low, high, state, work.contraction.expansion, work.newton) >= 10.0 * RESIDUAL:
        return False
    return clear_at(state, work.overlaps)


@lean
def refute(rings: Rings, low: Reals, high: Reals, most: int, work: Refutation) -> tuple[int, int]:
    """EMPTY, CLOSED or OPEN for a box, (n,) each, and how many boxes it took, no more than `most`.

    A closed state that is met is `work.state`; otherwise that is not changed where Newton's method is not tried.
    """
    n, boxes, waiting = len(low), 0, 1
    blocked = len(work.overlaps.plates.pairs) > 0
    for h in range(n):
        work.lows[0, h], work.highs[0, h] = low[h], high[h]
    while waiting:
        waiting -= 1
        boxes += 1
        below, above = work.lows[waiting], work.highs[waiting]
        if not contract(rings, below, above, work.contraction):
            continue
        side, widest = _side(below, above, work.contraction.shares)
        if boxes % AGAIN == 1 or (blocked and widest < SLIDING):
            for h in range(n):
                work.state[h] = 0.5 * (below[h] + above[h])
            if meets(rings, below, above, work.state, work):
                return CLOSED, boxes
        known = overlapping(rings, below, above, work.contraction, work.overlaps)
        if known == THROUGHOUT:
            continue
        if known == MET:
            side, _ = _side(below, above, work.overlaps.kept)
        if boxes >= most or widest < NARROW or waiting + 2 > DEPTH:
            return OPEN, boxes
        middle = 0.5 * (below[side] + above[side])
        for h in range(n):
            work.lows[waiting + 1, h], work.highs[waiting + 1, h] = below[h], above[h]
        work.lows[waiting + 1, side] = middle
        work.highs[waiting, side] = middle
        waiting += 2
    return EMPTY, boxes


@lean
def _side(low: Reals, high: Reals, shares: Reals) -> tuple[int, float]:
    """The side by which a box is split: that which contributes most to what is not known; and the longest one."""
    widest = 0.0
    for h in range(len(low)):
        widest = max(widest, high[h] - low[h])
    side, greatest = 0, -1.0
    for h in range(len(low)):
        if high[h] - low[h] >= WIDE * widest and shares[h] > greatest:
            side, greatest = h, shares[h]
    return side, widest
