"""Motions against closed forms and dense twins: pendulums, bounces, snaps, orders, books of energy, symmetries."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from naive_dynamics import Twin, random_body, random_system
from scipy.integrate import RK45, solve_ivp
from scipy.special import ellipj, ellipk

from hcsearch.basics.vocabulary import INTEGRATORS
from hcsearch.designs.folding import Folding
from hcsearch.scenes.laws import FREE_LAW, law_named, linear_law, quadratic_law
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld
from hcsearch.springs.dynamics.integration_methods import SCIPY_SOLVERS, method_named
from hcsearch.springs.dynamics.panels import panel_tree
from hcsearch.springs.dynamics.system import JointDrive, System
from hcsearch.springs.dynamics.time_integration import simulate_system

Y = np.array([0.0, 1.0, 0.0])
GRAVITY = (0.0, 0.0, -9.81)
ORDERS = {"bogacki-shampine": 3, "dormand-prince": 5, "dormand-prince-8": 8, "linearly-implicit": 4}


def rod(one, two, mass=1.0):
    """A slender rod between points, a little thick."""
    one, two = np.array(one, float), np.array(two, float)
    way = two - one
    inertia = mass / 12 * (way @ way * np.eye(3) - np.outer(way, way)) + 1e-4 * np.eye(3)
    return Body(mass, 0.5 * (one + two), inertia)


def wheel(inertia, drive):
    """One joint that turns a body of some inertia about its centre."""
    return System((TreeJoint(-1, Y, np.zeros(3)),), (Body(1.0, np.zeros(3), inertia * np.eye(3)),), (drive,))


def chain(n=3, damping=0.0):
    """Rods that hang one on another, about two directions by turns."""
    ends = [np.array([0.0, 0.0, -float(k)]) for k in range(n + 1)]
    joints = tuple(TreeJoint(k - 1, np.eye(3)[1 - k % 2], ends[k]) for k in range(n))
    bodies = tuple(rod(ends[k], ends[k + 1]) for k in range(n))
    drive = JointDrive(quadratic_law(0.3, 0.1, 0.2), damping)
    return System(joints, bodies, (drive,) * n, gravity=GRAVITY), np.linspace(0.5, 1.0, n)


def four_bar(damping=0.0):
    """A crank, a coupler and a rocker in a plane: the loop's gap across it says nothing new."""
    a, b, c, d = np.array([0.0, 0, 0]), np.array([0.3, 0, 1]), np.array([1.7, 0, 1.5]), np.array([1.5, 0, 0])
    joints = (TreeJoint(-1, Y, a), TreeJoint(0, Y, b), TreeJoint(-1, Y, d))
    drives = (JointDrive(linear_law(0.5, 2.0), damping), JointDrive(FREE_LAW, damping), JointDrive(FREE_LAW, damping))
    weld = Weld(1, 2, c, (3, 4, 5))
    return System(joints, (rod(a, b), rod(b, c), rod(d, c)), drives, (weld,), gravity=GRAVITY), np.zeros(3)


MODELS = [chain, four_bar]


def fixed_steps(system, q, end, n, method):
    motion = simulate_system(system, q, end=end, method=method, tolerance=1e6, first_step=end / n, longest_step=end / n)
    assert motion.ending == "time"
    assert abs(motion.steps - n) <= 1  # rounding may leave a last sliver
    return motion


@settings(max_examples=20)
@given(st.floats(0.05, 3.0), st.sampled_from(INTEGRATORS))
def test_a_pendulum_swings_as_elliptic_functions_do(start, method):
    tolerance = {"dormand-prince": 1e-11, "dormand-prince-8": 1e-11}.get(method, 1e-8)
    body = rod([0, 0, 0], [0, 0, -2], mass=3.0)
    system = System((TreeJoint(-1, Y, np.zeros(3)),), (body,), (JointDrive(),), gravity=GRAVITY)
    motion = simulate_system(system, np.array([start]), end=3.0, method=method, tolerance=tolerance)
    frequency = math.sqrt(3.0 * 9.81 * 1.0 / body.about(np.zeros(3))[1, 1])
    assert motion.q[:, 0] == pytest.approx(swing(start, frequency, motion.times), abs=1e4 * tolerance)


