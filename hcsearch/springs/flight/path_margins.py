"""Torque margins at the states of a path from packed to flat, with the worst spring failed, and at its singular ends.

At a singular state more rates close the loops to first order than belong to motions. There the linear program bounds
the margin from above, and true motions bound it from below: that of the path, and at ends better ones to which rates
climb (docs/explanation/flight_margins.md, 4). The flat end is arrived at, so stops count for the motion reversed.
Between states `certified_margin` bounds margins.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, Signs, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.planning.ends import EndClosure
from hcsearch.motion.planning.problems import group_of_all, loops_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.torque_margin import (
    ClosedRates,
    allowed_senses,
    closed_rates,
    kernel_margins,
    power_ratios,
    torque_margins,
    torque_margins_failed,
)

SURELY_LEAVING_RATE = 1e-6
"""Least rate, over the fastest hinge's, at which a hinge surely leaves its stop."""
STILL_RATE = 1e-12
"""Entries of unit vectors below this are rounding errors."""
MAX_FAILURES_TRIED = 2
"""Greatest number of failed springs for which motions at an end are searched for."""
MAX_CLIMBING_STEPS, MIN_CLIMB = 6, 1e-3
"""Greatest number of steps from motion to motion at an end, and least relative gain of a step's margin."""
CLIMBING_SHARES = (1.0, 0.5, 0.2)
"""Shares of the way to the best rates that are tried in a step."""


@dataclass(frozen=True, eq=False)
class PathRates(ByValue):
    """The rates that loops and stops allow at the k states of a path, whatever its springs are.

    angles : (k, n_hinges), rad. rates : of first order. senses : (k, n_hinges), from `allowed_senses`. singular : (k,),
    where more rates close the loops to first order than elsewhere on the path. tangents : (k, n_hinges), unit rates at
    which hinges open along the path; 0 where they are not known. ends : by state, the motions of singular ends.
    """

    linkage: Linkage
    angles: Reals
    rates: ClosedRates
    senses: Signs
    singular: Flags
    tangents: Reals
    ends: dict[int, EndMotions]


@dataclass(frozen=True, eq=False)
class PathMargins(ByValue):
    """Torque margins at the k states of a path.

    margins : (k,), attained by motions, less rounding: lower bounds. bounds : (k,), upper bounds of the linear program;
    equal to the margins but for rounding, except where singular. along, along_failed : (k,), power of the springs along
    the path over what friction takes, with all springs and with the worst one failed: the margins of an array that is
    guided along its path. Negative where springs push back; margins are at least as great.
    rates : (k, n_hinges), of the best motions. hinges : (k,), the hinge whose friction takes most of their power; -1
    where there is none.
    failed, failed_bounds : (k,), as margins and bounds, with the worst spring failed; failed_hinges : (k,), its hinge,
    -1 where none has a torque. known, failed_known : (k,), whether margins and bounds meet where they should.
    """

    margins: Reals
    bounds: Reals
    along: Reals
    along_failed: Reals
    rates: Reals
    hinges: WholeNumbers
    failed: Reals
    failed_bounds: Reals
    failed_hinges: WholeNumbers
    known: Flags
    failed_known: Flags

    @property
    def least_state(self) -> int:
        """The state of the least margin, the first of several."""
        return int(self.margins.argmin())

    @property
    def least_failed_state(self) -> int:
        """The state of the least margin with a spring failed, the first of several."""
        return int(self.failed.argmin())


def path_rates(linkage: Linkage, angles: Reals) -> PathRates:
    """Find the rates that loops and stops allow at the states of a path.

    angles : closed states, (k, n_hinges), rad, from packed to flat, two at least, none of them twice in succession.
    HcsearchError for other shapes.
    """
    if angles.ndim != 2 or len(angles) < 2 or angles.shape[1] != linkage.n_hinges:
        raise HcsearchError(
            f"a path of shape {angles.shape}: give two states or more of {linkage.n_hinges} fold angles each"
        )
    steps = np.linalg.norm(np.diff(angles, axis=0), axis=1)
    if not (steps > 0.0).all():
        raise HcsearchError(f"state {int(steps.argmin()) + 1} of the path is the one before it: leave it out")
    rates = closed_rates(np.array([linkage.closure(state)[1] for state in angles]))
    senses = allowed_senses(angles)
    senses[-1] = allowed_senses(angles[-1], arriving=True)
    tangents = rates.projected(-np.gradient(angles, np.r_[0.0, np.cumsum(steps)], axis=0))
    for state in np.flatnonzero((senses * tangents < 0.0).any(axis=1)):
        tangents[state] = _within_stops(rates.jacobians[state], tangents[state], senses[state])
    singular, ends = rates.nullities > rates.nullities.min(), {}
    for end, beside, arriving in ((0, 1, False), (len(angles) - 1, len(angles) - 2, True)):
        if singular[end] and senses[end].all():  # every hinge is at a stop
            ends[end] = EndMotions(linkage, angles[end], angles[beside], arriving=arriving)
            tangents[end] = ends[end].of_path
    sizes = np.linalg.norm(tangents, axis=1, keepdims=True)
    tangents /= np.where(sizes > 0.0, sizes, 1.0)
    return PathRates(linkage, angles, rates, senses, singular, tangents, ends)


