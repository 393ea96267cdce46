"""Laws that act from a time on, or rise in proportion to time."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.multibody.hinges import set_factors
from hcsearch.scenes import SCENES, check_verdicts
from hcsearch.scenes.laws import law_named, linear_law, preloaded_law, scaled_law, timed_law
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import compile_driven, simulate_deployment
from hcsearch.springs.flight.travel import travel_by_springs
from hcsearch.springs.tuning.spring_tuning import tune_springs
from hcsearch.springs.tuning.tuning_options import TuningOptions
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]
NAME = "hex:0234550132:4"
ONE_HINGE = "square:0123:0"
METHODS = ["bogacki-shampine", "dormand-prince", "dormand-prince-8", "implicit"]
LAWS = ["linear:0.1", "2*linear:0.1+0.02", "quadratic:0.02,0.03", "table:0@0,0.1@1.5,0.3@3.1"]
times = st.floats(0.001, 100.0).map(lambda value: float(f"{value:.6g}"))


def motion(linkage, scene, formulation="constrained", **options):
    return simulate_deployment(linkage, scene, formulation, certified=False, **options)


@given(
    st.sampled_from(["linear:0.1", "2*linear:0.1+0.02", "quadratic:0.02,0.03", "table:0@0,0.1@1.5,0.3@3.1"]),
    times,
    times,
)
def test_the_notation_of_a_law_in_time_reads_back(text, one, other):
    begin, full = sorted((one, other))
    law = timed_law(law_named(text), begin, full)
    assert (law.begin, law.full) == (begin, full)
    assert law_named(law.text) == law
    assert law_named(f"{text} from {begin} to {full} s") == law
    assert timed_law(law_named(text), begin, begin) == law_named(f"{text} from {begin} s")
    assert timed_law(law, 0.0, 0.0) == law_named(text)
    assert scaled_law(law, 2.0) == law_named(scaled_law(law, 2.0).text)
    assert preloaded_law(law, 0.5) == law_named(preloaded_law(law, 0.5).text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("linear:0.1 from 2 to 1 s", "no law acts from 2 to 1 s"),
        ("free from 1 s", "the law free always acts"),
        ("tape:0.2@0.05,0.03@0.01 from 1 s", "always acts"),
        ("linear:0.1 from -1 s", "cannot read the law"),
        ("linear:0.1 from 1e13 s", "no law acts from 10000000000000 to"),
    ],
)
def test_what_is_no_law_in_time_is_refused(text, message):
    with pytest.raises(HcsearchError, match=message):
        law_named(text)


@given(*(st.integers(0, most).map(lambda share: 0.125 * share) for most in (24, 16, 8)))
def test_factors_rise_in_proportion_to_time(time, begin, duration):
    system = compile_scene(linkage_named(ONE_HINGE), DEFAULT).system
    law = timed_law(linear_law(0.1), begin, begin + duration) if begin + duration > 0.0 else linear_law(0.1)
    hinges = system.driven((replace(system.drives[0], law=law),)).mechanism.hinges
    set_factors(hinges, time)
    if not begin + duration:
        assert len(hinges.factors) == len(hinges.ramps) == 0
        return
    expected = float(time >= begin) if not duration else min(max((time - begin) / duration, 0.0), 1.0)
    assert hinges.factors.tolist() == pytest.approx([expected], rel=1e-12)
    assert hinges.ramps[0, 2] == (pytest.approx(1.0 / duration) if begin == 0.0 and duration else 0.0)


@settings(max_examples=10)
@given(st.floats(1e-3, 3.0), st.sampled_from(METHODS), st.sampled_from([NAME, "square:01222300:3"]))
def test_a_motion_by_springs_that_act_later_is_the_same_later(time, method, name):
    linkage = linkage_named(name)
    free = motion(linkage, DEFAULT, method=method).motion
    later = motion(linkage, replace(DEFAULT, spring=f"linear:0.1 from {time!r} s"), method=method).motion
    assert later.ending == free.ending
    assert later.times[-1] - time == pytest.approx(free.times[-1], abs=1e-12 * (1.0 + time))
    assert later.q[-len(free.q) :].tolist() == free.q.tolist()
    assert later.stored[0] == 0.0
    assert later.lost[-1] - free.lost[-1] == pytest.approx(-free.stored[0], rel=1e-12)
    assert later.drift == pytest.approx(free.drift, abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("begin", "full"), [(0.0, 0.3), (0.05, 0.3), (0.05, 20.0)])
def test_one_hinge_follows_the_equation_of_a_spring_that_rises(method, begin, full):
    linkage = linkage_named(ONE_HINGE)
    scene = replace(DEFAULT, spring=f"linear:0.1 from {begin} to {full} s", damping=1e-3, seconds=1.0)
    deployment = motion(linkage, scene, method=method, tolerance=1e-8)
    system, states = deployment.compiled.system, deployment.motion
    joint, body, drive = system.joints[0], system.bodies[0], system.drives[0]
    inertia, stiffness = joint.axis @ body.about(joint.point) @ joint.axis, drive.law.mean_stiffness

    def rates(time, state):
        factor = min(max((time - begin) / (full - begin), 0.0), 1.0)
        return state[1], -(factor * stiffness * state[0] + drive.damping * state[1]) / inertia

    stops = sorted({time for time in (begin, full) if 0.0 < time < states.times[-1]} | {0.0, float(states.times[-1])})
    state = [states.q[0, 0], 0.0]
    for start, end in pairwise(stops):
        state = solve_ivp(rates, (start, end), state, rtol=1e-11, atol=1e-12, max_step=0.01).y[:, -1]
        assert states.at(np.array([end]))[0, 0] == pytest.approx(state[0], abs=2e-6)
    assert states.ending == ("flat" if full < 1.0 else "time")
    assert states.q[-1, 0] == pytest.approx(0.01, abs=1e-6) or full > 1.0
    assert states.drift < 1e-6 * states.largest_energy


@pytest.mark.parametrize(
    ("formulation", "method", "tolerance"), [("constrained", "dormand-prince", 1e-6), ("compliant", "implicit", 1e-7)]
)
def test_energy_is_balanced_while_springs_rise(formulation, method, tolerance):
    linkage = linkage_named("square:01222300:3")
    scene = replace(DEFAULT, spring="linear:0.1+0.01 from 0.05 to 0.4 s", seconds=0.6)
    states = motion(linkage, scene, formulation, method=method, tolerance=tolerance).motion
    assert states.ending == "flat"
    assert states.drift < 5e-4 * states.largest_energy
    given_energy = -(states.damped + states.lost)[-1]
    ends = [(states.kinetic + states.stored + states.height + states.in_stops)[k] for k in (0, -1)]
    assert abs(ends[0]) < 1e-20
    assert given_energy == pytest.approx(ends[1], abs=5e-4 * states.largest_energy)
    assert {0.05, 0.4} <= set(states.times.tolist())


def test_springs_that_rise_move_what_friction_holds_at_first():
    linkage = linkage_named(ONE_HINGE)
    scene = replace(DEFAULT, friction=0.1, spring="linear:0.1 from 0.1 to 2.1 s", seconds=4.0)
    deployment = motion(linkage, scene)
    system, states = deployment.compiled.system, deployment.motion
    drive = system.drives[0]
    needed = drive.friction / (drive.law.mean_stiffness * states.q[0, 0])
    moving = np.flatnonzero(np.abs(states.q[:, 0] - states.q[0, 0]) > 1e-3)[0]
    assert 0.0 < states.times[moving] - (0.1 + 2.0 * needed) < 0.3
    assert np.abs(states.q[states.times < 0.1 + 2.0 * needed - 0.01, 0] - states.q[0, 0]).max() < 1e-9


def test_laws_in_time_are_parts_of_the_symmetry():
    linkage = linkage_named("square:01222300:3")
    names = labels_of(linkage).hinges
    pair = tuple((names[hinge], "linear:0.1 from 0.1 to 0.2 s") for hinge in (1, 4))
    scene = replace(DEFAULT, seconds=0.25, springs=pair)
    half, full = (motion(linkage, scene, keep=frozenset(keep)) for keep in ((), {"half"}))
    assert (half.compiled.factor, full.compiled.factor) == (2.0, 1.0)
    at = np.array([0.15, 0.24])
    assert half.angles_at(at) == pytest.approx(full.angles_at(at), abs=1e-5)
    assert compile_scene(linkage, replace(DEFAULT, springs=pair[:1])).factor == 1.0


def test_time_is_given_until_springs_act_in_full():
    linkage = linkage_named(NAME)
    assert setup_of_scene(replace(DEFAULT, spring="linear:0.1 from 1 to 2.5 s"), linkage).seconds == 3.5


def test_a_table_of_a_file_may_act_from_a_time_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "spring.csv").write_text("angle_rad,moment_N_m\n0,0\n3.1,0.3\n")
    scene = replace(DEFAULT, spring="table:spring.csv+0.01 from 0.5 s")
    assert scene.spring == "table:0@0,0.3@3.1+0.01 from 0.5 s"
    assert math.isclose(law_named(scene.spring).full, 0.5)


def test_what_has_no_time_refuses_laws_in_time():
    linkage, scene = linkage_named(NAME), replace(DEFAULT, spring="linear:0.1 from 0.1 s")
    for refuse, message in (
        (lambda: compile_driven(linkage, scene, None), "without hold-downs and laws in time"),
        (lambda: tune_springs(linkage, scene, TuningOptions()), "without a preload or a time"),
        (lambda: compile_scene(linkage, scene, "penalty"), "no hold-downs and no laws in time"),
        (lambda: travel_by_springs(linkage, scene), "figures for flight are of springs that always act"),
        (lambda: check_verdicts(scene, "hex", 10), "springs that act from a time on"),
        (lambda: timed_law(linear_law(0.1), -1.0, 1.0), "no law acts from -1 to 1 s"),
    ):
        with pytest.raises(HcsearchError, match=message):
            refuse()