def swing(start, frequency, times):
    """Angle of a pendulum let go at rest: sin(q / 2) = k cn / dn."""
    k = math.sin(start / 2)
    _, cn, dn, _ = ellipj(frequency * times, k * k)
    return 2 * np.arcsin(k * cn / dn)


def test_a_pendulum_comes_back_after_its_period():
    system = System((TreeJoint(-1, Y, np.zeros(3)),), (rod([0, 0, 0], [0, 0, -2]),), (JointDrive(),), gravity=GRAVITY)
    frequency = math.sqrt(9.81 / system.bodies[0].about(np.zeros(3))[1, 1])
    motion = simulate_system(system, np.array([2.0]), end=4 * ellipk(math.sin(1.0) ** 2) / frequency, tolerance=1e-11)
    assert motion.q[-1, 0] == pytest.approx(2.0, abs=1e-8)
    assert motion.v[-1, 0] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize(
    ("model", "method", "end", "n"),
    [
        # few enough steps that rounding does not show, enough for the order to
        (chain, "bogacki-shampine", 1.0, 48),
        (chain, "dormand-prince", 1.0, 48),
        (chain, "dormand-prince-8", 1.0, 12),
        (chain, "linearly-implicit", 1.0, 24),
        (four_bar, "bogacki-shampine", 0.5, 24),
        (four_bar, "dormand-prince", 0.5, 12),
        (four_bar, "dormand-prince-8", 0.7, 16),
        (four_bar, "linearly-implicit", 0.5, 12),
    ],
)
def test_methods_have_their_orders(model, method, end, n):
    system, q = model()
    exact = simulate_system(system, q, end=end, method="dormand-prince-8", tolerance=1e-13).q[-1]
    errors = [np.abs(fixed_steps(system, q, end, k, method).q[-1] - exact).max() for k in (n, 2 * n)]
    assert math.log2(errors[0] / errors[1]) > ORDERS[method] - 0.6


@pytest.mark.parametrize("damping", [0.0, 10.0, 1e3, 1e5])
@pytest.mark.parametrize("model", MODELS)
def test_implicit_steps_keep_order_4_however_stiff_the_dampers_are(model, damping):
    """Between steps, too: a ten thousandth of the tolerance takes about ten times as many steps."""
    system, q = model(damping=damping)
    end = max(1.0, damping / 5.0)
    exact = simulate_system(system, q, end=end, method="implicit", tolerance=1e-12)
    if damping <= 10.0:
        other = simulate_system(system, q, end=end, method="dormand-prince-8", tolerance=1e-13)
        assert np.abs(exact.at(other.times) - other.q).max() < 1e-9
    motions = {tol: simulate_system(system, q, end=end, method="implicit", tolerance=tol) for tol in (1e-5, 1e-9)}
    times = np.linspace(0.0, end, 1000)
    for tolerance, motion in motions.items():
        assert motion.ending == "time"
        assert np.abs(motion.at(times) - exact.at(times)).max() < 100.0 * tolerance
    assert motions[1e-9].steps < 20.0 * motions[1e-5].steps


def test_the_coefficients_of_dormand_and_prince_are_those_of_scipy():
    method = method_named("dormand-prince")
    assert np.array_equal(method.a[:, :5], RK45.A)
    assert np.array_equal(method.b, RK45.B)
    assert np.array_equal(method.errors, [RK45.E, np.zeros(7)])
    assert method.order == RK45.error_estimator_order + 1


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("method", SCIPY_SOLVERS)
def test_less_tolerance_keeps_energy_better(method, model):
    system, q = model(damping=0.1)
    drifts = [simulate_system(system, q, end=2.0, method=method, tolerance=t).drift for t in (1e-4, 1e-6, 1e-8)]
    energy = np.ptp(simulate_system(system, q, end=2.0).kinetic)
    assert drifts[1] < 0.2 * drifts[0]
    assert drifts[2] < 0.2 * drifts[1]
    assert drifts[2] < 1e-6 * energy


