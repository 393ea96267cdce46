"""Judgements on simulations beside a truth: accurate, degraded within a bound, refused, or wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple, get_args

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.accuracy.reference_motions import NO_ANSWER
from hcsearch.springs.deployment.simulated_deployment import Deployment

Judgement = Literal["accurate", "degraded", "refused", "wrong"]
JUDGEMENTS: tuple[Judgement, ...] = get_args(Judgement)
"""`accurate`: the error is at most `ACCURATE_TOLERANCES` tolerances; `degraded`: within a bound by a rougher
simulation; `refused`: the simulation itself says that it has no answer; `wrong`: it claims one, but the error is beyond
the bound or a number is not finite."""
ACCURATE_TOLERANCES, ANGLE_FLOOR = 100.0, 1e-11
"""A simulation is accurate when its error is at most so many tolerances, and what rounding leaves (rad)."""
BOUND_FACTOR = 3.0
"""A bound is so many times the closure residual and the distance to a simulation that is ten times rougher."""
MAX_JUDGED_STATES = 200
"""Greatest number of states of a simulation that are compared with a rougher one."""
MAX_CLOSURE_STATES = 50
"""Number of states at which the closure residual is computed, about."""
DeploymentBound = Callable[[], float | None]
"""Computes the distance of a deployment from a rougher one, rad; None where no rougher one comes to an answer."""


class JudgedDeployment(NamedTuple):
    """The judgement on a simulation with its reason; error, bound : rad, as far as they are known and needed."""

    judgement: Judgement
    reason: str
    error: float | None = None
    bound: float | None = None


def judge_deployment(
    deployment: Deployment, tolerance: float, error: float | None, distance: DeploymentBound
) -> JudgedDeployment:
    """Judge a simulation by its error (rad), None where that is not known; distance : from a rougher simulation."""
    if deployment.outcome in NO_ANSWER:
        return JudgedDeployment("refused", f"{deployment.outcome}: {deployment.reason}")
    if not all_finite(deployment):
        return JudgedDeployment("wrong", "a number is not finite")
    allowed = ACCURATE_TOLERANCES * tolerance + ANGLE_FLOOR
    if error is not None and error <= allowed:
        return JudgedDeployment("accurate", "", error)
    rough = distance()
    bound = None if rough is None else allowed + BOUND_FACTOR * rough
    if error is None:  # nothing to compare to: fold angles cannot leave the stops
        bound = math.pi if bound is None else bound
        return JudgedDeployment("degraded", f"within {bound:.1e}; no finer simulation ends", None, bound)
    if bound is None or not error <= bound:
        return JudgedDeployment("wrong", f"off by more than bounded; {deployment.reason}", error, bound)
    return JudgedDeployment("degraded", f"within {bound:.1e}", error, bound)


def all_finite(deployment: Deployment) -> bool:
    """Return whether all numbers of a deployment are finite."""
    motion = deployment.motion
    parts = (deployment.angles, deployment.rates, motion.times, motion.a, motion.kinetic, motion.stored, motion.lost)
    return all(bool(np.isfinite(part).all()) for part in parts) and math.isfinite(motion.drift)


def closure_of_angles(deployment: Deployment) -> float:
    """Return the greatest closure residual of the fold angles: by the linkage, not by the simulation."""
    linkage = deployment.compiled.linkage
    if not linkage.loops:
        return 0.0
    _, angles = judged_states(deployment)
    every = max(1, len(angles) // MAX_CLOSURE_STATES)
    return max(float(np.abs(linkage.closure(state)[0]).max()) for state in angles[::every])


def judged_states(deployment: Deployment, last: float = math.inf) -> tuple[Reals, Reals]:
    """Return times at the ends of steps, up to `last` (s), and the fold angles there."""
    times, angles = deployment.motion.times, deployment.angles
    if deployment.outcome == "at rest":  # it says that nothing moves until the end
        times, angles = np.append(times, deployment.compiled.seconds), np.vstack([angles, angles[-1]])
    count = int(np.searchsorted(times, last, side="right"))
    chosen = np.unique(np.linspace(0, count - 1, min(count, MAX_JUDGED_STATES)).round().astype(int))
    return times[chosen], angles[chosen]


def distance_from(deployment: Deployment, rough: Deployment) -> float:
    """Return the greatest distance of a fold angle from a rougher simulation, plus the closure residual, rad."""
    end = float(rough.motion.times[-1])
    times, angles = judged_states(deployment, end if rough.outcome != "at rest" else math.inf)
    q = rough.motion.at(np.minimum(times, end))
    others, _ = rough.compiled.of_hinges(q, np.zeros_like(q))
    return float(np.abs(angles - others).max()) + closure_of_angles(deployment)
