"""How many boxes a search takes, estimated by some of its branches.

Source: D. E. Knuth, Math. Comp. 29 (1975) 122.
"""

from __future__ import annotations

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import (
    BOX_EMPTY,
    BOX_UNFINISHED,
    Refutation,
    split_box,
    start_refutation,
    test_box,
)


@compiled
def estimate_box_count(
    rings: HingeRings, low: Reals, high: Reals, probes: int, seed: int, work: Refutation
) -> tuple[float, int, int]:
    """How many boxes a search of a box, (n,) each, takes, about.

    Then EMPTY, or CLOSED or OPEN where a probe ends so; and how many boxes the probes took.

    Each probe follows one branch, and takes any of the two halves of a box; the k-th box after the first stands for
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