@pytest.mark.parametrize("model", MODELS)
def test_without_dampers_motions_run_backwards(model):
    system, q = model()
    there = simulate_system(system, q, end=1.0, tolerance=1e-11)
    back = simulate_system(system, there.q[-1], -there.v[-1], end=1.0, tolerance=1e-11)
    assert np.abs(there.v[-1]).max() > 0.1
    assert back.q[-1] == pytest.approx(q, abs=1e-7)
    assert back.v[-1] == pytest.approx(np.zeros(len(q)), abs=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_random_systems_move_as_their_dense_twins_do(seed):
    system, rng = random_system([5, seed], bodies=(3, 6), welds=1)
    twin, n = Twin(system), system.n_joints
    free = np.zeros(n, bool)
    q, v = twin.closed(np.zeros(n), 0.3 * rng.normal(size=n))

    def derivative(_, state):
        return [*state[n:], *twin.accelerations(state[:n], state[n:], free)[0]]

    expected = solve_ivp(derivative, (0.0, 0.2), [*q, *v], rtol=1e-8, atol=1e-8).y[:, -1]
    motion = simulate_system(system, q, v, end=0.2, tolerance=1e-9)
    assert [*motion.q[-1], *motion.v[-1]] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("seed", range(25))
def test_hard_stops_are_never_passed_and_only_take_energy(seed):
    system, rng = random_system([7, seed], welds=1, struts=0)
    drives = tuple(replace(drive, lower=-0.2, upper=0.3) for drive in system.drives)
    system = replace(system, stop_stiffness=0.0, drives=drives)
    restitution = float(rng.choice([0.0, 0.5, 1.0]))
    start = np.zeros(system.n_joints)
    motion = simulate_system(system, start, end=2.0, tolerance=1e-8, restitution=restitution, slow=1e-6)
    energy = max(np.abs(books).max() for books in (motion.kinetic, motion.stored, motion.height))
    assert motion.ending == "time"
    assert motion.q.min() >= -0.2 - 1e-5
    assert motion.q.max() <= 0.3 + 1e-5
    assert np.diff(motion.lost).min() >= -1e-5 * energy
    assert motion.drift <= 1e-5 * energy


def test_two_bodies_that_float_keep_their_momentum():
    rng = np.random.default_rng(3)
    nothing = Body(0.0, np.zeros(3), np.zeros((3, 3)))
    joints = [TreeJoint(k - 1, np.eye(3)[k % 3], np.zeros(3), slides=k < 3) for k in range(6)]
    joints += [TreeJoint(5, Y, np.array([0.3, 0.1, 0.2]))]
    system = System(
        tuple(joints),
        (nothing,) * 5 + (random_body(rng), random_body(rng)),
        (JointDrive(),) * 6 + (JointDrive(linear_law(2.0)),),
    )
    twin = Twin(system)

    def momentum(q, v):
        momentum = np.zeros(6)
        for i in (5, 6):
            body, turn = system.bodies[i], twin.poses(q)[i][:3, :3]
            motion = twin.jacobian(q, i, body.centre) @ v
            push = body.mass * motion[3:]
            momentum[:3] += push
            momentum[3:] += turn @ body.inertia @ turn.T @ motion[:3] + np.cross(twin.point(q, i, body.centre), push)
        return momentum

    motion = simulate_system(system, np.zeros(7), 0.3 * rng.normal(size=7), end=2.0, tolerance=1e-10)
    assert motion.ending == "time"
    start = momentum(motion.q[0], motion.v[0])
    for k in range(0, len(motion.times), 10):
        assert momentum(motion.q[k], motion.v[k]) == pytest.approx(start, abs=1e-7)
    assert np.abs(motion.q[-1] - motion.q[0]).min() > 1e-3


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6])
def test_a_joint_that_falls_on_its_stop_bounces_by_the_closed_form(restitution):
    inertia, pull, height = 2.0, 3.0, 1.5
    fall = pull / inertia
    system = wheel(inertia, JointDrive(linear_law(0.0, pull), lower=0.0))
    motion = simulate_system(system, np.array([height]), end=12.0, restitution=restitution, slow=1e-2, tolerance=1e-9)
    times, speeds = [math.sqrt(2 * height / fall)], [math.sqrt(2 * height * fall)]
    while restitution * speeds[-1] > 1e-2:  # slower ones do not come off
        speeds.append(restitution * speeds[-1])
        times.append(times[-1] + 2 * speeds[-1] / fall)
    hits = [event for event in motion.events if event.kind == "hit"]
    assert [event.time for event in hits] == pytest.approx(times, abs=1e-6)
    assert [-event.speed for event in hits] == pytest.approx(speeds, abs=1e-6)
    assert (motion.q[-1], motion.v[-1]) == (0.0, 0.0)
    assert motion.lost[-1] == pytest.approx(pull * height, rel=1e-9)
    assert motion.drift < 1e-8
    after = motion.lost[np.searchsorted(motion.times, hits[0].time, side="right") - 1]
    assert after == pytest.approx((1 - restitution**2) * pull * height, rel=1e-6)


