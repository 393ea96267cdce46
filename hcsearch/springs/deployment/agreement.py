"""Agreement of a deployment with a simulation of it at a tighter tolerance, and with a second one where they disagree.

Where branches of motions cross, and where rounding determines the rank of the closure equations, a simulation follows
one of several continuations, and hardly shows whether another one is as likely. Such a motion is branch-singular, in
whichever way it went here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from hcsearch.basics.vocabulary import Ending, Formulation, Verdict
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.error_estimates import (
    SLOW_DISTANCE,
    ErrorEstimates,
    angle_distances,
    clearances_of,
    comparison_times,
    estimate_errors,
)
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, DeploymentCheck
from hcsearch.springs.deployment.play import needed_margin_of
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.system.terminal import short_number

TIGHTENING_FACTORS = (10.0, 100.0)
"""Factors by which the other tolerances are tighter. The tightest confirms; the other one is for simulations that
disagree. Where springs close the loops, a hundredth takes too long."""
TIGHTEST_TOLERANCE = 1e-13
"""The tightest tolerance; where the others would be below it, they are looser by the same factors."""
AGREEMENT_STEPS_FACTOR = 4
"""Ratio of the greatest number of steps of these simulations to the first one's."""
MAX_FLAT_TIME_DIGITS = 4
"""Greatest number of digits of a reported flat time."""
FLAT_TIME_TOLERANCE = 0.1
"""Relative tolerance, over the mean, within which flat times agree."""
LOOSE_STATES_SHARE = 0.1
"""Share of states with open loops from which on a motion is taken to follow a branch of singular states. Among 10 and
12 hexagons that become flat at 1e-6 or 1e-7 the motions of four foldings have shares of 0.16 to 0.79, all others at
most 0.03."""
_DOUBTFUL_ENDINGS: frozenset[Ending] = frozenset({"flat", "jammed", "diverged"})
"""Endings that simulations at other tolerances must confirm: hinges that rattle at their stops may jam, or fail the
energy balance, or become flat."""
_CONTINUED = (
    "the motion passes a state where its continuation depends on that: take other springs, or the compliant formulation"
)
_LOOSE = (
    f"branch-singular: loops stay open at {LOOSE_STATES_SHARE:.0%} of its states or more, so that rounding decides "
    "which closure equations count and how it goes on: take the compliant formulation"
)


class SimulationFindings(NamedTuple):
    """The result of one simulation; time : its end, s. loose_share : share of its states with open loops."""

    tolerance: float
    outcome: Ending
    verdict: Verdict
    time: float
    loose_share: float


@dataclass(frozen=True)
class Agreement:
    """The agreement of simulations at several tolerances.

    verdict : the common verdict; `undecided` where they differ, or where they deploy along a branch of singular states.
    flat_time : s, in the digits that agree, in one digit where none does; None unless all become flat, at times that
    differ by a tenth at most, and not along such a branch.
    reason : the result in a sentence. others : the simulations at the other tolerances.
    needed_margin : m, the least at which all of them are certified clear; least_gap : m, of the first, as in `Play`;
    both None unless it deploys. outcome : the ending of the first, or `branch-singular`.
    errors : estimates of the errors of the first, from the others; None where motions are not compared.
    """

    verdict: Verdict
    flat_time: float | None
    reason: str
    others: tuple[SimulationFindings, ...]
    needed_margin: float | None = None
    least_gap: float | None = None
    outcome: Ending = "flat"
    errors: ErrorEstimates | None = None

    @property
    def untimed(self) -> bool:
        """Whether all become flat, but at times that do not agree."""
        return self.flat_time is None and self.outcome == "flat"


def agreement_tolerances(tolerance: float, formulation: Formulation = "constrained") -> tuple[float, ...]:
    """Return the tolerances at which a deployment is simulated again, if the tightest does not confirm it."""
    shares = TIGHTENING_FACTORS[:1] if formulation in {"penalty", "compliant"} else TIGHTENING_FACTORS
    looser = tolerance / shares[-1] < 0.99 * TIGHTEST_TOLERANCE
    return tuple(tolerance * share if looser else tolerance / share for share in shares)


