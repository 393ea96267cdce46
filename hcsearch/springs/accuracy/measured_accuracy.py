"""The accuracy of the deployment of one subject, measured: the result of `hcsearch accuracy`.

It has error bars, and error against run time as plain data, a table and a plot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.vocabulary import finite_or_none
from hcsearch.springs.accuracy.reference_motions import ReferenceMotion, ReferenceRun
from hcsearch.springs.accuracy.work_rows import FormulationWork, WorkRow
from hcsearch.springs.deployment.agreement import SimulatedCheck, simulated_at, tighter_simulations
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch.springs.deployment.error_estimates import (
    ErrorEstimates,
    angle_distances,
    clearances_of,
    comparison_times,
    error_facts,
    estimate_errors,
    parting_time,
)
from hcsearch.springs.deployment.omission_savings import OmissionSaving, saving_facts
from hcsearch.springs.deployment.simulated_deployment import Deployment, simulate_compiled
from hcsearch.system.figures import figure_for, line_style, set_title
from hcsearch.system.terminal import short_number

if TYPE_CHECKING:
    import pandas as pd

    from hcsearch.system.figures import Axes

_COLUMNS = {
    "angle_error": "angle_error_rad",
    "time_error": "time_error_s",
    "seconds": "processor_s",
    "drift": "energy_drift",
    "lost_error": "energy_lost_error",
    "opening": "closure_gap",
}
"""Keys of a row in data that differ from the names of its fields; energies are shares of the largest one."""
MIN_PLOTTED_ERROR = 1e-16
"""Smaller errors (rad) are drawn as this one."""


def work_facts(work: FormulationWork) -> dict[str, Any]:
    """Return the simulations in one formulation as plain data; keys name their units."""
    return {
        "formulation": work.formulation,
        "refusal": work.refusal or None,
        "reference": None if work.reference is None else _reference_facts(work.reference),
        "suffices": work.suffices,
        "model_angle_rad": finite_or_none(work.model_angle),
        "model_time_s": work.model_time,
        "model_until_s": work.model_until,
        "rows": [work_row_facts(row) for row in work.rows],
    }


def _reference_facts(reference: ReferenceMotion) -> dict[str, Any]:
    return {
        "first": _run_facts(reference.first),
        "second": None if reference.second is None else _run_facts(reference.second),
        "until_s": reference.until,
        "angle_doubt_rad": finite_or_none(reference.angle_doubt),
        "time_doubt_s": reference.time_doubt,
        "parting_s": reference.parting,
        "flat_time_s": reference.flat_time,
    }


def _run_facts(run: ReferenceRun) -> dict[str, Any]:
    motion = run.deployment.motion
    return {
        "method": run.method,
        "tolerance": run.tolerance,
        "outcome": run.deployment.outcome,
        "end_s": float(motion.times[-1]),
        "steps": motion.steps,
    }


def work_row_facts(row: WorkRow) -> dict[str, Any]:
    """Return a row as plain data."""
    return {_COLUMNS.get(name, name): finite_or_none(value) for name, value in asdict(row).items()}


def work_table(works: Sequence[FormulationWork]) -> pd.DataFrame:
    """Return all rows as a table."""
    texts = ("formulation", "method", "outcome", "note")
    return facts_table([work_row_facts(row) for work in works for row in work.rows], texts)


def facts_table(rows: Sequence[dict[str, Any]], texts: Sequence[str]) -> pd.DataFrame:
    """Return rows of plain data as a table: texts, empty for None, and numbers, NaN for None, also in whole columns."""
    import pandas as pd  # noqa: PLC0415 - only where a table is wanted

    table = pd.DataFrame(rows)
    for name in table:
        if name in texts:
            table[name] = ["" if value is None else str(value) for value in table[name]]
        elif table[name].dtype == object:
            table[name] = table[name].astype(float)
    return table


def reference_sentence(work: FormulationWork) -> str:
    """Return a sentence on the reference of the simulations in a formulation, and how far it is exact."""
    reference = work.reference
    if reference is None:
        return work.refusal
    second, until = reference.second, f"compared until {short_number(reference.until)} s"
    if second is None or reference.angle_doubt is None:
        return f"reference {reference.first.setting}, which nothing confirms; {until}"
    doubt = f"{reference.angle_doubt:.1e} rad"
    if reference.time_doubt is not None:
        doubt += f" and {reference.time_doubt:.1e} s"
    text = f"reference {reference.first.setting}; {second.setting} with nothing left out agrees to {doubt}; {until}"
    if reference.parting is not None:
        text += f"; both part at {short_number(reference.parting)} s, from where the motion is not reproducible"
    if not work.suffices:
        text += f"; they do not agree to a tenth of the least error: what is below {reference.angle_doubt:.1e} rad "
        text += "cannot be resolved"
    return text


def model_sentence(work: FormulationWork) -> str:
    """Return a sentence on how far a formulation differs from the constrained one; empty without a comparison."""
    if work.model_angle is None or work.model_until is None:
        return ""
    time = "" if work.model_time is None else f", its flat time by {work.model_time:.2g} s"
    until = f"until {short_number(work.model_until)} s"
    return f"its reference differs from the constrained one by {work.model_angle:.2g} rad {until}{time}"


def draw_work(works: Sequence[FormulationWork], path: str, title: str) -> None:
    """Draw the error of the angles against processor time, a plot a formulation and a curve a method.

    The default setting has a ring; a dotted line is the doubt of the reference.
    """
    shown = [work for work in works if any(row.angle_error is not None for row in work.rows)]
    with figure_for(path, (1.5 + 4.5 * max(1, len(shown)), 5)) as figure:
        plots = figure.subplots(1, max(1, len(shown)), squeeze=False)[0]
        for axes, work in zip(plots, shown, strict=False):
            _draw_one(axes, work)
        set_title(plots[0], title)
        if shown:
            handles = {str(line.get_label()): line for axes in plots for line in axes.get_legend_handles_labels()[0]}
            figure.legend(handles=list(handles.values()), loc="outside lower center", ncols=3, fontsize="small")


def draw_work_curve(
    axes: Axes, points: Sequence[tuple[float, float]], label: str, number: int, marker: str = "o"
) -> None:
    """Draw a curve of error against time, both on logarithmic scales; points : time and error of each run."""
    style: dict[str, Any] = {"marker": marker, "ms": 4, "label": label, **line_style(number)}
    axes.plot([at for at, _ in points], [max(error, MIN_PLOTTED_ERROR) for _, error in points], **style)
    axes.set(xscale="log", yscale="log")


def _draw_one(axes: Axes, work: FormulationWork) -> None:
    methods = list(dict.fromkeys(row.method for row in work.rows))
    for number, method in enumerate(methods):
        points = [
            (1e3 * row.seconds, row.angle_error)
            for row in work.rows
            if row.method == method and row.angle_error is not None and row.seconds
        ]
        if points:
            draw_work_curve(axes, points, method, number)
    for row in work.rows:
        if row.default and row.angle_error is not None and row.seconds:
            ring: dict[str, Any] = {"marker": "o", "ms": 12, "mfc": "none", "mec": "black", "linestyle": "none"}
            axes.plot([1e3 * row.seconds], [max(row.angle_error, MIN_PLOTTED_ERROR)], label="default", **ring)
    if work.reference is not None and work.reference.angle_doubt:
        axes.axhline(work.reference.angle_doubt, color="grey", linestyle=":", label="doubt of the reference")
    axes.set(xlabel="processor time, ms", ylabel=f"error of fold angles, rad, {work.formulation}")


PERTURBATION = 1e-12
"""Change of the fold angles (rad) at the start of a perturbed motion: about the rounding error there."""


@dataclass(frozen=True)
class DefaultErrors:
    """The default deployment, with estimates of its errors.

    estimates : None where nothing can be estimated. perturbed_until : time (s) from which on a start that differs by
    `PERTURBATION` changes fold angles by more than `PARTING_ANGLE`; None if it never does.
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


