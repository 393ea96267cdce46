"""Verdicts of the bench `stability`: a simulation is accurate, degraded by a bound, refused, or wrong."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.accuracy.reference_motions import NO_ANSWER
from hcsearch.springs.accuracy.stability_points import (
    JUDGEMENTS,
    JudgedDeployment,
    Judgement,
    all_finite,
    closure_of_angles,
    distance_from,
    judge_deployment,
)
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.deployment.simulated_deployment import Deployment, deployment_of_motion, simulate_compiled
from hcsearch.springs.dynamics.time_integration import simulate_system
from hcsearch_bench.stability.sweeps import FEW, SweepCase
from hcsearch_bench.stability.truths import largest_energy


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
    verdict: Judgement
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
        return _row(case, JudgedDeployment("refused", str(refusal)), time.perf_counter() - begin)
    seconds = time.perf_counter() - begin
    valid = deployment.outcome not in NO_ANSWER and all_finite(deployment)
    error = known_error(case, deployment) if valid else None
    judged = judge_deployment(deployment, case.tolerance, error, partial(rough_distance, case, deployment))
    return _row(case, judged, seconds, deployment)


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


def known_error(case: SweepCase, deployment: Deployment) -> float | None:
    """Distance from the truth, or the closure residual of exact loops; None where the truth is not known."""
    try:
        error = case.truth.error(deployment)
    except HcsearchError:
        return None
    return error if case.formulation == "penalty" else max(error, closure_of_angles(deployment))


def rough_distance(case: SweepCase, deployment: Deployment) -> float | None:
    """The distance from a rougher simulation, or a stiffer one, rad; None where none comes to an answer."""
    rough = next(filter(None, (_answer(other) for other in (case.rougher, case.stiffer) if other is not None)), None)
    return None if rough is None else distance_from(deployment, rough)


def _answer(case: SweepCase) -> Deployment | None:
    """A simulation that comes to an answer."""
    try:
        deployment = simulated(case)
    except HcsearchError:
        return None
    return None if deployment.outcome in NO_ANSWER or not all_finite(deployment) else deployment


def _row(
    case: SweepCase, judged: JudgedDeployment, seconds: float, deployment: Deployment | None = None
) -> StabilityRow:
    known = deployment is not None and all_finite(deployment)
    return StabilityRow(
        sweep=case.sweep,
        value=case.value,
        subject=str(case.subject),
        formulation=case.formulation,
        method=case.method,
        tolerance=case.tolerance,
        verdict=judged.judgement,
        error=judged.error,
        bound=judged.bound,
        truth=case.truth.name,
        energy=deployment.motion.drift / largest_energy(deployment.motion)
        if deployment is not None and known
        else None,
        gap=closure_of_angles(deployment) if deployment is not None and known else None,
        outcome=deployment.outcome if deployment is not None else "-",
        steps=deployment.motion.steps if deployment is not None else None,
        seconds=seconds,
        reason=judged.reason,
    )


def tally(rows: Sequence[StabilityRow]) -> list[TallyRow]:
    """A row a sweep, and one for all."""
    tallies = []
    for sweep in (*dict.fromkeys(row.sweep for row in rows), "all"):
        ours = [row for row in rows if sweep in {row.sweep, "all"}]
        numbers = {verdict: sum(row.verdict == verdict for row in ours) for verdict in JUDGEMENTS}
        errors = [row.error for row in ours if row.error is not None and row.verdict in JUDGEMENTS[:2]]
        tallies.append(
            TallyRow(sweep, len(ours), **numbers, worst=max(errors, default=None), seconds=sum(r.seconds for r in ours))
        )
    return tallies
