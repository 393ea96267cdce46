"""Proofs that a path leaves an end of the motion, where closure is singular and every hinge is at a stop.

At an end q0 the loops close exactly, and the Jacobian J has wrenches C that no hinge works against: C^T J = 0. States
q0 + s w are closed where F(q0 + s w) = s J w + s^2 B(w, w) + ... = 0, with B half the bend of theory.md, 28. Divided by
s across the wrenches C, and by s^2 along them, these equations are regular up to s = 0 where their derivative at a
direction b with J b = 0 and C^T B(b, b) = 0 has full rank: closed states then leave the end along a curve, and a
contraction as in `kernels.planning.tubes` says where it lies (docs/motion.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.linkage import Linkage

Reals = NDArray[np.float64]

CONTRACTION = 0.5
"""Greatest factor of a contraction that is asked for."""
HALVINGS = 30
"""A step is halved no more often than this."""
ROUNDING = 1e-13
"""What rounding makes of the equations, relative to the norms of what enters them: sums of some hundred products."""
ZERO = 1e-9
"""Singular values of the Jacobian below this share of the greatest are zeros."""


@dataclass(frozen=True)
class Departure:
    """Closed states beside the first step of a path, from the end on.

    share : of the step, up to which they are proved. wanders : (n_hinges,), what their fold angles differ by from the
    path's (rad), up to there.
    """

    share: float
    wanders: Reals


@dataclass(frozen=True)
class _Step:
    """Bounds of a step, in the share s of it.

    sizes : of the coefficients of s, s^2 and s^3 of the course. gain : size of what a ball of radius 1 turns.
    total : the same, summed over hinges (rad). left : norms of the terms of F / s across the wrenches, of order 0, 1, 2,
    and of F / s^2 along them, of order 0, 1. factors : of the derivative, of order 1 across, 1 along, 2 across.
    off : what rounding leaves of the derivative less 1.
    """

    sizes: tuple[float, ...]
    gains: Reals
    gain: float
    left: tuple[float, ...]
    factors: tuple[float, ...]
    off: float


class End:
    """The closure equations at an end of the motion, about the middle of each loop and in its own unit of length."""

    def __init__(self, linkage: Linkage, angles: Reals) -> None:
        _, jacobian = linkage.closure(angles)
        m, loops = linkage.n_hinges, linkage.loops
        self.angles = angles
        self.norms = np.zeros((len(loops), m))
        self.products = np.zeros((6 * len(loops), m, m))
        for number, loop in enumerate(loops):
            rows = slice(6 * number, 6 * number + 6)
            order = [hinge for hinge, _ in loop]
            jacobian[rows], self.norms[number, order] = _about_middle(jacobian[rows], order)
            self.products[rows] = _products(jacobian[rows], order)
        self.jacobian = jacobian
        self.orders = [[hinge for hinge, _ in loop] for loop in loops]
        left, values, _ = np.linalg.svd(jacobian)
        values = np.r_[values, np.zeros(len(left) - len(values))]
        self.rank = int((values > ZERO * max(values[0], 1.0)).sum()) if len(values) else 0
        self.across, self.along = left[:, : self.rank].T, left[:, self.rank :].T

    def equations(self, direction: Reals) -> tuple[Reals, Reals]:
        """What a direction leaves open at first and second order, (n_rows,), and the derivative, (n_rows, n_hinges)."""
        first = self.jacobian @ direction
        bent = self.products @ direction
        second = bent @ direction
        return np.r_[self.across @ first, self.along @ second], np.r_[
            self.across @ self.jacobian, 2.0 * self.along @ bent
        ]

    def direction(self, guess: Reals) -> Reals | None:
        """The direction nearest to a guess, of the same length, in which the end is left at second order; None without one."""
        length = float(np.linalg.norm(guess))
        found = guess / length
        for _ in range(30):
            open_, derivative = self.equations(found)
            if np.abs(open_).max(initial=0.0) < 1e-14:
                return length * found
            found = found - np.linalg.pinv(derivative, rcond=1e-10) @ open_
            found /= np.linalg.norm(found)
        return None

    def depart(self, course: Reals) -> Departure | None:
        """Prove that closed states lie beside the first part of a step from the end, a cubic, (n_hinges, 4); or not."""
        # in the unit of the step's own slope: else the equations across and along the wrenches differ in size
        slope = float(np.abs(course[:, 1]).max())
        step = self._step(course / slope ** np.arange(4))
        proved = False
        for halving in range(HALVINGS):
            share = 0.5**halving
            radius = self._contracts(step, slope * share)
            # half of the greatest share: the ball is an eighth there, which the proof that goes on from it needs
            if radius is None or not proved:
                proved = radius is not None
            else:
                return Departure(share, slope * share * radius * step.gains)
        return None

    def _step(self, course: Reals) -> _Step:
        """What the contraction of a step needs: norms, but for what is summed with signs."""
        b, c, d = course[:, 1], course[:, 2], course[:, 3]
        across, along = self.across, self.along
        _, derivative = self.equations(b)
        inverse = np.linalg.pinv(derivative)
        gains = np.linalg.norm(inverse, axis=1)
        bent = self.products @ b
        third, turned = self._third(b, inverse)
        left = (
            across @ (self.jacobian @ b),
            across @ (self.jacobian @ c + bent @ b),
            across @ (self.jacobian @ d + 2.0 * bent @ c + third),
            along @ (bent @ b),
            along @ (2.0 * bent @ c + third),
        )
        factors = (
            2.0 * across @ bent @ inverse,
            along @ (2.0 * (self.products @ c) @ inverse + turned),
            across @ turned,
        )
        return _Step(
            sizes=(self._size(b), self._size(c), self._size(d)),
            gains=gains,
            gain=self._size(gains),
            left=tuple(float(np.linalg.norm(part)) for part in left),
            factors=tuple(float(np.linalg.norm(part)) for part in factors),
            off=float(np.linalg.norm(derivative @ inverse - np.eye(len(derivative)))),
        )

    def _third(self, direction: Reals, inverse: Reals) -> tuple[Reals, Reals]:
        """The terms of third order of F in a direction, (n_rows,), and their derivative times a matrix, (n_rows, k)."""
        columns = inverse.shape[1]
        found, turned = np.zeros(len(self.jacobian)), np.zeros((len(self.jacobian), columns))
        for number, order in enumerate(self.orders):
            product, change = np.zeros((4, 4, 4)), np.zeros((4, columns, 4, 4))
            product[0] = np.eye(4)
            for h in order:
                screw = _matrix(self.jacobian[6 * number : 6 * number + 6, h])
                x, own, powers = direction[h], inverse[h][:, None, None], [np.eye(4)]
                for _ in range(3):
                    powers.append(powers[-1] @ screw)
                terms = [power * x**k / math.factorial(k) for k, power in enumerate(powers)]
                slopes = [0.0 * screw, *(powers[k] * x ** (k - 1) / math.factorial(k - 1) for k in (1, 2, 3))]
                change = np.stack(
                    [
                        sum(change[k - j] @ terms[j] + own * (product[k - j] @ slopes[j]) for j in range(k + 1))
                        for k in range(4)
                    ]
                )
                product = np.stack([sum(product[k - j] @ terms[j] for j in range(k + 1)) for k in range(4)])
            rows = slice(6 * number, 6 * number + 6)
            found[rows] = _twist(product[3])
            turned[rows] = _twist(change[3]).T
        return found, turned

    def _size(self, change: Reals) -> float:
        """The norm of the greatest product of matrices that a change of the angles stands for."""
        return float(np.sqrt(((self.norms @ np.abs(change)) ** 2).sum()))

    def _contracts(self, step: _Step, s: float) -> float | None:
        """The radius of the ball that the map contracts at all shares up to s, None where it is not proved to."""
        pair, across, along = _pair, self.across, self.along
        b, c, d = step.sizes
        beside = s * c + s * s * d  # what the course turns off its tangent by
        most = b + beside
        # F over s: the terms of the course, and what its third order and those above do not exceed
        higher = pair(c, c) + 2.0 * pair(b, d) + 2.0 * s * pair(c, d) + s * s * pair(d, d)
        third = 0.5 * beside * (b + most) ** 2 / 2.0 + _exp_rest(s * most, 4) / s**3
        left_across = step.left[0] + s * step.left[1] + s * s * step.left[2] + s**3 * higher + s * s * third
        left_along = step.left[3] + s * step.left[4] + s * s * higher + s * third
        rounding = ROUNDING * (1.0 + step.gain) * (b + b * b + c)
        radius = (math.hypot(left_across, left_along) + rounding) / (1.0 - CONTRACTION)
        off = beside + radius * step.gain
        turned = 0.5 * off * (2.0 * b + off) * step.gain + _exp_rest(s * (b + off), 3) / s**2 * step.gain
        factor_across = s * step.factors[0] + 2.0 * s * pair(off, step.gain) + s * s * (step.factors[2] + turned)
        factor_along = s * step.factors[1] + 2.0 * pair(off - s * c, step.gain) + s * turned
        factor = math.hypot(factor_across, factor_along) + step.off + rounding
        return radius if factor <= CONTRACTION else None


def _pair(one: float, two: float) -> float:
    """What B of two changes of given sizes does not exceed."""
    return 0.5 * one * two


def _exp_rest(x: float, terms: int) -> float:
    """The exponential less its first terms, of x >= 0."""
    if x > 1.0:
        return math.exp(min(x, 700.0))
    total, term = 0.0, x**terms / math.factorial(terms)
    for k in range(terms, terms + 20):
        total += term
        term *= x / (k + 1)
    return total


def _about_middle(screws: Reals, order: list[int]) -> tuple[Reals, Reals]:
    """Screws (6, m) about the middle of their lines' feet, in the unit of their mean distance, and bounds of their norms."""
    found = screws.copy()
    turns, moments = found[:3, order], found[3:, order]
    feet = np.cross(turns.T, moments.T)
    middle = feet.mean(axis=0)
    moments = moments - np.cross(middle, turns.T).T
    unit = max(math.sqrt(float((moments**2).sum(axis=0).mean())), 1e-3)
    found[3:, order] = moments / unit
    return found, 1.5 + np.linalg.norm(found[3:, order], axis=0)


