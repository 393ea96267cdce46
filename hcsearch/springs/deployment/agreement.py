"""What a deployment that becomes flat and simulations of it at tighter tolerances agree on.

Where branches of motions cross, and where rounding decides which closure equations count, a simulation follows one
continuation of several, and hardly shows how sure that one is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from hcsearch.basics.vocabulary import Ending, Formulation, Verdict
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE, MAX_DEPLOYMENT_STEPS, DeploymentCheck
from hcsearch.springs.deployment.play import needed_margin_of
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.system.terminal import short_number

TIGHTENING_FACTORS = (10.0, 100.0)
"""By what the other tolerances are tighter. Where springs close the loops, a hundred times takes too long."""
TIGHTEST_TOLERANCE = 1e-13
"""The tightest tolerance there is; from there the others are as much looser."""
AGREEMENT_STEPS_FACTOR = 4
"""Steps that these simulations may take, over those of the first."""
MAX_FLAT_TIME_DIGITS = 4
"""No flat time is reported with more."""
FLAT_TIME_TOLERANCE = 0.1
"""Share of their mean by which flat times may differ to be one."""
LOOSE_STATES_SHARE = 0.1
"""Share of the states with open loops from which on a motion runs along a branch of singular states. Of the motions of
10 and 12 hexagons that come flat at 1e-6 or 1e-7 those of four foldings have 0.16 to 0.79, all others at most 0.03."""


class SimulationFindings(NamedTuple):
    """What one simulation came to; time : of its end, s. loose : share of its states with open loops."""

    tolerance: float
    outcome: Ending
    verdict: Verdict
    time: float
    loose: float


@dataclass(frozen=True)
class Agreement:
    """What simulations at several tolerances agree on.

    verdict : that of all; `undecided` where they differ, or would deploy along a branch of singular states.
    flat_time : s, in the digits that agree, in one digit where none does; None unless all come flat, at times that
    differ by a tenth at most.
    reason : what became of it, in a sentence. others : the simulations at the other tolerances.
    needed_margin : m, the least at which all of them are certified clear; least_gap : m, of the first, as of `Play`;
    both None unless it deploys.
    """

    verdict: Verdict
    flat_time: float | None
    reason: str
    others: tuple[SimulationFindings, ...]
    needed_margin: float | None = None
    least_gap: float | None = None

    @property
    def untimed(self) -> bool:
        """Whether all come flat, at times too different to be one."""
        return self.flat_time is None and all(one.outcome == "flat" for one in self.others)


def agreement_tolerances(tolerance: float, formulation: Formulation = "constrained") -> tuple[float, ...]:
    """The tolerances at which a deployment is simulated again."""
    shares = TIGHTENING_FACTORS[:1] if formulation in {"penalty", "compliant"} else TIGHTENING_FACTORS
    looser = tolerance / shares[-1] < 0.99 * TIGHTEST_TOLERANCE
    return tuple(tolerance * share if looser else tolerance / share for share in shares)


def agreement_of_simulations(seen: Sequence[SimulationFindings]) -> Agreement:
    """What a simulation that becomes flat, the first one, and others agree on."""
    first, others = seen[0], tuple(seen[1:])
    verdict: Verdict = first.verdict if all(one.verdict == first.verdict for one in others) else "undecided"
    if any(one.outcome != "flat" for one in others):
        outcomes = _each(seen, [one.outcome for one in seen])
        reason = f"branch-singular: {outcomes}; the motion passes a state where its continuation depends on that"
        return Agreement(verdict, None, reason, others)
    time, reason = _flat(seen)
    loose = max(one.loose for one in seen)
    if verdict == "deploys" and loose >= LOOSE_STATES_SHARE:
        what = f"at {loose:.0%} of its states loops stay open, so that rounding decides which closure equations count"
        return Agreement("undecided", time, f"branch-singular: {reason}, but {what}", others)
    if any(one.verdict != first.verdict for one in others):
        reason += f", but {_each(seen, [one.verdict for one in seen])}"
    return Agreement(verdict, time, reason, others)


def confirm_deployment(
    deployment: Deployment, *, method: str | None = None, tolerance: float = 1e-6
) -> Agreement | None:
    """What a deployment, simulated at a tolerance, and others agree on; None unless it becomes flat."""
    if deployment.outcome != "flat":
        return None
    compiled, certified = deployment.compiled, deployment.clearance is not None
    steps = AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS[compiled.formulation]
    near = agreement_tolerances(tolerance, compiled.formulation)
    others = [
        simulate_compiled(compiled, method=method, tolerance=one, certified=certified, max_steps=steps) for one in near
    ]
    agreement = agreement_of_checks([one.check for one in (deployment, *others)], (tolerance, *near))
    if agreement.verdict != "deploys" or deployment.play is None:
        return agreement
    needed = deployment.play.needed_margin
    for one in others:
        needed = needed_margin_of(compiled, one.motion, needed)
    return replace(agreement, needed_margin=needed, least_gap=deployment.play.least_gap)


def agreement_of_checks(checks: Sequence[DeploymentCheck], tolerances: Sequence[float]) -> Agreement:
    """What checks at several tolerances agree on."""
    pairs = zip(checks, tolerances, strict=True)
    return agreement_of_simulations(
        [SimulationFindings(near, one.outcome, one.verdict, one.end_time, one.loose) for one, near in pairs]
    )


def _flat(seen: Sequence[SimulationFindings]) -> tuple[float | None, str]:
    """When simulations that all come flat do so, s, and a sentence; None where they differ by more than a tenth."""
    times = [one.time for one in seen]
    if max(times) - min(times) > FLAT_TIME_TOLERANCE * sum(times) / len(times):
        return None, "flat, at a time on which tolerances disagree by more than a tenth"
    time, digits = _common(times)
    if digits.startswith("about"):
        digits += f" ({_each(seen, [f'{short_number(one.time, 2)} s' for one in seen])})"
    return time, f"flat after {digits}"


def _common(times: Sequence[float]) -> tuple[float, str]:
    """The most digits that times share when they are rounded, as a number and in words."""
    for digits in range(MAX_FLAT_TIME_DIGITS, 0, -1):
        rounded = {f"{time:.{digits - 1}e}" for time in times}
        if len(rounded) == 1:
            value = float(rounded.pop())
            return value, f"{_digits(value, digits)} s"
    value = float(f"{sum(times) / len(times):.0e}")
    return value, f"about {_digits(value, 1)} s"


def _digits(value: float, digits: int) -> str:
    """A number with so many digits, its zeros included."""
    places = digits - 1 - math.floor(math.log10(value)) if value > 0.0 else 0
    return f"{value:.{max(0, places)}f}"


def _each(seen: Sequence[SimulationFindings], words: Sequence[str]) -> str:
    """What each simulation came to, with its tolerance as people write it, 1e-6."""
    at = [f"{one.tolerance:.6g}".replace("e-0", "e-") for one in seen]
    first, *others = [f"{word} at {near}" for word, near in zip(words, at, strict=True)]
    return ", ".join([first.replace(" at ", " at tolerance ", 1), *others])


ARRIVAL_TIME_TOLERANCE = 1e-4
"""Hinges that arrive within this of one another (s) arrive together: mirror images do, but for rounding."""


@dataclass(frozen=True)
class Arrival:
    """Hinges that come to their stops together: the first time (s), and the greatest speed (rad/s)."""

    time: float
    stop: Literal["flat", "folded"]
    hinges: tuple[int, ...]
    speed: float


def hinge_arrivals(deployment: Deployment) -> tuple[Arrival, ...]:
    """The arrivals of hinges at stops from which they were away, by more than 0.01 rad, since the hit before.

    Bounces are left out: how many there are, and how small, is a matter of how the stops are modelled.
    """
    arrived: list[Arrival] = []
    for time, stop, hinge, speed in sorted(_hits(deployment)):
        last = next((a for a in arrived[::-1] if a.stop == stop and time - a.time <= ARRIVAL_TIME_TOLERANCE), None)
        if last is None:
            arrived.append(Arrival(time, stop, (hinge,), speed))
        else:
            hinges = tuple(sorted({*last.hinges, hinge}))
            arrived[arrived.index(last)] = Arrival(last.time, stop, hinges, max(last.speed, speed))
    return tuple(arrived)


def _hits(deployment: Deployment) -> list[tuple[float, Literal["flat", "folded"], int, float]]:
    """Time, stop, hinge and speed of each hit that is no bounce."""
    times, angles, hits = deployment.motion.times, deployment.angles, []
    last: dict[int, float] = {}
    for event in deployment.motion.events:
        if event.kind != "hit":
            continue
        for hinge in deployment.compiled.hinges_of(event.joint):
            since = angles[np.searchsorted(times, last.get(hinge, 0.0)) : np.searchsorted(times, event.time), hinge]
            here = float(np.interp(event.time, times, angles[:, hinge]))
            stop: Literal["flat", "folded"] = "flat" if here < 0.5 * math.pi else "folded"
            limit = 0.0 if stop == "flat" else math.pi
            if np.abs(since - limit).max(initial=0.0) > FLAT_FOLD_ANGLE:
                hits.append((event.time, stop, hinge, abs(event.speed)))
            last[hinge] = event.time
    return hits