def _within_stops(jacobian: Reals, rates: Reals, senses: Signs) -> Reals:
    """Return closed rates near given ones that stops allow: hinges that would turn beyond a stop rest. 0 if none do."""
    held = np.zeros(len(rates), bool)
    while (senses * rates < 0.0).any():
        held |= senses * rates < 0.0
        closed = closed_rates(jacobian[None][:, :, ~held])
        own = closed.projected(rates[None][:, ~held])[0]
        rates = np.zeros(len(rates))
        rates[~held] = np.where(np.abs(own) > STILL_RATE, own, 0.0)
    return rates


def margins_along(path: PathRates, torques: Reals, friction: Reals) -> PathMargins:
    """Compute the torque margins at the states of a path, with all springs and with the worst one failed.

    torques : (k, n_hinges), N m, as `law_torques` gives them. friction : (n_hinges,), N m. Both are weighted by the
    factors of a rule beforehand. HcsearchError as in `torque_margins`.
    """
    program = torque_margins(path.rates, torques, friction, path.senses)
    without = torque_margins_failed(path.rates, torques, friction, path.senses, program)
    margins, rates = program.margins.copy(), program.rates.copy()
    failed, failed_hinges = without.margins.copy(), without.hinges.copy()
    for state in np.flatnonzero(path.singular).tolist():
        motions = _motions_at(path, state, torques[state], friction, MAX_FAILURES_TRIED)
        margins[state], rates[state] = _best_of(torques[state], friction, motions)
        failed[state], failed_hinges[state] = _failed_of(torques[state], friction, motions)
    losses = friction * np.abs(rates)
    return PathMargins(
        margins=margins,
        bounds=program.bounds,
        along=power_ratios(torques, friction, path.tangents),
        along_failed=_ratios_failed(torques, friction, path.tangents).min(axis=1),
        rates=rates,
        hinges=np.where(losses.any(axis=1), losses.argmax(axis=1), -1),
        failed=failed,
        failed_bounds=without.bounds,
        failed_hinges=failed_hinges,
        known=program.known | path.singular,
        failed_known=without.known | path.singular,
    )


def best_rates_along(path: PathRates, torques: Reals, friction: Reals, working: Reals) -> Reals:
    """Return the rates by which `margins_along` finds its margins, (n_cases, k, n_hinges), as far as the kernel can.

    working : (n_cases, n_hinges), 1 for the springs that work in a case, 0 for those that failed. Others as above.
    """
    rates = np.array([kernel_margins(path.rates, torques * works, friction, path.senses).rates for works in working])
    for state in np.flatnonzero(path.singular).tolist():
        motions = _motions_at(path, state, torques[state], friction, MAX_FAILURES_TRIED)
        rates[:, state] = [_best_of(torques[state] * works, friction, motions)[1] for works in working]
    return rates


def _motions_at(path: PathRates, state: int, torques: Reals, friction: Reals, failures: int) -> Reals:
    """Return known motions at a singular state, the motion of the path first; failures : as in `EndMotions.climbed`."""
    motions: Reals = path.tangents[state][None]
    if state in path.ends:
        motions = np.r_[motions, path.ends[state].climbed(torques, friction, motions, failures)]
    return motions


def _best_of(torques: Reals, friction: Reals, motions: Reals) -> tuple[float, Reals]:
    """Return the greatest margin of motions, and the one that attains it."""
    ratios = np.maximum(power_ratios(np.broadcast_to(torques, motions.shape), friction, motions), 0.0)
    return float(ratios.max()), motions[ratios.argmax()]


