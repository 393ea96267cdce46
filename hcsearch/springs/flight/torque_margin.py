"""Torque margins: by how much springs exceed the friction of hinges at closed states, by a linear program and its dual.

At a closed state with closure Jacobian A the rates at which hinges can open are the v with A v = 0 that stops allow.
With torques tau of springs and friction f >= 0 the torque margin is

    k = max tau . v / sum f_i |v_i|  =  least k for which |tau_i + (A' y)_i| <= k f_i for some wrench y in the loops,

where the second condition is left out on the side on which a hinge presses against a stop. Springs move the array, in
some direction, exactly where friction is less than k times f. Rates v bound k from below and wrenches y from above, so
that both together certify it. Proofs: docs/explanation/flight_margins.md, 1 to 3.

Torques and rates are positive where they open a hinge: laws of springs give such torques, and fold angles fall.
Requirements: ECSS-E-ST-33-01C, 4.7.5.3, whose factors belong in f and in tau.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, Signs, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.linkage.gauges import solve_failed_margins, solve_margins
from hcsearch.motion.paths.motions import STOP_TOLERANCE

CLOSED_RATE_TOLERANCE = 1e-9
"""Singular values of the closure Jacobian below this share of the greatest are zeros."""
MARGIN_ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Relative rounding error of a sum of some ten products."""


@dataclass(frozen=True, eq=False)
class TorqueMargins(ByValue):
    """Torque margins of k states; NaN where none was found, infinite where nothing resists a motion.

    margins : (k,), attained by the rates: lower bounds of the margins, less rounding. bounds : (k,), upper bounds,
    proved by the wrenches, with rounding.
    rates : (k, n_hinges), the best closed rates (opening is positive); 0 where the margin is 0. wrenches : (k,
    n_rows). moments : (k, n_hinges), N m, tau + A' y. places : (k, n_hinges), 1 or -1 where a hinge holds with its
    full friction, with the sign of its moment, else 0. hinges : (k,), the hinge whose friction takes most of the power;
    -1 where there is none. nullities : (k,), dimensions of the spaces of closed rates.
    """

    margins: Reals
    bounds: Reals
    rates: Reals
    wrenches: Reals
    moments: Reals
    places: Signs
    hinges: WholeNumbers
    nullities: WholeNumbers


@dataclass(frozen=True, eq=False)
class ClosedRates(ByValue):
    """The closed rates of k states, by singular values of their closure Jacobians.

    jacobians : (k, n_rows, n_hinges). left, values, right : singular vectors and values, all of them. ranks : (k,).
    """

    jacobians: Reals
    left: Reals
    values: Reals
    right: Reals
    ranks: WholeNumbers

    @property
    def nullities(self) -> WholeNumbers:
        """Dimensions of the spaces of closed rates, (k,)."""
        nullities: WholeNumbers = self.jacobians.shape[2] - self.ranks
        return nullities

    def bases(self, states: WholeNumbers, rank: int) -> Reals:
        """Return orthonormal bases of the closed rates, (k, n_hinges, m), of some states of one rank."""
        return np.ascontiguousarray(self.right[states, rank:].transpose(0, 2, 1))

    def projected(self, rates: Reals) -> Reals:
        """Return the closed rates nearest to given rates, (k, n_hinges)."""
        kept = np.arange(self.right.shape[1]) >= self.ranks[:, None]
        closed: Reals = np.einsum("kij,ki->kj", self.right, kept * np.einsum("kij,kj->ki", self.right, rates))
        return closed


def closed_rates(jacobians: Reals) -> ClosedRates:
    """Decompose closure Jacobians, (k, n_rows, n_hinges), into their row spaces and closed rates."""
    count, height, n = jacobians.shape
    if not height:
        empty, frames = np.zeros((count, 0)), np.broadcast_to(np.eye(n), (count, n, n))
        return ClosedRates(jacobians, np.zeros((count, 0, 0)), empty, frames, np.zeros(count, np.int64))
    left, values, right = np.linalg.svd(jacobians)
    ranks = (values > CLOSED_RATE_TOLERANCE * np.maximum(values[:, :1], 1.0)).sum(axis=1)
    return ClosedRates(jacobians, left, values, right, ranks)


def allowed_senses(angles: Reals, *, arriving: bool = False) -> Signs:
    """Return the senses in which stops let hinges turn at fold angles: 1 to open only, -1 to fold only, 0 for both.

    angles : any shape, rad. arriving : senses of the motions that end at the state, not of those that leave it.
    """
    senses = (angles > math.pi - STOP_TOLERANCE).astype(np.int8) - (angles < STOP_TOLERANCE).astype(np.int8)
    return -senses if arriving else senses


def torque_margins(rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs) -> TorqueMargins:
    """Compute the torque margins of k states.

    torques : (k, n_hinges), N m, positive where they open. friction : (n_hinges,), N m, not negative.
    senses : (k, n_hinges), of `allowed_senses`. HcsearchError for numbers of hinges that differ, for torques and
    friction that are not finite, and for negative friction.
    """
    count, _, n = rates.jacobians.shape
    _check_torques(torques, friction, (count, n))
    margins, found, moments = np.empty(count), np.empty((count, n)), np.empty((count, n))
    places = np.empty((count, n), np.int8)
    for states, basis in _by_rank(rates):
        results = np.empty(len(states)), found[states], moments[states], places[states]
        solve_margins(basis, torques[states], friction, senses[states], *results)
        margins[states], found[states], moments[states], places[states] = results
    wrenches, bounds = _proved(rates, torques, friction, senses, moments, margins)
    losses = friction * np.abs(found)
    hinges = np.where(losses.any(axis=1), losses.argmax(axis=1), -1)
    attained = np.where(np.isfinite(margins), _attained(rates, torques, friction, found), margins)
    return TorqueMargins(attained, bounds, found, wrenches, moments, places, hinges, rates.nullities)


