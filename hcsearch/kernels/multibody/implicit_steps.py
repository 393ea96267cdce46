"""Implicit integration steps: singly diagonally implicit Runge-Kutta methods with an explicit first stage.

A stage solves v = v* + g a(q, v), q = q* + g v, with g the step times the diagonal coefficient. The Newton iteration
takes the slopes k of springs and c of dampers, which make motions stiff, as its Jacobian: they add g c + g^2 k to the
joint's own inertia, so that an iteration costs no more than an explicit stage. As stages are solved to a share of the
tolerance, what the Jacobian neglects takes iterations, not accuracy.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import (
    DiscreteState,
    Stepper,
    solve_accelerations,
    solve_accelerations_ahead,
    update_bodies,
)
from hcsearch.kernels.multibody.hinges import (
    add_drive_inertia,
    add_drive_torques,
    add_friction,
    joint_torques,
    set_factors,
    slope_and_damping,
    write_drive_targets,
)
from hcsearch.kernels.multibody.integrators import IntegrationMethod, combine_stages, step_error, write_stage

STAGE_TOLERANCE = 0.02
"""Greatest error of the solution of an implicit stage, over the tolerance of a step."""
NEGLIGIBLE_STAGE_CHANGE = 1e-4
"""Change of the solution of a stage, over the tolerance, with which it is accepted whatever the contraction."""
STALLED_STAGE_CHANGE = 1.0
"""Change, over the tolerance, up to which an iteration that contracts no further is taken to have converged."""
EPSILON, ROUNDING_SHARES, MAX_ROUNDING_ERROR = 2.0**-52, 10.0, 10.0
"""Rounding unit; multiple of the change by rounding of the state that counts as its rounding error; and the greatest,
over the tolerance, with which a stage is accepted."""
MAX_STAGE_ITERATIONS = 10
UNSOLVED_STAGE_ERROR = 16.0
"""Error of a step whose stages are not solved: with order 4, the next one is 0.45 times as long."""


@compiled
def implicit_step(method: IntegrationMethod, stepper: Stepper, h: float) -> float:
    """Take an implicit step of length h whose first stage is given; return its error over the tolerance.

    The last stage is at the end of the step (stiff accuracy), so its derivative is that at the end. The tables in
    `work` are left with the added inertia of that stage. A step whose stages are not solved is to be repeated, shorter.
    Errors are compared with the rounding error of accelerations where that is greater than the tolerance, as it may be
    near singular states, where only far shorter steps would make it less.
    """
    mechanism, hold, work, stages, end = stepper.mechanism, stepper.hold, stepper.work, stepper.stages, stepper.end
    n, last = len(hold.held), len(method.b) - 1
    work.row_accelerations[:] = 0.0
    contraction, noise = 1.0, 1.0
    for k in range(1, last + 1):
        combine_stages(method.a[k], k, h, stages, stepper.start, end)
        end[2 * n + 1] += h * method.diagonal
        contraction, rounding = _solve_stage(method, stepper, k, h, contraction)
        if contraction < 0.0:
            work.added_inertia[:] = 0.0
            return UNSOLVED_STAGE_ERROR
        noise = max(noise, rounding)
        write_stage(mechanism, hold, end, work.accelerations, work, stages[k])
        end[2 * n] += h * method.diagonal * stages[k, 2 * n]
    work.added_inertia[:] = 0.0
    for i in range(2 * n + 2):
        stages[last + 1, i] = stages[last, i]
    end[2 * n + 1] = stepper.start[2 * n + 1] + h
    return h * step_error(method.errors, stepper) / noise


@compiled
def _solve_stage(
    method: IntegrationMethod, stepper: Stepper, k: int, h: float, contraction: float
) -> tuple[float, float]:
    """Solve stage k of an implicit step; return contraction and rounding error of the iteration.

    The contraction is -1 where the iteration does not converge. The rounding error, over the tolerance, is 0 where it
    is less than what a stage may be off by.

    stepper.end : (q*, v*), what earlier stages give, which becomes the state of the stage; its accelerations (its
        velocities, in overdamped motion) are left in `work.accelerations`. contraction : of the stage before.
    """
    hold, work, end, overdamped = stepper.hold, stepper.work, stepper.end, stepper.mechanism.overdamped
    n, g = len(hold.held), h * method.diagonal
    guess, given = stepper.stages[k], work.trial
    for i in range(n):
        given[0, i], given[1, i] = end[i], end[n + i]
        guess[i] = 0.0
        for j in range(k):
            guess[i] += method.predictors[k, j] * stepper.stages[j, i if overdamped else n + i]
    before = 0.0
    for iteration in range(MAX_STAGE_ITERATIONS):
        _move_stage(hold, overdamped, g, given, guess, end)
        change = _iterate(stepper, g, guess)
        if iteration == 0 and stepper.mechanism.closure_stiffness > 0.0:
            continue  # the accelerations of the rows were not those of the guess
        if before > 0.0:
            contraction = change / before
        stalls = before > 0.0 and contraction >= 1.0
        rounding = 0.0
        if stalls and change > STALLED_STAGE_CHANGE:
            rounding = min(_rounding_error(stepper, g, guess), MAX_ROUNDING_ERROR)
        if not change < 1e100 or (stalls and change > STALLED_STAGE_CHANGE + rounding):
            return -1.0, 0.0
        if stalls or contraction * change <= STAGE_TOLERANCE * (1.0 - contraction) or change <= NEGLIGIBLE_STAGE_CHANGE:
            _move_stage(hold, overdamped, g, given, guess, end)
            return min(contraction, 1.0), rounding
        before = change
    return -1.0, 0.0


@compiled
def _iterate(stepper: Stepper, g: float, guess: Reals) -> float:
    """Improve the guessed accelerations of a stage by a Newton step; return the change of the state over the tolerance.

    They are left in `work.accelerations`, too.
    """
    hold, overdamped, a = stepper.hold, stepper.mechanism.overdamped, stepper.work.accelerations
    n = len(hold.held)
    _accelerate_ahead(stepper, g, guess, a)
    stepper.counts[2] += 1
    change = 0.0
    for i in range(n):
        if hold.held[i]:
            continue
        velocity_change = g * (a[i] - guess[i])
        guess[i] = a[i]
        if overdamped:
            change += (velocity_change / _allowed(stepper, i)) ** 2
        else:
            change += (velocity_change / _allowed(stepper, n + i)) ** 2
            change += (g * velocity_change / _allowed(stepper, i)) ** 2
    return math.sqrt(change / (2 * n))


@compiled
def _rounding_error(stepper: Stepper, g: float, guess: Reals) -> float:
    """Return how far a stage may be off by rounding, over the tolerance: `ROUNDING_SHARES` of a state's last digit."""
    end, n = stepper.end, len(stepper.hold.held)
    _iterate(stepper, g, guess)
    for i in range(n):
        if not stepper.hold.held[i]:
            end[i] *= 1.0 + 2.0 * EPSILON
            end[n + i] *= 1.0 + 2.0 * EPSILON
    return ROUNDING_SHARES * _iterate(stepper, g, guess)


