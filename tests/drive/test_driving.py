"""Drives of foldings: driven hinges, time laws, torques, and the motion under control."""

import math
import tomllib
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError, SceneError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import read_panel
from hcsearch.kernels.multibody.hinges import write_drive_targets
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes import SCENES, with_panel
from hcsearch.scenes.laws import linear_law
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.drives import drives_in, drives_text
from hcsearch.springs.deployment.simulated_deployment import compile_driven, simulate_deployment
from hcsearch.springs.drive import driven_folding
from hcsearch.springs.drive.choosing import choose_driven_hinges, frames_at, least_singular_values, monotone_hinges
from hcsearch.springs.drive.drive_facts import envelope, judge_following
from hcsearch.springs.drive.torques import static_stability, torques_along
from hcsearch.springs.drive.trajectory import smooth_path, time_path
from hcsearch.springs.dynamics.time_integration import simulate_system

QUICK = driven_folding.DriveOptions(rate=4.0, acceleration=40.0, period=0.005)
TEN = (
    "square:0122333011:1",
    "hex:0234550132:3",
    "hex:0234435011:1",
    "hex:0233445110:1",
    "square:012233300121:2",
    "square:012233330111:4",
    "hex:023454401022:0",
    "hex:023444000231:0",
    "triangle:0123434501:1",
    "hex:0234550132:4",
)
SIX_BY_FIVE = "square:012233332111123333300001210121:1"


def folding_named(name):
    return Folding.from_notation(name)


@pytest.fixture(scope="module")
def machine():
    folding, scene = folding_named("hex:0234435011:1"), SCENES["default"]
    return driven_folding.drive_along(folding, scene, driven_folding.find_drive_motion(folding, scene), QUICK)


@pytest.fixture(scope="module")
def on_earth(machine):
    compiled = compile_driven(machine.linkage, replace(machine.setup, gravity=(0.0, 3.0, -9.81)), None)
    return compiled, torques_along(compiled, machine.timed, machine.choice, 500)


def test_it_comes_flat_under_control_certified_clear(machine):
    assert machine.deployment.deploys
    assert machine.deployment.clearance.margin == machine.setup.margin == pytest.approx(1e-4)
    assert machine.play <= 1.0001e-4
    assert machine.missed < 2e-3
    assert machine.choice.freedoms == len(machine.drives.hinges) == 4
    assert (machine.greatest > 0.0).all()
    driven = machine.deployment.driven
    assert driven.drift < 1e-3 * np.ptp(driven.motion.stored)


@pytest.mark.parametrize("period", [1e-4, 5e-3])
@pytest.mark.parametrize(
    ("name", "scene", "panel"),
    [
        ("hex:0234435011:1", "earth", None),
        ("triangle:0123434501:1", "default", None),
        ("rectangle:0122230323000121:5", "earth", None),
        ("square:01223330000111233221:0", "earth", "300x12"),  # whose greatest torques come after it counts as flat
    ],
)
def test_greatest_torques_are_those_planned_at_any_period(name, scene, panel, period):
    folding, scene = folding_named(name), SCENES[scene]
    if panel is not None:
        scene = with_panel(scene, read_panel(panel), folding.circuit.grid.name)
    own = driven_folding.drive_along(
        folding, scene, driven_folding.find_drive_motion(folding, scene), driven_folding.DriveOptions(period=period)
    )
    assert own.deployment.deploys
    assert own.greatest == pytest.approx(np.abs(own.torques.torques).max(axis=0), rel=0.05)
    assert judge_following(own).follows
    driven = own.deployment.driven
    assert driven.drift < 1e-3 * np.ptp(driven.motion.stored)


@pytest.mark.parametrize("wishes", [{"firm": 0.0}, {"rate": 100.0, "acceleration": 1e4, "period": 0.1}])
def test_a_drive_that_does_not_follow_says_so_with_the_remedy(wishes):
    folding, scene = folding_named("hex:0234550132:3"), SCENES["default"]
    own = judge_following(
        driven_folding.drive_along(
            folding, scene, driven_folding.find_drive_motion(folding, scene), driven_folding.DriveOptions(**wishes)
        )
    )
    assert not own.follows
    assert own.share > 0.05
    assert own.sentence.startswith("does not follow: hinge ")
    assert own.sentence.endswith("(a greater --firm)" if "firm" in wishes else "--period, or a smaller --rate")


