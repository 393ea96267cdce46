"""Agreement of a deployment with simulations of it at tighter tolerances.

Where branches of motions cross, and where rounding determines the rank of the closure equations, a simulation follows
one of several continuations, and hardly shows whether another one is as likely. Such a motion is branch-singular, in
whichever way it went here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from hcsearch.basics.vocabulary import Ending, Formulation, Verdict
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.error_estimates import ErrorEstimates, clearances_of, estimate_errors
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, DeploymentCheck
from hcsearch.springs.deployment.play import needed_margin_of
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.system.terminal import short_number

TIGHTENING_FACTORS = (10.0, 100.0)
"""Factors by which the other tolerances are tighter; where springs close the loops, the second takes too long."""
TIGHTEST_TOLERANCE = 1e-13
"""The tightest tolerance; where the others would be below it, they are looser by the same factors."""
AGREEMENT_STEPS_FACTOR = 4
"""Ratio of the greatest number of steps of these simulations to that of the first."""
MAX_FLAT_TIME_DIGITS = 4
"""Greatest number of digits of a reported flat time."""
FLAT_TIME_TOLERANCE = 0.1
"""Relative tolerance, over the mean, within which flat times agree."""
LOOSE_STATES_SHARE = 0.1
"""Share of states with open loops from which on a motion is taken to follow a branch of singular states. Of the motions
of 10 and 12 hexagons that become flat at 1e-6 or 1e-7 those of four foldings have 0.16 to 0.79, all others at most
0.03."""
_DOUBTFUL_ENDINGS: frozenset[Ending] = frozenset({"flat", "jammed", "diverged"})
"""Endings that simulations at other tolerances confirm: where hinges that rattle at their stops jam, where they jam the
energy balance may fail as well, and either may become flat."""
_CONTINUED = (
    "the motion passes a state where its continuation depends on that: take other springs, or the compliant formulation"
)
_LOOSE = (
    f"branch-singular: loops stay open at {LOOSE_STATES_SHARE:.0%} of its states or more, so that rounding decides "
    "which closure equations count and how it goes on: take the compliant formulation"
)


class SimulationFindings(NamedTuple):
    """The result of one simulation; time : of its end, s. loose_share : share of its states with open loops."""

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
    needed_margin : m, the least at which all of them are certified clear; least_gap : m, of the first, as of `Play`;
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
    """Return the tolerances at which a deployment is simulated again."""
    shares = TIGHTENING_FACTORS[:1] if formulation in {"penalty", "compliant"} else TIGHTENING_FACTORS
    looser = tolerance / shares[-1] < 0.99 * TIGHTEST_TOLERANCE
    return tuple(tolerance * share if looser else tolerance / share for share in shares)


def is_doubtful(check: DeploymentCheck) -> bool:
    """Return whether the ending of a deployment may depend on rounding, so that other simulations must confirm it."""
    return check.outcome in _DOUBTFUL_ENDINGS or check.loose_share >= LOOSE_STATES_SHARE


def tolerances_to_confirm(
    check: DeploymentCheck, tolerance: float, formulation: Formulation = "constrained"
) -> tuple[float, ...]:
    """Return the tolerances at which a doubtful deployment is simulated again: none where its loops say enough."""
    if check.outcome != "flat" and check.verdict != "collides" and check.loose_share >= LOOSE_STATES_SHARE:
        return ()
    return agreement_tolerances(tolerance, formulation)


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
    compiled: CompiledScene, tolerances: Sequence[float], *, method: str | None = None, certified: bool = True
) -> list[Deployment]:
    """Simulate a compiled scene at several tolerances, with as many steps as the tightest of an agreement may take."""
    steps = AGREEMENT_STEPS_FACTOR * MAX_DEPLOYMENT_STEPS[compiled.formulation]
    simulated = partial(simulate_compiled, compiled, method=method, certified=certified, max_steps=steps)
    return [simulated(tolerance=tolerance) for tolerance in tolerances]


def confirm_deployment(
    deployment: Deployment, *, method: str | None = None, tolerance: float = 1e-6
) -> Agreement | None:
    """Simulate a deployment at other tolerances and compare; None where its ending is none that they confirm."""
    if not is_doubtful(deployment.check):
        return None
    compiled, certified = deployment.compiled, deployment.clearance is not None
    tolerances = tolerances_to_confirm(deployment.check, tolerance, compiled.formulation)
    others = simulated_at(compiled, tolerances, method=method, certified=certified)
    agreement = agreement_of_checks([other.check for other in (deployment, *others)], (tolerance, *tolerances))
    if agreement is None:
        return None
    play = deployment.play if agreement.verdict == "deploys" else None
    gaps = clearances_of([deployment, *others], play)
    agreement = replace(agreement, errors=estimate_errors([deployment, *others], tolerance, gaps))
    if play is None:
        return agreement
    needed = play.needed_margin
    for other in others:
        needed = needed_margin_of(compiled, other.motion, needed)
    return replace(agreement, needed_margin=needed, least_gap=play.least_gap)


def agreement_of_checks(checks: Sequence[DeploymentCheck], tolerances: Sequence[float]) -> Agreement | None:
    """Compare checks at several tolerances, as `agreement_of_simulations` does."""
    pairs = zip(checks, tolerances, strict=True)
    return agreement_of_simulations(
        [SimulationFindings(at, check.outcome, check.verdict, check.end_time, check.loose_share) for check, at in pairs]
    )


def _flat(simulations: Sequence[SimulationFindings]) -> tuple[float | None, str]:
    """Return the common flat time of simulations, s, and a sentence; None where the times differ by over a tenth."""
    times = [simulation.time for simulation in simulations]
    if max(times) - min(times) > FLAT_TIME_TOLERANCE * sum(times) / len(times):
        return None, "flat, at a time on which tolerances disagree by more than a tenth"
    time, digits = _common(times)
    if digits.startswith("about"):
        digits += f" ({_each(simulations, [f'{short_number(one.time, 2)} s' for one in simulations])})"
    return time, f"flat after {digits}"


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
