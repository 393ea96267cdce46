"""The rank of a linkage at a generic closed state of its motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.motion.kinematics.numerical_rank import Rank, rank_at
from hcsearch.shape.linkage import Linkage

GENERIC_STEP_COUNT = 6
MAX_GENERIC_ATTEMPTS = 3


def leaving_step(folded: Reals, attempt: int) -> Reals:
    """Changes of the fold angles in each of `GENERIC_STEP_COUNT` steps away from the folded state, against the stops.

    No two hinges of a linkage open equally, and no two attempts are alike: 0.075 to 0.225 rad, equally spread.
    """
    share = (0.5 + np.arange(len(folded)) * 0.6180339887498949 + attempt * 0.7548776662466927) % 1.0
    steps: Reals = np.where(folded > 0.0, -0.15, 0.15) * (0.5 + share)
    return steps


def generic_rank(linkage: Linkage) -> Rank:
    """The greatest rank at closed states on the way from the folded state, with hinges two-sided.

    A linkage may leave its folded state in several ways, with more freedom in some (all of its parallel hinges first,
    say) than in others; the rank is that of the way with the least. Undecided where no attempt gets away.
    """
    best = replace(rank_at(linkage, linkage.folded), rank=None, gap=0.0)
    for attempt in range(MAX_GENERIC_ATTEMPTS):
        angles = linkage.folded
        for _ in range(GENERIC_STEP_COUNT):
            angles = close_linkage(linkage, angles + leaving_step(linkage.folded, attempt), max_steps=3).angles
        state = close_linkage(linkage, angles)
        angles = state.angles
        if state.residual > CLOSED_LOOP_RESIDUAL or np.abs(angles - linkage.folded).max(initial=0.0) < 1e-3:
            continue
        rank = rank_at(linkage, angles)
        if rank.rank is not None and (best.rank is None or rank.rank > best.rank):
            best = rank
            if best.rank == len(best.singular_values):  # no rank is greater
                break
    return best