def test_motors_are_sized_by_the_simulation_where_no_remedy_helps():
    folding = folding_named("square:012233330111:4")
    scene = with_panel(SCENES["default"], read_panel("1000x20"), "square")
    own = judge_following(driven_folding.drive_along(folding, scene, driven_folding.find_drive_motion(folding, scene)))
    assert not own.follows
    assert own.sentence.endswith("singular at 1 of the path: size motors by simulated torques, or try other panels")


def test_the_work_of_drives_is_the_integral_of_their_power(machine):
    """The simulation books energies and dampers; torques and rates are looked at apart from it."""
    driven, motion = machine.deployment.driven, machine.deployment.motion
    joints = [int(machine.deployment.compiled.joint_of[hinge]) for hinge in machine.drives.hinges]
    power = (driven.torques * motion.v[:, joints]).sum(axis=1)
    work = np.r_[0.0, np.cumsum(0.5 * np.diff(motion.times) * (power[1:] + power[:-1]))]
    assert driven.work == pytest.approx(work, abs=1e-4 * np.ptp(work))


@given(period=st.floats(1e-5, 0.1), share=st.floats(0.0, 1.3))
@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_drives_are_asked_for_what_the_plan_interpolated_within_a_period_says(machine, period, share):
    own = replace(machine.drives.commands(machine.deployment.compiled), period=period)
    time = np.array([share * own.times[-1]])
    work = work_for(machine.deployment.compiled.system.mechanism.tree)
    write_drive_targets(own.targets, float(time[0]), work)
    expected = np.array([part[0] for part in own.interpolated(time)]).T
    size = np.abs(np.array(own.at(own.times))).max(axis=(1, 2))
    assert (np.abs(work.drive_targets[: len(own.joints)] - expected) <= 1e-9 * size + 1e-12).all()
    ends = period * np.floor(time / period) + period * np.array([[0.0], [1.0]])  # where nothing is left to interpolate
    for end in ends:
        for asked, planned in zip(own.interpolated(end), own.at(end), strict=True):
            assert asked == pytest.approx(planned, abs=1e-6 * np.abs(size).max())


def test_torques_that_are_drawn_lie_in_their_band():
    rng = np.random.default_rng(3)
    times = np.r_[0.0, np.cumsum(rng.exponential(size=400))]
    values = rng.normal(size=(401, 3))
    middles, mean, least, greatest = envelope(times, values, 20)
    assert (np.diff(middles) > 0.0).all()
    assert len(middles) <= 20
    assert ((least <= mean) & (mean <= greatest)).all()
    assert (least.min(axis=0) == values.min(axis=0)).all()
    assert (greatest.max(axis=0) == values.max(axis=0)).all()
    assert np.ptp(envelope(times, np.ones((401, 1)))[1]) < 1e-12


def test_the_path_is_closed_and_smooth(machine):
    path = machine.timed.path
    assert path.opening < 1e-6
    assert path.stop_overshoot <= 5e-4
    places = np.linspace(0.0, path.length, 997)
    angles, slopes, bends = path.at(places)
    assert max(np.abs(machine.linkage.closure(state)[0]).max() for state in angles[::50]) < 1e-6
    step = places[1]
    assert np.gradient(angles, step, axis=0)[1:-1] == pytest.approx(slopes[1:-1], abs=1e-3)
    assert np.gradient(slopes, step, axis=0)[1:-1] == pytest.approx(bends[1:-1], abs=0.05 * np.abs(bends).max())


def test_the_least_singular_value_is_that_of_the_reduced_jacobian(machine):
    angles = machine.timed.path.at(np.linspace(0.0, machine.timed.path.length, 40))[0]
    frames, values = frames_at(machine.linkage, angles)
    rank, n = values.shape[1], machine.linkage.n_hinges
    sets = np.array(list(combinations(range(n), n - rank)))[::7]
    direct = np.linalg.svd(frames[:, sets, rank:], compute_uv=False)[..., -1].T
    assert least_singular_values(frames, n - rank, sets) == pytest.approx(direct, abs=1e-12)
    for more in (n - rank + 1, n - 1):  # few are not driven: their rows of closure say the same
        wide = np.array(list(combinations(range(n), more)))[::11]
        direct = np.linalg.svd(frames[:, wide, rank:], compute_uv=False)[..., -1].T
        assert least_singular_values(frames, n - rank, wide) == pytest.approx(direct, abs=1e-7)


