"""The fastest runs of the bench `dynamics`, and its goals, by what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hcsearch_bench.dynamics.case_rows import CaseRow, seconds_at
from hcsearch_bench.dynamics.deployment_rows import BOUNCE, COMPARED, DeploymentRow, QuickRow
from hcsearch_bench.dynamics.evaluation_rows import EvaluationRow
from hcsearch_bench.run.table import Goal
from hcsearch_bench.run.work_precision import OURS, fastest_rows, seconds_of
from hcsearch_bench.subjects.deployments import LOOP, WHOLE

ERROR = 2e-5
"""Of a hinge angle, at which run times are compared, rad."""


@dataclass(frozen=True, kw_only=True)
class FastestCaseRow(CaseRow):
    """The fastest run of a formulation, engine and method that reaches a level.

    times_ours : its time over that of our fastest constrained one.
    """

    level: str
    times_ours: float | None


def best_of(rows: Sequence[CaseRow]) -> list[FastestCaseRow]:
    """A row a level, formulation, engine and method that reaches it, all but quasistatic ones."""
    return list(
        fastest_rows(
            [row for row in rows if row.formulation != "quasistatic"],
            subject=lambda row: row.subject,
            key=lambda row: (row.formulation, row.engine, row.method),
            is_ours=lambda row: (row.engine, row.formulation) == (OURS, "constrained"),
            kind=FastestCaseRow,
        )
    )


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
