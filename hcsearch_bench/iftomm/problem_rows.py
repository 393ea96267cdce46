"""Rows of the bench `iftomm`: one problem by one engine, method and tolerance or step, against its reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.time_integration import Motion
from hcsearch_bench.iftomm.problems import Problem
from hcsearch_bench.peers.measured_runs import Comparison
from hcsearch_bench.peers.states import Trajectory, closure, places
from hcsearch_bench.run.work_precision import OURS, MeasuredRow, fastest_rows, level_of

OUTPUTS = 400
"""Equal spaces between the times at which the error is taken; those of the published rules for A02."""
MAX_STEPS = 200_000
LEVELS = (("precise", 1e-6), ("high", 1e-3), ("low", 1e-1))
"""Verdicts by the greatest error over the problem's length; `high` and `low` are the published precisions of A02."""


@dataclass(frozen=True, kw_only=True)
class ProblemRow(MeasuredRow):
    """A run of a problem.

    error : greatest distance of the measured point from where it should be, at all output times, m; at_steps : at the
        ends of the steps of ours, without interpolation. closure : greatest gap, m.
    """

    problem: str
    at_steps: float | None = None
    closure: float | None = None


@dataclass(frozen=True, kw_only=True)
class FastestProblemRow(ProblemRow):
    """The fastest run of an engine on a problem that reaches a level; times_ours: its time over our fastest."""

    level: str
    times_ours: float | None


def our_settings(quick: bool) -> dict[str, tuple[float, ...]]:
    """Methods and tolerances, the coarsest first."""
    if quick:
        return {"dormand-prince": (1e-6,), "dormand-prince-8": (1e-6, 1e-10)}
    return {
        "bogacki-shampine": (1e-4, 1e-6),
        "dormand-prince": (1e-4, 1e-6, 1e-8, 1e-10),
        "dormand-prince-8": (1e-4, 1e-6, 1e-8, 1e-10, 1e-12),
        "implicit": (1e-4, 1e-6, 1e-8),
    }


def problem_comparison(problem: Problem, times: Reals) -> Comparison[ProblemRow]:
    """What the way of a problem's point is compared with, at times from 0 on."""
    way = problem.reference(times)

    def judged(row: ProblemRow, q: Reals, motion: Motion | Trajectory) -> ProblemRow:
        error, ours = _distance(problem, q, way), row.engine == OURS
        at_steps = _distance(problem, motion.q, problem.reference(motion.times)) if ours else None
        verdict = level_of(max(error, at_steps or 0.0), LEVELS, problem.length)
        gap = closure(problem.system, motion.q)
        return replace(row, verdict=verdict, error=error, at_steps=at_steps, closure=gap)

    return Comparison(problem, times, MAX_STEPS, partial(ProblemRow, problem=problem.name), judged)


def _distance(problem: Problem, q: Reals, way: Reals) -> float:
    """Greatest distance of the measured point from where it should be, m."""
    points, _ = places(problem.system, q).point(problem.body, problem.point)
    return float(np.linalg.norm(points - way, axis=1).max())


def best_of(rows: Sequence[ProblemRow]) -> list[FastestProblemRow]:
    """Two levels a problem, a row an engine that reaches it."""
    return list(
        fastest_rows(
            rows,
            subject=lambda row: row.problem,
            key=lambda row: row.engine,
            is_ours=lambda row: row.engine == OURS,
            kind=FastestProblemRow,
        )
    )
