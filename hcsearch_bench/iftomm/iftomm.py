"""The bench `iftomm`: problems A01 to A05 of the IFToMM benchmark, error against time, beside other engines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch_bench.run.bench import Bench, Say
from hcsearch_bench.run.table import Table
from hcsearch_bench.run.work_precision import OURS, PATIENCE, QUICK_PATIENCE, plot_work, seconds_of

if TYPE_CHECKING:
    from hcsearch_bench.iftomm.problem_rows import FastestProblemRow, ProblemRow

BRICARD = {"error": 1e-6, "seconds": 10e-3, "closure": 1e-12, "energy": 1e-9}
"""What A04 must keep over 10 s: m, s, m, J."""


@dataclass(frozen=True)
class BricardRow:
    """A goal for A04 over 10 s, and what the fastest run that keeps the other goals of precision has.

    over : time that was simulated, s.
    """

    problem: str
    over: float
    goal: str
    at_most: float
    measured: float | None
    method: str
    met: str


@dataclass(frozen=True)
class IftommResults:
    """All that one run of the bench measured."""

    work: list[ProblemRow]
    best: list[FastestProblemRow]
    goals: list[BricardRow]


def tables(results: IftommResults) -> list[Table]:
    """What is shown and saved, in order."""
    from hcsearch_bench.iftomm.problem_rows import LEVELS, OUTPUTS

    levels = ", ".join(f"{name} up to {limit:g}" for name, limit in LEVELS)
    return [
        Table(
            "work",
            "Work and precision",
            "`error` (m) is the greatest distance of the measured point from a reference solution at "
            f"{OUTPUTS + 1} times from start to end; `at_steps` is the error of hcsearch at the ends of the "
            f"steps, without interpolation. `verdict`: {levels} of the problem's length (1 m; A03: the crank of "
            "7 mm), otherwise wrong. `energy` (J) is the error of the energy balance, `closure` the greatest "
            "gap (m). `evaluations`: of accelerations; of implicit methods, Newton steps. `seconds` is the wall "
            "time of the integration alone, median of `runs`; the loops of hcsearch, MuJoCo and Exudyn are "
            "compiled, that of Pinocchio is SciPy's.",
            results.work,
            columns=(
                *("problem", "engine", "method", "tolerance", "step", "verdict", "error", "at_steps", "energy"),
                *("closure", "evaluations", "seconds", "runs", "note"),
            ),
        ),
        Table(
            "best",
            "The fastest run that is precise enough",
            "The fastest run of each engine. `times_ours`: seconds relative to those of hcsearch at the same level.",
            results.best,
            columns=(
                *("problem", "level", "engine", "method", "tolerance", "step", "error", "energy", "seconds"),
                "times_ours",
            ),
        ),
        Table(
            "goals",
            "Goals for A04",
            "The simulated time is 10 s. The table gives the fastest run of hcsearch that meets all goals of "
            "precision, over the whole time.",
            results.goals,
        ),
    ]


def draw(results: IftommResults, folder: Path) -> None:
    """Write the pictures."""
    points = [
        (row.problem, row.engine, f"{row.engine}, {row.method}", seconds_of(row), row.error)
        for row in results.work
        if row.error is not None
    ]
    plot_work(points, "greatest error (m)", folder / "work.png")


def measure(*, quick: bool, repeats: int, say: Say) -> IftommResults:
    """Run the whole bench: minutes; `quick`: a tenth of each time, and few settings."""
    import numpy as np

    from hcsearch_bench.iftomm.problem_rows import OUTPUTS, best_of, our_settings, problem_comparison
    from hcsearch_bench.iftomm.problems import problems
    from hcsearch_bench.peers.multibody import peers

    patience = QUICK_PATIENCE if quick else PATIENCE
    rows: list[ProblemRow] = []
    for whole in problems():
        problem = replace(whole, end=whole.end / 10) if quick else whole
        comparison = problem_comparison(problem, np.linspace(0.0, problem.end, OUTPUTS + 1))
        say(f"{problem.name}, {problem.title}")
        rows += comparison.our_rows(our_settings(quick), repeats, math.inf)
        for peer in peers(quick, OUTPUTS):
            if peer.fits(problem):
                say(f"{problem.name}: {peer.engine}, {peer.method}")
                rows += comparison.peer_rows(peer, repeats, patience)
    return IftommResults(rows, best_of(rows), goals_of(rows, 1.0 if quick else 10.0))


def goals_of(rows: Sequence[ProblemRow], over: float) -> list[BricardRow]:
    """The goals for both variants of A04, by our fastest run that is precise enough, or our most precise one."""
    goals = []
    for problem in ("A04 thin", "A04 square"):
        ours = [row for row in rows if (row.problem, row.engine) == (problem, OURS) and row.error is not None]
        precise = [row for row in ours if all(_kept(row, goal) for goal in ("error", "closure", "energy"))]
        row = min(precise, key=seconds_of) if precise else min(ours, key=lambda row: row.error or 0.0, default=None)
        for goal, limit in BRICARD.items():
            goals.append(
                BricardRow(
                    *(problem, over, goal, limit, None if row is None else getattr(row, goal)),
                    "-" if row is None else f"{row.method}, {row.tolerance:g}",
                    "yes" if row is not None and _kept(row, goal) else "no",
                )
            )
    return goals


def _kept(row: ProblemRow, goal: str) -> bool:
    value = getattr(row, goal)
    return value is not None and value <= BRICARD[goal]


IFTOMM = Bench(
    "iftomm",
    "Measure the dynamics on published problems. Errors, energies and times for A01 to A05 of IFToMM, beside other "
    "programs.\n"
    "\n"
    "MuJoCo, Pinocchio and Exudyn come with an extra: pip install 'hcsearch[bench]'.",
    "hcsearch bench iftomm --quick --json iftomm.json",
    measure,
    tables,
    draw,
    peers=("scipy", "mujoco", "pin", "exudyn"),
    repeats=True,
)
