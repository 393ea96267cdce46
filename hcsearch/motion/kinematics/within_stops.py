"""Closed states within the stops 0 <= rho <= pi: the nearest one, links between two, and least-energy velocities."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.kernels.linkage.cones import nonnegative_least_squares
from hcsearch.motion.kinematics.closing import CLOSED_LOOP_RESIDUAL, correction
from hcsearch.motion.kinematics.local import LocalState, local_at
from hcsearch.shape.linkage import Linkage

UNMOVED_HINGE_TURN = 1e-9
"""A hinge counts as fixed in a tangent space whose unit vectors turn it by no more than this."""
STRAIGHT_DEVIATION_SHARE, MAX_DEVIATION_SHARE = 0.1, 0.5
"""Deviations of the closed state at the middle of a step, as shares of half the step: up to the first the states are
linked; up to the second both halves are examined in turn; beyond it they are not linked."""


def close_within_stops(
    linkage: Linkage, angles: Reals, *, held: Flags | None = None, max_steps: int = 25
) -> tuple[LocalState | None, int]:
    """The closed state within the stops that is nearest to some fold angles, and the number of closure evaluations.

    Held hinges do not turn. Hinges that a correction would take beyond a stop are clamped there; None where the others
    cannot close the loops.
    """
    angles = np.clip(angles, 0.0, math.pi)
    held = np.zeros(len(angles), bool) if held is None else held.copy()
    for count in range(1, max_steps + 1):
        residual, jacobian = linkage.closure(angles)
        worst = float(np.abs(residual).max(initial=0.0))
        if worst <= CLOSED_LOOP_RESIDUAL:
            return local_at(linkage, angles, closure=(residual, jacobian)), count
        if not math.isfinite(worst) or held.all():
            return None, count
        change = np.zeros(len(angles))
        change[~held] = correction(jacobian[:, ~held], residual)
        moved = angles + change
        held |= (moved < 0.0) | (moved > math.pi)
        angles = np.clip(moved, 0.0, math.pi)
    return None, max_steps


def states_are_linked(
    linkage: Linkage, start: Reals, end: Reals, *, held: Flags | None = None, depth: int = 5
) -> tuple[bool, int]:
    """Whether closed states near the straight line connect two of them, and the number of closure evaluations.

    The closed state nearest to the midpoint must be near it. Where it deviates by more than a little, both halves are
    examined likewise.
    """
    half = 0.5 * float(np.linalg.norm(end - start))
    middle, count = close_within_stops(linkage, 0.5 * (start + end), held=held)
    if middle is None:
        return False, count
    deviation = float(np.linalg.norm(middle.angles - 0.5 * (start + end)))
    if deviation <= STRAIGHT_DEVIATION_SHARE * half:
        return True, count
    if deviation > MAX_DEVIATION_SHARE * half or not depth:
        return False, count
    for pair in ((start, middle.angles), (middle.angles, end)):
        linked, evaluations = states_are_linked(linkage, *pair, held=held, depth=depth - 1)
        count += evaluations
        if not linked:
            return False, count
    return True, count


def least_energy(basis: Reals, springs: Reals, angles: Reals, low: Reals, high: Reals) -> Reals:
    """The velocity v = basis z that minimises 1/2 sum k (rho + v)^2 subject to low <= v <= high.

    basis : orthonormal columns, shape (n_hinges, m). springs : k > 0, shape (n_hinges,). low <= 0 <= high, so that
    v = 0 is allowed; it is also the answer where rounding hides all others.
    A least distance problem, min |y| with G y >= h, solved by non-negative least squares (Lawson and Hanson 1974,
    Solving Least Squares Problems, chapter 23).
    """
    zero_velocity = np.zeros(len(angles))
    if not basis.shape[1]:
        return zero_velocity
    root = np.sqrt(springs)
    q, r = np.linalg.qr(root[:, None] * basis)
    offset = q.T @ (root * angles)  # the energy is 1/2 |y|^2 for y = r z + offset, plus a constant
    movable = np.linalg.norm(basis, axis=1) > UNMOVED_HINGE_TURN  # fixed hinges must not become constraints by rounding
    rows = np.linalg.solve(r.T, basis[movable].T).T
    shift = rows @ offset
    constraints = np.vstack([rows, -rows])
    bounds = np.concatenate([np.minimum(low[movable], 0.0) + shift, -np.maximum(high[movable], 0.0) - shift])
    columns = np.c_[constraints, bounds]
    columns /= np.linalg.norm(columns, axis=1)[:, None]
    target = np.zeros(columns.shape[1])
    target[-1] = 1.0
    weights, residual = np.empty(len(constraints)), np.empty(len(target))
    nonnegative_least_squares(columns, target, weights, residual)
    if residual[-1] < 1e-12:
        return zero_velocity
    nearest: Reals = basis @ np.linalg.solve(r, -residual[:-1] / residual[-1] - offset)
    # a hinge that reaches a bound but for rounding is at it
    nearest = np.where(nearest < low + UNMOVED_HINGE_TURN, low, nearest)
    return np.where(nearest > high - UNMOVED_HINGE_TURN, high, nearest)
