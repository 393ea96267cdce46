"""Proofs that a box of fold angles holds no closed state, by branch and bound, and estimates of their cost.

With panels that do not pass through each other, the proof says that no closed state is clear of overlaps.

Source: D. E. Knuth, Math. Comp. 29 (1975) 122.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.contraction import (
    NEWTON_RESIDUAL,
    Contraction,
    Newton,
    close_within_box,
    contract_box,
    new_contraction,
    new_newton,
)
from hcsearch.kernels.enclosure.expansion import HingeRings, cut_loops, keep_cuts
from hcsearch.kernels.enclosure.overlaps import (
    OVERLAP_AT_MIDDLE,
    OVERLAP_THROUGHOUT,
    Overlaps,
    clear_at,
    new_overlaps,
    overlap_in_box,
)
from hcsearch.kernels.enclosure.plates import Plates, no_plates

BOX_EMPTY, BOX_CLOSED, BOX_OPEN, BOX_UNFINISHED = 0, 1, 2, 3
"""Result for a box: proved to hold no closed and clear state; holds one, by Newton's method; undecided; unfinished."""
NEWTON_BOX_INTERVAL = 64
"""Number of boxes between two tries of Newton's method."""
MIN_SPLIT_WIDTH = 1e-5
"""Width (rad) up to which a box is not split."""
SLIDING_BOX_WIDTH = 0.01
"""Width (rad) up to which, with panels, Newton's method is tried in each box: panels may slide at a state of it."""
REFUTATION_WAITING_BOXES, REFUTATION_TESTED_BOXES = 0, 1
"""Indices of the counts of a search."""
MAX_WAITING_BOXES = 400
"""Greatest number of waiting boxes."""
MIN_SPLIT_SHARE = 0.2
"""Sides shorter than this share of the longest are not split."""


class Refutation(NamedTuple):
    """Work tables of a search.

    lows, highs : (DEPTH, n), waiting boxes, and cuts : (DEPTH, n_loops, 2), the initial cuts of loops in each.
    counts : (2,), number of waiting boxes, and of boxes tested since the search began. state : (n,).
    """

    contraction: Contraction
    overlaps: Overlaps
    newton: Newton
    lows: Reals
    highs: Reals
    cuts: WholeNumbers
    counts: WholeNumbers
    state: Reals


@compiled
def refutation_with(rings: HingeRings, plates: Plates) -> Refutation:
    """Return empty tables for panels that do not pass through each other."""
    n = rings.hinge_count
    return Refutation(
        new_contraction(rings),
        new_overlaps(rings, plates),
        new_newton(rings),
        np.zeros((MAX_WAITING_BOXES, n)),
        np.zeros((MAX_WAITING_BOXES, n)),
        np.zeros((MAX_WAITING_BOXES, len(rings.starts) - 1, 2), np.int64),
        np.zeros(2, np.int64),
        np.zeros(n),
    )


@compiled
def new_refutation(rings: HingeRings) -> Refutation:
    """Return empty tables for panels that pass through each other."""
    return refutation_with(rings, no_plates())


@compiled
def reaches_closed_state(rings: HingeRings, low: Reals, high: Reals, state: Reals, work: Refutation) -> bool:
    """Move a state to a closed one within a box, (n,) each; return whether it is closed and panels are clear there."""
    if close_within_box(rings, low, high, state, work.contraction.expansion, work.newton) >= 10.0 * NEWTON_RESIDUAL:
        return False
    return clear_at(state, work.overlaps)


@compiled
def start_refutation(rings: HingeRings, low: Reals, high: Reals, work: Refutation) -> None:
    """Start the search of a box, (n,) each."""
    for h in range(len(low)):
        work.lows[0, h], work.highs[0, h] = low[h], high[h]
        work.contraction.radii[h] = 0.5 * (high[h] - low[h])
    cut_loops(rings, work.contraction.radii, 0, work.cuts[0])
    work.counts[REFUTATION_WAITING_BOXES], work.counts[REFUTATION_TESTED_BOXES] = 1, 0


@compiled
def continue_refutation(rings: HingeRings, max_boxes: int, work: Refutation) -> int:
    """Continue a search up to a total of `max_boxes` tested boxes; return EMPTY, CLOSED, OPEN or UNFINISHED."""
    counts = work.counts
    while counts[REFUTATION_WAITING_BOXES]:
        if counts[REFUTATION_TESTED_BOXES] >= max_boxes:
            return BOX_UNFINISHED
        counts[REFUTATION_WAITING_BOXES] -= 1
        verdict, side = test_box(rings, counts[REFUTATION_WAITING_BOXES], work)
        if verdict in (BOX_CLOSED, BOX_OPEN):
            return verdict
        if verdict == BOX_UNFINISHED:
            split_box(side, counts[REFUTATION_WAITING_BOXES], work)
            counts[REFUTATION_WAITING_BOXES] += 2
    return BOX_EMPTY


