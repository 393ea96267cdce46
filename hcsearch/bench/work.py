"""What benches of error against time share: other engines, their settings, and runs of rising work, each timed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hcsearch.bench import exudyn_system, mujoco_system, pinocchio_system
from hcsearch.bench.states import Trajectory, UnableError
from hcsearch.bench.timing import ENOUGH
from hcsearch.dynamics.system import System

Reals = NDArray[np.float64]

OURS = "hcsearch"
PATIENCE, QUICK_PATIENCE = 8.0, 2.0
"""Seconds that a run may be expected to take, from the one before it."""
SHORT = 0.1
"""Seconds."""
MISSING = "not installed"
"""What an engine says that is not there."""


class Task(Protocol):
    """A system to follow from coordinates q and velocities v until a time (s)."""

    @property
    def system(self) -> System:
        """What moves."""

    @property
    def q(self) -> Reals:
        """Coordinates at the start."""

    @property
    def v(self) -> Reals:
        """Velocities at the start."""

    @property
    def end(self) -> float:
        """When it ends, s."""


@dataclass(frozen=True)
class Peer:
    """A method of another engine: its settings are tolerances, or steps as shares of a task's time."""

    engine: str
    method: str
    settings: tuple[float, ...]
    run: Callable[..., Trajectory]
    by_tolerance: bool = False
    fits: Callable[[Task], bool] = lambda _: True

    def sizes(self, task: Task, setting: float) -> tuple[float | None, float | None]:
        """Tolerance and step (s), one of which it has."""
        return (setting, None) if self.by_tolerance else (None, setting * task.end)

    def follow(self, task: Task, times: Reals, setting: float) -> Trajectory:
        """Run it."""
        size = {"tolerance": setting} if self.by_tolerance else {"step": setting * task.end}
        return self.run(task.system, task.q, task.v, times, **size)


def peers(quick: bool, outputs: int) -> list[Peer]:
    """Other engines, their methods and settings, the coarsest first; outputs : equal spaces between output times."""
    steps = tuple(1 / (outputs * k) for k in ((1, 10) if quick else (1, 3, 10, 30, 100, 300)))
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
        Peer("Exudyn", "RK4", steps[:5], partial(exudyn, integrator="RK44"), fits=lambda task: not task.system.welds),
    ]


def _is_stiff(task: Task) -> bool:
    return any(strut.damping for strut in task.system.struts)


class _Measured(Protocol):
    """A row of a table of work."""

    @property
    def seconds(self) -> float | None: ...
    @property
    def note(self) -> str: ...


Row = TypeVar("Row", bound=_Measured)


def rising(
    settings: Sequence[float],
    patience: float,
    blank: Callable[[float], Row],
    measure: Callable[[float], Row],
    *,
    by_tolerance: bool,
) -> Iterator[Row]:
    """Rows of rising work, until one would take too long; one with the reason where the engine is unable.

    blank : a row without numbers; measure : one with them, or UnableError.
    """
    took, before = 0.0, None
    for setting in settings:
        more = 2.0 if by_tolerance or before is None else before / setting
        if took * more > patience:
            yield noted(blank(setting), f"not tried: more than {patience:g} s")
            continue
        try:
            row = measure(setting)
        except UnableError as error:
            row = noted(blank(setting), str(error))
        yield row
        if row.note == MISSING:
            return
        if row.seconds is not None:
            took, before = row.seconds, setting


def noted(row: Row, note: str) -> Row:
    """The row with a note."""
    changed: Any = replace(row, note=note)  # type: ignore[type-var]
    found: Row = changed
    return found


def timed(run: Callable[[], float], repeats: int) -> tuple[float, int]:
    """Median of the seconds of runs, and how many there were: five times as many where they are short."""
    times = [run()]
    wanted = 5 * repeats if repeats > 1 and times[0] < SHORT else repeats
    while len(times) < wanted and sum(times) < ENOUGH:
        times.append(run())
    return float(np.median(times)), len(times)
