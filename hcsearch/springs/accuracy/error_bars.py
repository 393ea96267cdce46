"""Error bars of the numbers that users read of a deployment by the default setting."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hcsearch.springs.deployment.agreement import SimulatedCheck, simulated_at, tighter_simulations
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.error_estimates import (
    ErrorEstimates,
    angle_distances,
    clearances_of,
    comparison_times,
    estimate_errors,
    parting_time,
)
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled

PERTURBATION = 1e-12
"""Greatest change of a fold angle at the start by which a motion is tested (rad): about what rounding leaves there."""


@dataclass(frozen=True)
class DefaultErrors:
    """The default deployment, with estimates of its errors.

    estimates : None where nothing can be estimated. perturbed_until : s, from which on a start that differs by
    `PERTURBATION` leads to fold angles that differ by more than `PARTING_ANGLE`; None if it never does.
    """

    deployment: Deployment
    estimates: ErrorEstimates | None
    perturbed_until: float | None


def default_errors(compiled: CompiledScene, tolerance: float) -> DefaultErrors:
    """Simulate a scene at the default tolerance, at tighter ones and from a perturbed start, and estimate errors."""
    first = simulate_compiled(compiled, tolerance=tolerance)
    simulated = SimulatedCheck(tolerance, first.check, first)
    others = tighter_simulations(simulated, partial(simulated_at, compiled), compiled.formulation)
    deployments = [first, *(other.deployment for other in others if other.deployment is not None)]
    estimates = estimate_errors(deployments, tolerance, clearances_of(deployments, first.play))
    turned = simulated_at(perturbed(compiled), tolerance, certified=False).deployment
    assert turned is not None
    return DefaultErrors(first, estimates, _parting(first, turned))


def perturbed(compiled: CompiledScene) -> CompiledScene:
    """Return a scene whose start differs by `PERTURBATION` in each joint of a hinge, with alternating signs."""
    signs = np.where(np.arange(len(compiled.start)) % 2, -1.0, 1.0)
    return replace(compiled, start=compiled.start - PERTURBATION * signs * compiled.hinged)


def _parting(one: Deployment, other: Deployment) -> float | None:
    if min(len(one.motion.times), len(other.motion.times)) < 2:
        return None
    times = comparison_times(one.motion.times, float(min(one.motion.times[-1], other.motion.times[-1])))
    return parting_time(times, angle_distances(one, other, times))
