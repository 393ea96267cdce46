"""Steps at singular states, where accelerations are unbounded: loops stay closed, and packed panels only touch."""

import math

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.kernels.multibody.events import INTERPOLATED_STATE_RESIDUAL, largest_opening, refined_motion
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes import SCENES, panel_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.agreement import confirm_deployment
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch.springs.dynamics.integration_methods import interpolate_motion
from hcsearch.springs.dynamics.time_integration import closed_between

DEFAULT = SCENES["default"]
SINGULAR = [
    ("kite:23203030:3", "merged", "implicit", 1e-6),
    ("kite:23203030:3", "merged", "implicit", 1e-5),
    ("square:01222300:3", "rigid", "bogacki-shampine", 1e-6),
    ("square:0122323001:3", "hinged", "dormand-prince", 1e-6),
    ("rectangle:12333011:3", "rigid", "dormand-prince", 1e-6),
    ("rectangle:0122323001:3", "rigid", "implicit", 1e-5),
    ("rectangle:0122323001:3", "hinged", "dormand-prince-8", 1e-6),
]
"""Motions that become flat past a state at which a hinge is about to leave its stop; loops then opened by 1e-3 to 3
between two states of the simulation."""


def compiled_of(name, way):
    linkage: Linkage = Folding.from_notation(name).linkage(panel_of(DEFAULT, name.split(":")[0]), flat_pairs=way)
    return compile_scene(linkage, DEFAULT)


@pytest.mark.parametrize(("name", "way", "method", "tolerance"), SINGULAR)
def test_packed_panels_touch_and_do_not_collide_whatever_the_method(name, way, method, tolerance):
    deployment = simulate_compiled(compiled_of(name, way), method=method, tolerance=tolerance)
    assert deployment.outcome == "flat"
    assert deployment.clearance.kind == "clear"
    assert deployment.check.opening < 2.0 * INTERPOLATED_STATE_RESIDUAL


@pytest.mark.parametrize(
    ("name", "way"),
    [
        ("kite:23203030:3", "merged"),
        ("rectangle:12333011:3", "rigid"),
        ("rectangle:0122323001:3", "rigid"),
        ("hex:0233445011:1", "rigid"),  # nearly touches where loops hardly open
        ("hex:0234435011:1", "rigid"),  # diverges
    ],
)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-6])
def test_a_check_of_many_has_the_slack_of_each_step_too(name, way, tolerance):
    compiled = compiled_of(name, way)
    one = simulate_compiled(compiled, tolerance=tolerance)
    (found,) = check_deployments([compiled], tolerance=tolerance)
    clearance = one.clearance
    assert (found.verdict, found.looks, found.gap) == (one.verdict, clearance.bound_count, clearance.gap)
    assert (found.opening, found.collision, found.speed) == (one.check.opening, one.check.collision, clearance.speed)


def test_one_method_deploys_at_all_tolerances():
    deployment = simulate_compiled(compiled_of("kite:23203030:3", "merged"), method="implicit", tolerance=1e-6)
    assert confirm_deployment(deployment, method="implicit", tolerance=1e-6).verdict == "deploys"


def test_pictures_of_such_steps_have_closed_loops():
    compiled = compiled_of("rectangle:0122323001:3", "rigid")
    deployment = simulate_compiled(compiled, method="implicit", tolerance=1e-5)
    times = np.linspace(0.0, deployment.motion.times[-1], 1000)
    for angles in deployment.angles_at(times):
        assert np.abs(compiled.linkage.closure(angles)[0]).max() < 1e-5
    assert deployment.angles_at(times).max() < np.pi + 1e-3


def test_diverged_motions_are_not_near_a_collision_at_their_start():
    deployment = simulate_compiled(compiled_of("hex:0234435011:1", "rigid"))
    assert deployment.verdict == "undecided"
    assert deployment.clearance.time is None or deployment.clearance.time > 1e-3


def test_a_step_with_a_false_acceleration_is_the_cubic_through_its_ends():
    compiled = compiled_of("hex:0234550132:4", "rigid")
    system, motion = compiled.system, simulate_compiled(compiled, certified=False).motion
    k = int(np.argmax(np.diff(motion.times)))
    false = motion.a.copy()
    false[k, 0] += 1e6
    states, tree = (motion.times, motion.q, motion.v, false), system.mechanism.tree
    work = work_for(tree)
    assert largest_opening(tree, states, False, work) > 1e-2
    times, q, v, a = refined_motion(system.mechanism, states, INTERPOLATED_STATE_RESIDUAL, math.inf, work)
    assert largest_opening(tree, (times, q, v, a), False, work) < 1e-3
    # all states are still there, and those of the step are there twice
    for row in range(len(motion.times)):
        same = [j for j in range(len(times)) if (q[j] == motion.q[row]).all() and times[j] == motion.times[row]]
        assert any((a[j] == false[row]).all() for j in same)
        assert len(same) >= (2 if row in (k, k + 1) else 1)
    inside = np.linspace(*motion.times[k : k + 2], 9)
    own = interpolate_motion(times, q, v, a, inside)
    cubic = interpolate_motion(motion.times, motion.q, motion.v, None, inside)
    assert own == pytest.approx(cubic, abs=1e-4)  # closed states within it may be added


def test_motions_that_are_smooth_keep_their_states():
    compiled = compiled_of("hex:0234550132:4", "rigid")
    motion = simulate_compiled(compiled, tolerance=1e-9, certified=False).motion
    assert closed_between(compiled.system, motion)[0][0].tobytes() == motion.times.tobytes()