class EndMotions:
    """The motions that leave the packed end of a path, or arrive at the flat one, as rates at which hinges open.

    of_path : (n_hinges,), of the motion nearest to the path, which begins or ends with a given state beside the end; 0
    where none is found.
    """

    def __init__(self, linkage: Linkage, angles: Reals, beside: Reals, *, arriving: bool) -> None:
        self.closure = EndClosure(linkage, angles, group_of_all(loops_of(linkage)))
        self.leaving = 1.0 if arriving else -1.0  # at the flat end angles grow where a motion leaves
        self.rates = closed_rates(self.closure.jacobian[None])
        self.senses = allowed_senses(angles, arriving=arriving)[None]
        found = self._motion_near(self.leaving * (beside - angles), regular=False)
        self.of_path = np.zeros(len(angles)) if found is None else found

    def climbed(self, torques: Reals, friction: Reals, known: Reals, failures: int) -> Reals:
        """Return motions, (k, n_hinges), that may have greater margins than known ones.

        They climb from the regular motions nearest to the best rates of the linear program, or to the path: first with
        all springs, then, as often as `failures`, without the one whose failure leaves the least margin to the motions
        so far.
        """
        motions, left = known, torques
        for _ in range(1 + failures):
            program = torque_margins(self.rates, left[None], friction, self.senses)
            ratio = power_ratios(np.broadcast_to(left, motions.shape), friction, motions).max()
            if ratio < program.bounds[0] * (1.0 - MIN_CLIMB):
                starts = (program.rates[0], self.of_path)
                found = next((own for start in starts if (own := self._climb(left, friction, start)) is not None), None)
                if found is not None:
                    motions = np.r_[motions, found[None]]
            failed = _failed_of(torques, friction, motions)[1]
            if failed < 0 or (left[failed] == 0.0 and left is not torques):
                break
            left = torques.copy()
            left[failed] = 0.0
        return motions[len(known) :]

    def _climb(self, torques: Reals, friction: Reals, rates: Reals) -> Reals | None:
        """Return a regular motion near given rates, or None: the last of a row with ever greater margins.

        Each is near the one before, towards the best rates in the plane that touches the motions of second order there.
        """
        best = self._motion_near(rates, regular=True)
        for _ in range(MAX_CLIMBING_STEPS if best is not None else 0):
            assert best is not None
            touching = closed_rates(self.closure.equations(best)[1][None])
            towards = torque_margins(touching, torques[None], friction, self.senses).rates[0]
            higher = self._higher(torques, friction, best, towards) if towards.any() else None
            if higher is None:
                break
            best = higher
        return best

    def _higher(self, torques: Reals, friction: Reals, rates: Reals, towards: Reals) -> Reals | None:
        """Return a regular motion of greater margin than rates, on the way to others; None where none is found."""
        least = float(power_ratios(torques, friction, rates[None])[0]) * (1.0 + MIN_CLIMB)
        # scaled alike, so that a share of the way is one of the turn
        start, end = rates / np.linalg.norm(rates), towards / np.linalg.norm(towards)
        for share in CLIMBING_SHARES:
            found = self._motion_near(start + share * (end - start), regular=True)
            if found is not None and power_ratios(torques, friction, found[None])[0] > least:
                return found
        return None

    def _motion_near(self, rates: Reals, *, regular: bool) -> Reals | None:
        """Return the motion nearest to given rates, or None; regular : whether it has to be one by itself."""
        found = self.closure.direction(self.leaving * rates) if rates.any() else None
        if found is None or (regular and not self._is_regular(found)):
            return None
        return self.leaving * found

    def _is_regular(self, direction: Reals) -> bool:
        """Return whether a motion surely leaves an end in a direction: its equations are regular and no hinge rests."""
        _, derivative = self.closure.equations(direction)
        leaves = np.abs(direction).min() > SURELY_LEAVING_RATE
        return bool(leaves) and int(np.linalg.matrix_rank(derivative)) == len(derivative)


def _failed_of(torques: Reals, friction: Reals, motions: Reals) -> tuple[float, int]:
    """Return the least margin of motions without one of the torques, and its hinge; 0 and -1 where all are 0."""
    hinges = np.flatnonzero(torques)
    if not len(hinges):
        return 0.0, -1
    ratios = _ratios_failed(np.broadcast_to(torques, motions.shape), friction, motions)[:, hinges]
    best = np.maximum(ratios.max(axis=0), 0.0)
    return float(best.min()), int(hinges[best.argmin()])


def _ratios_failed(torques: Reals, friction: Reals, rates: Reals) -> Reals:
    """Return `power_ratios` with each of the torques 0, (k, n_hinges)."""
    powers = torques * rates
    power, losses = powers.sum(axis=1, keepdims=True) - powers, (friction * np.abs(rates)).sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(power == 0.0, 0.0, power / losses)
