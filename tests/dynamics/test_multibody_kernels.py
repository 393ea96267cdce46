"""The recursions against dense twins, on random trees with welds, struts, laws, dampers, stops and gravity."""

import numpy as np
import pytest
from naive_dynamics import Twin, along, random_system

from hcsearch.kernels.multibody import accelerations, sweeps, welds
from hcsearch.kernels.multibody.hinges import joint_torques, kinetic_energy, lost_power, write_energies
from hcsearch.kernels.multibody.stops import push_apart
from hcsearch.kernels.multibody.tree import work_for

SEEDS = range(25)


class Case:
    """A random system in a random closed state, some joints held."""

    def __init__(self, seed, *, hold=0.0, **options):
        # some cannot be closed, or are all but singular: the first that can
        self.twin, self.q, self.v, self.held, self.rng = next(
            filter(None, (closed_state([seed, k], hold, **options) for k in range(20)))
        )
        self.mechanism, self.n = self.twin.system.mechanism, self.twin.n
        self.tree = self.mechanism.tree
        self.work = work_for(self.tree)
        signs = np.where(self.held, self.rng.choice([-1, 1], self.n), 0).astype(np.int8)
        self.hold = accelerations.discrete_state_for(self.mechanism, self.q)._replace(held=signs)
        self.scale = accelerations.largest_pivot(self.mechanism, self.q, self.work)

    def move(self):
        sweeps.place_bodies(self.tree, self.q, self.work)
        sweeps.move_bodies(self.tree, self.v, self.work)

    def accelerations(self):
        found = np.empty(self.n)
        assert accelerations.accelerate(self.mechanism, self.hold, self.q, self.v, self.scale, True, self.work, found)
        return found


def closed_state(seed, hold, **options):
    """Twin, coordinates, velocities, held joints; None where the loops do not close or are all but singular."""
    system, rng = random_system(seed, **options)
    twin, n = Twin(system), system.n_joints
    held = rng.random(n) < hold
    q, v = twin.closed(0.3 * rng.normal(size=n), rng.normal(size=n), held)
    rows = twin.rows(q)
    free = rows[:, ~held] @ np.linalg.inv(twin.masses(q)[np.ix_(~held, ~held)]) @ rows[:, ~held].T
    sizes = np.linalg.svd(free)[1] / (np.trace(rows @ rows.T) + 1e-300) if len(rows) else np.zeros(0)
    clear = not ((sizes > 1e-10) & (sizes < 1e-4)).any()
    is_closed = np.abs(twin.errors(q)).max(initial=0.0) < 1e-12 and np.abs(rows @ v).max(initial=0.0) < 1e-9
    return (twin, q, v, held, rng) if clear and is_closed else None


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_and_holding_forces_are_those_of_the_dense_equations(seed):
    case = Case(seed, hold=0.2)
    expected, holding = case.twin.accelerations(case.q, case.v, case.held)
    found = case.accelerations()
    size = max(1.0, np.abs(expected).max())
    assert found[~case.held] == pytest.approx(expected[~case.held], rel=1e-7, abs=1e-7 * size)
    rows = case.twin.rows(case.q)
    if np.linalg.matrix_rank(rows[:, ~case.held], 1e-6) == np.linalg.matrix_rank(rows, 1e-6):
        assert found[case.held] == pytest.approx(holding, rel=1e-7, abs=1e-7 * size)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_delassus_matrix_is_that_of_the_dense_equations(seed):
    case = Case(seed, hold=0.2)
    case.accelerations()
    free = ~case.held
    rows = case.twin.rows(case.q)[:, free]
    expected = rows @ np.linalg.inv(case.twin.masses(case.q)[np.ix_(free, free)]) @ rows.T
    assert case.work.delassus == pytest.approx(expected, rel=1e-9, abs=1e-9 * max(case.scale, 1e-300))


