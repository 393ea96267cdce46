"""Other multibody engines as peers of ours: their methods and settings, and how each is run on a system."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.system import System
from hcsearch_bench.peers import exudyn_system, mujoco_system, pinocchio_system
from hcsearch_bench.peers.states import Trajectory
from hcsearch_bench.run.timing import median_time


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

    def measured(self, task: Task, times: Reals, setting: float, repeats: int) -> tuple[Trajectory, float, int]:
        """What it gives, the median of the seconds of its integration, and how many runs there were."""
        last: list[Trajectory] = []

        def run() -> float:
            last[:] = [self.follow(task, times, setting)]
            return last[0].seconds

        seconds, runs = median_time(run, repeats)
        return last[0], seconds, runs


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
