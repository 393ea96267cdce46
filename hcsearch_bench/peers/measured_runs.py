"""Runs of one system by our engine and by others, each measured and compared with a reference."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Generic

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.time_integration import Motion, simulate_system
from hcsearch_bench.peers.multibody import Peer, Task
from hcsearch_bench.peers.states import Trajectory, energy_error
from hcsearch_bench.run.timing import measured
from hcsearch_bench.run.work_precision import OURS, AnyRow, rising

WARMING = 1e-4
"""Share of a task's time that is simulated before the clock runs: kernels are compiled, and tables made."""


@dataclass(frozen=True)
class Comparison(Generic[AnyRow]):
    """What the runs of a task are compared with.

    times : at which errors are taken, s. max_steps : of ours. blank : a row without numbers, by engine, method,
    tolerance and step (s). judged : such a row with errors and verdict, by the coordinates at the times and the whole
    motion. factor : of our energies, where symmetry leaves bodies out.
    """

    task: Task
    times: Reals
    max_steps: int
    blank: Callable[[str, str, float | None, float | None], AnyRow]
    judged: Callable[[AnyRow, Reals, Motion | Trajectory], AnyRow]
    factor: float = 1.0

    def our_rows(self, settings: Mapping[str, Sequence[float]], repeats: int, patience: float) -> Iterator[AnyRow]:
        """Our engine gives a row a method and tolerance."""
        for method, tolerances in settings.items():
            blank, measure = partial(self._our_blank, method), partial(self.our_row, method, repeats=repeats)
            yield from rising(tolerances, patience, blank, measure, by_tolerance=True)

    def _our_blank(self, method: str, tolerance: float) -> AnyRow:
        return self.blank(OURS, method, tolerance, None)

    def our_row(self, method: str, tolerance: float, *, repeats: int = 1) -> AnyRow:
        """Our engine gives a row of one method and tolerance."""
        run = partial(our_motion, self.task, method, tolerance, self.max_steps)
        run(share=WARMING)
        motion, seconds, runs = measured(run, repeats)
        row = replace(self._our_blank(method, tolerance), evaluations=motion.evaluations, seconds=seconds, runs=runs)
        if motion.ending != "time":
            return replace(row, note=f"refused: {motion.ending} at {motion.times[-1]:.3g} s")
        return self.judged(replace(row, energy=self.factor * motion.drift), motion.at(self.times), motion)

    def peer_rows(self, peer: Peer, repeats: int, patience: float) -> Iterator[AnyRow]:
        """Another engine gives rows of rising work."""
        blank, measure = partial(self._peer_blank, peer), partial(self._peer_row, peer, repeats)
        return rising(peer.settings, patience, blank, measure, by_tolerance=peer.by_tolerance)

    def _peer_blank(self, peer: Peer, setting: float) -> AnyRow:
        return self.blank(peer.engine, peer.method, *peer.sizes(self.task, setting))

    def _peer_row(self, peer: Peer, repeats: int, setting: float) -> AnyRow:
        motion, seconds, runs = peer.measured(self.task, self.times, setting, repeats)
        row = replace(self._peer_blank(peer, setting), evaluations=motion.evaluations, seconds=seconds, runs=runs)
        return self.judged(replace(row, energy=energy_error(self.task.system, motion)), motion.q, motion)


def our_motion(
    task: Task, method: str, tolerance: float, max_steps: int, *, longest: float = np.inf, share: float = 1.0
) -> Motion:
    """Our engine follows a task, or a share of its time; longest : step, s."""
    options = {"tolerance": tolerance, "longest_step": longest, "max_steps": max_steps, "end": share * task.end}
    return simulate_system(task.system, task.q, task.v, method=method, **options)  # type: ignore[arg-type]