@pytest.mark.parametrize("seed", SEEDS)
def test_closure_errors_and_their_rates_are_those_of_plain_matrices(seed):
    case = Case(seed)
    anywhere = case.rng.normal(size=case.n)
    sweeps.place_bodies(case.tree, anywhere, case.work)
    worst = welds.weld_errors(case.tree, case.work, case.work.errors)
    assert case.work.errors == pytest.approx(case.twin.errors(anywhere), abs=1e-12)
    assert worst == np.abs(case.work.errors).max(initial=0.0)
    sweeps.move_bodies(case.tree, case.v, case.work)
    assert welds.weld_rates(case.tree, case.work, case.work.rates) == np.abs(case.work.rates).max(initial=0.0)
    assert case.work.rates == pytest.approx(case.twin.rows(anywhere) @ case.v, abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_rates_are_the_derivatives_of_the_errors_of_closed_loops(seed):
    case = Case(seed)
    v = case.rng.normal(size=case.n)
    sweeps.place_bodies(case.tree, case.q, case.work)
    sweeps.move_bodies(case.tree, v, case.work)
    welds.weld_rates(case.tree, case.work, case.work.rates)
    full = [k for k, (weld, kind) in enumerate(rows_of(case)) if whole(weld.kinds, kind)]
    assert case.work.rates[full] == pytest.approx(along(case.twin.errors, case.q, v)[full], abs=1e-8)


def rows_of(case):
    return [(weld, kind) for weld in case.twin.system.welds for kind in weld.kinds]


def whole(kinds, kind):
    """Whether turns are closed about all axes, where their residual is the turn itself; gaps are what they are."""
    return kind >= 3 or {0, 1, 2} <= set(kinds)


@pytest.mark.parametrize("seed", SEEDS)
def test_projection_closes_a_state_by_the_change_of_least_mass(seed):
    case = Case(seed, hold=0.1)
    case.accelerations()
    off = 1e-5
    q0 = case.q + np.where(case.held, 0.0, off * case.rng.normal(size=case.n))
    v0 = case.v + np.where(case.held, 0.0, off * case.rng.normal(size=case.n))
    expected = case.twin.closing_step(q0, case.held, case.twin.errors(q0))
    q, v = q0.copy(), v0.copy()
    error, rate = accelerations.project_state(case.tree, case.hold.held, q, v, 1e-15, case.work)
    assert error < 1e-13
    assert rate < 1e-9
    assert np.abs(case.twin.errors(q)).max(initial=0.0) < 1e-13
    assert q - q0 == pytest.approx(expected, abs=1e-3 * off)
    assert v - v0 == pytest.approx(case.twin.closing_step(q, case.held, case.twin.rows(q) @ v0), abs=1e-3 * off)
    assert (q[case.held] == q0[case.held]).all()
    assert (v[case.held] == v0[case.held]).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_energies_and_losses_are_those_of_plain_sums(seed):
    case = Case(seed)
    case.move()
    twin, mechanism, q, v = case.twin, case.mechanism, case.q, case.v
    parts = np.empty(4)
    write_energies(case.tree, mechanism.hinges, mechanism.struts, case.hold.branches, q, case.work, parts)
    expected = [0.5 * v @ twin.masses(q) @ v, twin.stored(q), twin.height(q), twin.in_stops(q)]
    assert parts == pytest.approx(expected, rel=1e-10, abs=1e-10)
    assert kinetic_energy(case.tree, case.work) == parts[0]
    lost = lost_power(mechanism.hinges, mechanism.struts, q, v, case.work)
    assert lost == pytest.approx(twin.lost_power(q, v), rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_energy_falls_by_what_is_lost(seed):
    case = Case(seed)
    twin, q, v = case.twin, case.q, case.v
    a = case.accelerations()

    def energy(t):
        x, u = q + t * v + t * t / 2 * a, v + t * a
        return 0.5 * u @ twin.masses(x) @ u + twin.stored(x) + twin.height(x) + twin.in_stops(x)

    power = along(lambda t: energy(t[0]), np.zeros(1), np.ones(1))
    assert power == pytest.approx(-twin.lost_power(q, v), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("seed", range(40))
def test_stops_push_joints_apart_by_the_least_change(seed):
    case = Case(seed, bodies=(3, 9), welds=1)
    touching = case.rng.choice([-1, 0, 1], case.n).astype(np.int8)
    wanted = np.where(touching != 0, case.rng.normal(size=case.n), 0.0)
    expected = case.twin.pushed_apart(case.q, touching, wanted)
    if expected is None:  # the loops leave too little freedom
        return
    case.move()
    sweeps.gather_inertias(case.tree, np.zeros(case.n, np.int8), case.work)
    pushed, change = np.empty(case.n), np.empty(case.n)
    assert push_apart(case.tree, touching, wanted, case.scale, case.work, pushed, change)
    size = max(1.0, np.abs(expected).max())
    assert change == pytest.approx(expected, abs=1e-4 * size)
    assert np.abs(case.twin.rows(case.q) @ change).max(initial=0.0) < 1e-6 * size
    active = (touching != 0) & (np.abs(-touching * change - wanted) < 1e-4 * size)
    assert not (pushed[~active]).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_closure_springs_pull_as_in_the_dense_equations(seed):
    case = Case(seed, hold=0.2, welds=1)
    q, v = case.q + 0.01 * case.rng.normal(size=case.n), case.rng.normal(size=case.n)
    stiffness, damping = case.rng.uniform(1.0, 50.0, 2)
    case.mechanism = case.mechanism._replace(closure_stiffness=stiffness, closure_damping=damping)
    case.q, case.v = q, v
    rows, gaps, free = case.twin.rows(q), case.twin.errors(q), ~case.held
    forces = case.twin.forces(q, v) - rows.T @ (stiffness * gaps + damping * rows @ v)
    expected = np.linalg.solve(case.twin.masses(q)[np.ix_(free, free)], forces[free])
    found = case.accelerations()[free]
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * max(1.0, np.abs(expected).max(initial=0.0)))
    case.move()
    stored, lost = accelerations.closure_energy(case.mechanism, case.work)
    assert stored == pytest.approx(0.5 * stiffness * gaps @ gaps, rel=1e-9)
    assert lost == pytest.approx(damping * np.sum((rows @ v) ** 2), rel=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_closure_springs_ahead_yield_as_in_the_dense_equations(seed):
    case = Case(seed, hold=0.2, welds=1)
    h, stiffness, damping = case.rng.uniform(0.01, 0.1), *case.rng.uniform(1.0, 50.0, 2)
    mechanism = case.mechanism._replace(closure_stiffness=stiffness, closure_damping=damping)
    accelerations.update_bodies(mechanism, case.hold, case.q, case.v, case.work)
    joint_torques(mechanism.hinges, case.hold.branches, case.q, case.v, case.work.torques)
    found = np.empty(case.n)
    accelerations.solve_accelerations_ahead(mechanism, case.hold, h, True, case.work, found)
    rows, free = case.twin.rows(case.q), ~case.held
    drift = along(lambda x: case.twin.rows(x) @ case.v, case.q, case.v)
    # gap and rate are 0 now, so that both are h^2 and h times the rows' acceleration then
    soft = h * h * stiffness + h * damping
    matrix = case.twin.masses(case.q) + soft * rows.T @ rows
    forces = case.twin.forces(case.q, case.v) - soft * rows.T @ drift
    expected = np.linalg.solve(matrix[np.ix_(free, free)], forces[free])
    assert found[free] == pytest.approx(expected, rel=1e-6, abs=1e-6 * max(1.0, np.abs(expected).max(initial=0.0)))
