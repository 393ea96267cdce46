"""Proofs that a path leaves an end of the motion, where closure is singular and hinges are at their stops.

At an end q0 the loops close exactly, and the left null space of the Jacobian J holds wrenches C: C^T J = 0. States
q0 + s w are closed where F(q0 + s w) = s J w + s^2 B(w, w) + ... = 0, with B half the bend of theory.md, 28. Divided by
s across the wrenches C, and by s^2 along them, these equations are regular up to s = 0 where their derivative at a
direction b with J b = 0 and C^T B(b, b) = 0 has full rank: closed states then leave the end along a curve, and a
contraction as in `kernels.planning.tubes` bounds its position (docs/explanation/motion.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.kernels.planning.closed_states import Group
from hcsearch.kernels.planning.series import SERIES_ORDER_COUNT, centre_screws, write_series
from hcsearch.motion.locks.lattice import reduced_rows, whole_end
from hcsearch.shape.linkage import Linkage, at_stops

MAX_DEPARTURE_CONTRACTION = 0.5
"""Greatest contraction factor that is accepted."""
MAX_DEPARTURE_HALVINGS = 30
"""Greatest number of halvings of a step."""
DEPARTURE_ROUNDING = 1e-13
"""Rounding error of the equations, relative to the norms of their terms: sums of some hundred products."""
MIN_DEPARTURE_TURN_RATIO = 0.01
"""Least turn of a hinge that leaves an end, over the turn of the fastest hinge."""
DEPARTURE_RESIDUAL = 1e-14
"""Greatest residual of a direction at first and second order."""
UNTURNED_RATIO = DEPARTURE_RESIDUAL**0.5
"""A hinge at a stop stays there if its turn, over the turn of the fastest hinge, is no greater: directions with a
residual of second order are only so exact."""
ZERO_JACOBIAN_SHARE = 1e-9
"""Singular values of the Jacobian below this share of the greatest count as zeros."""
END_CLOSURE_RESIDUAL = 1e-12
"""Closure residual (rad, or gap over size) of an end that is known in floating point only."""


@dataclass(frozen=True, eq=False)
class Departure(ByValue):
    """Closed states proved beside the first part of a path's first step.

    share : the share of the step up to which they are proved. wanders : (n_hinges,), greatest deviations of their fold
    angles from the path's (rad) in that part.
    """

    share: float
    wanders: Reals


@dataclass(frozen=True, eq=False)
class _Step(ByValue):
    """Bounds of a step, as functions of its share s.

    sizes : sizes of the coefficients of s, s^2 and s^3 of the course. gains : (n_hinges,), turns (rad) in a ball of
    radius 1; gain : the size of these turns. across, along : norms of the terms of F / s across the wrenches, from
    order 0 on, and of F / s^2 along them. turned_across, turned_along : the same norms of the derivative, from order 1
    on. bent_across, bent_along : the same norms of the second derivative at the end, in the directions in which the
    ball lies. off : rounding error of the derivative less 1.
    """

    sizes: tuple[float, float, float]
    gains: Reals
    gain: float
    across: Reals
    along: Reals
    turned_across: Reals
    turned_along: Reals
    bent_across: float
    bent_along: float
    off: float


class EndClosure:
    """The closure equations at an end of the motion, about the middle of each loop and in its own unit of length.

    exact : whether whole numbers confirm that loops are closed and that the Jacobian has the rank used here (theory.md,
    25): else proofs about the end hold up to rounding. provable : whether anything can be proved: not where whole
    numbers give another rank, or the loops are open. regular : whether the equations are regular at first order.
    """

    def __init__(self, linkage: Linkage, angles: Reals, group: Group) -> None:
        residual, jacobian = linkage.closure(angles)
        self.moving = group.moving
        jacobian[:, ~self.moving] = 0.0
        m, loops = linkage.n_hinges, linkage.loops
        self.angles = angles
        self.norms = np.zeros((len(loops), m))
        self.products = np.zeros((6 * len(loops), m, m))
        self.orders: list[WholeNumbers] = []
        for number, loop in enumerate(loops):
            rows = slice(6 * number, 6 * number + 6)
            order = np.array([hinge for hinge, _ in loop if self.moving[hinge]], np.int64)
            if not len(order):
                self.orders.append(order)
                continue
            centre_screws(jacobian, 6 * number, order, np.empty(3), self.norms[number])
            self.norms[number, order] += 1.5
            self.products[rows] = _products(jacobian[rows], order)
            self.orders.append(order)
        self.jacobian = jacobian
        left, values, _ = np.linalg.svd(group.rows @ jacobian)
        rank = int((values > ZERO_JACOBIAN_SHARE * max(values[0], 1.0)).sum()) if len(values) else 0
        whole = whole_end(linkage, angles)
        columns = None if whole is None else whole.columns[self.moving]  # an open chain has no rows
        self.rank = rank
        self.exact = columns is not None and rank == (len(reduced_rows(columns)) if columns.size else 0)
        self.provable = self.exact or (
            whole is None and float(np.abs(residual).max(initial=0.0)) < END_CLOSURE_RESIDUAL
        )
        self.across, self.along = left[:, :rank].T @ group.rows, left[:, rank:].T @ group.rows
        self.regular = self.provable and rank == len(group.rows)

    def equations(self, direction: Reals) -> tuple[Reals, Reals]:
        """Return the residuals of a direction and their derivative.

        The residuals, (n_rows,), are at first and second order; the derivative is (n_rows, n_hinges).
        """
        first = self.jacobian @ direction
        bent = self.products @ direction
        second = bent @ direction
        bending = 2.0 * self.along @ bent
        bending[:, ~self.moving] = 0.0
        return np.r_[self.across @ first, self.along @ second], np.r_[self.across @ self.jacobian, bending]

    def direction(self, guess: Reals) -> Reals | None:
        """Return the direction nearest to a guess that leaves the end at second order and keeps stops, or None.

        Its greatest entry is 1. A hinge turns by `MIN_DEPARTURE_TURN_RATIO` at least, where possible, or not at all;
        one between its stops turns either way.
        """
        sense = np.where(self.angles > 1.0, -1.0, 1.0)
        for slowest_turn in (MIN_DEPARTURE_TURN_RATIO, 0.0):
            turns = self._within(sense * guess / np.abs(guess).max(), sense, slowest_turn)
            if turns is not None:
                direction: Reals = sense * turns / np.abs(turns).max()
                return direction
        return None

    def _within(self, turns: Reals, sense: Reals, slowest_turn: float) -> Reals | None:
        """Find the nearest turns off the stops, none below a bound, that close the loops at second order (Newton)."""
        least_turns = np.where(self.moving, np.where(at_stops(self.angles), slowest_turn, -math.inf), 0.0)
        turns = np.maximum(np.where(self.moving, turns, 0.0), least_turns)
        held = ~self.moving
        for _ in range(40):
            residual, derivative = self.equations(sense * turns)
            if np.abs(residual).max(initial=0.0) < DEPARTURE_RESIDUAL:
                unturned = ~held & (turns > least_turns) & (turns <= least_turns + UNTURNED_RATIO * np.abs(turns).max())
                if not unturned.any():
                    return turns
                held |= unturned
                turns = np.where(unturned, least_turns, turns)
                continue
            if held.all():
                return None
            step = np.linalg.pinv((derivative * sense)[:, ~held], rcond=1e-10) @ residual
            turns[~held] -= step
            held |= turns < least_turns
            turns = np.maximum(turns, least_turns)
            if not np.isfinite(turns).all() or np.abs(turns).max() < 0.1:
                return None
        return None

    def depart(self, course: Reals) -> Departure | None:
        """Prove that closed states lie beside the first part of a step from the end, a cubic, (n_hinges, 4).

        None where that is not proved.
        """
        if not self.provable:
            return None
        # in the unit of the step's own slope: else the equations across and along the wrenches differ in size
        slope = float(np.abs(course[:, 1]).max())
        step = self._step(course / slope ** np.arange(4))
        proved = False
        for halving in range(MAX_DEPARTURE_HALVINGS):
            share = 0.5**halving
            radius = self._contracts(step, slope * share)
            # half of the greatest share: the ball is an eighth there, which the proof that goes on from it needs
            if radius is None or not proved:
                proved = radius is not None
            else:
                return Departure(share, slope * share * radius * step.gains)
        return None

    def _step(self, course: Reals) -> _Step:
        """Compute the bounds of a step: norms, except for sums with signs."""
        across, along = self.across, self.along
        _, derivative = self.equations(course[:, 1])
        inverse: Reals = np.linalg.pinv(derivative).astype(float)
        gains = np.linalg.norm(inverse, axis=1)
        height, count = len(self.jacobian), inverse.shape[1]
        terms, slopes = np.zeros((SERIES_ORDER_COUNT, height)), np.zeros((SERIES_ORDER_COUNT, height, count))
        for number, order in enumerate(self.orders):
            rows = slice(6 * number, 6 * number + 6)
            loop_terms, loop_slopes = np.zeros((SERIES_ORDER_COUNT, 6)), np.zeros((SERIES_ORDER_COUNT, 6, count))
            write_series(self.jacobian[rows], order, course, inverse, loop_terms, loop_slopes)
            terms[:, rows], slopes[:, rows] = loop_terms, loop_slopes
        bent = 2.0 * inverse.T @ (self.products @ inverse)
        return _Step(
            sizes=(self._size(course[:, 1]), self._size(course[:, 2]), self._size(course[:, 3])),
            gains=gains,
            gain=self._size(gains),
            across=np.linalg.norm(terms[1:] @ across.T, axis=1),
            along=np.linalg.norm(terms[2:] @ along.T, axis=1),
            turned_across=np.linalg.norm(across @ slopes[1:], axis=(1, 2)),
            turned_along=np.linalg.norm(along @ slopes[2:], axis=(1, 2)),
            bent_across=_norm(np.tensordot(across, bent, 1)),
            bent_along=_norm(np.tensordot(along, bent, 1)),
            off=_norm(derivative @ inverse - np.eye(count)),
        )

    def _size(self, change: Reals) -> float:
        """The norm of the greatest product of matrices that corresponds to a change of the angles."""
        return float(np.sqrt(((self.norms @ np.abs(change)) ** 2).sum()))

    def _contracts(self, step: _Step, s: float) -> float | None:
        """Return the radius of a ball that the map contracts at all shares up to s; None where that is not proved."""
        b, c, _ = step.sizes
        rounding = DEPARTURE_ROUNDING * (1.0 + b + b * b + c)
        powers = s ** np.arange(SERIES_ORDER_COUNT)
        rest = _rest(step.sizes, s, SERIES_ORDER_COUNT)
        left_across = float(step.across @ powers[: SERIES_ORDER_COUNT - 1]) + rest / s
        left_along = float(step.along @ powers[: SERIES_ORDER_COUNT - 2]) + rest / s**2
        radius = (math.hypot(left_across, left_along) + rounding) / (1.0 - MAX_DEPARTURE_CONTRACTION)
        off = radius * step.gain  # the term of order 1 that the ball adds to the course
        rest = step.gain * rest
        # all but the second derivative at the end itself, which is known with signs
        beside = off * step.gain * math.expm1(min(s * (b + off) + s * s * c + s**3 * step.sizes[2], 700.0))
        factor_across = float(step.turned_across @ powers[1:]) + rest + s * (radius * step.bent_across + beside)
        factor_along = float(step.turned_along @ powers[1:-1]) + rest / s + radius * step.bent_along + beside
        factor = math.hypot(factor_across, factor_along) + step.off + rounding * (1.0 + step.gain)
        return radius if factor <= MAX_DEPARTURE_CONTRACTION else None


def _rest(sizes: tuple[float, float, float], s: float, order: int) -> float:
    """An upper bound of the terms of exp(s b + s^2 c + s^3 d) from an order on, for sizes b, c, d.

    All of them are positive, so that from s to r >= s they grow by (r / s)^order at least.
    """
    b, c, d = sizes
    bound = math.inf
    for share in (0.004, 0.015, 0.06, 0.25, 0.5, 1.0, 2.0):
        radius = max(s, share * order / max(b, 1e-300))
        exponent = radius * (b + radius * (c + radius * d))
        if exponent < 700.0:  # else exp overflows
            bound = min(bound, (s / radius) ** order * math.exp(exponent))
    return bound


def _norm(matrix: Reals) -> float:
    """The Frobenius norm."""
    return float(np.linalg.norm(matrix))


def _products(screws: Reals, order: WholeNumbers) -> Reals:
    """B of a loop, shape (6, m, m), symmetric: the twist of the second-order terms of its product less 1.

    `write_series` gives the same, hinge by hinge, but takes ten times as long.
    """
    m = screws.shape[1]
    products = np.zeros((6, m, m))
    turning = screws[:, order]
    w, v = turning[:3].T, turning[3:].T
    turn = np.cross(w[:, None], w[None])
    shift = np.cross(w[:, None], v[None]) + np.cross(v[:, None], w[None])
    bracket = np.concatenate([turn, shift], axis=2)  # [S_i, S_j], antisymmetric
    later = np.triu(np.ones((len(order), len(order))), 1)[:, :, None]
    half = 0.5 * bracket * later
    half = 0.5 * (half + half.transpose(1, 0, 2))
    moved = np.cross(w[:, None], v[None])  # the product of a twist with itself also moves
    half[:, :, 3:] += 0.25 * (moved + moved.transpose(1, 0, 2))
    for i, h in enumerate(order):
        products[:, h, order] += half[i].T
    return products
