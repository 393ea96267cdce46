"""Torque margins: by how much springs exceed the friction of hinges at closed states, by a linear program and its dual.

At a closed state with closure Jacobian A the rates at which hinges can open are the v with A v = 0 that stops allow.
With torques tau of springs and friction f >= 0 the torque margin is

    k = max tau . v / sum f_i |v_i|  =  least k for which |tau_i + (A' y)_i| <= k f_i for some wrench y in the loops,

where the second condition is left out on the side on which a hinge presses against a stop. Springs move the array, in
some direction, exactly where friction is less than k times f. Rates v bound k from below and wrenches y from above, so
that both together certify it. Where both bounds of the fast kernel do not meet, HiGHS solves the program again; where
its bounds do not meet either, the margin is known to lie between them only. Proofs:
docs/explanation/flight_margins.md, 1 to 3.

Torques and rates are positive where they open a hinge: laws of springs give such torques, and fold angles fall.
Requirements: ECSS-E-ST-33-01C, 4.7.5.3, whose factors belong in f and in tau.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, Signs, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.linkage.gauges import solve_margins
from hcsearch.motion.paths.motions import STOP_TOLERANCE

CLOSED_RATE_TOLERANCE = 1e-9
"""Singular values of the closure Jacobian below this share of the greatest are zeros."""
CERTIFICATE_TOLERANCE = 1e-10
"""Greatest difference of a margin and its bound at which the program counts as solved, over the bound, or over the
greatest torque to the greatest friction where that is more."""
KNOWN_MARGIN_TOLERANCE = 1e-6
"""The same difference, beyond which a margin is not known: near singular states closed rates have no more digits."""
HIGHS_TOLERANCE = 1e-10
"""Feasibility tolerance of HiGHS, the least that it takes."""
MARGIN_ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Relative rounding error of a sum of some ten products."""


@dataclass(frozen=True, eq=False)
class TorqueMargins(ByValue):
    """Torque margins of k states, infinite where nothing resists a motion.

    margins : (k,), attained by the rates: lower bounds of the margins, less rounding. bounds : (k,), upper bounds,
    proved by the wrenches, with rounding. known : (k,), whether both meet, within `KNOWN_MARGIN_TOLERANCE`.
    rates : (k, n_hinges), the best closed rates (opening is positive); 0 where the margin is 0. wrenches : (k,
    n_rows). hinges : (k,), the hinge whose friction takes most of the power; -1 where there is none. nullities : (k,),
    dimensions of the spaces of closed rates.
    """

    margins: Reals
    bounds: Reals
    known: Flags
    rates: Reals
    wrenches: Reals
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

    def take(self, states: WholeNumbers) -> ClosedRates:
        """Return the closed rates of some of the states."""
        return ClosedRates(*(values[states] for values in vars(self).values()))

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


