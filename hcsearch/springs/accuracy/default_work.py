"""Error against run time of a deployment by its default method, in as little time as a page may take."""

from __future__ import annotations

from hcsearch.springs.accuracy.reference_motions import compared_references, reference_run
from hcsearch.springs.accuracy.work_rows import (
    DEFAULT_TOLERANCE,
    TOLERANCES,
    FormulationWork,
    WorkRow,
    measured_row,
)
from hcsearch.springs.deployment.outcomes import METHODS
from hcsearch.springs.deployment.simulated_deployment import Deployment

QUICK_TOLERANCES = TOLERANCES[:6]
"""Tolerances of the simulations that are compared."""
QUICK_REFERENCES = (1e-11, 1e-10, 1e-9)
"""Tolerances of the reference; the first one that comes to an end is taken."""
QUICK_RUN_SECONDS = 0.1
"""Greatest time of a simulation, s, about."""


def quick_work(deployment: Deployment) -> FormulationWork:
    """Measure error against run time of the method that a deployment takes by default, with one run at each tolerance.

    The reference is of the same method at a tighter tolerance, which nothing confirms; `work_of_formulations` has
    references of other methods.
    """
    compiled, motion = deployment.compiled, deployment.motion
    method = METHODS[compiled.formulation][motion.stiff_time == 0.0]
    settings = tuple((method, tolerance) for tolerance in QUICK_REFERENCES)
    first = reference_run(compiled, settings, float(motion.times[-1]) or compiled.seconds, QUICK_RUN_SECONDS)
    if first is None:
        return FormulationWork(
            compiled.formulation, None, (), refusal="no simulation at a tighter tolerance has a step"
        )
    reference = compared_references(first, None)
    blanks = [
        WorkRow(compiled.formulation, method, tolerance, default=tolerance == DEFAULT_TOLERANCE)
        for tolerance in QUICK_TOLERANCES
    ]
    rows = [measured_row(compiled, reference, blank, QUICK_RUN_SECONDS, repeated=False) for blank in blanks]
    return FormulationWork(compiled.formulation, reference, tuple(rows))
