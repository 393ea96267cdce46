"""Verdicts of the bench `stability`: a simulation is accurate, degraded by a bound, refused, or wrong."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.deployment.simulated_deployment import Deployment, deployment_of_motion, simulate_compiled
from hcsearch.springs.dynamics.time_integration import simulate_system
from hcsearch_bench.stability.sweeps import FEW, SweepCase
from hcsearch_bench.stability.truths import largest_energy, states

VERDICTS = ("accurate", "degraded", "refused", "wrong")
ALLOWED, ROUNDING = 100.0, 1e-11
"""A simulation is accurate when its error is at most so many tolerances, and what rounding leaves (rad)."""
SAFETY = 3.0
"""A bound is so many times the closure residual and the distance to a simulation that is ten times rougher."""
REFUSED = ("diverged", "out of steps", "jammed")
"""Outcomes by which a simulation says that it did not come to an answer."""


@dataclass(frozen=True)
class StabilityRow:
    """One simulation and the verdict on it.

    error : greatest distance of a fold angle from `truth`, or the closure residual where that is greater (rad);
        of `energy`, share of the largest energy. bound : of the error, from a rougher simulation; None where the
        error is within the tolerance. energy : error of the balance, share of the largest. gap : closure residual of
        the fold angles (rad, or gap over size).
    """

    sweep: str
    value: float
    subject: str
    formulation: str
    method: str
    tolerance: float
    verdict: str
    error: float | None
    bound: float | None
    truth: str
    energy: float | None
    gap: float | None
    outcome: str
    steps: int | None
    seconds: float
    reason: str


@dataclass(frozen=True)
class TallyRow:
    """How many simulations of a sweep got each verdict; worst : greatest error of accurate and degraded ones."""

    sweep: str
    scenes: int
    accurate: int
    degraded: int
    refused: int
    wrong: int
    worst: float | None
    seconds: float


def judge(case: SweepCase) -> StabilityRow:
    """Simulate a case and give the verdict."""
    begin = time.perf_counter()
    try:
        deployment = simulated(case)
    except HcsearchError as refusal:
        return _row(case, "refused", str(refusal), time.perf_counter() - begin)
    seconds = time.perf_counter() - begin
    if deployment.outcome in REFUSED:
        return _row(case, "refused", f"{deployment.outcome}: {deployment.reason}", seconds, deployment)
    if not finite(deployment):
        return _row(case, "wrong", "a number is not finite", seconds, deployment)
    return _compared(case, deployment, seconds)


def _compared(case: SweepCase, deployment: Deployment, seconds: float) -> StabilityRow:
    """The verdict on a simulation that claims an answer."""
    error = known_error(case, deployment)
    allowed = ALLOWED * case.tolerance + ROUNDING
    if error is not None and error <= allowed:
        return _row(case, "accurate", "", seconds, deployment, error)
    bound = bound_of(case, deployment, allowed)
    if error is None:  # nothing to compare to: fold angles cannot leave the stops
        bound = math.pi if bound is None else bound
        return _row(case, "degraded", f"within {bound:.1e}; no finer simulation ends", seconds, deployment, None, bound)
    if bound is None or not error <= bound:
        return _row(case, "wrong", f"off by more than bounded; {deployment.reason}", seconds, deployment, error, bound)
    return _row(case, "degraded", f"within {bound:.1e}", seconds, deployment, error, bound)


def simulated(case: SweepCase) -> Deployment:
    """The deployment of a case; a case that starts flat is simulated to its end, without stopping at flat."""
    keep = frozenset(OMISSIONS if case.whole else ())
    compiled = compile_scene(case.subject.linkage, case.scene, case.formulation, keep=keep)
    if not case.subject.flat:
        return simulate_compiled(compiled, method=case.method, tolerance=case.tolerance, certified=False, max_steps=FEW)
    begin = time.perf_counter()
    motion = simulate_system(
        compiled.system,
        case.subject.start_of(compiled),
        end=compiled.seconds,
        method=case.method,
        tolerance=case.tolerance,
        restitution=case.scene.restitution,
        max_steps=FEW,
    )
    return deployment_of_motion(compiled, motion, time.perf_counter() - begin, certified=False)


def finite(deployment: Deployment) -> bool:
    """Whether all numbers of a deployment are finite."""
    motion = deployment.motion
    parts = (deployment.angles, deployment.rates, motion.times, motion.a, motion.kinetic, motion.stored, motion.lost)
    return all(bool(np.isfinite(part).all()) for part in parts) and math.isfinite(motion.drift)


def known_error(case: SweepCase, deployment: Deployment) -> float | None:
    """Distance from the truth, or the closure residual of exact loops; None where the truth is not known."""
    try:
        error = case.truth.error(deployment)
    except HcsearchError:
        return None
    return error if case.formulation == "penalty" else max(error, gap_of(deployment))


def gap_of(deployment: Deployment) -> float:
    """Greatest closure residual of the fold angles: by the linkage, not by the simulation."""
    linkage = deployment.compiled.linkage
    if not linkage.loops:
        return 0.0
    _, angles = states(deployment)
    every = max(1, len(angles) // 50)
    return max(float(np.abs(linkage.closure(state)[0]).max()) for state in angles[::every])


def bound_of(case: SweepCase, deployment: Deployment, allowed: float) -> float | None:
    """A bound of the error by the distance to another simulation; None where none comes to an answer."""
    rough = next(filter(None, (_answer(other) for other in (case.rougher, case.stiffer) if other is not None)), None)
    if rough is None:
        return None
    end = float(rough.motion.times[-1])
    times, angles = states(deployment, end if rough.outcome != "at rest" else math.inf)
    q = rough.motion.at(np.minimum(times, end))
    others, _ = rough.compiled.of_hinges(q, np.zeros_like(q))
    return allowed + SAFETY * (float(np.abs(angles - others).max()) + gap_of(deployment))


def _answer(case: SweepCase) -> Deployment | None:
    """A simulation that comes to an answer."""
    try:
        deployment = simulated(case)
    except HcsearchError:
        return None
    return None if deployment.outcome in REFUSED or not finite(deployment) else deployment


def _row(
    case: SweepCase,
    verdict: str,
    reason: str,
    seconds: float,
    deployment: Deployment | None = None,
    error: float | None = None,
    bound: float | None = None,
) -> StabilityRow:
    known = deployment is not None and finite(deployment)
    return StabilityRow(
        sweep=case.sweep,
        value=case.value,
        subject=str(case.subject),
        formulation=case.formulation,
        method=case.method,
        tolerance=case.tolerance,
        verdict=verdict,
        error=error,
        bound=bound,
        truth=case.truth.name,
        energy=deployment.motion.drift / largest_energy(deployment.motion)
        if deployment is not None and known
        else None,
        gap=gap_of(deployment) if deployment is not None and known else None,
        outcome=deployment.outcome if deployment is not None else "-",
        steps=deployment.motion.steps if deployment is not None else None,
        seconds=seconds,
        reason=reason,
    )


def tally(rows: Sequence[StabilityRow]) -> list[TallyRow]:
    """A row a sweep, and one for all."""
    tallies = []
    for sweep in (*dict.fromkeys(row.sweep for row in rows), "all"):
        ours = [row for row in rows if sweep in {row.sweep, "all"}]
        numbers = {verdict: sum(row.verdict == verdict for row in ours) for verdict in VERDICTS}
        errors = [row.error for row in ours if row.error is not None and row.verdict in VERDICTS[:2]]
        tallies.append(
            TallyRow(sweep, len(ours), **numbers, worst=max(errors, default=None), seconds=sum(r.seconds for r in ours))
        )
    return tallies
