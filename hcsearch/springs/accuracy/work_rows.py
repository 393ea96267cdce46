"""Error against run time of a scene: simulations by all methods over decades of tolerance, beside a reference."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, TypeVar

from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import FORMULATIONS, INTEGRATORS, Ending, Formulation, Integrator
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.accuracy.reference_motions import (
    NO_ANSWER,
    ReferenceMotion,
    affordable_steps,
    compared_references,
    is_stiff,
    reference_motion,
    reference_run,
)
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, CompiledScene, compile_scene
from hcsearch.springs.deployment.error_estimates import angle_distances, comparison_times
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS, METHODS, methods_of
from hcsearch.springs.deployment.simulated_deployment import (
    MIN_BALANCE_ENERGY,
    Deployment,
    simulate_compiled,
)
from hcsearch.springs.dynamics.time_integration import Motion
from hcsearch.system.terminal import tolerance_text

TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
"""Tolerances of the simulations that are compared, the coarsest first."""
DEFAULT_TOLERANCE = 1e-6
"""The tolerance of `deploy` unless another is given."""
DEFAULT_GROWTH = 2.0
"""Assumed ratio of the times of a simulation at two decades of tolerance, before two are measured."""
SUFFICIENT_SHARE = 0.1
"""A reference suffices where its doubt is at most this share of the least error that it measures."""

Announce = Callable[[str], None]
"""Called with the words of each simulation that begins."""


@dataclass(frozen=True)
class WorkRow:
    """A simulation by one method at one tolerance.

    outcome : None where it was not tried. angle_error : greatest error of a fold angle until `ReferenceMotion.until`,
    rad. below : whether the reference cannot tell that error, or the one in time, from its own doubt. time_error :
    error of the flat time, s. drift : greatest error of the energy balance; lost_error : error of the energy lost in
    dampers, to friction and at stops; both as shares of the largest energy. opening : greatest closure residual, rad or
    gap over size. seconds : processor time, median of `runs`. default : whether `deploy` takes this setting by
    default.
    """

    formulation: Formulation
    method: Integrator
    tolerance: float
    outcome: Ending | None = None
    angle_error: float | None = None
    below: bool = False
    time_error: float | None = None
    drift: float | None = None
    lost_error: float | None = None
    opening: float | None = None
    seconds: float | None = None
    runs: int = 0
    steps: int | None = None
    rejected: int | None = None
    evaluations: int | None = None
    default: bool = False
    note: str = ""

    @property
    def options(self) -> str:
        """The options of `hcsearch deploy` for this setting."""
        tolerance = tolerance_text(self.tolerance)
        return f"--formulation {self.formulation} --method {self.method} --tolerance {tolerance}"


@dataclass(frozen=True)
class FormulationWork:
    """All simulations in one formulation, and the reference that they are compared with.

    model_angle, model_time : error of the formulation itself: greatest distance of a fold angle (rad), and distance of
    the flat times (s), between its reference and that of the constrained formulation up to `model_until` (s); None
    without one. refusal : why the formulation does not apply, or has no reference; there are no rows then.
    """

    formulation: Formulation
    reference: ReferenceMotion | None
    rows: tuple[WorkRow, ...]
    model_angle: float | None = None
    model_time: float | None = None
    model_until: float | None = None
    refusal: str = ""

    @property
    def least_error(self) -> float | None:
        """The least error of the angles in the table, rad."""
        errors = [row.angle_error for row in self.rows if row.angle_error is not None]
        return min(errors, default=None)

    @property
    def suffices(self) -> bool:
        """Whether the references agree to a tenth of the least error in the table."""
        doubt = None if self.reference is None else self.reference.angle_doubt
        return doubt is not None and (self.least_error is None or doubt <= SUFFICIENT_SHARE * self.least_error)

    def cheapest(self, angle: float) -> WorkRow | None:
        """Return the row with the least processor time of those with at most a given error of the angles (rad).

        An error that the reference cannot measure counts as the doubt of the reference.
        """
        doubt = 0.0 if self.reference is None else self.reference.angle_doubt or 0.0
        usable = [
            row
            for row in self.rows
            if row.angle_error is not None and max(row.angle_error, doubt if row.below else 0.0) <= angle
        ]
        return min(usable, key=lambda row: row.seconds or 0.0, default=None)


def work_of_formulations(
    linkage: Linkage,
    setup: Setup,
    formulations: Sequence[Formulation] = FORMULATIONS,
    *,
    tolerances: Sequence[float] = TOLERANCES,
    seconds: float = 2.0,
    announce: Announce = lambda _words: None,
) -> Iterator[FormulationWork]:
    """Measure error against run time in each formulation; seconds : greatest time of one simulation, s, about."""
    constrained: ReferenceMotion | None = None
    for formulation in formulations:
        if formulation in {"penalty", "compliant"} and not linkage.loops:
            yield FormulationWork(formulation, None, (), refusal="the array has no loops that springs could close")
            continue
        try:
            compiled = compile_scene(linkage, setup, formulation)
            whole = compile_scene(linkage, setup, formulation, keep=frozenset(OMISSIONS))
            announce(f"{formulation}, reference")
            run = partial(simulate_compiled, compiled, certified=False)
            usual = run(max_steps=affordable_steps(run, seconds))
            end = float(usual.motion.times[-1]) or compiled.seconds
            reference = reference_motion(compiled, whole, end=end, seconds=seconds)
        except HcsearchError as refusal:
            yield FormulationWork(formulation, None, (), refusal=str(refusal))
            continue
        rows = tuple(_rows(compiled, reference, tolerances, seconds, announce))
        work = FormulationWork(formulation, reference, rows)
        if formulation == "constrained":
            constrained = reference
        elif constrained is not None:
            work = replace(work, **_model_difference(reference, constrained))
        yield work


def _model_difference(reference: ReferenceMotion, constrained: ReferenceMotion) -> dict[str, Any]:
    """Return how far a formulation's own reference is from the constrained one, as fields of `FormulationWork`."""
    until = min(reference.until, constrained.until)
    one, other = reference.first.deployment, constrained.first.deployment
    distances = angle_distances(one, other, comparison_times(other.motion.times, until))
    ours, theirs = reference.flat_time, constrained.flat_time
    apart = None if ours is None or theirs is None else abs(ours - theirs)
    return {"model_angle": float(distances.max(initial=0.0)), "model_time": apart, "model_until": until}


