"""Reports of error against run time: plain data, a table and a plot of work and precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from hcsearch.springs.accuracy.reference_motions import ReferenceMotion, ReferenceRun
from hcsearch.springs.accuracy.work_rows import FormulationWork, WorkRow
from hcsearch.springs.deployment.deployment_facts import finite_or_none
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
"""Names of fields of a row in data, where a unit or more words are due; energies are shares of the largest one."""
MIN_PLOTTED_ERROR = 1e-16
"""Errors below this (rad) are drawn at it."""


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
    """Return a sentence on what the simulations in a formulation are compared with, and how far that is exact."""
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