def torque_margins_failed(
    rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs, whole: TorqueMargins
) -> tuple[Reals, WholeNumbers]:
    """Return the least torque margins of k states with the spring of one hinge failed, (k,), and these hinges.

    A failed spring has no torque, and its hinge keeps its friction. Hinges without a torque are passed over: 0 and -1
    where there is no other. whole : the margins with all springs. Others as in `torque_margins`.
    """
    count, _, n = rates.jacobians.shape
    _check_torques(torques, friction, (count, n))
    margins, failed = np.empty(count), np.empty(count, np.int64)
    for states, basis in _by_rank(rates):
        results = np.empty(len(states)), np.empty(len(states), np.int64)
        solve_failed_margins(basis, torques[states], friction, senses[states], whole.rates[states], *results)
        margins[states], failed[states] = results
    return margins, failed


def power_ratios(torques: Reals, friction: Reals, rates: Reals) -> Reals:
    """Return the power of torques at some rates over that lost to friction, (k,); signed, and 0 without any power.

    Of closed rates that stops allow it is a lower bound of the torque margin.
    """
    power, losses = (torques * rates).sum(axis=1), (friction * np.abs(rates)).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(power == 0.0, 0.0, power / losses)


def _check_torques(torques: Reals, friction: Reals, shape: tuple[int, int]) -> None:
    """Refuse torques and friction of wrong shapes or values."""
    if torques.shape != shape or friction.shape != shape[1:]:
        raise HcsearchError(
            f"torques of shape {torques.shape} and friction of shape {friction.shape} for {shape[0]} states: give "
            f"{shape[1]} numbers for each state, and for friction, one for each hinge"
        )
    if not (np.isfinite(torques).all() and np.isfinite(friction).all() and (friction >= 0.0).all()):
        raise HcsearchError(
            "a torque or friction is not finite or friction is negative: give friction of 0 N m or more"
        )


def _by_rank(rates: ClosedRates) -> list[tuple[WholeNumbers, Reals]]:
    """Return the states of each rank, and the bases of their closed rates."""
    groups = [(np.flatnonzero(rates.ranks == rank), int(rank)) for rank in np.unique(rates.ranks)]
    return [(states, rates.bases(states, rank)) for states, rank in groups]


def _attained(rates: ClosedRates, torques: Reals, friction: Reals, found: Reals) -> Reals:
    """Return the ratios of rates, less what closing them exactly may change."""
    opened = np.linalg.norm(np.einsum("krn,kn->kr", rates.jacobians, found), axis=1)
    off = opened / _least_values(rates) + MARGIN_ROUNDING * np.linalg.norm(found, axis=1)
    power = (torques * found).sum(axis=1) - off * np.linalg.norm(torques, axis=1)
    losses = (friction * np.abs(found)).sum(axis=1) + off * np.linalg.norm(friction)
    return np.where(losses > 0.0, np.maximum(power, 0.0) / np.where(losses > 0.0, losses, 1.0), 0.0)


def _least_values(rates: ClosedRates) -> Reals:
    """Return the least singular values that count, (k,); infinite where there is none."""
    count = len(rates.ranks)
    padded = np.c_[np.full(count, np.inf), rates.values]
    least: Reals = padded[np.arange(count), rates.ranks]
    return least


def _proved(
    rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs, moments: Reals, margins: Reals
) -> tuple[Reals, Reals]:
    """Return the wrenches that leave moments to friction, and the bounds of the margins that these prove."""
    kept = np.arange(rates.values.shape[1]) < rates.ranks[:, None]
    inverse = np.where(kept, 1.0, 0.0) / np.where(kept, rates.values, 1.0)
    borne = np.einsum("kij,kj->ki", rates.right[:, : rates.values.shape[1]], moments - torques)
    wrenches = np.einsum("kri,ki->kr", rates.left[:, :, : rates.values.shape[1]], inverse * borne)
    left = torques + np.einsum("krn,kr->kn", rates.jacobians, wrenches)
    sizes = np.abs(torques) + np.einsum("krn,kr->kn", np.abs(rates.jacobians), np.abs(wrenches))
    sizes = sizes.max(axis=1, initial=0.0, keepdims=True)
    # stops bear what presses hinges against them
    left = np.where(senses == 1, np.maximum(left, 0.0), np.where(senses == -1, np.maximum(-left, 0.0), np.abs(left)))
    bearing = friction > 0.0
    ratios = (left + MARGIN_ROUNDING * sizes)[:, bearing] / friction[bearing]
    bounds = ratios.max(axis=1, initial=0.0)
    loose = (left > CLOSED_RATE_TOLERANCE * sizes)[:, ~bearing].any(axis=1)  # without friction nothing bears it
    bounds = np.where(loose | np.isinf(margins), np.inf, np.where(np.isnan(margins), np.nan, bounds))
    return wrenches, bounds