def is_doubtful(check: DeploymentCheck) -> bool:
    """Return whether the ending of a deployment may depend on rounding, so that other simulations must confirm it."""
    return check.outcome in _DOUBTFUL_ENDINGS or check.loose_share >= LOOSE_STATES_SHARE


def loops_decide(check: DeploymentCheck) -> bool:
    """Return whether open loops make a motion branch-singular, whatever others show."""
    return check.verdict != "collides" and check.loose_share >= LOOSE_STATES_SHARE


class SimulatedCheck(NamedTuple):
    """The check of a deployment simulated at a tolerance, and its states, which are known where it becomes flat."""

    tolerance: float
    check: DeploymentCheck
    deployment: Deployment | None


def simulations_to_confirm(
    first: SimulatedCheck, simulated: Callable[[float], SimulatedCheck], formulation: Formulation = "constrained"
) -> list[SimulatedCheck]:
    """Return a doubtful simulation with those that confirm it, or do not.

    simulated : simulates the same at a tolerance. Where loops decide, others only estimate the error of a flat time.
    """
    if first.check.outcome != "flat" and loops_decide(first.check):
        return [first]
    return [first, *tighter_simulations(first, simulated, formulation)]


def tighter_simulations(
    first: SimulatedCheck, simulated: Callable[[float], SimulatedCheck], formulation: Formulation
) -> list[SimulatedCheck]:
    """Simulate again at the tightest tolerance, and unless this one agrees at another; the tightest comes last."""
    others: list[SimulatedCheck] = []
    for tolerance in sorted(agreement_tolerances(first.tolerance, formulation)):
        others.insert(0, simulated(tolerance))
        if _agree(first, others[0]):
            break
    return others


def _agree(first: SimulatedCheck, other: SimulatedCheck) -> bool:
    """Return whether two simulations become flat alike: with the same verdict, at times and by fold angles that agree.

    Fold angles agree where they are so near that errors are known to fall with the tolerance. Where joints meet stops
    or stick, two simulations may agree by chance, and rounding may decide how a motion ends at any tolerance.
    """
    one, two = first.check, other.check
    if not one.outcome == two.outcome == "flat" or one.verdict != two.verdict:
        return False
    assert first.deployment is not None
    assert other.deployment is not None
    motion = first.deployment.motion
    if motion.events or not _times_agree([one.end_time, two.end_time]):
        return False
    times = comparison_times(motion.times, min(one.end_time, two.end_time))
    distance = float(angle_distances(first.deployment, other.deployment, times).max())
    return distance <= SLOW_DISTANCE * first.tolerance


def agreement_of_simulations(simulations: Sequence[SimulationFindings]) -> Agreement | None:
    """Compare a simulation whose ending is doubtful, the first one, with others at other tolerances.

    None where it does not become flat, and the others end or collide as it does.
    """
    first, others = simulations[0], tuple(simulations[1:])
    verdict: Verdict = (
        first.verdict if all(simulation.verdict == first.verdict for simulation in others) else "undecided"
    )
    loose_share = max(simulation.loose_share for simulation in simulations)
    if verdict != "collides" and loose_share >= LOOSE_STATES_SHARE:
        return Agreement("undecided", None, _LOOSE, others, outcome="branch-singular")
    if verdict == "collides" and first.outcome != "flat":
        return None
    if any(simulation.outcome != first.outcome for simulation in others):
        outcomes = _each(simulations, [simulation.outcome for simulation in simulations])
        reason = f"branch-singular: {outcomes}; {_CONTINUED}"
        return Agreement(verdict, None, reason, others, outcome="branch-singular")
    if first.outcome != "flat":
        return None
    time, reason = _flat(simulations)
    if any(simulation.verdict != first.verdict for simulation in others):
        reason += f", but {_each(simulations, [simulation.verdict for simulation in simulations])}"
    return Agreement(verdict, time, reason, others)