def test_a_joint_that_bounces_for_long_is_not_jammed():
    fall, height, restitution = 1.5, 1.5, 0.98
    system = wheel(2.0, JointDrive(linear_law(0.0, 2.0 * fall), lower=0.0))
    motion = simulate_system(system, np.array([height]), end=200.0, restitution=restitution, slow=1e-2)
    assert motion.ending == "time"
    bounces = math.log(1e-2 / math.sqrt(2 * height * fall)) / math.log(restitution)
    assert len([event for event in motion.events if event.kind == "hit"]) == math.ceil(bounces)
    assert bounces > 200


@pytest.mark.parametrize("method", ORDERS)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_a_spring_brings_a_joint_to_its_stop_after_part_of_a_period(method, tolerance):
    inertia, stiffness, height, stop = 2.0, 5.0, 1.5, -0.4
    rate = math.sqrt(stiffness / inertia)
    system = wheel(inertia, JointDrive(linear_law(stiffness), lower=stop))
    motion = simulate_system(system, np.array([height]), end=2.0, method=method, tolerance=tolerance)
    hit = motion.events[0]
    assert hit.time == pytest.approx(math.acos(stop / height) / rate, abs=100 * tolerance)
    assert -hit.speed == pytest.approx(rate * math.sqrt(height**2 - stop**2), abs=100 * tolerance)
    (before, _) = np.flatnonzero(motion.times == hit.time)
    assert motion.q[before, 0] == pytest.approx(stop, abs=1e-9)  # in a step that ends there, whatever the tolerance


def test_a_joint_that_creeps_is_not_at_rest():
    stiffness, damping = 0.1, 1e3
    time = damping / stiffness
    system = wheel(1e-5, JointDrive(linear_law(stiffness), damping))
    motion = simulate_system(system, np.array([3.0]), end=5 * time, method="implicit", rest=1e-4)
    assert motion.ending == "time"
    assert np.abs(motion.v[-1, 0]) < 1e-4
    assert motion.q[:, 0] == pytest.approx(3.0 * np.exp(-motion.times / time), abs=1e-4)
    longer = simulate_system(system, np.array([3.0]), end=100 * time, method="implicit", rest=1e-4)
    assert longer.ending == "rest"
    assert np.abs(longer.q[-1, 0]) < 1e-4


