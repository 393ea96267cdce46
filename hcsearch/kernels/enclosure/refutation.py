"""Proofs that a box of fold angles holds no closed state, by branch and bound; closed states by Newton's method.

With panels that do not pass through each other: none at which they are clear.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.contraction import Contraction, contract, new_contraction
from hcsearch.kernels.enclosure.expansion import Rings, write_first_order
from hcsearch.kernels.enclosure.overlaps import MET, THROUGHOUT, Overlaps, clear_at, new_overlaps, overlapping
from hcsearch.kernels.enclosure.plates import Plates, no_plates
from hcsearch.typing import Reals

EMPTY, CLOSED, OPEN = 0, 1, 2
"""A box holds no closed and clear state: proved; holds one, by Newton's method; neither is known."""
NEWTON, AGAIN = 60, 64
"""Steps of Newton's method, and after how many boxes it is tried again."""
RESIDUAL = 1e-7
"""Root of the sum of squares of the equations at a closed state."""
NARROW = 1e-5
"""A box that is no wider (rad) is not split."""
SLIDING = 0.01
"""Newton's method is tried in each box that is no wider (rad), with panels: it may hold states at which these slide."""
DEPTH = 400
"""Boxes that wait, at most."""
WIDE = 0.2
"""Sides shorter than this share of the longest are not split."""


class Refutation(NamedTuple):
    """Tables: boxes that wait, (DEPTH, n) each; a state, its step and the equations of the step, (n,) and (n, n)."""

    contraction: Contraction
    overlaps: Overlaps
    lows: Reals
    highs: Reals
    state: Reals
    step: Reals
    right: Reals
    normal: Reals


@compiled
def refutation_with(rings: Rings, plates: Plates) -> Refutation:
    """Empty tables for panels that do not pass through each other."""
    n = rings.folds
    return Refutation(
        new_contraction(rings),
        new_overlaps(rings, plates),
        np.zeros((DEPTH, n)),
        np.zeros((DEPTH, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros((n, n)),
    )


@compiled
def new_refutation(rings: Rings) -> Refutation:
    """Empty tables for panels that pass through each other."""
    return refutation_with(rings, no_plates())


@lean
def close_within(rings: Rings, low: Reals, high: Reals, state: Reals, steps: int, work: Refutation) -> float:
    """Move a state to a closed one within a box, (n,) each; what is left of the equations there.

    Damped Gauss-Newton steps of least squares within the bounds, by descent along one angle after the other.
    """
    n, own = len(state), work.contraction.expansion
    residual = math.inf
    for step in range(steps):
        write_first_order(rings, state, own)
        total = 0.0
        for i in range(len(own.values)):
            total += own.values[i] * own.values[i]
        residual = math.sqrt(total)
        if residual < RESIDUAL or (step > 8 and residual > 0.05):
            break
        _normal_equations(1e-3 * residual + 1e-12, work)
        _descend(low, high, state, work)
        moved = 0.0
        for h in range(n):
            state[h] += work.step[h]
            moved = max(moved, abs(work.step[h]))
        if moved < 1e-10:
            break
    return residual


@lean
def meets(rings: Rings, low: Reals, high: Reals, state: Reals, work: Refutation) -> bool:
    """Move a state to a closed one within a box, (n,) each; whether it comes to one at which panels are clear."""
    if close_within(rings, low, high, state, NEWTON, work) >= 10.0 * RESIDUAL:
        return False
    return clear_at(state, work.overlaps)


@lean
def _normal_equations(damping: float, work: Refutation) -> None:
    """Write the normal equations of a step."""
    own = work.contraction.expansion
    r, n = own.slopes.shape
    for h in range(n):
        work.step[h] = work.right[h] = 0.0
        for k in range(n):
            work.normal[h, k] = 0.0
    for i in range(r):
        for h in range(n):
            slope = own.slopes[i, h]
            if slope != 0.0:
                work.right[h] += slope * own.values[i]
                for k in range(n):
                    work.normal[h, k] += slope * own.slopes[i, k]
    for h in range(n):
        work.normal[h, h] += damping


@lean
def _descend(low: Reals, high: Reals, state: Reals, work: Refutation) -> None:
    """Solve the normal equations within bounds."""
    n = len(state)
    for _ in range(40):
        greatest = 0.0
        for h in range(n):
            slope = work.right[h]
            for k in range(n):
                slope += work.normal[h, k] * work.step[k]
            to = min(max(work.step[h] - slope / work.normal[h, h], low[h] - state[h]), high[h] - state[h])
            greatest = max(greatest, abs(to - work.step[h]))
            work.step[h] = to
        if greatest < 1e-9:
            return


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