def _rows(
    compiled: CompiledScene, reference: ReferenceMotion, tolerances: Sequence[float], seconds: float, announce: Announce
) -> Iterator[WorkRow]:
    """Simulate by each method at rising accuracy, until a simulation would take too long."""
    formulation = compiled.formulation
    chosen = methods_of(formulation)[is_stiff(compiled)]
    for method in INTEGRATORS:
        taken: list[float] = []
        stopped = ""
        for tolerance in tolerances:
            default = method == chosen and tolerance == DEFAULT_TOLERANCE
            blank = WorkRow(formulation, method, tolerance, default=default)
            if taken and (stopped or taken[-1] * _growth(taken) > seconds):
                yield replace(blank, note=f"not tried: {stopped or _too_long(seconds)}")
                continue
            announce(f"{formulation}, {method} at {tolerance_text(tolerance)}")
            row = measured_row(compiled, reference, blank, seconds)
            taken.append(row.seconds or 0.0)
            stopped = f"out of steps at {tolerance_text(tolerance)}" if row.outcome == "out of steps" else ""
            yield row


def _too_long(seconds: float) -> str:
    return f"would take more than {seconds:g} s"


def _growth(taken: Sequence[float]) -> float:
    """Return by what factor the next simulation is expected to take longer than the last one."""
    return max(1.0, taken[-1] / taken[-2]) if len(taken) > 1 and taken[-2] else DEFAULT_GROWTH


