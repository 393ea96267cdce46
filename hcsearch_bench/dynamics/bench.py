"""The bench `dynamics`: error against run time, by formulation, integrator and tolerance, and other engines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from hcsearch.library.unit_search.elements import untwisted
from hcsearch_bench.dynamics.case_rows import LEVELS, OUTPUTS, CaseRow, ReferenceRow, seconds_at, subject_rows
from hcsearch_bench.dynamics.deployments import (
    BOUNCE,
    COMPARED,
    DeploymentRow,
    QuickRow,
    deployment_rows,
    quick_row,
)
from hcsearch_bench.dynamics.evaluations import EvaluationRow, evaluation_rows
from hcsearch_bench.run.figures import plot_work
from hcsearch_bench.run.goals import Goal
from hcsearch_bench.run.machine import this_machine
from hcsearch_bench.run.report import BenchReport, Say
from hcsearch_bench.run.tables import Table
from hcsearch_bench.run.work_precision import OURS, QUICK_PATIENCE, fastest_by, seconds_of
from hcsearch_bench.subjects.deployments import LOOP, WHOLE, subjects

PEERS = ("scipy", "mujoco", "pin", "exudyn")
PATIENCE = 5.0
"""Seconds that a run may be expected to take, from the one before it."""
ERROR = 2e-5
"""Of a hinge angle, at which run times are compared, rad."""
SIZES, QUICK_SIZES = (10, 20, 50, 100, 200, 500, 1000), (10, 30, 100)
CHECKED, QUICK_CHECKED = (("hex", 10), ("hex", 12), ("square", 12)), (("hex", 8),)


@dataclass(frozen=True)
class FastestCaseRow:
    """The fastest run of a formulation, engine and method that reaches a level.

    times_ours : its time over that of our fastest constrained one.
    """

    subject: str
    level: str
    formulation: str
    engine: str
    method: str
    tolerance: float | None
    step: float | None
    error: float
    seconds: float
    times_ours: float | None


@dataclass(frozen=True)
class DynamicsReport(BenchReport):
    """All that one run of the bench measured."""

    page: ClassVar[str] = "dynamics"

    work: list[CaseRow]
    references: list[ReferenceRow]
    deployments: list[DeploymentRow]
    scale: list[EvaluationRow]
    quick: list[QuickRow]

    @property
    def best(self) -> list[FastestCaseRow]:
        """The fastest runs at each level."""
        return best_of(self.work)

    @property
    def goals(self) -> list[Goal]:
        """The goals, by what was measured."""
        return goals_of(self.work, self.deployments, self.scale, self.quick)

    @property
    def tables(self) -> list[Table]:
        """What is shown and saved, in order."""
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
                self.work,
            ),
            Table(
                "references",
                "The references",
                "`apart` and `whole_apart` (rad) are the distances from the reference of DOP853 of SciPy, on "
                "accelerations from dense NumPy matrices, until `scipy_end` (s), and of the solution of hcsearch "
                "for the whole array.",
                self.references,
            ),
            Table(
                "best",
                "The fastest run that is precise enough",
                "`times_ours`: seconds relative to those of the fastest constrained run of hcsearch at the same level.",
                self.best,
            ),
            Table(
                "deployments",
                "Whole deployments",
                "Deployments with stops and damping, to flat. `arrivals`: the first hinges that come to a stop, "
                "with milliseconds, without bounces. The thesis's stops are springs that throw hinges back, those "
                "of `constrained` are hard, with `restitution` (default 0). `apart`: the share of the time by "
                f"which the first {COMPARED} arrivals come earlier or later than in `constrained` with restitution "
                f"{BOUNCE:g}. `cut` (N/m): stiffness of the springs at the cut hinge, 1e8 in the thesis.",
                self.deployments,
            ),
            Table(
                "scale",
                "Cost of an evaluation",
                "Microseconds of a step for each evaluation in it, with projection and bookkeeping. `slope`: "
                "exponent of n.",
                self.scale,
            ),
            Table(
                "quick",
                "The quick check",
                "All untwisted foldings, including locked ones: linkage, start, simulation to flat or for 1 s, "
                "clearance. `tenth_ms`: a tenth of the foldings takes longer.",
                self.quick,
            ),
            Table(
                "goals",
                "Goals",
                f"Ratios of run times at an error of {ERROR:g} rad.",
                self.goals,
                columns=("goal", "at_least", "at_most", "measured", "met", "note"),
            ),
        ]

    def draw(self, folder: Path) -> None:
        """Write the pictures."""
        points = [
            (row.subject, row.engine, _curve(row), seconds_of(row), row.error)
            for row in self.work
            if row.error is not None and row.formulation != "quasistatic"
        ]
        plot_work(points, "greatest error of a hinge angle (rad)", folder / "work.png")


def measure(*, quick: bool = False, repeats: int = 3, say: Say = print) -> DynamicsReport:
    """Run the whole bench: minutes; `quick`: two subjects, few settings, a tenth of a deployment."""
    machine = this_machine(PEERS)
    repeats, patience = (1, QUICK_PATIENCE) if quick else (repeats, PATIENCE)
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
        checked.append(quick_row(f"{grid} n = {n}", list(untwisted(grid, n))))
    return DynamicsReport(machine, work, references, deployments, scale, checked)


def best_of(rows: Sequence[CaseRow]) -> list[FastestCaseRow]:
    """A row a level, formulation, engine and method that reaches it, all but quasistatic ones."""
    best = []
    for subject in dict.fromkeys(row.subject for row in rows):
        own = [row for row in rows if row.subject == subject and row.formulation != "quasistatic"]
        for level, limit in LEVELS[1::-1]:
            precise = (row for row in own if _within(row, limit))
            fastest = fastest_by(lambda row: (row.formulation, row.engine, row.method), precise)
            ours = min((seconds_of(r) for r in fastest.values() if _is_ours(r)), default=None)
            for (formulation, engine, method), row in fastest.items():
                assert row.error is not None
                ratio = None if ours is None else seconds_of(row) / ours
                best.append(
                    FastestCaseRow(
                        *(subject, level, formulation, engine, method, row.tolerance, row.step, row.error),
                        *(seconds_of(row), ratio),
                    )
                )
    return best


def _within(row: CaseRow, limit: float) -> bool:
    return row.error is not None and row.error <= limit and row.seconds is not None


def _is_ours(row: CaseRow) -> bool:
    return (row.engine, row.formulation) == (OURS, "constrained")


def goals_of(
    work: Sequence[CaseRow],
    deployments: Sequence[DeploymentRow],
    scale: Sequence[EvaluationRow],
    quick: Sequence[QuickRow],
) -> list[Goal]:
    """The goals of speed, each by what this run measured."""
    slopes = {row.kind: row.slope for row in scale}
    twelve = next((row for row in quick if row.designs == "hex n = 12"), None)
    return [
        *(_faster(work, *goal) for goal in FASTER),
        *_whole_deployment(deployments),
        *(Goal(f"cost of an evaluation, {kind}: power of n", slope, 0.9, 1.1) for kind, slope in slopes.items()),
        Goal(
            "quick check of one design of 12 panels, median ms",
            None if twelve is None else twelve.median_ms,
            at_most=50.0,
            note="" if twelve is None else _parts(twelve),
        ),
    ]


def _parts(row: QuickRow) -> str:
    return f"simulation {row.simulation_ms:.0f}, clearance {row.clearance_ms:.0f} ms"


FASTER = (
    ("penalty", OURS, "bogacki-shampine", 100.0),
    (WHOLE, "MuJoCo", "RK4", 10.0),
    (WHOLE, "Pinocchio", "SciPy DOP853", 10.0),
)
"""Formulation, engine and method, and how many times faster than it we are to be."""


def _faster(work: Sequence[CaseRow], formulation: str, engine: str, method: str, at_least: float) -> Goal:
    """The goal against one method, on the loop, of the scene as it is compiled; the whole array in the note."""
    loop = [row for row in work if row.subject == LOOP]
    theirs = [row for row in loop if (row.formulation, row.engine, row.method) == (formulation, engine, method)]
    ours = {own: _fastest(loop, own) for own in ("constrained", WHOLE)}
    seconds, notes = seconds_at(theirs, ERROR), []
    reached = [row for row in theirs if row.error is not None]
    if seconds is None and reached:
        nearest = min(reached, key=lambda row: row.error or 0.0)
        seconds = seconds_of(min((row for row in reached if row.error == nearest.error), key=seconds_of))
        notes.append(f"it never comes to {ERROR:g}: {nearest.error:.2g} rad in {seconds:.3g} s")
    ratios = {own: None if not seconds or not time else seconds / time for own, time in ours.items()}
    if ratios[WHOLE]:
        notes.append(f"nothing left out: {ratios[WHOLE]:.3g}")
    name = f"{formulation if engine == OURS else engine}, {method}"
    return Goal(
        f"{LOOP} at {ERROR:g} rad: times faster than {name}", ratios["constrained"], at_least, note="; ".join(notes)
    )


def _fastest(rows: Sequence[CaseRow], formulation: str) -> float | None:
    """Our least seconds at the error, over all methods."""
    ours = [row for row in rows if (row.engine, row.formulation) == (OURS, formulation)]
    times = [seconds_at([row for row in ours if row.method == m], ERROR) for m in {row.method for row in ours}]
    return min((time for time in times if time is not None), default=None)


def _whole_deployment(rows: Sequence[DeploymentRow]) -> list[Goal]:
    """The goals of the loop's whole deployment: run times, and whether events come at equal times.

    They do where the thesis's springs are so stiff that what they give way matters no more.
    """
    loop = [row for row in rows if row.subject == LOOP]
    ours = next((row for row in loop if row.restitution == BOUNCE), None)
    if ours is None:
        return []
    goals = []
    for row in (row for row in loop if row.formulation == "penalty"):
        name = f"{LOOP}, whole deployment, springs of {row.cut:.0e} N/m"
        ends = f"ours {ours.outcome} at {ours.end:.4g} s, theirs {row.outcome} at {row.end:.4g} s"
        apart = abs(ours.end - row.end) / ours.end if ours.outcome == row.outcome == "flat" else None
        goals += [
            Goal(f"{name}: times faster than the thesis's method", row.seconds / ours.seconds, 50.0, note=ends),
            Goal(f"{name}: first {COMPARED} arrivals apart, as a share", row.apart, at_most=1e-3),
            Goal(f"{name}: flat times apart, as a share", apart, at_most=0.01, note=ends),
        ]
    return goals


def _curve(row: CaseRow) -> str:
    """Label of a row's curve; only ours have several formulations."""
    return f"{row.engine}, {row.method}" + (f", {row.formulation}" if row.engine == OURS else "")
