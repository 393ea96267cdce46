"""Implicit steps against the same Runge-Kutta method with stages solved by dense equations."""

import numpy as np
import pytest
from scipy.optimize import root
from test_multibody_kernels import Case

from hcsearch.kernels.multibody.accelerations import Stepper
from hcsearch.kernels.multibody.implicit_steps import UNSOLVED_STAGE_ERROR
from hcsearch.kernels.multibody.integrators import write_stage
from hcsearch.kernels.multibody.steps import accelerate_at, take_step
from hcsearch.springs.dynamics.integration_methods import method_named

METHOD = method_named("implicit")
TOLERANCE = 1e-9


def step_of(case, h, tolerance=TOLERANCE):
    """Take an implicit step from the state of a case: its stepper and the error over the tolerance."""
    n = case.n
    stages, start, end = np.zeros((len(METHOD.b) + 1, 2 * n + 2)), np.zeros(2 * n + 2), np.zeros(2 * n + 2)
    start[:n], start[n : 2 * n] = case.q, case.v
    tables = (case.work, stages, start, end, np.zeros(6, np.int64))
    stepper = Stepper(case.mechanism, case.hold, case.scale, tolerance, tolerance, *tables)
    accelerate_at(stepper, start, True)
    write_stage(case.mechanism, case.hold, start, case.work.accelerations, case.work, stages[0])
    return stepper, take_step(METHOD, stepper, h)


def dense_step(case, accelerations, h):
    """The derivatives (s, 2 n) of the stages, and the state at the end: each stage by a general solver."""
    n, free, g = case.n, ~case.held, h * METHOD.diagonal
    state = np.concatenate([case.q, case.v])

    def derivative(y, a):
        return np.concatenate([np.where(free, y[n:], 0.0), np.where(free, a, 0.0)])

    derivatives = [derivative(state, accelerations(case.q, case.v))]
    for k in range(1, len(METHOD.b)):
        base = state + h * sum(METHOD.a[k, j] * derivatives[j] for j in range(k))

        def moved(a, base=base):
            v = base[n:] + g * np.where(free, a, 0.0)
            return np.concatenate([base[:n] + g * np.where(free, v, 0.0), v])

        def residual(a, moved=moved):
            y = moved(a)
            return np.where(free, accelerations(y[:n], y[n:]) - a, a)

        solved = root(residual, derivatives[-1][n:], tol=1e-13).x
        derivatives.append(derivative(moved(solved), solved))
    return np.array(derivatives), moved(solved)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("stiff", [1.0, 1e4])
def test_stages_solve_their_equations(seed, stiff):
    case = Case(seed, hold=0.2, welds=0)
    scaled = case.twin.system.drives
    dampers = np.array([drive.damping for drive in scaled])
    case.mechanism.hinges.damping[:] = stiff * dampers

    def accelerations(q, v):
        forces = case.twin.forces(q, v) - (stiff - 1.0) * dampers * v
        a, free = np.zeros(case.n), ~case.held
        a[free] = np.linalg.solve(case.twin.masses(q)[np.ix_(free, free)], forces[free])
        return a

    h = 1e-3
    stepper, error = step_of(case, h)
    derivatives, end = dense_step(case, accelerations, h)
    n, last = case.n, len(METHOD.b) - 1
    size = max(1.0, np.abs(end).max())
    assert stepper.end[: 2 * n] == pytest.approx(end, abs=10.0 * TOLERANCE * size)
    assert stepper.end[2 * n + 1] == pytest.approx(h)
    assert (stepper.stages[last + 1] == stepper.stages[last]).all()
    estimate = h * (METHOD.errors[0, : last + 1] @ derivatives)
    allowed = TOLERANCE * (1.0 + np.maximum(np.abs(end), np.abs(np.concatenate([case.q, case.v]))))
    expected = np.sqrt(np.mean((estimate / allowed) ** 2))
    assert error == pytest.approx(expected, rel=0.05, abs=1.0)
    assert not case.work.added_inertia.any()


@pytest.mark.parametrize("seed", [3, 6])
@pytest.mark.parametrize("stiffness", [10.0, 1e5])
def test_springs_that_close_loops_are_part_of_the_stages(seed, stiffness):
    case = Case(seed, hold=0.1, welds=1)
    damping = 1e-3 * stiffness
    case.mechanism = case.mechanism._replace(closure_stiffness=stiffness, closure_damping=damping)

    def accelerations(q, v):
        rows, free = case.twin.rows(q), ~case.held
        forces = case.twin.forces(q, v) - rows.T @ (stiffness * case.twin.errors(q) + damping * rows @ v)
        a = np.zeros(case.n)
        a[free] = np.linalg.solve(case.twin.masses(q)[np.ix_(free, free)], forces[free])
        return a

    stepper, _ = step_of(case, 1e-3)
    _, end = dense_step(case, accelerations, 1e-3)
    assert stepper.end[: 2 * case.n] == pytest.approx(end, abs=10.0 * TOLERANCE * max(1.0, np.abs(end).max()))


def test_a_stage_that_is_not_solved_asks_for_a_shorter_step():
    case = Case(3, welds=0)
    _, error = step_of(case, 1e3)
    assert error == UNSOLVED_STAGE_ERROR
    assert not case.work.added_inertia.any()
