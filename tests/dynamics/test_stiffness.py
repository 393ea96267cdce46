"""Stiffness of motions: its estimate, and implicit steps where explicit ones are limited by their stability."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hcsearch import Folding, Scene, deploy
from hcsearch.kernels.multibody.accelerations import accelerate, discrete_state_for, largest_pivot
from hcsearch.kernels.multibody.endings import SINGULAR_REJECTION_SHARE
from hcsearch.kernels.multibody.paused_simulation import PACE_COORDINATES, PACE_SCALE, Simulation, new_pace
from hcsearch.kernels.multibody.simulation import continue_simulation, start_simulation
from hcsearch.kernels.multibody.stiffness import STABLE_STEP, STIFF_STEPS, fastest_rate
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.springs.accuracy.swept_values import SWEPT_VALUES, ScenePoint
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.outcomes import MAX_DEPLOYMENT_STEPS
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.dynamics.integration_methods import method_named
from hcsearch.springs.dynamics.time_integration import plan_for, record_for
from tests.linkages import linkage_named

DEPLOYS = "hex:0234550132:4"
FOLDINGS = (DEPLOYS, "hex:0122334550:1", "square:01222300:1", "square:0121222323030001:5")


def compiled_of(name, *, formulation="constrained", **values):
    return compile_scene(linkage_named(name), Scene(**values), formulation)


def slower(name, factor, spread=1.0):
    """Return the scene `default` with dampers stronger by a factor, in as much more time, and a spread of springs."""
    linkage = linkage_named(name)
    point = SWEPT_VALUES["spread"].changed(ScenePoint(linkage, setup_of_scene(Scene(), linkage)), spread)
    times = tuple(factor * time for time in point.setup.damping_time)
    return compile_scene(linkage, replace(point.setup, damping_time=times, seconds=factor * point.setup.seconds))


def dense_operator(compiled):
    """The derivative of accelerations by velocities (of velocities by coordinates), column by column."""
    mechanism, q, n = compiled.system.mechanism, compiled.start, compiled.system.n_joints
    work, hold = work_for(mechanism.tree), discrete_state_for(mechanism, q)
    scale = largest_pivot(mechanism, q, work)

    def response(change):
        a = np.zeros(n)
        moved, v = (q + change, np.zeros(n)) if mechanism.overdamped else (q, change)
        accelerate(mechanism, hold, moved, v, scale, True, work, a)
        return a

    columns = [(response(1e-6 * unit) - response(np.zeros(n))) / 1e-6 for unit in np.eye(n)]
    return np.array(columns).T


def estimated_rate(compiled):
    mechanism, q, n = compiled.system.mechanism, compiled.start.copy(), compiled.system.n_joints
    work = work_for(mechanism.tree)
    pace = new_pace(n)
    pace[:PACE_COORDINATES] = 0.0
    pace[PACE_SCALE] = largest_pivot(mechanism, q, work)
    methods = method_named("dormand-prince"), method_named("implicit")
    plan = plan_for(compiled.system, end=compiled.seconds)
    hold = discrete_state_for(mechanism, q)
    return fastest_rate(Simulation(mechanism, hold, *methods, plan, q, np.zeros(n), work, pace, record_for(n, 10)))


@pytest.mark.parametrize("name", FOLDINGS)
@pytest.mark.parametrize("values", [{}, {"damping": 4.0}, {"springs": (("0", "linear:10"),)}])
@pytest.mark.parametrize("formulation", ["constrained", "quasistatic"])
def test_the_fastest_rate_is_the_largest_eigenvalue(name, values, formulation):
    compiled = compiled_of(name, formulation=formulation, **values)
    largest = np.abs(np.linalg.eigvals(dense_operator(compiled))).max()
    assert 0.6 * largest < estimated_rate(compiled) < 1.4 * largest


@pytest.mark.parametrize("name", FOLDINGS)
def test_motions_of_the_scene_default_are_not_stiff(name):
    compiled = compiled_of(name)
    assert estimated_rate(compiled) * compiled.seconds / STABLE_STEP < STIFF_STEPS
    motion = simulate_compiled(compiled, certified=False).motion
    explicit = simulate_compiled(compiled, method="dormand-prince", certified=False).motion
    assert math.isinf(motion.stiff_time)
    for table in ("times", "q", "v", "a"):
        assert getattr(motion, table).tobytes() == getattr(explicit, table).tobytes()


@pytest.mark.parametrize("damping", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("name", ["square:01222300:1", "triangle:0123434501:1"])
def test_stiff_motions_take_implicit_steps_and_become_flat(name, damping):
    compiled = compiled_of(name, damping=damping)
    motion = simulate_compiled(compiled, certified=False).motion
    assert (motion.ending, motion.stiff_time) == ("flat", 0.0)
    assert motion.steps < 500
    exact = simulate_compiled(compiled, method="implicit", tolerance=1e-10, certified=False).motion
    assert motion.times[-1] == pytest.approx(exact.times[-1], rel=1e-4)
    explicit = simulate_compiled(compiled, method="dormand-prince", certified=False).motion
    assert explicit.ending == "steps"


def test_steps_that_stability_limits_become_implicit_on_the_way():
    compiled = slower("square:01222300:1", 3.0)
    explicit = simulate_compiled(compiled, method="dormand-prince", certified=False).motion
    motion = simulate_compiled(compiled, certified=False).motion
    assert 0.0 < motion.stiff_time < 0.2 * explicit.times[-1]
    assert motion.evaluations < explicit.evaluations / 3
    assert motion.ending == explicit.ending == "flat"
    assert motion.times[-1] == pytest.approx(explicit.times[-1], rel=1e-4)


@pytest.mark.parametrize(
    ("name", "factor", "spread"),
    [("hex:0232335050:2", 1000.0, 1.0), ("hex:0234550132:4", 1000.0, 1e6), ("square:01222300:1", 100.0, 1.0)],
)
@pytest.mark.parametrize(("method", "greatest"), [("implicit", 2e-4), ("linearly-implicit", 3e-3)])
def test_stiff_motions_are_exact_within_steps_too(name, factor, spread, method, greatest):
    compiled = slower(name, factor, spread)
    exact = simulate_compiled(compiled, method="implicit", tolerance=1e-10, certified=False)
    deployment = simulate_compiled(compiled, method=method, tolerance=1e-6, certified=False)
    times = np.linspace(0.0, 0.999 * exact.motion.times[-1], 3001)
    assert np.abs(deployment.angles_at(times) - exact.angles_at(times)).max() < greatest


def test_a_stiff_motion_with_a_gap_is_no_collision():
    # a quintic through the states of 37 steps once crossed a stop by 3 degrees between two of them
    (check,) = check_deployments([slower("hex:0232335050:2", 1000.0)])
    assert (check.outcome, check.clear) == ("at rest", True)


@pytest.mark.parametrize("method", ["dormand-prince", "implicit", "linearly-implicit"])
@pytest.mark.parametrize(("name", "factor"), [("hex:0232335050:2", 1000.0), ("hex:0122334550:1", 1.0)])
def test_a_motion_does_not_depend_on_how_often_it_is_paused(name, factor, method):
    def simulated(states):
        compiled = slower(name, factor)
        mechanism, q, n = compiled.system.mechanism, compiled.start.copy(), compiled.system.n_joints
        record, hold = record_for(n, 300), discrete_state_for(mechanism, q)
        plan, methods = plan_for(compiled.system, end=compiled.seconds), [method_named(method)] * 2
        work, pace = work_for(mechanism.tree), new_pace(n)
        simulation = Simulation(mechanism, hold, *methods, plan, q, np.zeros(n), work, pace, record)
        start_simulation(simulation)
        for most in (*range(2, 300, states), 301):
            continue_simulation(simulation, most)
        tables = record.times, record.q, record.v, record.a
        return record.counts.tolist(), [table[: record.counts[0]].tobytes() for table in tables]

    assert simulated(3) == simulated(299)


def test_steps_near_singular_states_stay_explicit():
    compiled = slower("hex:0122334550:1", 10.0)
    motion = simulate_compiled(compiled, certified=False).motion
    assert math.isinf(motion.stiff_time)
    assert motion.evaluations < simulate_compiled(compiled, method="implicit", certified=False).motion.evaluations / 4


def test_a_motion_that_creeps_to_a_singular_state_is_branch_singular():
    compiled = slower("square:0122323001:3", 1000.0, spread=1e6)
    simulated = simulate_compiled(compiled, certified=False)
    assert (simulated.outcome, simulated.verdict) == ("branch-singular", "undecided")
    assert simulated.motion.steps < MAX_DEPLOYMENT_STEPS["constrained"] / 2
    assert simulated.motion.rejected > SINGULAR_REJECTION_SHARE * MAX_DEPLOYMENT_STEPS["constrained"]
    assert "rounding errors limit its steps" in simulated.reason
    assert check_deployments([compiled])[0].outcome == "branch-singular"


def test_a_motion_that_would_run_out_of_steps_goes_on_implicitly():
    compiled = compiled_of("square:01222300:1", damping=0.01)
    explicit = simulate_compiled(compiled, method="dormand-prince", certified=False, max_steps=200)
    assert explicit.outcome == "out of steps"
    motion = simulate_compiled(compiled, certified=False, max_steps=200).motion
    assert motion.ending == "flat"
    assert 0.0 < motion.stiff_time < motion.times[-1]
    before = int(np.searchsorted(motion.times, motion.stiff_time))
    assert before == 150
    whole = simulate_compiled(compiled, method="dormand-prince", tolerance=1e-9, certified=False).motion
    assert motion.times[-1] == pytest.approx(whole.times[-1], rel=1e-4)
    times = np.linspace(0.0, whole.times[-1], 500)
    assert np.abs(motion.at(times) - whole.at(times)).max() < 1e-4


@pytest.mark.parametrize("values", [{}, {"damping": 0.1}, {"damping": 3.0}])
def test_quick_checks_choose_the_same_method(values):
    compiled = compiled_of("square:01222300:1", **values)
    check = check_deployments([compiled])[0]
    assert check.stiff_time == simulate_compiled(compiled).check.stiff_time
    assert check.outcome == "flat"
    assert (check.stiff_time == 0.0) == bool(values)


def test_a_method_that_is_given_is_kept():
    folding = Folding.from_notation(DEPLOYS)
    facts = deploy(folding, damping=1.0, method="dormand-prince").facts()
    assert (facts["method"], facts["outcome"]) == ("dormand-prince", "out of steps")
    assert deploy(folding, damping=1.0).facts()["method"] == "implicit"
    assert deploy(folding).facts()["method"] == "dormand-prince"
