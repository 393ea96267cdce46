"""The bench `dynamics`: error against run time, by formulation, integrator and tolerance, and other engines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table
from hcsearch_bench.run.work_precision import OURS, QUICK_PATIENCE, plot_work, seconds_of

if TYPE_CHECKING:
    from hcsearch_bench.dynamics.case_rows import CaseRow, ReferenceRow
    from hcsearch_bench.dynamics.deployment_rows import DeploymentRow, QuickRow
    from hcsearch_bench.dynamics.evaluation_rows import EvaluationRow

PATIENCE = 5.0
"""Seconds that a run may be expected to take, from the one before it."""
SIZES, QUICK_SIZES = (10, 20, 50, 100, 200, 500, 1000), (10, 30, 100)
CHECKED, QUICK_CHECKED = (("hex", 10), ("hex", 12), ("square", 12)), (("hex", 8),)


@dataclass(frozen=True)
class DynamicsResults:
    """All that one run of the bench measured."""

    work: list[CaseRow]
    references: list[ReferenceRow]
    deployments: list[DeploymentRow]
    scale: list[EvaluationRow]
    quick: list[QuickRow]


def tables(results: DynamicsResults) -> list[Table]:
    """What is shown and saved, in order."""
    from hcsearch_bench.dynamics.case_rows import LEVELS, OUTPUTS
    from hcsearch_bench.dynamics.deployment_rows import BOUNCE, COMPARED
    from hcsearch_bench.dynamics.speed_goals import ERROR, best_of, goals_of
    from hcsearch_bench.subjects.deployments import WHOLE

    levels = ", ".join(f"{name} up to {limit:g}" for name, limit in LEVELS)
    return [
        Table(
            "work",
            "Work and precision",
            f"`error` (rad) is the greatest error of a hinge angle relative to the reference at {OUTPUTS + 1} "
            "times until the end, which is before anything hits a stop; `penalty` is another model, with an "
            f"error of its own, and `quasistatic` has a reference of its own. `verdict`: {levels}, otherwise "
            "wrong. `energy` (J) is the error of the energy balance, `gap` (m) that of the loops. `seconds` is "
            f"the wall time of the integration alone, median of `runs`. In rows `{WHOLE}` nothing is left out "
            "of the scene; the other engines simulate this scene.",
            results.work,
            columns=(
                *("subject", "formulation", "engine", "method", "tolerance", "step", "verdict", "error", "energy"),
                *("gap", "evaluations", "seconds", "runs", "note"),
            ),
        ),
        Table(
            "references",
            "The references",
            "`apart` and `whole_apart` (rad) are the distances from the reference of DOP853 of SciPy, on "
            "accelerations from dense NumPy matrices, until `scipy_end` (s), and of the solution of hcsearch "
            "for the whole array.",
            results.references,
        ),
        Table(
            "best",
            "The fastest run that is precise enough",
            "`times_ours`: seconds relative to those of the fastest constrained run of hcsearch at the same level.",
            best_of(results.work),
            columns=(
                *("subject", "level", "formulation", "engine", "method", "tolerance", "step", "error", "seconds"),
                "times_ours",
            ),
        ),
        Table(
            "deployments",
            "Whole deployments",
            "Deployments with stops and damping, to flat. `arrivals`: the first hinges that come to a stop, "
            "with milliseconds, without bounces. The thesis's stops are springs that throw hinges back, those "
            "of `constrained` are hard, with `restitution` (default 0). `apart`: the share of the time by "
            f"which the first {COMPARED} arrivals come earlier or later than in `constrained` with restitution "
            f"{BOUNCE:g}. `cut` (N/m): stiffness of the springs at the cut hinge, 1e8 in the thesis.",
            results.deployments,
        ),
        Table(
            "scale",
            "Cost of an evaluation",
            "Microseconds of a step for each evaluation in it, with projection and bookkeeping. `slope`: "
            "exponent of n.",
            results.scale,
        ),
        Table(
            "quick",
            "The quick check",
            "All untwisted foldings, including locked ones: linkage, start, simulation to flat or for 1 s, "
            "clearance. `tenth_ms`: a tenth of the foldings takes longer.",
            results.quick,
        ),
        Table(
            "goals",
            "Goals",
            f"Ratios of run times at an error of {ERROR:g} rad.",
            goals_of(results.work, results.deployments, results.scale, results.quick),
            columns=("goal", "at_least", "at_most", "measured", "met", "note"),
        ),
    ]


def draw(results: DynamicsResults, folder: Path) -> None:
    """Write the pictures."""
    points = [
        (row.subject, row.engine, _curve(row), seconds_of(row), row.error)
        for row in results.work
        if row.error is not None and row.formulation != "quasistatic"
    ]
    plot_work(points, "greatest error of a hinge angle (rad)", folder / "work.png")


def measure(*, quick: bool, repeats: int, say: Say) -> DynamicsResults:
    """Run the whole bench: minutes; `quick`: two subjects, few settings, a tenth of a deployment."""
    from hcsearch.library.unit_search.elements import untwisted_foldings_of
    from hcsearch_bench.dynamics.case_rows import subject_rows
    from hcsearch_bench.dynamics.deployment_rows import deployment_rows, quick_row
    from hcsearch_bench.dynamics.evaluation_rows import evaluation_rows
    from hcsearch_bench.subjects.deployments import LOOP, subjects

    patience = QUICK_PATIENCE if quick else PATIENCE
    work: list[CaseRow] = []
    references: list[ReferenceRow] = []
    deployments: list[DeploymentRow] = []
    for subject in subjects()[: 2 if quick else None]:
        say(f"{subject.name}: {subject.what}")
        rows, compared = subject_rows(subject, quick, repeats, patience)
        work += rows
        references += compared
        say(f"{subject.name}: whole deployments")
        stiffer = subject.name == LOOP and not quick
        deployments += deployment_rows(subject, 0.05 if quick else 1.0, stiffer=stiffer)
    say("cost of an evaluation")
    scale = evaluation_rows(QUICK_SIZES if quick else SIZES, 3 * repeats)
    checked = []
    for grid, n in QUICK_CHECKED if quick else CHECKED:
        say(f"the quick check: {grid} n = {n}")
        checked.append(quick_row(f"{grid} n = {n}", list(untwisted_foldings_of(grid, n))))
    return DynamicsResults(work, references, deployments, scale, checked)


def _curve(row: CaseRow) -> str:
    """Label of a row's curve; only ours have several formulations."""
    return f"{row.engine}, {row.method}" + (f", {row.formulation}" if row.engine == OURS else "")


DYNAMICS = Bench(
    "dynamics",
    "Measure deployments. Errors and times beside other programs, whole deployments, and quick checks.\n"
    "\n"
    "MuJoCo, Pinocchio and Exudyn come with an extra: pip install 'hcsearch[bench]'.",
    "hcsearch bench dynamics --quick --output dynamics",
    measure,
    tables,
    draw,
    peers=("scipy", "mujoco", "pin", "exudyn"),
    repeats=True,
)