@compiled
def _move_stage(hold: DiscreteState, overdamped: bool, g: float, given: Reals, guess: Reals, end: Reals) -> None:
    """Write the state of a stage, (q, v), by its accelerations, or its velocities in overdamped motion."""
    n = len(hold.held)
    for i in range(n):
        if hold.held[i]:
            continue
        if not overdamped:
            end[n + i] = given[1, i] + g * guess[i]
        end[i] = given[0, i] + g * (guess[i] if overdamped else end[n + i])


@compiled
def _allowed(stepper: Stepper, j: int) -> float:
    """Return the error allowed in an entry of the state at the end of a step."""
    size = max(abs(stepper.start[j]), abs(stepper.end[j]))
    allowed: float = stepper.absolute_tolerance + stepper.relative_tolerance * size
    return allowed


@compiled
def _accelerate_ahead(stepper: Stepper, g: float, guess: Reals, a: Reals) -> None:
    """Write the accelerations of a stage by one Newton step from a guess, whose state is in `stepper.end`."""
    mechanism, hold, work, end = stepper.mechanism, stepper.hold, stepper.work, stepper.end
    hinges, n = mechanism.hinges, len(hold.held)
    q, v = end[:n], end[n : 2 * n]
    work.time[0] = end[2 * n + 1]
    update_bodies(mechanism, hold, q, v, work)
    set_factors(hinges, work.time[0])
    joint_torques(hinges, hold.branches, q, v, work.torques)
    add_friction(hinges, hold.slides, work.torques)
    for i in range(n):
        slope, damping = slope_and_damping(hinges, i, hold.branches[i], q[i])
        ahead = g * slope if mechanism.overdamped else g * (damping + g * slope)
        work.added_inertia[i] = damping + ahead if mechanism.overdamped else ahead
        work.torques[i] += ahead * guess[i]
    write_drive_targets(mechanism.targets, work.time[0], work)
    add_drive_torques(mechanism.targets, q, v, work, work.torques)
    add_drive_inertia(mechanism.targets, g, guess, work)
    if mechanism.closure_stiffness > 0.0:
        solve_accelerations_ahead(mechanism, hold, g, False, work, a)
    else:
        solve_accelerations(mechanism, hold, stepper.scale, False, work, a)