def measured_row(
    compiled: CompiledScene, reference: ReferenceMotion, blank: WorkRow, limit: float, *, repeated: bool = True
) -> WorkRow:
    """Fill in a row: simulate once for the errors, and again for the median of the processor time, if repeated.

    limit : greatest time of the simulation, s, about. What comes to no answer is not repeated.
    """
    run = partial(simulate_compiled, compiled, method=blank.method, tolerance=blank.tolerance, certified=False)
    most, affordable = MAX_DEPLOYMENT_STEPS[compiled.formulation], affordable_steps(run, limit)
    run = partial(run, max_steps=min(most, affordable))
    begin = time.process_time()
    deployment = run()
    seconds, runs = time.process_time() - begin, 1
    if deployment.outcome == "out of steps" and affordable < most:
        return replace(blank, seconds=limit, note=_too_long(limit))
    if repeated and deployment.outcome not in NO_ANSWER:
        deployment, seconds, runs = processor_seconds(run)
    motion = deployment.motion
    return replace(
        blank,
        outcome=deployment.outcome,
        seconds=seconds,
        runs=runs,
        steps=motion.steps,
        rejected=motion.rejected,
        evaluations=motion.evaluations,
        **row_errors(deployment, reference),
    )


def row_errors(deployment: Deployment, reference: ReferenceMotion) -> dict[str, Any]:
    """Return the errors of a deployment beside a reference, as fields of `WorkRow`."""
    motion, exact = deployment.motion, reference.first.deployment
    angle = reference.angle_error(deployment)
    if angle is None:
        return {"note": deployment.reason}
    time_error = None
    if reference.flat_time is not None and deployment.flat_time is not None:
        time_error = abs(deployment.flat_time - reference.flat_time)
    lost_error = None
    if reference.whole and deployment.outcome == exact.outcome:
        largest = max(exact.motion.largest_energy, MIN_BALANCE_ENERGY)
        lost_error = abs(_lost(motion) - _lost(exact.motion)) / largest
    note = "" if deployment.outcome == exact.outcome or not reference.whole else f"the reference is {exact.outcome}"
    return {
        "angle_error": angle,
        "below": reference.angle_doubt is not None and angle <= reference.angle_doubt,
        "time_error": time_error,
        "drift": motion.drift / max(motion.largest_energy, MIN_BALANCE_ENERGY),
        "lost_error": lost_error,
        "opening": deployment.opening,
        "note": deployment.reason if deployment.outcome in NO_ANSWER else note,
    }


def _lost(motion: Motion) -> float:
    """Return the energy lost until the end of a motion, J."""
    return float(motion.damped[-1] + motion.lost[-1])


QUICK_TOLERANCES = TOLERANCES[:6]
"""Tolerances of the simulations that are compared."""
QUICK_REFERENCES = (1e-11, 1e-10, 1e-9)
"""Tolerances of the reference; the first one that comes to an end is taken."""
QUICK_RUN_SECONDS = 0.1
"""Greatest time of a simulation, s, about."""


def quick_work(deployment: Deployment) -> FormulationWork:
    """Measure error against run time of the method that a deployment takes by default, with one run at each tolerance.

    The reference is the same method at a tighter tolerance, which nothing confirms; `work_of_formulations` has
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


T = TypeVar("T")


class Repeats(NamedTuple):
    """How often runs are repeated.

    usual : number of runs; short : number where the first takes less than `short_seconds`. enough_seconds : total time
    after which no further run begins.
    """

    usual: int
    short: int
    short_seconds: float
    enough_seconds: float


PROCESSOR_REPEATS = Repeats(usual=3, short=15, short_seconds=0.02, enough_seconds=0.5)
"""Repeats of the simulations of a table of methods."""


def median_of_runs(run: Callable[[], float], repeats: Repeats) -> tuple[float, int]:
    """Return the median of the seconds of runs, and how many there were; run : returns its seconds."""
    times = [run()]
    wanted = repeats.short if times[0] < repeats.short_seconds else repeats.usual
    while len(times) < wanted and sum(times) < repeats.enough_seconds:
        times.append(run())
    return statistics.median(times), len(times)


def processor_seconds(run: Callable[[], T], repeats: Repeats = PROCESSOR_REPEATS) -> tuple[T, float, int]:
    """Return the result of a run, the median of its processor time (s) after a first run, and the number of runs."""
    results = [run()]

    def timed() -> float:
        begin = time.process_time()
        results[:] = [run()]
        return time.process_time() - begin

    seconds, runs = median_of_runs(timed, repeats)
    return results[0], seconds, runs