def test_driven_hinges_are_the_best_but_for_monotone_ones(machine):
    angles = machine.timed.path.at(np.linspace(0.0, machine.timed.path.length, 80))[0]
    choice = choose_driven_hinges(machine.linkage, angles, min_value=0.0)
    frames, _ = frames_at(machine.linkage, angles)
    sets = np.array(list(combinations(range(machine.linkage.n_hinges), choice.freedoms)))
    best = least_singular_values(frames, choice.freedoms, sets).min(axis=1).max()
    assert len(choice.hinges) == choice.freedoms
    assert choice.least_value >= 0.45 * best
    steady = monotone_hinges(angles)
    assert choice.monotone == tuple(hinge for hinge in choice.hinges if steady[hinge])
    assert len(choose_driven_hinges(machine.linkage, angles, min_value=0.9).hinges) > choice.freedoms


def test_rates_and_accelerations_keep_their_bounds(machine):
    course = time_path(machine.timed.path, 2.0, 7.0)
    times = np.linspace(0.0, course.seconds, 3001)
    angles, rates, accelerations = course.at(times)
    assert np.abs(rates).max() <= 2.0 * 1.002
    assert np.abs(accelerations).max() <= 7.0 * 1.01
    assert max(np.abs(rates).max() / 2.0, math.sqrt(np.abs(accelerations).max() / 7.0)) > 0.95
    for end in (0, -1):
        assert rates[end] == pytest.approx(0.0, abs=1e-6)
        assert accelerations[end] == pytest.approx(0.0, abs=1e-2)
    assert np.gradient(angles, times[1], axis=0) == pytest.approx(rates, abs=2e-2)


def test_a_rate_that_is_no_bound_leaves_an_even_pace(machine):
    """From rest to rest over half a turn: 2 sqrt(pi / 7) s at the least."""
    path = machine.timed.path
    assert time_path(path, 1e6, 7.0).seconds == time_path(path, 50.0, 7.0).seconds < 6 * math.sqrt(math.pi / 7.0)


def test_torques_balance_the_energy(machine, on_earth):
    for torques in (machine.torques, on_earth[1]):
        assert np.ptp(torques.height) > 0.0 or torques is machine.torques
        assert torques.imbalance < 1e-5 * np.ptp(torques.stored)


def test_forward_dynamics_give_the_motion_that_torques_are_for(machine, on_earth):
    compiled, torques = on_earth
    for k in (100, 250, 400):
        drives = [replace(drive, lower=-math.inf, upper=math.inf) for drive in compiled.system.drives]
        for number, hinge in enumerate(torques.driven):
            joint = compiled.joint_of[hinge]
            drives[joint] = replace(drives[joint], law=linear_law(0.1, -torques.torques[k, number]))
        q, v, a = np.zeros((3, compiled.system.n_joints))
        q[compiled.joint_of], v[compiled.joint_of], a[compiled.joint_of] = (
            part[k] for part in (torques.angles, torques.rates, torques.accelerations)
        )
        motion = simulate_system(compiled.system.driven(tuple(drives)), q, v, end=1e-9, closed=math.inf)
        assert motion.a[0] == pytest.approx(a, abs=1e-3 * np.abs(torques.accelerations).max())


def test_springs_that_push_ask_for_stiff_control_and_none_for_nothing(machine):
    compiled = compile_driven(machine.linkage, machine.setup, None)
    slow = time_path(machine.timed.path, 0.2, 0.5)
    needed = static_stability(compiled, torques_along(compiled, slow, machine.choice, 300))
    free = compile_driven(machine.linkage, replace(machine.scene, spring="linear:0.0001", damping=0.004), None)
    less = static_stability(free, torques_along(free, slow, machine.choice, 300))
    assert less.stiffness < 0.1 * needed.stiffness
    assert needed.time < 0.2 * slow.seconds  # by the packed state closure bends most
    assert (machine.drives.stiffness >= 2.0 * needed.stiffness).all()


