"""The cost of one evaluation of the accelerations as a loop, or a chain, gets longer."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hcsearch.kernels.multibody.accelerations import accelerate, discrete_state_for, largest_pivot
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes.laws import linear_law
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, prism_body
from hcsearch.springs.dynamics.system import JointDrive, System
from hcsearch.springs.dynamics.time_integration import simulate_system
from hcsearch_bench.kernels.repeating import accelerate_often

EVALUATED = 100_000
"""Panels times evaluations that are timed together."""
STEPS, STEP = 200, 1e-6
"""Steps that are timed, and their length, s."""
SIDE, THICKNESS, DENSITY = 0.05, 0.006, 547.0


@dataclass(frozen=True)
class EvaluationRow:
    """A loop or chain of n panels: microseconds an evaluation of the accelerations, also over the panels.

    step_us : of a whole step with its projection, books and record, over the evaluations in it. slope : of the
    evaluations of all sizes of this kind, by least squares of logarithms.
    """

    kind: str
    panels: int
    evaluations: int
    evaluation_us: float
    panel_us: float
    step_us: float
    slope: float


def strip(n: int, *, closed: bool) -> System:
    """Panels hinged in parallel in a ring, each turned by 1/n of a turn against the one before.

    Joint i is between panels i - 1 and i, joint 0 at the ground. closed : whether the last panel is welded to the
    ground where joint 0 is.
    """
    turn = 2 * np.pi / n
    axis = np.array([0.0, 1.0, 0.0])
    joints, bodies = [], []
    place = np.zeros(3)
    flat = prism_body([(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)], THICKNESS, DENSITY)
    for i in range(n):
        c, s = np.cos(i * turn), np.sin(i * turn)
        rotation = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        joints.append(TreeJoint(i - 1 if i else GROUND, axis, place))
        bodies.append(Body(flat.mass, place + rotation @ flat.centre, rotation @ flat.inertia @ rotation.T))
        place = place + SIDE * rotation[:, 0]
    welds = (Weld(GROUND, n - 1, place),) if closed else ()
    return System(tuple(joints), tuple(bodies), (JointDrive(linear_law(0.1), 0.0043),) * n, welds, size=SIDE)


def evaluation_rows(sizes: Sequence[int], repeats: int) -> list[EvaluationRow]:
    """A row a size, of loops and of chains."""
    timed = []
    for kind, closed in (("loop", True), ("chain", False)):
        rows = [_row(kind, strip(n, closed=closed), repeats) for n in sizes]
        slope = slope_of([row.panels for row in rows], [row.evaluation_us for row in rows])
        timed += [replace(row, slope=slope) for row in rows]
    return timed


def _row(kind: str, system: System, repeats: int) -> EvaluationRow:
    n = system.n_joints
    evaluations = max(1, EVALUATED // n)
    evaluation = _evaluation_us(system, evaluations, repeats)
    return EvaluationRow(kind, n, evaluations, evaluation, evaluation / n, _step_us(system, repeats), 0.0)


def _evaluation_us(system: System, evaluations: int, repeats: int) -> float:
    mechanism, still = system.mechanism, np.zeros(system.n_joints)
    hold, work, accelerations = discrete_state_for(mechanism, still), work_for(mechanism.tree), np.empty_like(still)
    scale = largest_pivot(mechanism, still, work)
    accelerate(mechanism, hold, still, still, scale, True, work, accelerations)

    def run(times: int) -> float:
        begin = time.perf_counter()
        accelerate_often(mechanism, hold, still, still, scale, times, work, accelerations)
        return time.perf_counter() - begin

    run(1)
    return 1e6 * float(np.median([run(evaluations) for _ in range(repeats)])) / evaluations


def _step_us(system: System, repeats: int) -> float:
    v = np.zeros(system.n_joints)

    def run(steps: int) -> tuple[float, int]:
        # steps of one length, so short that none is rejected
        begin = time.perf_counter()
        motion = simulate_system(
            system, v, v, end=steps * STEP, tolerance=1.0, first_step=STEP, longest_step=STEP, max_steps=2 * steps
        )
        return time.perf_counter() - begin, motion.evaluations

    run(2)  # compiled, and its tables made
    each = []
    for _ in range(repeats):
        fewest, many = run(STEPS // 10), run(STEPS)
        each.append((many[0] - fewest[0]) / (many[1] - fewest[1]))  # without what comes once a simulation
    return 1e6 * float(np.median(each))


def slope_of(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Exponent of the power of the size that fits best."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])
