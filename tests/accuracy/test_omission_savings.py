"""What is left out changes nothing beyond numerical errors: each omission is put back truly, on three scenes."""

import math

import numpy as np
import pytest

from hcsearch.scenes import Scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import ALL_OMISSIONS, NO_GRAVITY, compile_scene
from hcsearch.springs.deployment.omission_savings import (
    EVERYTHING,
    can_restore,
    omission_savings,
    saving_facts,
    saving_sentence,
)
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled
from hcsearch_bench.stability.strips import StabilitySubject
from tests.accuracy.subjects import FOLDING, linkage_named

STRIP = StabilitySubject("strip", 4).linkage
FLAT = linkage_named("hex:023350:1")
STIFF = Scene(start=0.9, seconds=0.05, springs=((labels_of(linkage_named(FOLDING)).hinges[3], "linear:3"),))
SCENES = {
    "an open chain": (STRIP, Scene(seconds=0.05)),
    "a loop with parallel hinges": (FLAT, Scene(seconds=0.02)),
    "a loop with a stiff spring": (linkage_named(FOLDING), STIFF),
}


@pytest.mark.parametrize("name", SCENES)
def test_omissions_change_nothing_beyond_numerical_errors(name):
    compiled = compile_scene(*SCENES[name])
    savings = list(omission_savings(compiled, method=None, tolerance=1e-6, together=True))
    assert [saving.omission.name for saving in savings] == [
        *(omission.name for omission in compiled.omissions),
        EVERYTHING,
    ]
    for saving in savings:
        assert saving.difference <= saving.bound < 1e-6, (name, saving)
        assert saving.within
        assert min(saving.milliseconds) > 0.0
        assert saving.noise >= 0.0
        assert "MORE THAN STATED" not in saving_sentence(saving_facts(saving))
    for exact in ("gravity", "pairs"):
        assert [saving.difference for saving in savings if saving.omission.name == exact] == [0.0]


def test_the_scenes_have_all_omissions_between_them():
    left_out = [omission.name for scene in SCENES.values() for omission in compile_scene(*scene).omissions]
    assert set(left_out) == set(ALL_OMISSIONS)
    assert len(left_out) >= 10


def kept(linkage, scene, name):
    return compile_scene(linkage, scene, keep=frozenset({name}))


def test_a_base_put_back_has_joints_that_do_not_move():
    for linkage, scene in SCENES.values():
        compiled, full = compile_scene(linkage, scene), kept(linkage, scene, "base")
        base = full.system.n_joints - compiled.system.n_joints
        assert base in (3, 6)  # fewer in a mirror plane
        assert (~full.hinged).sum() == base
        motion = simulate_compiled(full, certified=False).motion
        assert np.abs(motion.q[:, :base]).max() < 1e-12
        assert np.abs(motion.q[:, base:]).max() > 0.1


def test_closure_put_back_is_a_panel_in_two_halves():
    compiled, full = compile_scene(STRIP, SCENES["an open chain"][1]), kept(*SCENES["an open chain"], "closure")
    assert full.system.n_joints == compiled.system.n_joints + 1
    assert len(full.system.welds) == 1
    mass = sum(body.mass for body in full.system.bodies)
    whole = sum(body.mass for body in kept(*SCENES["an open chain"], "half").system.bodies)
    assert full.factor * mass == pytest.approx(whole, rel=1e-12)
    drives = [drive for drive in full.system.drives if drive.upper < math.inf or drive.damping > 0.0]
    assert len(drives) == full.system.n_joints - 1  # one half has neither spring nor stops


def names(compiled):
    return {omission.name for omission in compiled.omissions}


def test_gravity_put_back_is_there_and_pairs_put_back_are_checked():
    linkage, scene = SCENES["a loop with a stiff spring"]
    full = kept(linkage, scene, "gravity")
    assert full.system.gravity == NO_GRAVITY
    assert "stops" in names(full)  # the bound on the energy still holds
    assert kept(linkage, scene, "pairs").separated_pairs == frozenset()
    for name in ALL_OMISSIONS:
        assert name not in names(kept(linkage, scene, name))


def test_without_inertia_no_joint_may_be_undamped():
    compiled = compile_scene(STRIP, Scene(), "quasistatic")
    assert not can_restore(compiled, "base")
    assert {saving.omission.name for saving in omission_savings(compiled, method=None, tolerance=1e-6)} == {
        name for name in names(compiled) if name not in {"base", "closure"}
    }


def test_omissions_of_stiff_scenes_are_compared_by_the_method_that_ends():
    compiled = compile_scene(linkage_named(FOLDING), Scene(damping=0.2))
    assert simulate_compiled(compiled, certified=False).motion.method == "implicit"
    for saving in omission_savings(compiled, method=None, tolerance=1e-6):
        assert saving.difference is not None, saving
        assert saving.within, saving
