"""The accuracy of a deployment on a page: error against run time, and what its simulation leaves out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hcsearch.basics.vocabulary import percent
from hcsearch.springs.accuracy.measured_accuracy import MIN_PLOTTED_ERROR, reference_sentence
from hcsearch.springs.accuracy.work_rows import QUICK_TOLERANCES, FormulationWork, WorkRow, quick_work
from hcsearch.springs.deployment.compiled_scene import Omission
from hcsearch.springs.deployment.omission_savings import saved_share
from hcsearch.springs.deployment.simulated_deployment import Deployment
from hcsearch.system.terminal import tolerance_text
from hcsearch.system.work_steps import work_step
from hcsearch.web.report.plots import DrawnPlot, PlotCurve, PlotMark, draw_plot


@dataclass(frozen=True)
class ShownAccuracy:
    """The accuracy of a deployment; `command` measures it more closely.

    summary : the error of the default setting and the share of work saved, in words. plot : of error against run time;
    None where nothing could be compared. omissions : what the simulation leaves out.
    """

    summary: str
    plot: DrawnPlot | None
    omissions: Sequence[Omission]
    command: str


@work_step("measuring the accuracy")
def accuracy_of_deployment(deployment: Deployment, command: str) -> ShownAccuracy:
    """Measure the accuracy of a deployment for a page, with one run of each setting."""
    compiled, check = deployment.compiled, deployment.check
    work = quick_work(deployment)
    default = next((row for row in work.rows if row.default and row.angle_error is not None), None)
    saved = percent(saved_share(compiled, check.evaluations, check.looks))
    error = "" if default is None else f"fold angles within {default.angle_error:.0e} rad, "
    return ShownAccuracy(f"{error}{saved} of the work left out", _plot(work), compiled.omissions, command)


def _plot(work: FormulationWork) -> DrawnPlot | None:
    curves, marks = [], []
    for method in dict.fromkeys(row.method for row in work.rows):
        measured = [row for row in work.rows if row.method == method and _point(row) is not None]
        points = [point for row in measured if (point := _point(row)) is not None]
        if points:
            curves.append(PlotCurve(method, [x for x, _ in points], [y for _, y in points], method))
        marks += [PlotMark(1e3 * row.seconds, "default") for row in measured if row.default and row.seconds]
    if not curves:
        return None
    least = min(y for curve in curves for y in curve.y if y is not None)
    tolerances = " to ".join(tolerance_text(QUICK_TOLERANCES[k]) for k in (0, -1))
    note = f"One run at each tolerance from {tolerances}; {reference_sentence(work)}."
    return draw_plot(
        *(curves, "Error against run time", "processor time, ms", "error of fold angles, rad"),
        marks=marks,
        linear_to=10.0 ** math.floor(math.log10(least)),
        note=note,
    )


def _point(row: WorkRow) -> tuple[float, float] | None:
    """Return run time (ms) and error of the angles (rad) of a row; None where it was not measured."""
    if row.angle_error is None or not row.seconds:
        return None
    return 1e3 * row.seconds, max(row.angle_error, MIN_PLOTTED_ERROR)
