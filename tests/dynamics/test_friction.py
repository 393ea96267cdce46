"""Coulomb friction with sticking: exact motions, the dense problem of Gauss's principle, energy, and MuJoCo."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_dynamics import Twin, random_body, random_system
from scipy.optimize import lsq_linear

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.linkage.boxed_quadratics import minimise_in_box
from hcsearch.kernels.multibody import accelerations, sticking
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes.laws import FREE_LAW, linear_law
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint
from hcsearch.springs.dynamics.law_torques import holding_friction
from hcsearch.springs.dynamics.system import JointDrive, Strut, System
from hcsearch.springs.dynamics.time_integration import simulate_system

Y = np.array([0.0, 1.0, 0.0])
X = np.array([1.0, 0.0, 0.0])


def wheel(inertia, drive):
    """One joint that turns a body of some inertia about its centre."""
    return System((TreeJoint(-1, Y, np.zeros(3)),), (Body(1.0, np.zeros(3), inertia * np.eye(3)),), (drive,))


# quadratics within bounds


@settings(max_examples=200)
@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.floats(0.0, 0.6))
def test_a_quadratic_within_bounds_is_bounded_least_squares(seed, n, open_share):
    rng = np.random.default_rng(seed)
    root, target = rng.normal(size=(n + 2, n)), rng.normal(size=n + 2)
    lower, upper = -rng.uniform(0.0, 0.5, n), rng.uniform(0.0, 0.5, n)
    lower[rng.random(n) < open_share], upper[rng.random(n) < open_share] = -np.inf, np.inf
    lower[rng.random(n) < 0.2] = -0.0
    upper[lower == upper] = 0.1
    x = np.empty(n)
    assert minimise_in_box(root.T @ root, -root.T @ target, lower, upper, x)
    expected = lsq_linear(root, target, (lower, upper), method="bvls", tol=1e-14).x
    assert x == pytest.approx(expected, abs=1e-8)


def test_forces_of_two_equal_joints_share_what_both_can_bear():
    gram = np.ones((2, 2)) + 1e-8 * np.eye(2)
    x = np.empty(2)
    assert minimise_in_box(gram, np.array([-1.0, -1.0]), np.array([-0.1, -5.0]), np.array([0.1, 5.0]), x)
    assert x == pytest.approx([0.1, 0.9], abs=1e-7)


# one joint


@settings(max_examples=30)
@given(st.floats(0.1, 5.0), st.floats(0.01, 3.0), st.floats(0.05, 3.0), st.floats(0.1, 4.0))
def test_a_joint_with_a_constant_torque_decelerates_and_sticks_or_turns_back(inertia, pull, resistance, speed):
    if abs(pull - resistance) < 1e-3 * resistance:
        return
    system = wheel(inertia, JointDrive(linear_law(0.0, pull), friction=resistance))
    rest_time = inertia * speed / (pull + resistance)
    rest_place = 0.5 * speed * rest_time
    motion = simulate_system(system, np.zeros(1), np.array([speed]), end=2.0 * rest_time)
    if pull < resistance:
        assert motion.ending == "stuck"
        assert motion.times[-1] == pytest.approx(rest_time, rel=1e-9)
        assert motion.q[-1, 0] == pytest.approx(rest_place, rel=1e-9)
        assert motion.v[-1, 0] == 0.0
        assert [(event.kind, event.joint) for event in motion.events] == [("stuck", 0)]
        assert holding_friction(system, motion.q[-1]) == pytest.approx([pull], abs=1e-12)
    else:
        assert motion.ending == "time"
        back = (pull - resistance) / inertia
        assert motion.v[-1, 0] == pytest.approx(-back * rest_time, rel=1e-8)
        assert motion.q[-1, 0] == pytest.approx(rest_place - 0.5 * back * rest_time**2, rel=1e-8, abs=1e-10)
        assert holding_friction(system, motion.q[-1]) == pytest.approx([resistance])
    assert motion.drift < 1e-8 * motion.largest_energy


@settings(max_examples=20)
@given(st.floats(0.2, 3.0), st.floats(0.5, 5.0), st.floats(0.02, 0.3), st.floats(0.5, 3.0))
def test_a_spring_swings_half_a_period_at_a_time_until_friction_holds_it(inertia, stiffness, shift, start):
    turns = (start / shift - 1.0) / 2.0
    if abs(turns - round(turns)) < 1e-3:
        return
    half, count = math.pi * math.sqrt(inertia / stiffness), math.ceil(max(turns, 0.0))
    system = wheel(inertia, JointDrive(linear_law(stiffness), friction=shift * stiffness))
    motion = simulate_system(system, np.array([start]), end=(count + 1) * half, tolerance=1e-10)
    assert motion.ending == "stuck"
    assert motion.times[-1] == pytest.approx(count * half, rel=1e-7)
    assert motion.q[-1, 0] == pytest.approx((-1.0) ** count * (start - 2.0 * count * shift), abs=1e-6)
    path = sum(2.0 * (start - (2 * k + 1) * shift) for k in range(count))
    assert motion.damped[-1] == pytest.approx(shift * stiffness * path, rel=1e-6, abs=1e-12)


def test_a_motion_that_a_damper_slows_down_ever_more_is_stuck_where_friction_balances_the_spring():
    stiffness, damping, resistance = 1.0, 0.1, 0.3
    system = wheel(1e-5, JointDrive(linear_law(stiffness), damping, friction=resistance))
    motion = simulate_system(system, np.array([1.0]), end=3.0, rest=1e-4)
    balance, decay = resistance / stiffness, stiffness / damping
    slow = math.log((1.0 - balance) * decay * 2.0 / 1e-4) / decay  # when its rate would turn it by 1e-4 rad
    assert motion.ending == "stuck"
    assert motion.times[-1] == pytest.approx(slow, rel=0.05)
    assert motion.q[-1, 0] == pytest.approx(balance, abs=1e-4)
    faster = simulate_system(system, np.array([1.001 * balance + 1e-6]), end=3.0, rest=1e-4)
    assert faster.times[-1] > 0.0  # what begins to move is not stuck, however slow
    assert motion.drift < 1e-6 * motion.largest_energy


def dragged_block(speed, stiffness, mass, resistance):
    """A heavy tug that drags a block with friction by a spring; and the rates at its start."""
    tug, block = Body(1e6, np.zeros(3), np.eye(3)), Body(mass, -X, np.eye(3))
    joints = TreeJoint(GROUND, X, np.zeros(3), True), TreeJoint(GROUND, X, -X, True)
    strut = Strut(0, 1, np.zeros(3), -X, stiffness, rest=1.0)
    return System(joints, (tug, block), (JointDrive(), JointDrive(friction=resistance)), struts=(strut,)), [speed, 0.0]


def test_a_block_that_a_spring_drags_slips_when_the_spring_bears_its_friction():
    speed, stiffness, mass, resistance = 0.5, 20.0, 0.3, 1.5
    system, rates = dragged_block(speed, stiffness, mass, resistance)
    slip, rate = resistance / (stiffness * speed), math.sqrt(stiffness / mass)
    end = slip + 1.5 * math.pi / rate
    motion = simulate_system(system, np.zeros(2), np.array(rates), end=end, tolerance=1e-10)
    (event,) = motion.events
    assert (event.kind, event.joint) == ("slips", 1)
    assert event.time == pytest.approx(slip, rel=1e-4)
    after = motion.times[motion.times > slip] - slip
    assert len(after) > 10
    places = motion.q[motion.times > slip, 1]
    assert places == pytest.approx(speed * (after - np.sin(rate * after) / rate), abs=1e-6)
    assert (motion.q[motion.times < 0.999 * slip, 1] == 0.0).all()


@pytest.mark.parametrize("rest_time", [0.1, 0.16, 0.25])
def test_a_slip_is_not_missed_in_a_step_in_which_another_joint_comes_to_rest(rest_time):
    block, rates = dragged_block(0.5, 20.0, 0.3, 1.5)
    wheel_joint, body = TreeJoint(GROUND, Y, np.array([0.0, 9.0, 0.0])), Body(1.0, np.zeros(3), np.eye(3))
    system = replace(
        block,
        joints=(*block.joints, wheel_joint),
        bodies=(*block.bodies, body),
        drives=(*block.drives, JointDrive(friction=2.0)),
    )
    motion = simulate_system(system, np.zeros(3), np.array([*rates, 2.0 * rest_time]), end=0.3)
    expected = sorted([(0.15, "slips", 1), (rest_time, "stuck", 2)])
    assert [(event.kind, event.joint) for event in motion.events] == [place[1:] for place in expected]
    assert [event.time for event in motion.events] == pytest.approx([time for time, *_ in expected], rel=1e-4)
    assert motion.q[-1, 2] == pytest.approx(rest_time**2, rel=1e-8)


def test_a_joint_at_its_stop_needs_a_pull_above_its_friction_to_leave_it():
    for pull, ending in ((0.3, "stuck"), (0.5, "time"), (-0.3, "rest")):
        drive = JointDrive(linear_law(0.0, pull), lower=-math.inf, upper=0.0, friction=0.4)
        motion = simulate_system(wheel(1.0, drive), np.zeros(1), end=1.0, rest=1e-6)
        assert motion.ending == ending
        moved = 0.5 * (pull - 0.4) if pull > 0.4 else 0.0
        assert motion.q[-1, 0] == pytest.approx(-moved, abs=1e-9)


def test_rest_without_the_help_of_friction_is_rest():
    motion = simulate_system(wheel(1.0, JointDrive(friction=1.0)), np.array([0.3]), end=1.0, rest=1e-4)
    assert (motion.ending, len(motion.times)) == ("rest", 1)
    assert holding_friction(wheel(1.0, JointDrive()), np.zeros(1)) == pytest.approx([0.0])


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_friction_below_zero_is_refused(value):
    with pytest.raises(HcsearchError, match="give 0 N m or more"):
        JointDrive(friction=value)


def test_soft_stops_and_overdamped_motion_refuse_friction():
    system = wheel(1.0, JointDrive(FREE_LAW, 0.1, friction=0.1))
    for change in ({"stop_stiffness": 1.0}, {"closure_stiffness": 1.0}, {"overdamped": True}):
        with pytest.raises(HcsearchError, match="take the constrained formulation"):
            replace(system, **change)


# many joints


def frictional(seed):
    """A random closed system with hard stops at some joints, joints at rest, and friction in most; or None."""
    system, rng = random_system(seed, bodies=(3, 9), struts=1)
    n = system.n_joints
    twin = Twin(replace(system, stop_stiffness=0.0, stop_damping=0.0))
    resting = rng.random(n) < 0.6
    q, v = twin.closed(0.3 * rng.normal(size=n), rng.normal(size=n), resting)
    rows, basis = twin.rows(q), closed_rates(twin, q)
    if np.abs(twin.errors(q)).max(initial=0.0) > 1e-12 or np.abs(rows @ v).max(initial=0.0) > 1e-9:
        return None
    if (
        not basis.shape[1]
        or np.linalg.svd(basis[resting])[1][: min(resting.sum(), basis.shape[1])].min(initial=1) < 1e-2
    ):
        return None
    sizes = np.linalg.svd(rows)[1] if len(rows) else np.zeros(0)
    if ((sizes > 1e-8) & (sizes < 1e-3)).any():
        return None
    resting |= np.abs(v) < 1e-12  # the loops hold it
    v[resting] = 0.0
    limits = np.where(rng.random(n) < 0.8, rng.uniform(0.0, 3.0, n), 0.0)
    stops = np.where(resting & (rng.random(n) < 0.4), rng.choice([-1, 1], n), 0)
    drives = tuple(
        replace(
            drive,
            lower=q[i] if stops[i] < 0 else -math.inf,
            upper=q[i] if stops[i] > 0 else math.inf,
            friction=float(limits[i]),
        )
        for i, drive in enumerate(twin.system.drives)
    )
    return replace(twin.system, drives=drives), q, v, resting, limits, stops


def closed_rates(twin, q):
    rows = twin.rows(q)
    if not len(rows):
        return np.eye(twin.n)
    _, sizes, vt = np.linalg.svd(rows)
    return vt[np.count_nonzero(sizes > 1e-7 * max([1.0, *sizes])) :].T


def gauss(system, q, v, resting, limits, stops):
    """Accelerations by the dense dual problem, bounded-variable least squares of SciPy."""
    twin = Twin(replace(system, drives=tuple(replace(drive, friction=0.0) for drive in system.drives)))
    basis, masses = closed_rates(twin, q), twin.masses(q)
    sliding = np.where(resting, 0.0, limits * np.sign(v))
    free, _ = twin.accelerations(q, v, np.zeros(twin.n, bool))
    spread = basis @ np.linalg.solve(basis.T @ masses @ basis, basis.T)
    free = free - spread @ sliding
    is_mobile = np.linalg.norm(basis, axis=1) > 1e-9
    at = np.flatnonzero(resting & is_mobile & ((limits > 0.0) | (stops != 0)))
    if not len(at):
        return free
    root = np.linalg.solve(np.linalg.cholesky(basis.T @ masses @ basis), basis[at].T)
    lower = np.where(stops[at] > 0, -np.inf, -limits[at])
    upper = np.where(stops[at] < 0, np.inf, limits[at])
    target = np.linalg.lstsq(root.T, free[at], rcond=1e-9)[0]
    if np.abs(root.T @ target - free[at]).max() > 1e-7:  # loops tie these accelerations together
        return None
    forces = lsq_linear(root, -target, (lower, upper), method="bvls", tol=1e-15, max_iter=1000).x
    return free + spread[:, at] @ forces


@pytest.mark.parametrize("seed", range(60))
def test_joints_at_rest_stick_and_slide_by_gauss_principle(seed):
    case = next(filter(None, (frictional([seed, k]) for k in range(40))))
    system, q, v, resting, limits, _ = case
    expected = gauss(*case)
    if expected is None or not limits.any():
        return
    mechanism, n = system.mechanism, system.n_joints
    work, hold = work_for(mechanism.tree), accelerations.discrete_state_for(mechanism, q)
    scale, found = accelerations.largest_pivot(mechanism, q, work), np.empty(n)
    sticking.settle_joints(mechanism, hold, 1e-2, -1, q.copy(), v.copy(), scale, work, found)
    found[hold.held != 0] = 0.0
    size = max(1.0, np.abs(expected).max())
    assert found == pytest.approx(expected, abs=1e-5 * size)
    starting = resting & (limits > 0.0) & (np.abs(expected) > 1e-4 * size)
    assert (hold.slides[starting] == np.sign(expected[starting])).all()
    assert (hold.slides[~resting & (limits > 0.0)] == np.sign(v[~resting & (limits > 0.0)])).all()


@pytest.mark.parametrize("seed", range(8))
def test_energy_that_friction_takes_is_in_the_books(seed):
    rng = np.random.default_rng(seed)
    n = 4
    joints = tuple(TreeJoint(i - 1, np.eye(3)[rng.integers(3)], rng.normal(size=3)) for i in range(n))
    drives = tuple(
        JointDrive(linear_law(float(rng.uniform(1.0, 9.0))), friction=float(rng.uniform(0.1, 1.0))) for _ in joints
    )
    system = System(joints, tuple(random_body(rng) for _ in joints), drives)
    motion = simulate_system(system, rng.uniform(-1.0, 1.0, n), end=600.0, tolerance=1e-8)
    assert motion.ending == "stuck"
    assert motion.drift < 1e-6 * motion.largest_energy
    assert (np.diff(motion.damped) >= -1e-12).all()
    travelled = np.abs(np.diff(motion.q, axis=0)).sum(axis=0)  # rates keep their signs within steps
    assert motion.damped[-1] == pytest.approx(travelled @ [drive.friction for drive in drives], rel=1e-6)
    assert {event.kind for event in motion.events} == {"stuck", "slips"}
    held = holding_friction(system, motion.q[-1])
    balance = [drive.law.straight.moment(x) for drive, x in zip(drives, motion.q[-1], strict=True)]
    assert held == pytest.approx(balance, abs=1e-9)
    assert (np.abs(held) <= [drive.friction * (1.0 + 1e-7) for drive in drives]).all()