@compiled
def test_box(rings: HingeRings, number: int, work: Refutation) -> tuple[int, int]:
    """Contract a box of the list; return EMPTY, CLOSED, OPEN, or UNFINISHED, and the side to split."""
    low, high, cuts = work.lows[number], work.highs[number], work.contraction.expansion.cuts
    blocked = len(work.overlaps.plates.pairs) > 0
    work.counts[REFUTATION_TESTED_BOXES] += 1
    keep_cuts(work.cuts[number], cuts)
    before = _widest(low, high)
    if not contract_box(rings, low, high, work.contraction):
        return BOX_EMPTY, 0
    keep_cuts(cuts, work.cuts[number])
    side, widest = _side(low, high, work.contraction.shares)
    small = widest < MIN_SPLIT_WIDTH or (blocked and widest < SLIDING_BOX_WIDTH)
    if small or work.counts[REFUTATION_TESTED_BOXES] % NEWTON_BOX_INTERVAL == 1:
        for h in range(len(low)):
            work.state[h] = 0.5 * (low[h] + high[h])
        if reaches_closed_state(rings, low, high, work.state, work):
            return BOX_CLOSED, 0
    known = overlap_in_box(rings, low, high, work.contraction, work.overlaps)
    if known == OVERLAP_THROUGHOUT:
        return BOX_EMPTY, 0
    if known == OVERLAP_AT_MIDDLE:
        side, _ = _side(low, high, work.overlaps.kept_shares)
    # a box that was contracted to so little at once may be empty, as its next test shows
    if before < MIN_SPLIT_WIDTH or number + 2 > MAX_WAITING_BOXES:
        return BOX_OPEN, 0
    return BOX_UNFINISHED, side


@compiled
def split_box(side: int, number: int, work: Refutation) -> None:
    """Split a box of the list in the middle of a side; the upper half is put next to it."""
    below, above = work.lows[number], work.highs[number]
    middle = 0.5 * (below[side] + above[side])
    for h in range(len(below)):
        work.lows[number + 1, h], work.highs[number + 1, h] = below[h], above[h]
    keep_cuts(work.cuts[number], work.cuts[number + 1])
    work.lows[number + 1, side] = middle
    work.highs[number, side] = middle


@compiled
def _side(low: Reals, high: Reals, shares: Reals) -> tuple[int, float]:
    """The side to split, which contributes most to the unknown part, and the length of the longest side."""
    widest = _widest(low, high)
    side, greatest = 0, -1.0
    for h in range(len(low)):
        if high[h] - low[h] >= MIN_SPLIT_SHARE * widest and shares[h] > greatest:
            side, greatest = h, shares[h]
    return side, widest


@compiled
def _widest(low: Reals, high: Reals) -> float:
    """The length of the longest side of a box."""
    widest = 0.0
    for h in range(len(low)):
        widest = max(widest, high[h] - low[h])
    return widest


@compiled
def estimate_box_count(
    rings: HingeRings, low: Reals, high: Reals, probes: int, seed: int, work: Refutation
) -> tuple[float, int, int]:
    """Estimate the number of boxes that a search of a box, (n,) each, takes.

    Also returns EMPTY, or CLOSED or OPEN where a probe ends so; and how many boxes the probes took.

    Each probe follows one branch, and takes either half of a box at random; the k-th box after the first stands for
    2^k. The mean over branches is the number of boxes; few branches miss what few others take. A closed state that a
    probe meets is `work.state`.
    """
    np.random.seed(seed)
    total, tested = 0.0, 0
    for _ in range(probes):
        start_refutation(rings, low, high, work)
        stands_for, verdict = 1.0, BOX_UNFINISHED
        while verdict == BOX_UNFINISHED:
            total += stands_for
            stands_for *= 2.0
            verdict, side = test_box(rings, 0, work)
            tested += 1
            if verdict == BOX_UNFINISHED:
                split_box(side, 0, work)
                if np.random.random() < 0.5:
                    work.lows[0], work.highs[0], work.cuts[0] = work.lows[1], work.highs[1], work.cuts[1]
        if verdict != BOX_EMPTY:
            return total, verdict, tested
    return total / probes, BOX_EMPTY, tested