def _products(screws: Reals, order: list[int]) -> Reals:
    """B of a loop, shape (6, m, m), symmetric: the twist of the terms of second order of its product less 1."""
    m = screws.shape[1]
    found = np.zeros((6, m, m))
    own = screws[:, order]
    w, v = own[:3].T, own[3:].T
    turn = np.cross(w[:, None], w[None])
    shift = np.cross(w[:, None], v[None]) + np.cross(v[:, None], w[None])
    bracket = np.concatenate([turn, shift], axis=2)  # [S_i, S_j], antisymmetric
    later = np.triu(np.ones((len(order), len(order))), 1)[:, :, None]
    half = 0.5 * bracket * later
    half = 0.5 * (half + half.transpose(1, 0, 2))
    moved = np.cross(w[:, None], v[None])  # the product of a twist with itself also moves
    half[:, :, 3:] += 0.25 * (moved + moved.transpose(1, 0, 2))
    for i, h in enumerate(order):
        found[:, h, order] += half[i].T
    return found


def _matrix(screw: Reals) -> Reals:
    """The 4 x 4 matrix of a screw."""
    x, y, z, a, b, c = screw
    return np.array([[0.0, -z, y, a], [z, 0.0, -x, b], [-y, x, 0.0, c], [0.0, 0.0, 0.0, 0.0]])


def _twist(matrices: Reals) -> Reals:
    """The twist of 4 x 4 matrices, shape (..., 6): the skew part of their rotations, and their translations."""
    m = matrices
    skew = [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]]
    return np.stack([*(0.5 * part for part in skew), m[..., 0, 3], m[..., 1, 3], m[..., 2, 3]], axis=-1)