@dataclass(frozen=True, repr=False)
class MeasuredAccuracy:
    """The accuracy of a deployment by each method and formulation, beside references.

    Parameters
    ----------
    name
        The name of the folding or assembly.
    scene
        The name of the scene.
    works
        The simulations of each formulation, with their errors and processor time.
    errors
        The deployment by the default setting of the first formulation, with estimates of its errors.
    omitted
        The savings and the effect of each omission of that scene, put back in turn, and of all of them last.
    wanted
        The greatest error of the fold angles for which the cheapest setting is wanted, rad; None without one.
    """

    name: str
    scene: str
    works: tuple[FormulationWork, ...]
    errors: DefaultErrors
    omitted: tuple[OmissionSaving, ...] = ()
    wanted: float | None = None

    @property
    def cheapest(self) -> WorkRow | None:
        """The cheapest setting for the wanted error in the first formulation; None where no setting has it."""
        return None if self.wanted is None or not self.works else self.works[0].cheapest(self.wanted)

    def facts(self) -> dict[str, Any]:
        """All results as plain data, as `hcsearch accuracy --json` prints them; keys name their units."""
        cheapest = self.cheapest
        return {
            "subject": self.name,
            "scene": self.scene,
            "errors": self._error_facts(),
            "left_out": [asdict(saving.omission) | saving_facts(saving) for saving in self.omitted],
            "wanted_error_rad": self.wanted,
            "cheapest": None if cheapest is None else work_row_facts(cheapest) | {"options": cheapest.options},
            "formulations": [work_facts(work) for work in self.works],
        }

    def _error_facts(self) -> dict[str, Any] | None:
        """The estimates of errors as plain data, with what the reference says; None without estimates."""
        errors = self.errors
        if errors.estimates is None:
            return None
        row = next((row for work in self.works[:1] for row in work.rows if row.default), None)
        measured = {name: None if row is None else getattr(row, name) for name in ("angle_error", "time_error")}
        return error_facts(errors.estimates) | {
            "perturbed_until_s": errors.perturbed_until,
            "measured_angles_rad": measured["angle_error"],
            "measured_flat_time_s": measured["time_error"],
        }

    def table(self) -> pd.DataFrame:
        """A pandas table of all simulations, as `hcsearch accuracy --output` writes it."""
        return work_table(self.works)

    def picture(self, path: str) -> None:
        """Draw error against processor time into a file .svg, .png or .pdf."""
        draw_work(self.works, path, f"{self.name}, scene {self.scene}: error against processor time")

    def __repr__(self) -> str:
        return f"<accuracy of {self.name}, scene {self.scene}>"