def test_a_file_holds_the_drive(machine):
    labels = labels_of(machine.linkage)
    table = tomllib.loads(drives_text(machine.drives, labels))["drive"]
    assert [str(name) for name in table["driven"]] == [labels.hinges[hinge] for hinge in machine.drives.hinges]
    again = drives_in(table, labels)
    assert again.hinges == machine.drives.hinges
    assert np.array_equal(again.start, machine.drives.start)
    assert again.angles == pytest.approx(machine.drives.angles, abs=1e-9)
    deployment = simulate_deployment(machine.linkage, machine.setup, drives=again)
    assert deployment.deploys
    assert deployment.flat_time == pytest.approx(machine.deployment.flat_time, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"period": 0.0}, "period"),
        ({"period": 1e5}, "period"),
        ({"period": 10**320}, "no table of numbers"),
        ({"period": True}, "no table of numbers"),
        ({"stiffness": [1.0, True]}, "no table of numbers"),
        ({"start": [[0.0], [0.0, 1.0]]}, "no table of numbers"),
        ({"times": [0.0, 1.0]}, "as many numbers"),
        ({"start": "no"}, "no table of numbers"),
        ({"speed": 1}, "'speed'"),
    ],
)
def test_tables_that_hold_no_drive_are_refused(machine, change, word):
    with pytest.raises(SceneError, match=word):
        drives_in(table_of(machine) | change, labels_of(machine.linkage))


@pytest.mark.parametrize(
    ("driven", "word"),
    [([0, 0, 1, 2], "once"), ([0.5], "as pictures do"), ([True], "as pictures do"), (["x"], "as pictures do"),
     ("0", "as pictures do"), ([99], "no hinge 99")],
)  # fmt: skip
def test_names_that_are_no_driven_hinges_are_refused(machine, driven, word):
    labels = labels_of(machine.linkage)
    table = tomllib.loads(drives_text(machine.drives, labels))["drive"]
    with pytest.raises(SceneError, match=word):
        drives_in(table | {"driven": driven}, labels)


def table_of(machine):
    return tomllib.loads(drives_text(machine.drives, labels_of(machine.linkage)))["drive"]


def test_drives_of_other_panels_are_refused(machine):
    with pytest.raises(SceneError, match="does not start from a closed state"):
        simulate_deployment(
            machine.linkage, machine.scene, drives=replace(machine.drives, start=machine.drives.start[::-1] * 0.9)
        )
    with pytest.raises(HcsearchError, match="exact closure"):
        simulate_deployment(machine.linkage, machine.scene, "penalty", drives=machine.drives)


@pytest.mark.extra
def test_moments_of_joints_are_those_of_pinocchio(on_earth):
    import pinocchio as pin

    from hcsearch.springs.dynamics.inverse import joint_forces
    from hcsearch_bench.peers.pinocchio_system import _Forces

    system = on_earth[0].system
    free = tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in system.drives)  # rnea knows no stops
    forces = _Forces(pin, system.driven(free))
    q, v, a = np.random.default_rng(1).normal(size=(3, system.n_joints))
    given = np.empty((3, system.n_joints))
    given[:, forces.order] = q, v, a
    expected = pin.rnea(forces.model, forces.data, *given)[forces.order]
    assert joint_forces(system, q[None], v[None], a[None]).joints[0] == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*TEN, SIX_BY_FIVE])
def test_ten_foldings_and_6x5_come_flat_clear(name):
    folding, scene = folding_named(name), SCENES["default"]
    motion = driven_folding.find_drive_motion(folding, scene)
    machine = driven_folding.drive_along(folding, scene, motion, replace(QUICK, period=0.002))
    assert machine.deployment.deploys, machine.deployment.reason
    assert machine.missed < 5e-3
    assert machine.torques.imbalance < 1e-4 * np.ptp(machine.torques.stored)


def test_smoothing_refuses_ends_that_leave_nothing(machine):
    motion = driven_folding.find_drive_motion(Folding.from_notation(machine.title), SCENES["default"])
    with pytest.raises(HcsearchError, match="smaller --near"):
        smooth_path(machine.linkage, motion.proof.motion, (4.0, 4.0))
