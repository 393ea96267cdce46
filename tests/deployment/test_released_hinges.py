"""Hold-downs: hinges that are released at a time, or after another hinge."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES, check_verdicts
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import compile_driven, simulate_deployment
from hcsearch.springs.tuning.spring_tuning import tune_springs
from hcsearch.springs.tuning.tuning_options import TuningOptions
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]
NAME = "hex:0234550132:4"
ONE_HINGE = "square:0123:0"
METHODS = ["bogacki-shampine", "dormand-prince", "dormand-prince-8", "implicit"]


def all_released(linkage, text, scene=DEFAULT):
    return replace(scene, releases=tuple((hinge, text) for hinge in labels_of(linkage).hinges))


def motion(linkage, scene, formulation="constrained", **options):
    return simulate_deployment(linkage, scene, formulation, certified=False, **options)


def releases_of(deployment, joint):
    return [event.time for event in deployment.motion.events if event.kind == "released" and event.joint == joint]


@settings(max_examples=10)
@given(st.floats(1e-3, 3.0), st.sampled_from(METHODS), st.sampled_from([NAME, "square:01222300:3"]))
def test_a_motion_that_is_released_later_is_the_same_later(time, method, name):
    linkage = linkage_named(name)
    free = motion(linkage, DEFAULT, method=method).motion
    held = motion(linkage, all_released(linkage, f"{time!r} s"), method=method).motion
    assert held.ending == free.ending
    assert held.times[-1] - time == pytest.approx(free.times[-1], abs=1e-12 * (1.0 + time))
    assert held.q[-len(free.q) :].tolist() == free.q.tolist()
    waiting = held.q[: -len(free.q)]
    assert np.abs(waiting - free.q[0]).max() == 0.0


@pytest.mark.parametrize("method", METHODS)
def test_one_hinge_swings_from_its_release_on(method):
    linkage = linkage_named(ONE_HINGE)
    scene = replace(all_released(linkage, "0.25 s"), damping=0.0, seconds=1.0)
    deployment = motion(linkage, scene, method=method, tolerance=1e-9)
    system = deployment.compiled.system
    assert system.n_joints == 1
    joint, body = system.joints[0], system.bodies[0]
    inertia = joint.axis @ body.about(joint.point) @ joint.axis
    rate = math.sqrt(system.drives[0].law.mean_stiffness / inertia)
    start = deployment.motion.q[0, 0]
    times = np.linspace(0.0, deployment.motion.times[-1], 50)
    swung = start * np.cos(rate * np.maximum(times - 0.25, 0.0))
    assert deployment.motion.at(times)[:, 0] == pytest.approx(swung, abs=1e-6)
    assert deployment.motion.times[-1] == pytest.approx(0.25 + math.acos(0.01 / start) / rate, abs=1e-6)
    assert deployment.motion.drift < 1e-8


@pytest.mark.parametrize(
    ("formulation", "method"),
    [("constrained", "dormand-prince"), ("constrained", "implicit"), ("compliant", "implicit")],
)
def test_a_hinge_is_released_when_another_has_opened(formulation, method):
    linkage = linkage_named("square:01222300:3")
    first, later = labels_of(linkage).hinges[1], labels_of(linkage).hinges[0]
    scene = replace(DEFAULT, releases=((later, f"hinge {first} at 2.5 rad"),), seconds=0.4)
    deployment = motion(linkage, scene, formulation, method=method)
    compiled, states = deployment.compiled, deployment.motion
    joints = [int(compiled.joint_of[labels_of(linkage).hinge(name)]) for name in (first, later)]
    (time, *_) = releases_of(deployment, joints[1])
    before, after = (states.q[np.flatnonzero(states.times == time)[k]] for k in (0, -1))
    assert before[joints[0]] == pytest.approx(2.5, abs=1e-5)
    assert np.array_equal(before, after)
    held = states.q[states.times <= time][:, joints[1]]
    assert np.abs(held - held[0]).max() < 1e-5
    assert states.q[states.times < time][:, joints[0]].min() >= 2.5
    assert states.drift < 1e-4 * states.largest_energy
    assert "held down" not in deployment.reason


def test_a_hinge_that_waits_in_vain_is_named():
    linkage = linkage_named(NAME)
    names = labels_of(linkage).hinges
    scene = replace(DEFAULT, releases=((names[0], f"hinge {names[2]} at 0.1 rad"),))
    deployment = motion(linkage, scene)
    assert deployment.outcome != "flat"
    assert deployment.reason.endswith(f"; still held down: hinges {names[0]}")
    joint = int(deployment.compiled.joint_of[0])
    assert deployment.motion.q[:, joint].min() == deployment.motion.q[0, joint]  # it may close, but not open


def test_an_array_that_is_stuck_waits_for_its_release():
    linkage = linkage_named(NAME)
    names = labels_of(linkage).hinges
    deployment = motion(linkage, replace(DEFAULT, friction=1.0, seconds=1.0, releases=((names[0], "0.2 s"),)))
    assert deployment.outcome == "stuck"
    assert deployment.motion.times[-1] == 0.2
    assert deployment.angles.tolist() == [deployment.angles[0].tolist()] * len(deployment.angles)
    assert "held down" not in deployment.reason
    free = motion(linkage, DEFAULT).motion
    late = motion(linkage, all_released(linkage, "40 s", replace(DEFAULT, damping=0.0043))).motion
    assert late.times[-1] == pytest.approx(40.0 + free.times[-1], abs=1e-9)


def test_hold_downs_are_parts_of_the_symmetry():
    linkage = linkage_named("square:01222300:3")
    names = labels_of(linkage).hinges
    pair = tuple((names[hinge], "0.05 s") for hinge in (1, 4))
    half, full = (
        motion(linkage, replace(DEFAULT, seconds=0.2, releases=pair), keep=frozenset(k)) for k in ((), {"half"})
    )
    assert (half.compiled.factor, full.compiled.factor) == (2.0, 1.0)
    assert half.angles_at(np.array([0.1])) == pytest.approx(full.angles_at(np.array([0.1])), abs=1e-5)
    for releases in (pair[:1], (pair[0], (names[4], "0.06 s"))):
        assert compile_scene(linkage, replace(DEFAULT, releases=releases)).factor == 1.0


def test_a_congruent_folding_is_released_at_the_same_hinges():
    linkage = linkage_named("hex:0223344000:4")
    twin = linkage.twin
    assert twin is not None
    names = labels_of(linkage).hinges
    scene = replace(DEFAULT, releases=((names[0], "0.1 s"), (names[1], f"hinge {names[3]} at 2 rad")))
    setup = setup_of_scene(scene, linkage)
    images = {(held.hinge, held.time, held.after) for held in setup.of_congruent(linkage).hold_downs}
    assert images == {(twin.hinges[0], 0.1, -1), (twin.hinges[1], -1.0, twin.hinges[3])}
    own, other = motion(linkage, setup), motion(twin.linkage, setup.of_congruent(linkage))
    assert own.angles[-1].tolist() == other.angles[-1][list(twin.hinges)].tolist()


def test_time_is_given_for_the_last_release():
    linkage = linkage_named(NAME)
    assert setup_of_scene(all_released(linkage, "2.5 s"), linkage).seconds == 3.5
    assert setup_of_scene(all_released(linkage, "2.5 s", replace(DEFAULT, seconds=0.5)), linkage).seconds == 0.5


def test_what_has_no_hold_downs_refuses_them():
    linkage = linkage_named(NAME)
    scene = all_released(linkage, "0.1 s")
    for refuse, message in (
        (lambda: compile_driven(linkage, scene, None), "drives are simulated without hold-downs"),
        (lambda: tune_springs(linkage, scene, TuningOptions()), "springs are tuned without hold-downs"),
        (lambda: compile_scene(linkage, scene, "penalty"), "the penalty formulation has no hold-downs"),
        (lambda: check_deployments([compile_scene(linkage, scene)]), "the quick check is of scenes without hold-downs"),
        (lambda: check_verdicts(scene, "hex", 10), "has hold-downs of single hinges"),
        (lambda: setup_of_scene(replace(DEFAULT, releases=(("0", "hinge 0 at 1 rad"),)), linkage), "waits for itself"),
        (lambda: setup_of_scene(replace(DEFAULT, releases=(("0", "hinge 99 at 1 rad"),)), linkage), "no hinge 99"),
    ):
        with pytest.raises(HcsearchError, match=message):
            refuse()