@pytest.mark.parametrize("method", ORDERS)
def test_a_body_leaves_a_rising_platform_where_its_spring_is_at_its_natural_length(method):
    up, zero = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    platform, body, stiffness, low = 2.0, 0.5, 300.0, -0.4
    joints = (TreeJoint(-1, up, zero, slides=True), TreeJoint(0, up, zero, slides=True))
    bodies = (Body(platform, zero, np.eye(3)), Body(body, zero, np.eye(3)))
    system = System(joints, bodies, (JointDrive(linear_law(stiffness)), JointDrive(lower=0.0)), gravity=GRAVITY)
    rate, balance = math.sqrt(stiffness / (platform + body)), 9.81 * (platform + body) / stiffness
    leaves = math.acos(balance / (balance + low)) / rate  # there both fall freely
    speed = -(low + balance) * rate * math.sin(rate * leaves)
    end = leaves + 0.05
    tolerance = 1e-6 if method == "bogacki-shampine" else 1e-9
    motion = simulate_system(system, np.array([low, 0.0]), end=end, method=method, tolerance=tolerance)
    assert [event.kind for event in motion.events] == ["released"]
    assert motion.events[0].time == pytest.approx(leaves, abs=1e-5)
    flown = speed * (end - leaves) - 0.5 * 9.81 * (end - leaves) ** 2
    assert motion.q[-1].sum() == pytest.approx(flown, abs=300 * tolerance)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_states_before_an_impact_know_nothing_of_it(restitution):
    fall, height = 1.5, 1.5
    system = wheel(2.0, JointDrive(linear_law(0.0, 2.0 * fall), lower=0.0))
    motion = simulate_system(system, np.array([height]), end=2.0, restitution=restitution, longest_step=0.3)
    (hit, *_) = (event.time for event in motion.events)
    times = np.linspace(0.0, hit, 101)
    assert motion.at(times)[:, 0] == pytest.approx(height - 0.5 * fall * times**2, abs=1e-6)
    before, after = np.flatnonzero(motion.times == hit)
    assert motion.v[after, 0] == pytest.approx(-restitution * motion.v[before, 0])
    assert motion.lost[before] == 0.0 < motion.lost[after]
    assert motion.steps == len(motion.times) - 1 - len([event for event in motion.events if event.kind == "hit"])


def test_a_joint_swings_on_a_compliant_stop_for_half_a_period():
    inertia, stiffness, speed = 2.0, 800.0, 3.0
    system = replace(wheel(inertia, JointDrive(lower=0.0)), stop_stiffness=stiffness)
    frequency = math.sqrt(stiffness / inertia)
    motion = simulate_system(system, np.array([0.3]), np.array([-speed]), end=1.0, tolerance=1e-9, longest_step=1e-3)
    since = motion.times - 0.1
    within = (since > 0) & (since < math.pi / frequency)
    assert motion.q[within, 0] == pytest.approx(-speed / frequency * np.sin(frequency * since[within]), abs=1e-6)
    assert motion.v[-1, 0] == pytest.approx(speed, rel=1e-6)
    assert motion.in_stops.max() == pytest.approx(0.5 * inertia * speed**2, rel=1e-3)
    assert [event.kind for event in motion.events] == ["hit", "released"]


def test_a_damped_compliant_stop_takes_what_the_joint_loses():
    system = replace(wheel(2.0, JointDrive(lower=0.0)), stop_stiffness=800.0, stop_damping=4.0)
    motion = simulate_system(system, np.array([0.3]), np.array([-3.0]), end=1.0, tolerance=1e-9)
    # until the joint comes back to its stop: q is proportional to exp(-t) sin(w t)
    frequency = math.sqrt(800.0 / 2.0 - 1.0)
    back = 3.0 * math.exp(-math.pi / frequency)
    assert motion.v[-1, 0] == pytest.approx(back, rel=1e-5)
    assert motion.damped[-1] == pytest.approx(9.0 - back**2, rel=1e-5)


