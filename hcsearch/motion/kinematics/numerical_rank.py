"""Rank of a closure Jacobian, decided by a gap in its singular values; the rank at a generic closed state."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, close_linkage
from hcsearch.shape.linkage import Linkage

DECIDED_RANK_GAP = 1e3
"""A rank is decided when no singular value lies within this factor above the noise."""

MAX_NOISE_SHARE = 1e-7
"""No rank is decided where more than this share of the greatest singular value is noise."""


@dataclass(frozen=True, eq=False)
class Rank(ByValue):
    """Rank of a closure Jacobian in the screw form, lengths divided by the pattern's size.

    singular_values : all of them, the greatest first.
    noise : bound of a singular value that is zero but for rounding and the closure residual.
    rank : number of singular values above the noise; None (undecided) where one lies within `DECIDED_RANK_GAP` of it.
    gap : least singular value that counts, over the greater of the noise and the next one.
    """

    singular_values: Reals
    n_columns: int
    noise: float
    rank: int | None
    gap: float

    @property
    def nullity(self) -> int | None:
        """Degrees of freedom at first order: number of hinges less the rank."""
        return None if self.rank is None else self.n_columns - self.rank


def decide_rank(singular_values: Reals, n_columns: int, residual: float = 0.0) -> Rank:
    """Decide the rank of a matrix from its singular values and the relative error of its entries."""
    largest = float(singular_values[0]) if len(singular_values) else 0.0
    shape = max(n_columns, len(singular_values))
    noise = (8 * shape * np.finfo(float).eps + 10 * residual) * max(largest, 1.0)
    if noise > MAX_NOISE_SHARE * max(largest, 1.0):  # not a closed state: small values say nothing
        return Rank(singular_values, n_columns, noise, None, 0.0)
    above = int(np.count_nonzero(singular_values > noise))
    if above == 0:
        return Rank(singular_values, n_columns, noise, 0, np.inf)
    below = float(singular_values[above]) if above < len(singular_values) else 0.0
    gap = float(singular_values[above - 1]) / max(noise, below)
    return Rank(singular_values, n_columns, noise, above if gap >= DECIDED_RANK_GAP else None, gap)


NEAR_ZERO_SHARE = 1e-6
"""Singular values below this share of the greatest are zeros of a singular state near by, where a gap separates them
from the others: such a state is located to some 1e-7 rad."""


def kept_beside_singular(rank: Rank) -> int | None:
    """Return the number of singular values that are not zero at a state, or at a singular state near by.

    It is the rank, None where undecided, unless all values below a gap of `DECIDED_RANK_GAP` are near zero.
    """
    values = rank.singular_values
    kept = int(np.count_nonzero(values > max(rank.noise, NEAR_ZERO_SHARE * values.max(initial=0.0))))
    others = float(values[kept]) if kept < len(values) else 0.0
    return kept if kept and values[kept - 1] >= DECIDED_RANK_GAP * max(rank.noise, others) else rank.rank


def rank_at(linkage: Linkage, angles: Reals) -> Rank:
    """Rank of the closure Jacobian at a closed state; an open chain has rank 0."""
    residual, jacobian = linkage.closure(angles)
    if not len(residual):
        return decide_rank(np.zeros(0), linkage.n_hinges)
    values = np.asarray(np.linalg.svd(jacobian, compute_uv=False), float)
    return decide_rank(values, linkage.n_hinges, float(np.abs(residual).max()))


GENERIC_STEP_COUNT = 6
MAX_GENERIC_ATTEMPTS = 3


def leaving_step(start: Reals, attempt: int) -> Reals:
    """The change of the fold angles in each of `GENERIC_STEP_COUNT` steps from a state away from the stops.

    Changes are spread evenly over 0.075 to 0.225 rad, and differ between hinges and between attempts. All steps
    together take a hinge between its stops three quarters of its way to flat at most.
    """
    share = (0.5 + np.arange(len(start)) * 0.6180339887498949 + attempt * 0.7548776662466927) % 1.0
    sizes = np.where(start > 0.0, np.minimum(0.15, 0.5 * start / GENERIC_STEP_COUNT), 0.15)
    steps: Reals = np.where(start > 0.0, -sizes, sizes) * (0.5 + share)
    return steps


def generic_rank(linkage: Linkage, start: Reals | None = None) -> Rank:
    """The greatest rank at closed states near a state, with two-sided hinges; start : the folded state unless given.

    A linkage may leave its folded state in several ways, some with more freedom (all of its parallel hinges first, say)
    than others; the rank belongs to the way with the least freedom. Undecided where no attempt leaves the state.
    """
    start = linkage.folded if start is None else start
    best = replace(rank_at(linkage, start), rank=None, gap=0.0)
    for attempt in range(MAX_GENERIC_ATTEMPTS):
        angles = start
        for _ in range(GENERIC_STEP_COUNT):
            angles = close_linkage(linkage, angles + leaving_step(start, attempt), max_steps=3).angles
        state = close_linkage(linkage, angles)
        angles = state.angles
        if state.residual > CLOSED_LOOP_RESIDUAL or np.abs(angles - start).max(initial=0.0) < 1e-3:
            continue
        rank = rank_at(linkage, angles)
        if rank.rank is not None and (best.rank is None or rank.rank > best.rank):
            best = rank
            if best.rank == len(best.singular_values):  # no rank is greater
                break
    return best