def simulated_at(
    compiled: CompiledScene, tolerance: float, *, method: str | None = None, certified: bool = True
) -> SimulatedCheck:
    """Simulate a compiled scene at a tolerance, with as many steps as the tightest of an agreement may take."""
    steps = AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS[compiled.formulation]
    other = simulate_compiled(compiled, method=method, tolerance=tolerance, certified=certified, max_steps=steps)
    return SimulatedCheck(tolerance, other.check, other)


def confirm_deployment(
    deployment: Deployment, *, method: str | None = None, tolerance: float = 1e-6
) -> Agreement | None:
    """Simulate a deployment at other tolerances and compare; None where its ending needs no other tolerance."""
    if not is_doubtful(deployment.check):
        return None
    compiled, certified = deployment.compiled, deployment.clearance is not None
    first = SimulatedCheck(tolerance, deployment.check, deployment)
    simulated = partial(simulated_at, compiled, method=method, certified=certified)
    simulations = simulations_to_confirm(first, simulated, compiled.formulation)
    agreement = agreement_of_checks(simulations)
    if agreement is None:
        return None
    deployments = [simulation.deployment for simulation in simulations if simulation.deployment is not None]
    play = deployment.play if agreement.verdict == "deploys" else None
    agreement = replace(agreement, errors=estimate_errors(deployments, tolerance, clearances_of(deployments, play)))
    if play is None:
        return agreement
    needed = play.needed_margin
    for other in deployments[1:]:
        needed = needed_margin_of(compiled, other.motion, needed)
    return replace(agreement, needed_margin=needed, least_gap=play.least_gap)


def agreement_of_checks(simulations: Sequence[SimulatedCheck]) -> Agreement | None:
    """Compare simulations at several tolerances, as `agreement_of_simulations` does."""
    return agreement_of_simulations(
        [
            SimulationFindings(at, check.outcome, check.verdict, check.end_time, check.loose_share)
            for at, check, _ in simulations
        ]
    )


def _flat(simulations: Sequence[SimulationFindings]) -> tuple[float | None, str]:
    """Return the common flat time of simulations, s, and a sentence; None where the times differ by over a tenth."""
    times = [simulation.time for simulation in simulations]
    if not _times_agree(times):
        return None, "flat, at a time on which tolerances disagree by more than a tenth"
    time, digits = _common(times)
    if digits.startswith("about"):
        digits += f" ({_each(simulations, [f'{short_number(one.time, 2)} s' for one in simulations])})"
    return time, f"flat after {digits}"


def _times_agree(times: Sequence[float]) -> bool:
    return max(times) - min(times) <= FLAT_TIME_TOLERANCE * sum(times) / len(times)


def _common(times: Sequence[float]) -> tuple[float, str]:
    """Round times to the most digits in which they agree; return a number and words."""
    for digits in range(MAX_FLAT_TIME_DIGITS, 0, -1):
        rounded = {f"{time:.{digits - 1}e}" for time in times}
        if len(rounded) == 1:
            value = float(rounded.pop())
            return value, f"{_digits(value, digits)} s"
    value = float(f"{sum(times) / len(times):.0e}")
    return value, f"about {_digits(value, 1)} s"


def _digits(value: float, digits: int) -> str:
    """Format a number with a number of significant digits, trailing zeros included."""
    decimals = digits - 1 - math.floor(math.log10(value)) if value > 0.0 else 0
    return f"{value:.{max(0, decimals)}f}"


def _each(simulations: Sequence[SimulationFindings], words: Sequence[str]) -> str:
    """Join the results of simulations with their tolerances, written as 1e-6."""
    tolerances = [f"{simulation.tolerance:.6g}".replace("e-0", "e-") for simulation in simulations]
    first, *rest = [f"{word} at {tolerance}" for word, tolerance in zip(words, tolerances, strict=True)]
    return ", ".join([first.replace(" at ", " at tolerance ", 1), *rest])