def test_a_bounce_at_an_upper_stop_is_that_at_a_lower_one_in_a_mirror():
    drives = JointDrive(linear_law(0.2, 1.0), lower=-0.5), JointDrive(linear_law(0.2, -1.0), upper=0.5)
    one, two = (
        simulate_system(wheel(1.0, drive), np.array([start]), end=5.0, restitution=0.7)
        for drive, start in zip(drives, (1.0, -1.0), strict=True)
    )
    assert (one.q == -two.q).all()
    assert [event.time for event in one.events] == [event.time for event in two.events]


def test_a_tape_spring_swings_until_it_locks_and_each_snap_takes_its_energy():
    law = law_named("tape:0.2@0.05,0.03@0.01")
    motion = simulate_system(
        wheel(0.01, JointDrive(law)), np.array([math.pi]), end=200.0, tolerance=1e-9, max_steps=100_000
    )
    up, down = 0.5 * 0.2 * 0.05 - 0.03 * 0.05, 0.03 * 0.01 - 0.5 * 0.2 / 0.05 * 0.01**2
    energy, taken = 0.03 * math.pi - down, [down]
    while energy > 0.5 * 0.2 * 0.05:  # enough to snap again
        taken += [up, down]
        energy -= up + down
    assert [event.kind for event in motion.events] == ["snap"] * len(taken)
    speeds = [event.speed for event in motion.events]
    assert [speed > 0 for speed in speeds] == [k % 2 == 1 for k in range(len(taken))]
    assert motion.lost[-1] == pytest.approx(sum(taken), rel=1e-6)
    for k, event in enumerate(motion.events):
        after = motion.lost[np.searchsorted(motion.times, event.time, side="right") - 1]
        assert after == pytest.approx(sum(taken[: k + 1]), rel=1e-6)
    assert np.abs(motion.q[-20:]).max() < law.snap_up
    assert motion.drift < 1e-6


def test_a_tape_spring_on_its_stop_holds_it_flat():
    drive = JointDrive(law_named("tape:0.2@0.05,0.03@0.01+0.001"), damping=1e-4, lower=0.0, upper=math.pi)
    motion = simulate_system(wheel(0.01, drive), np.array([math.pi]), end=5.0, rest=1e-6)
    assert [event.kind for event in motion.events] == ["snap", "hit"]
    assert (motion.q[-1], motion.v[-1]) == (0.0, 0.0)


@pytest.mark.parametrize("method", ORDERS)
def test_the_same_input_gives_the_same_bits(method):
    motions = []
    for _ in range(2):
        system, q = four_bar(damping=0.1)
        motions.append(simulate_system(system, q, end=1.0, method=method))
    one, two = motions
    assert one.q.tobytes() == two.q.tobytes()
    assert one.times.tobytes() == two.times.tobytes()
    assert one.lost.tobytes() == two.lost.tobytes()


def test_states_between_steps_have_an_error_of_sixth_order():
    system = System((TreeJoint(-1, Y, np.zeros(3)),), (rod([0, 0, 0], [0, 0, -2]),), (JointDrive(),), gravity=GRAVITY)
    frequency = math.sqrt(9.81 / system.bodies[0].about(np.zeros(3))[1, 1])
    times = np.linspace(0.0, 1.0, 301)
    errors = []
    for n in (10, 20):
        motion = fixed_steps(system, np.array([1.5]), 1.0, n, "dormand-prince-8")
        errors.append(np.abs(motion.at(times)[:, 0] - swing(1.5, frequency, times)).max())
        assert motion.at(motion.times) == pytest.approx(motion.q, abs=1e-15)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(6.0, abs=0.5)