@dataclass(frozen=True, eq=False)
class FailedMargins(ByValue):
    """The least torque margins of k states with one spring failed: margins, bounds and known as in `TorqueMargins`.

    hinges : (k,), of the failed springs; -1 where there is none.
    """

    margins: Reals
    bounds: Reals
    known: Flags
    hinges: WholeNumbers

    @staticmethod
    def none_of(count: int) -> FailedMargins:
        """Return the margins of states at which no spring has a torque."""
        return FailedMargins(np.zeros(count), np.zeros(count), np.ones(count, bool), np.full(count, -1))

    def take_less(self, states: WholeNumbers, hinges: WholeNumbers, found: TorqueMargins) -> None:
        """Take the margins of some states where they are less than those so far."""
        first = self.hinges[states] < 0
        less = first | (found.margins < self.margins[states])
        self.known[states] = np.where(first, True, self.known[states]) & found.known
        self.bounds[states] = np.minimum(np.where(first, np.inf, self.bounds[states]), found.bounds)
        self.margins[states[less]], self.hinges[states[less]] = found.margins[less], hinges[less]


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
    senses : (k, n_hinges), from `allowed_senses`. HcsearchError for numbers of hinges that differ, for torques and
    friction that are not finite, and for negative friction.
    """
    count, _, n = rates.jacobians.shape
    _check_torques(torques, friction, (count, n))
    found = kernel_margins(rates, torques, friction, senses)
    scale = np.abs(torques).max(axis=1, initial=0.0) / (friction.max(initial=0.0) or 1.0)
    for state in np.flatnonzero(~_meet(found, scale, CERTIFICATE_TOLERANCE)).tolist():
        _solve_again(found, state, rates.take(np.array([state])), torques[state], friction, senses[state])
    losses = friction * np.abs(found.rates)
    hinges = np.where(losses.any(axis=1), losses.argmax(axis=1), -1)
    # beside singular states stops that rates pass by rounding may put the margin above its bound
    between = np.minimum(found.margins, found.bounds), np.maximum(found.margins, found.bounds)
    known = _meet(found, scale, KNOWN_MARGIN_TOLERANCE)
    return replace(found, margins=between[0], bounds=between[1], known=known, hinges=hinges)


def torque_margins_failed(
    rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs, whole: TorqueMargins
) -> FailedMargins:
    """Compute the least torque margins of k states with the spring of one hinge failed.

    A failed spring has no torque, and its hinge keeps its friction. Hinges without a torque are passed over: 0 and -1
    where there is no other. whole : the margins with all springs, whose rates bound the margins without one from below,
    so that most programs are left out. Others as in `torque_margins`.
    """
    count = len(torques)
    powers = torques * whole.rates
    lost = (friction * np.abs(whole.rates)).sum(axis=1, keepdims=True)
    least = np.maximum(powers.sum(axis=1, keepdims=True) - powers, 0.0) / np.where(lost > 0.0, lost, np.inf)
    least[~whole.known] = 0.0  # their rates bound nothing
    least[torques == 0.0] = np.inf
    order, found = np.argsort(least, axis=1), FailedMargins.none_of(count)
    for turn in range(torques.shape[1]):
        hinges = order[:, turn]
        left = np.flatnonzero(least[np.arange(count), hinges] < np.where(found.hinges < 0, np.inf, found.margins))
        if not len(left):
            break
        failed = torques[left]
        failed[np.arange(len(left)), hinges[left]] = 0.0
        found.take_less(left, hinges[left], torque_margins(rates.take(left), failed, friction, senses[left]))
    return found


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


def kernel_margins(rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs) -> TorqueMargins:
    """Bound the torque margins of k states by the kernel alone; nearly everywhere both bounds meet."""
    count, n = torques.shape
    multiples, found, moments = np.empty(count), np.empty((count, n)), np.empty((count, n))
    for rank in np.unique(rates.ranks).tolist():
        states = np.flatnonzero(rates.ranks == rank)
        results = np.empty(len(states)), found[states], moments[states]
        solve_margins(rates.bases(states, rank), torques[states], friction, senses[states], *results)
        multiples[states], found[states], moments[states] = results
    found = np.where(np.isnan(multiples)[:, None], 0.0, found)
    moments = np.where(np.isnan(multiples)[:, None], torques, moments)
    wrenches, bounds = _proved(rates, torques, friction, senses, moments)
    free = np.isinf(multiples)
    margins = np.where(free, np.inf, _attained(rates, torques, friction, senses, found))
    bounds = np.where(free, np.inf, bounds)
    return TorqueMargins(margins, bounds, np.isinf(margins), found, wrenches, np.full(count, -1), rates.nullities)


def _meet(found: TorqueMargins, scale: Reals, tolerance: float) -> Flags:
    """Return where margins and bounds differ by no more than a tolerance, (k,)."""
    with np.errstate(invalid="ignore"):  # of infinite ones
        near = np.abs(found.bounds - found.margins) <= tolerance * np.maximum(found.bounds, scale)
    meet: Flags = (found.margins == found.bounds) | (near & np.isfinite(found.bounds))
    return meet


def _solve_again(
    found: TorqueMargins, state: int, rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs
) -> None:
    """Solve the program of one state by HiGHS, and keep the better one of each bound."""
    from scipy.optimize import linprog  # noqa: PLC0415 - loads slowly

    rows, n = rates.right[0, : rates.ranks[0]], len(torques)
    bounds = [(0.0, 0.0 if sense < 0 else None) for sense in senses]
    bounds += [(0.0, 0.0 if sense > 0 else None) for sense in senses]
    size, scale = float(np.abs(torques).max(initial=0.0)) or 1.0, float(friction.max(initial=0.0)) or 1.0
    solution = linprog(
        np.r_[-torques, torques] / size,
        A_ub=np.r_[friction, friction][None] / scale,
        b_ub=[1.0],
        A_eq=np.c_[rows, -rows] if len(rows) else None,
        b_eq=np.zeros(len(rows)) if len(rows) else None,
        bounds=bounds,
        options={"primal_feasibility_tolerance": HIGHS_TOLERANCE, "dual_feasibility_tolerance": HIGHS_TOLERANCE},
    )
    if solution.status != 0:
        return
    own = rates.projected((solution.x[:n] - solution.x[n:])[None])
    moments = torques + size * (solution.eqlin.marginals @ rows if len(rows) else 0.0)
    program = rates, torques[None], friction, senses[None]
    margin = float(_attained(*program, own)[0])
    wrenches, bound = _proved(*program, moments[None])
    if margin > found.margins[state]:
        found.margins[state], found.rates[state] = margin, own[0]
    if bound[0] < found.bounds[state]:
        found.bounds[state], found.wrenches[state] = bound[0], wrenches[0]


def _attained(rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs, found: Reals) -> Reals:
    """Return the ratios of rates without those that pass a stop, less the change that exact closing may make."""
    found = np.where(senses * found < 0.0, 0.0, found)
    opened = np.linalg.norm(np.einsum("krn,kn->kr", rates.jacobians, found), axis=1)
    off = opened / _least_values(rates) + MARGIN_ROUNDING * np.linalg.norm(found, axis=1)
    power = (torques * found).sum(axis=1) - off * np.linalg.norm(torques, axis=1)
    losses = (friction * np.abs(found)).sum(axis=1) + off * np.linalg.norm(friction)
    usable = losses > 0.0
    return np.where(usable, np.maximum(power, 0.0) / np.where(usable, losses, 1.0), 0.0)


def _least_values(rates: ClosedRates) -> Reals:
    """Return the least singular values that count, (k,); infinite where there is none."""
    count = len(rates.ranks)
    padded = np.c_[np.full(count, np.inf), rates.values]
    least: Reals = padded[np.arange(count), rates.ranks]
    return least


def _proved(rates: ClosedRates, torques: Reals, friction: Reals, senses: Signs, moments: Reals) -> tuple[Reals, Reals]:
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
    return wrenches, np.where(loose, np.inf, bounds)
