"""Rows of the bench `iftomm`: one problem by one engine, method and tolerance or step, against its reference."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch_bench.iftomm.problems import Problem
from hcsearch_bench.peers.multibody import Peer
from hcsearch_bench.peers.states import closure, energy_error, places
from hcsearch_bench.run.timing import measured
from hcsearch_bench.run.work_precision import OURS, level_of, rising

if TYPE_CHECKING:
    from hcsearch.springs.dynamics.time_integration import Motion


OUTPUTS = 400
"""Equal spaces between the times at which the error is taken; those of the published rules for A02."""
MAX_STEPS = 200_000
LEVELS = (("precise", 1e-6), ("high", 1e-3), ("low", 1e-1))
"""Verdicts by the greatest error over the problem's length; `high` and `low` are the published precisions of A02."""


@dataclass(frozen=True)
class ProblemRow:
    """One problem, engine, method and tolerance, or step (s).

    verdict : of LEVELS, `wrong`, or `none` where there is no motion (`note` says why).
    error : greatest distance of the measured point from where it should be, at all output times, m; at_steps : at the
        ends of the steps, without interpolation.
    energy : greatest error of the energy balance, J; of other engines only where nothing is damped.
    closure : greatest gap, m. evaluations : of accelerations; of implicit methods, Newton steps.
    seconds : on the wall, median of `runs`.
    """

    problem: str
    engine: str
    method: str
    tolerance: float | None
    step: float | None
    verdict: str = "none"
    error: float | None = None
    at_steps: float | None = None
    energy: float | None = None
    closure: float | None = None
    evaluations: int | None = None
    seconds: float | None = None
    runs: int = 0
    note: str = ""


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


def measure_ours(
    problem: Problem, method: str, tolerance: float, times: Reals, way: Reals, repeats: int = 1
) -> ProblemRow:
    """One run of our engine, repeated."""
    from hcsearch.springs.dynamics.time_integration import simulate_system

    def follow(end: float) -> Motion:
        options = {"method": method, "tolerance": tolerance, "max_steps": MAX_STEPS}
        return simulate_system(problem.system, problem.q, problem.v, end=end, **options)  # type: ignore[arg-type]

    follow(1e-3 * problem.end)  # compiled, and its tables made
    motion, seconds, runs = measured(lambda: follow(problem.end), repeats)
    row = ProblemRow(
        *(problem.name, OURS, method, tolerance, None), evaluations=motion.evaluations, seconds=seconds, runs=runs
    )
    if motion.ending != "time":
        return replace(row, note=f"refused: {motion.ending} at {motion.times[-1]:.3g} s")
    error = _distance(problem, motion.at(times), way)
    at_steps = _distance(problem, motion.q, problem.reference(motion.times))
    return replace(
        row,
        verdict=level_of(max(error, at_steps), LEVELS, problem.length),
        error=error,
        at_steps=at_steps,
        energy=motion.drift,
        closure=closure(problem.system, motion.q),
    )


def our_rows(
    problem: Problem, times: Reals, way: Reals, settings: dict[str, tuple[float, ...]], repeats: int
) -> Iterator[ProblemRow]:
    """A row a method and tolerance."""
    for method, tolerances in settings.items():
        for tolerance in tolerances:
            yield measure_ours(problem, method, tolerance, times, way, repeats)


def peer_rows(
    problem: Problem, times: Reals, way: Reals, peer: Peer, repeats: int, patience: float
) -> Iterator[ProblemRow]:
    """Rows of rising work, until one would take too long; one with the reason where the engine is unable."""
    return rising(
        peer.settings,
        patience,
        lambda setting: ProblemRow(problem.name, peer.engine, peer.method, *peer.sizes(problem, setting)),
        lambda setting: _peer_row(problem, times, way, peer, setting, repeats),
        by_tolerance=peer.by_tolerance,
    )


def _peer_row(problem: Problem, times: Reals, way: Reals, peer: Peer, setting: float, repeats: int) -> ProblemRow:
    motion, seconds, runs = peer.measured(problem, times, setting, repeats)
    error = _distance(problem, motion.q, way)
    system = problem.system
    return ProblemRow(
        *(problem.name, peer.engine, peer.method, *peer.sizes(problem, setting)),
        verdict=level_of(error, LEVELS, problem.length),
        error=error,
        energy=energy_error(system, motion),
        closure=closure(system, motion.q),
        evaluations=motion.evaluations,
        seconds=seconds,
        runs=runs,
    )


def _distance(problem: Problem, q: Reals, way: Reals) -> float:
    """Greatest distance of the measured point from where it should be, m."""
    points, _ = places(problem.system, q).point(problem.body, problem.point)
    return float(np.linalg.norm(points - way, axis=1).max())
