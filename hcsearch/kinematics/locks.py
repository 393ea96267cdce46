"""Proofs that one-sided hinges lock a linkage in its folded or its flat state.

At an end of the motion every hinge is at a stop and can turn one way only. Let x >= 0 be how far each has turned. The
loops ask A x + bend(x) / 2 + ... = 0, where A holds the screws of the hinges in the sense in which they can turn.

First order: a wrench y with y . A_i > 0 for every hinge i holds them all shut, and no x >= 0 but 0 is possible
(Gordan's theorem). Second order: where some x in the cone K = {x >= 0, A x = 0} are possible to first order, a
wrench with y . A_i >= 0 and y . bend(x) > 0 on all of K but 0 excludes them: along a motion the loops would ask
y . A x + y . bend(x) / 2 = 0 up to third order, a sum of which no term is negative and one is not zero.
Locked means that the state is isolated: panels, hinges and stops are exact. Others may lie near it, behind a gap of
micrometres. Nothing here says that a linkage moves: that is for a path to show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.cones import MOST_RAYS, cone_rays, nonnegative
from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

MARGIN = 1e-7
"""A proof counts when its inequalities hold by this much, with screws and wrench of unit length; rounding is 1e-13."""

MOST_PRODUCTS = 60
"""Rays up to which a second-order proof is looked for: it has an inequality for every two of them."""


@dataclass(frozen=True)
class Lock:
    """What is known about leaving one state.

    order : 1 or 2 where it is proved locked, by first or by second order; None where it is not proved.
    tried : whether a proof by second order was looked for; there may be too many motions at first order to try.
    wrench : of a proof, shape (n_rows,), of greatest entry 1; margin : the least of what it proves positive.
    motion : turns of the hinges to first order that stops and loops allow, summing to 1; None where there are none.
    stuck : hinges that no motion turns at first order.
    """

    order: Literal[1, 2] | None
    tried: bool
    wrench: Reals | None
    margin: float
    motion: Reals | None
    stuck: tuple[int, ...]

    @property
    def locked(self) -> bool:
        """Whether no motion leaves the state: proved."""
        return self.order is not None

    @property
    def reason(self) -> str:
        """The verdict in a sentence."""
        if self.order == 1:
            return "a wrench in the loops loads every hinge onto its stop, so none can open"
        if self.order == 2:
            return "what the hinges can do at first order drives the loops apart at second order"
        if self.tried:
            return "the stops allow a motion at first order, and no wrench was found that excludes it at second order"
        return "the stops allow many motions at first order, too many to look for what excludes them at second order"


def lock_at(linkage: Linkage, angles: Reals) -> Lock:
    """Look for a proof that one-sided hinges cannot leave a closed state where each is at a stop, 0 or pi.

    Source: thesis 2.3.3 speaks of first-order and finite motions of two-sided hinges only; the one-sided conditions
    are ours (docs/theory.md).
    """
    _, jacobian = linkage.closure(angles)
    senses = np.where(angles > 0.5 * np.pi, -1.0, 1.0)
    columns = np.ascontiguousarray((jacobian * senses).T)

    def bend(x: Reals) -> Reals:
        return linkage.bend(jacobian, senses * x)

    lengths = np.sqrt((columns**2).sum(axis=1))
    if not len(columns) or not columns.shape[1] or lengths.min() == 0.0:  # a hinge in no loop is free
        free = lengths == 0.0 if columns.shape[1] else np.ones(len(columns), bool)
        motion = free / max(free.sum(), 1)
        return Lock(None, True, None, 0.0, motion, ())
    unit = columns / lengths[:, None]
    motion, wrench, margin = _first_order(unit)
    if margin > MARGIN:
        return Lock(1, True, wrench, margin, None, tuple(range(len(unit))))
    rays = np.empty((MOST_RAYS, len(unit)))
    count = cone_rays(unit, rays)
    if not 0 < count <= MOST_PRODUCTS:
        motion /= lengths
        return Lock(None, False, None, 0.0, motion / motion.sum(), ())
    found = rays[:count] / lengths
    found /= found.sum(axis=1)[:, None]
    proof = second_order(columns, found, _products(found, bend))
    stuck = tuple(int(k) for k in np.flatnonzero(found.max(axis=0) <= 1e-9))
    motion = found.mean(axis=0)
    if proof is None:
        return Lock(None, True, None, 0.0, motion, stuck)
    return Lock(2, True, proof[0], proof[1], motion, stuck)


def _first_order(columns: Reals) -> tuple[Reals, Reals, float]:
    """The x >= 0 of sum 1 with A x nearest to 0, the wrench of greatest entry 1 that parts them, and its least power.

    Where the power is positive the wrench holds every hinge shut; else A x is 0 but for rounding.
    """
    n, height = columns.shape
    x, left = np.empty(n), np.empty(height + 1)
    nonnegative(np.c_[columns, np.ones(n)], np.r_[np.zeros(height), 1.0], x, left)
    wrench = -left[:height] / max(np.abs(left[:height]).max(), np.finfo(float).tiny)
    return x, wrench, float((columns @ wrench).min())


def _products(rays: Reals, bend: Callable[[Reals], Reals]) -> Reals:
    """Bilinear form of `bend` for all pairs of rays, shape (n_rays, n_rays, n_rows)."""
    own = np.array([bend(ray) for ray in rays])
    found = np.empty((len(rays), len(rays), own.shape[1]))
    for i, j in combinations_with_replacement(range(len(rays)), 2):
        found[i, j] = found[j, i] = own[i] if i == j else 0.5 * (bend(rays[i] + rays[j]) - own[i] - own[j])
    return found


def second_order(columns: Reals, rays: Reals, products: Reals) -> tuple[Reals, float] | None:
    """A wrench y, of greatest entry 1, that excludes motions at second order, and its margin; None if none is found.

    columns : shape (n, n_rows), screws in the sense in which hinges turn. rays : of the cone K. products : of `bend`.
    On hinges that can turn at first order y has no power; it is asked to hold the others shut, that y . bend of every
    ray is positive, and y . bend of every two rays not negative, which suffices for all their sums.
    """
    from scipy.linalg import null_space  # noqa: PLC0415 - takes longer to load than most runs of the stage
    from scipy.optimize import linprog  # noqa: PLC0415

    turning = rays.max(axis=0) > 1e-9
    basis = null_space(columns[turning])  # shape (n_rows, freedom of y)
    if not basis.shape[1]:
        return None
    own = products.diagonal(axis1=0, axis2=1).T
    first, second = np.triu_indices(len(rays), 1)
    positive, nonnegative_ = np.r_[columns[~turning], own] @ basis, products[first, second] @ basis
    upper = np.c_[np.r_[-positive, -nonnegative_], np.r_[np.ones(len(positive)), np.zeros(len(nonnegative_))]]
    bounds = [(-1.0, 1.0)] * basis.shape[1] + [(None, 1.0)]
    objective = np.r_[np.zeros(basis.shape[1]), -1.0]
    result = linprog(objective, A_ub=upper, b_ub=np.zeros(len(upper)), bounds=bounds, method="highs")
    if result.status != 0:
        return None
    wrench = basis @ result.x[:-1]
    largest = np.abs(wrench).max()
    if largest == 0.0:
        return None
    wrench /= largest
    margin = float((np.r_[columns[~turning], own] @ wrench).min())
    crossing = float((products[first, second] @ wrench).min(initial=0.0))
    # the solver may leave products of two rays a little below zero: those of the rays alone outweigh them
    return (wrench, margin) if margin > MARGIN and margin > -2 * len(rays) * crossing else None