@pytest.mark.parametrize("notation", ["square:012233300121:5", "square:012122333001:1", "hex:0233340501:3"])
def test_equal_springs_deploy_a_mirror_symmetric_folding_symmetrically(notation):
    folding = Folding.from_notation(notation)
    linkage = Linkage(folding.pattern((0.05, 0.05, 0.006), flat_pairs="merged"))
    one, two = folding.mirror_pairs[0]
    cells = np.array([np.mean(facet, axis=0) for facet in linkage.pattern.facets])
    middle, normal = (
        0.5 * (cells[one] + cells[two]),
        (cells[two] - cells[one]) / np.linalg.norm(cells[two] - cells[one]),
    )
    points = linkage.points[:, :2]
    images = points - 2 * ((points - middle) @ normal)[:, None] * normal
    twins = [int(np.linalg.norm(points - image, axis=1).argmin()) for image in images]
    assert points[twins] == pytest.approx(images, abs=1e-12)
    tree = panel_tree(linkage, 1000.0, held=linkage.pattern.panel_of[one])
    drives = (JointDrive(linear_law(0.1), 1e-4, 0.0, math.pi),) * len(tree.joints)
    system = System(tree.joints, tree.bodies, drives, tree.welds, size=linkage.pattern.size)
    q = np.zeros(len(tree.joints))
    q[tree.joint_of] = linkage.folded
    motion = simulate_system(system, q, end=0.05, tolerance=1e-8)
    angles = motion.q[:, tree.joint_of]
    assert np.abs(angles - angles[0]).max() > 0.5
    assert angles == pytest.approx(angles[:, twins], abs=1e-4)


def test_a_compliant_stop_is_hit_and_left_at_the_times_of_half_a_period():
    system = replace(wheel(2.0, JointDrive(lower=0.0)), stop_stiffness=800.0)
    motion = simulate_system(system, np.array([0.3]), np.array([-3.0]), end=1.0, tolerance=1e-9, longest_step=1e-3)
    hit, left = motion.events
    assert (hit.kind, left.kind, hit.joint, left.joint) == ("hit", "released", 0, 0)
    assert (hit.time, left.time - hit.time) == pytest.approx((0.1, math.pi / 20), abs=1e-6)
    assert (hit.speed, left.speed) == pytest.approx((-3.0, 3.0), rel=1e-3)


def test_joints_that_come_to_their_stops_together_are_all_told():
    drive = JointDrive(linear_law(0.0, 1.0), lower=0.0)
    joints = tuple(TreeJoint(GROUND, Y, np.array([float(k), 0.0, 0.0])) for k in range(3))
    bodies = tuple(Body(1.0, joint.point, np.eye(3)) for joint in joints)
    system = System(joints, bodies, (drive,) * 3)
    motion = simulate_system(system, np.array([0.5, 0.7, 0.5]), end=1.1, tolerance=1e-9)
    assert [(event.kind, event.joint) for event in motion.events] == [("hit", 0), ("hit", 2)]


def test_a_flat_state_is_reached_within_a_step():
    motion = simulate_system(
        wheel(2.0, JointDrive()), np.array([1.0]), np.array([-1.0]), end=9.0, flat=0.1, longest_step=0.4
    )
    assert motion.ending == "flat"
    assert motion.times[-1] == pytest.approx(0.9, abs=1e-9)
    assert motion.q[-1, 0] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_without_inertia_the_flat_state_is_reached_at_its_time(method, tolerance):
    """A spring and a damper: q = exp(-k t / c); the time was once located by rates of 0."""
    joint, body = TreeJoint(-1, Y, np.zeros(3)), Body(1.0, np.zeros(3), np.eye(3))
    system = System((joint,), (body,), (JointDrive(linear_law(0.5), 0.02),), overdamped=True)
    motion = simulate_system(
        system, np.array([1.0]), end=5.0, method=method, tolerance=tolerance, flat=0.01, max_steps=50_000
    )
    assert motion.ending == "flat"
    assert motion.times[-1] == pytest.approx(0.04 * math.log(100.0), abs=1000.0 * 0.04 * tolerance)
