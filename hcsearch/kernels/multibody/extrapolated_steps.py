"""Extrapolated linearly implicit Euler steps.

In a linearly implicit step of length h, a spring of slope k and a damper c add h c + h^2 k to the joint's own inertia,
so that the step costs no more than an explicit one. Steps in 1, 2, 3, ... parts are extrapolated to h = 0 (Deuflhard
1985; Hairer and Wanner 1996, section IV.9). The order falls where motions are stiff, but springs that close loops,
which are nearly constraints of positions, allow far longer steps than in `implicit_steps`.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import (
    DiscreteState,
    Mechanism,
    Stepper,
    solve_accelerations,
    solve_accelerations_ahead,
    update_bodies,
)
from hcsearch.kernels.multibody.drag import drag_power
from hcsearch.kernels.multibody.hinges import (
    add_drive_torques_ahead,
    add_friction,
    driving_power,
    friction_power,
    joint_torques,
    lost_power,
    set_factors,
    slope_and_damping,
    write_drive_targets,
)
from hcsearch.kernels.multibody.tree import Work
from hcsearch.kernels.multibody.welds import cut_energy, spring_loss


@compiled
def _euler_step(
    mechanism: Mechanism, hold: DiscreteState, h: float, scale: float, work: Work, a: Reals, state: Reals
) -> None:
    """Advance a state (q, v, energy lost, time) by one linearly implicit Euler step.

    Without inertia the velocities at its start do not count: dampers and springs decide those of the step.
    """
    n = len(a)
    q, v = state[:n], state[n : 2 * n]
    if mechanism.overdamped:
        v[:] = 0.0
    update_bodies(mechanism, hold, q, v, work)
    set_factors(mechanism.hinges, state[2 * n + 1] + h)
    joint_torques(mechanism.hinges, hold.branches, q, v, work.torques)
    add_friction(mechanism.hinges, hold.slides, work.torques)
    for i in range(n):
        slope, damping = slope_and_damping(mechanism.hinges, i, hold.branches[i], q[i])
        work.added_inertia[i] = h * damping + h * h * slope
        work.torques[i] -= h * slope * v[i]
    state[2 * n + 1] += h
    write_drive_targets(mechanism.targets, state[2 * n + 1], work)
    add_drive_torques_ahead(mechanism.targets, h, q, v, work)
    if mechanism.closure_stiffness > 0.0:
        work.row_accelerations[:] = 0.0
        solve_accelerations_ahead(mechanism, hold, h, True, work, a)
    else:
        solve_accelerations(mechanism, hold, scale, False, work, a)
    for i in range(n):
        if not hold.held[i]:
            v[i] += h * a[i]
            q[i] += h * v[i]
    lost = lost_power(mechanism.hinges, mechanism.struts, q, v, work)
    state[2 * n] += h * (lost - driving_power(mechanism.targets, q, v, work))
    if len(hold.slides):
        state[2 * n] += h * friction_power(mechanism.hinges, hold.slides, v)
    if len(mechanism.cuts.bodies):
        _, _, _, lost = cut_energy(mechanism.cuts, hold.cut_branches, work)
        state[2 * n] += h * lost
    if mechanism.closure_stiffness > 0.0:
        state[2 * n] += h * spring_loss(mechanism.closure_damping, work)
    if len(mechanism.drag.bodies):
        state[2 * n] += h * drag_power(mechanism.drag, work)


@compiled
def extrapolated_step(columns: int, stepper: Stepper, h: float) -> float:
    """Take an extrapolated step of order `columns`; return its error over the tolerance. Overwrites stages[1:]."""
    hold, work, table, start, end = stepper.hold, stepper.work, stepper.stages[1:], stepper.start, stepper.end
    n = len(hold.held)
    a = work.accelerations
    error = 0.0
    for j in range(columns):
        for i in range(2 * n + 2):
            end[i] = start[i]
        for _ in range(j + 1):
            _euler_step(stepper.mechanism, hold, h / (j + 1), stepper.scale, work, a, end)
        # Aitken and Neville: row k of the table holds the extrapolation of order k
        for i in range(2 * n + 2):
            value = end[i]
            for k in range(j):
                old = table[k, i]
                table[k, i] = value
                value += (value - old) / ((j + 1.0) / (j - k) - 1.0)
            table[j, i] = value
    work.added_inertia[:] = 0.0
    end[2 * n] = table[columns - 1, 2 * n]
    end[2 * n + 1] = start[2 * n + 1] + h
    for i in range(2 * n):
        if i >= n and stepper.mechanism.overdamped:
            end[i] = 0.0
            continue
        end[i] = table[columns - 1, i]
        weight = stepper.absolute_tolerance + stepper.relative_tolerance * max(abs(start[i]), abs(end[i]))
        error += ((table[columns - 1, i] - table[columns - 2, i]) / weight) ** 2
    return math.sqrt(error / (2 * n))
