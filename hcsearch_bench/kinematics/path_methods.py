"""Path methods measured against the exact motion of units I and II, and what one closure costs as loops grow."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.integrate import quad

from hcsearch.basics.array_values import Reals
from hcsearch.library.assemblies.eight_r import joint_parts, skew_symmetric_angles, unit_i, unit_ii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.motion.paths.following import PathLimits, Stepping, follow_path
from hcsearch.motion.paths.motions import MotionPath
from hcsearch.shape.linkage import Linkage
from hcsearch_bench.run.bench import Say
from hcsearch_bench.subjects.squares import SIDE, THICKNESS, ring_folding

UNITS = ("I", "II")
METHODS = ("euler", "taylor", "adams", "runge-kutta", "hermite")
STEPS = (0.8, 0.4, 0.2, 0.1, 0.05, 0.025)
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
INCREMENTS = (0.08, 0.04, 0.02, 0.01)
MARGIN = 0.1
PANELS = (10, 20, 50, 100, 200, 500, 1000, 2000)
QUICK_STEPS, QUICK_TOLERANCES, QUICK_INCREMENTS, QUICK_PANELS = (0.4, 0.1), (1e-2, 1e-4), (0.04,), (10, 50, 200)


@dataclass(frozen=True)
class PathRow:
    """One path. Errors in rad: None where it was lost, or where nothing says where it should end.

    step : length of every step (rad); tolerance : of the prediction, where steps adapt.
    corrections : Newton corrections a step, `closed` for as many as closure needs.
    residual : greatest closure residual of its states. off_path : how far a hinge is from where (5.24) puts it, seen
        from the first one. at_end : the same at the end, seen from the arc length.
    """

    unit: str
    method: str
    step: float | None
    tolerance: float | None
    corrections: str
    outcome: str
    steps: int
    evaluations: int
    seconds: float
    residual: float
    off_path: float | None
    at_end: float | None
    runs: int


@dataclass(frozen=True)
class CostRow:
    """A ring of squares: one closure with its Jacobian, its second-order term, its singular values, microseconds."""

    panels: int
    hinges: int
    closure_us: float
    bend_us: float
    svd_us: float


@dataclass(frozen=True)
class SlopeRow:
    """Power of the number of panels with which a time grows, fitted to the larger half of the rings."""

    what: str
    power: float
    microseconds_a_panel: float


class KnownUnit:
    """A unit whose motion is known: thesis (5.24), base angle 70 degrees."""

    def __init__(self, unit: str, **parameters: float) -> None:
        self.parameters = Parameters(**parameters)  # type: ignore[arg-type]
        self.pattern = {"I": unit_i, "II": unit_ii}[unit](self.parameters)
        self.linkage = Linkage(self.pattern)
        parts = joint_parts(self.pattern)
        assert parts is not None
        self.legs = parts == 1

    def at(self, first: float) -> Reals:
        """Fold angles where the first dihedral angle is given."""
        return skew_symmetric_angles(self.pattern, self.parameters.alpha, first)

    def opening(self) -> Reals:
        """Velocity of the motion at the folded state."""
        velocity: Reals = -np.where(self.legs, 1.0, math.cos(self.parameters.alpha))
        return velocity

    def folding(self) -> Reals:
        """Velocity of the motion at the flat state."""
        velocity: Reals = np.where(self.legs, math.cos(self.parameters.alpha), 1.0)
        return velocity

    def off_path(self, angles: Reals) -> float:
        """How far hinges are from where (5.24) puts them, seen from the first hinge with a base angle (rad)."""
        phi = math.pi - np.atleast_2d(angles)
        first = phi[:, [int(np.flatnonzero(~self.legs)[0])]]
        second = 2 * np.arctan2(np.sin(first / 2), math.cos(self.parameters.alpha) * np.cos(first / 2))
        return float(np.abs(phi - np.where(self.legs, second, first)).max())

    def path_error(self, path: MotionPath) -> float:
        """`off_path` of a path's states."""
        return self.off_path(path.angles)

    def speed(self, first: float) -> float:
        """Arc length in the space of fold angles, by the first dihedral angle."""
        c = math.cos(self.parameters.alpha)
        slope = c / (c * c * math.cos(first / 2) ** 2 + math.sin(first / 2) ** 2)
        legs = int(self.legs.sum())
        return math.sqrt(len(self.legs) - legs + legs * slope * slope)

    def length(self, start: float, end: float) -> float:
        """Arc length between two states, given by their first dihedral angles."""
        return float(quad(self.speed, start, end, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


def measure_paths(units: Sequence[str], *, quick: bool, repeats: int, say: Say) -> list[PathRow]:
    """One row a unit, method and step. Fixed steps begin and end beside the singular ends; adaptive ones at them."""
    rows = []
    for name in units:
        unit = KnownUnit(name)
        for stepping in _steppings(quick):
            say(f"unit {name}: {stepping.method}, {stepping.step or stepping.tolerance}")
            rows.append(_path_row(name, unit, stepping, repeats))
    return rows


def _steppings(quick: bool) -> Iterator[Stepping]:
    for method in METHODS:
        for step in QUICK_STEPS if quick else STEPS:
            for corrections in (0, 1, None):
                yield Stepping(method, step, adaptive=False, corrections=corrections)
    for step in QUICK_INCREMENTS if quick else INCREMENTS:
        yield Stepping("increment", step)
    for method in METHODS:
        for tolerance in QUICK_TOLERANCES if quick else TOLERANCES:
            yield Stepping(method, tolerance=tolerance)


def _path_row(name: str, unit: KnownUnit, stepping: Stepping, repeats: int) -> PathRow:
    adaptive = stepping.adapts
    start = unit.linkage.folded if adaptive else unit.at(MARGIN)
    limits = PathLimits(events=False, max_steps=20_000)
    if not adaptive:
        limits = replace(limits, goal="none", length=unit.length(MARGIN, math.pi - MARGIN))

    def run() -> MotionPath:
        return follow_path(unit.linkage, start, unit.opening(), stepping=stepping, limits=limits)

    path, seconds, runs = _timed(run, repeats)
    arrived = path.success
    end = unit.linkage.flat if adaptive else unit.at(math.pi - MARGIN)
    return PathRow(
        unit=name,
        method=stepping.method,
        step=stepping.step,
        tolerance=stepping.tolerance if adaptive else None,
        corrections="closed" if stepping.corrections is None else str(stepping.corrections),
        outcome=path.outcome,
        steps=path.steps,
        evaluations=path.evaluations,
        seconds=seconds,
        residual=float(path.residuals.max()),
        off_path=unit.off_path(path.angles) if arrived else None,
        at_end=float(np.abs(path.end - end).max()) if arrived else None,
        runs=runs,
    )


def _timed(run: Callable[[], MotionPath], repeats: int) -> tuple[MotionPath, float, int]:
    """What a run gives, the median of its times, and how often it ran: once where it is slow."""
    times: list[float] = []
    while len(times) < repeats and sum(times) < 2.0:
        begin = time.perf_counter()
        path = run()
        times.append(time.perf_counter() - begin)
    return path, float(np.median(times)), len(times)


def ring(columns: int) -> Linkage:
    """A ring of 2 x `columns` squares, which stands on its first panel."""
    return Linkage(ring_folding(columns).pattern((SIDE, SIDE, THICKNESS)))


def measure_costs(panels: Sequence[int], *, say: Say) -> list[CostRow]:
    """One row a ring: medians over repeated evaluations at a folded-up state that is not closed."""
    rows = []
    for n in panels:
        say(f"a closure of a ring of {n} squares")
        linkage = ring(n // 2)
        angles = np.random.default_rng(n).uniform(0.0, math.pi, linkage.n_hinges)
        jacobian = linkage.closure(angles)[1]
        rows.append(
            CostRow(
                n,
                linkage.n_hinges,
                1e6 * _each(partial(linkage.closure, angles)),
                1e6 * _each(partial(linkage.bend, jacobian, angles)),
                1e6 * _each(partial(np.linalg.svd, jacobian, full_matrices=False)),
            )
        )
    return rows


def _each(run: Callable[[], object]) -> float:
    """Median seconds of a call."""
    run()
    times: list[float] = []
    begin = time.perf_counter()
    while len(times) < 7 or (time.perf_counter() - begin < 0.05 and len(times) < 500):
        now = time.perf_counter()
        run()
        times.append(time.perf_counter() - now)
    return float(np.median(times))


def fit_costs(rows: Sequence[CostRow]) -> list[SlopeRow]:
    """Log-log slopes of the times over the larger half of the rings."""
    half = rows[len(rows) // 2 :] if len(rows) > 3 else rows
    panels = np.array([row.panels for row in half], float)
    slopes = []
    for what in ("closure_us", "bend_us", "svd_us"):
        times = np.array([getattr(row, what) for row in half])
        power = float(np.polyfit(np.log(panels), np.log(times), 1)[0])
        slopes.append(SlopeRow(what.removesuffix("_us"), power, float(times[-1] / panels[-1])))
    return slopes
