"""Rows of the bench `iftomm`: one problem by one engine, method and tolerance or step, against its reference."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hcsearch.bench import exudyn_system, mujoco_system, pinocchio_system
from hcsearch.bench.iftomm_problems import Problem
from hcsearch.bench.states import Trajectory, UnableError, closure, energies, places
from hcsearch.bench.timing import ENOUGH

if TYPE_CHECKING:
    from hcsearch.dynamics.simulation import Motion

Reals = NDArray[np.float64]

OURS = "hcsearch"
OUTPUTS = 400
"""Equal spaces between the times at which the error is taken; those of the published rules for A02."""
PATIENCE, QUICK_PATIENCE = 8.0, 2.0
"""Seconds that a run may be expected to take, from the one before it."""
MAX_STEPS = 200_000
SHORT = 0.1
"""Seconds."""
LEVELS = (("precise", 1e-6), ("high", 1e-3), ("low", 1e-1))
"""Verdicts by the greatest error over the problem's length; `high` and `low` are the published precisions of A02."""


@dataclass(frozen=True)
class WorkRow:
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


@dataclass(frozen=True)
class Peer:
    """A method of another engine: its settings are tolerances, or steps as shares of a problem's time."""

    engine: str
    method: str
    settings: tuple[float, ...]
    run: Callable[..., Trajectory]
    by_tolerance: bool = False
    fits: Callable[[Problem], bool] = lambda _: True

    def row(self, problem: Problem, setting: float) -> WorkRow:
        """A row without numbers yet."""
        sizes = (setting, None) if self.by_tolerance else (None, setting * problem.end)
        return WorkRow(problem.name, self.engine, self.method, *sizes)

    def follow(self, problem: Problem, times: Reals, setting: float) -> Trajectory:
        """Run it."""
        size = {"tolerance": setting} if self.by_tolerance else {"step": setting * problem.end}
        return self.run(problem.system, problem.q, problem.v, times, **size)


def peers(quick: bool) -> list[Peer]:
    """Other engines, their methods and settings, the coarsest first."""
    steps = tuple(1 / (OUTPUTS * k) for k in ((1, 10) if quick else (1, 3, 10, 30, 100, 300)))
    tolerances = (1e-6, 1e-9) if quick else (1e-4, 1e-6, 1e-8, 1e-10)
    mujoco, exudyn = mujoco_system.run, exudyn_system.run
    return [
        Peer("MuJoCo", "RK4", steps, mujoco),
        Peer("MuJoCo", "implicitfast", steps, partial(mujoco, integrator="implicitfast")),
        Peer("Pinocchio", "SciPy DOP853", tolerances, pinocchio_system.run, by_tolerance=True),
        Peer(
            "Pinocchio",
            "SciPy Radau",
            tolerances[:2],
            partial(pinocchio_system.run, method="Radau"),
            by_tolerance=True,
            fits=_is_stiff,
        ),
        Peer("Exudyn", "generalized alpha", steps[:5], exudyn),
        Peer("Exudyn", "RK4", steps[:5], partial(exudyn, integrator="RK44"), fits=lambda p: not p.system.welds),
    ]


def _is_stiff(problem: Problem) -> bool:
    return any(strut.damping for strut in problem.system.struts)


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
) -> WorkRow:
    """One run of our engine, repeated."""
    from hcsearch.dynamics.simulation import simulate  # noqa: PLC0415 - loads numba

    found: list[Motion] = []

    def follow(end: float) -> Motion:
        options = {"method": method, "tolerance": tolerance, "max_steps": MAX_STEPS}
        return simulate(problem.system, problem.q, problem.v, end=end, **options)  # type: ignore[arg-type]

    def run() -> float:
        begin = time.perf_counter()
        found[:] = [follow(problem.end)]
        return time.perf_counter() - begin

    follow(1e-3 * problem.end)  # compiled, and its tables made
    seconds, runs = _timed(run, repeats)
    (motion,) = found
    row = WorkRow(
        *(problem.name, OURS, method, tolerance, None), evaluations=motion.evaluations, seconds=seconds, runs=runs
    )
    if motion.ending != "time":
        return replace(row, note=f"refused: {motion.ending} at {motion.times[-1]:.3g} s")
    error = _distance(problem, motion.at(times), way)
    at_steps = _distance(problem, motion.q, problem.reference(motion.times))
    return replace(
        row,
        verdict=verdict_of(problem, max(error, at_steps)),
        error=error,
        at_steps=at_steps,
        energy=motion.drift,
        closure=closure(problem.system, motion.q),
    )


def our_rows(
    problem: Problem, times: Reals, way: Reals, settings: dict[str, tuple[float, ...]], repeats: int
) -> Iterator[WorkRow]:
    """A row a method and tolerance."""
    for method, tolerances in settings.items():
        for tolerance in tolerances:
            yield measure_ours(problem, method, tolerance, times, way, repeats)


def peer_rows(
    problem: Problem, times: Reals, way: Reals, peer: Peer, repeats: int, patience: float
) -> Iterator[WorkRow]:
    """Rows of rising work, until one would take too long; one with the reason where the engine is unable."""
    took, before = 0.0, None
    for setting in peer.settings:
        row = peer.row(problem, setting)
        more = 2.0 if peer.by_tolerance or before is None else before / setting
        if took * more > patience:
            yield replace(row, note=f"not tried: more than {patience:g} s")
            continue
        try:
            row = _peer_row(problem, times, way, peer, setting, repeats)
        except UnableError as error:
            row = replace(row, note=str(error))
        yield row
        if row.note == "not installed":
            return
        if row.seconds is not None:
            took, before = row.seconds, setting


def _peer_row(problem: Problem, times: Reals, way: Reals, peer: Peer, setting: float, repeats: int) -> WorkRow:
    found: list[Trajectory] = []

    def run() -> float:
        found[:] = [peer.follow(problem, times, setting)]
        return found[0].seconds

    seconds, runs = _timed(run, repeats)
    (motion,) = found
    error = _distance(problem, motion.q, way)
    system = problem.system
    lossless = not any(drive.damping for drive in system.drives) and not any(strut.damping for strut in system.struts)
    energy = energies(system, motion.q, motion.v)
    return replace(
        peer.row(problem, setting),
        verdict=verdict_of(problem, error),
        error=error,
        energy=float(np.abs(energy - energy[0]).max()) if lossless else None,
        closure=closure(system, motion.q),
        evaluations=motion.evaluations,
        seconds=seconds,
        runs=runs,
    )


def _timed(run: Callable[[], float], repeats: int) -> tuple[float, int]:
    """Median of the seconds of runs, and how many there were: five times as many where they are short."""
    times = [run()]
    wanted = 5 * repeats if repeats > 1 and times[0] < SHORT else repeats
    while len(times) < wanted and sum(times) < ENOUGH:
        times.append(run())
    return float(np.median(times)), len(times)


def _distance(problem: Problem, q: Reals, way: Reals) -> float:
    """Greatest distance of the measured point from where it should be, m."""
    found, _ = places(problem.system, q).point(problem.body, problem.point)
    return float(np.linalg.norm(found - way, axis=1).max())


def verdict_of(problem: Problem, error: float) -> str:
    """Its level."""
    return next((name for name, limit in LEVELS if error <= limit * problem.length), "wrong")
