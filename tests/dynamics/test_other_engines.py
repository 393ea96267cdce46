"""Deployments before the first impact against Pinocchio, MuJoCo and Exudyn, which have dynamics of their own."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.dynamics.time_integration import simulate_system
from hcsearch_bench.peers import exudyn_system, mujoco_system, pinocchio_system
from tests.linkages import linkage_named

pytestmark = pytest.mark.extra

SCENE_CHANGES = {
    "default": {},
    "gravity": {"gravity": (0.0, -9.81, 0.0)},
    "floating": {"held": "free", "base_mass": 0.02, "base_inertia": (1e-5, 2e-5, 3e-5)},
}
NAMES = ("thesis-4x4", "hex:023224350400:4")
END = 0.03


def unstopped(name, changes):
    """The changed scene with nothing left out, and without stops, which nothing hits in the time; its start."""
    compiled = compile_scene(linkage_named(name), replace(SCENES["default"], **changes), keep=frozenset(OMISSIONS))
    drives = tuple(replace(drive, lower=-math.inf, upper=math.inf) for drive in compiled.system.drives)
    return replace(compiled.system, drives=drives), compiled.start


@pytest.mark.parametrize("scene", SCENE_CHANGES)
@pytest.mark.parametrize("name", NAMES)
def test_other_engines_find_the_same_motion(name, scene):
    system, start = unstopped(name, SCENE_CHANGES[scene])
    times, still = np.linspace(0.0, END, 31), np.zeros(len(start))
    own = simulate_system(system, start, end=END, method="dormand-prince-8", tolerance=1e-11)
    expected = own.at(times)
    assert np.abs(expected[-1] - start).max() > 0.1
    pinocchio = pinocchio_system.run(system, start, still, times, tolerance=1e-9)
    assert pinocchio.q == pytest.approx(expected, abs=1e-6)
    if scene == "floating":  # the others take no bodies without mass, which a base of six joints has
        return
    mujoco = mujoco_system.run(system, start, still, times, step=2e-6)
    assert mujoco.q == pytest.approx(expected, abs=2e-5)
    exudyn = exudyn_system.run(system, start, still, times, step=2e-5)
    assert exudyn.q == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize(("friction", "start"), [(0.02, 0.999), (0.1, 0.9)])
@pytest.mark.parametrize("name", NAMES)
def test_mujoco_finds_the_same_sticking_and_sliding(name, friction, start):
    """Its friction yields a little, by the length of its steps."""
    system, q = unstopped(name, {"friction": friction, "start": start})
    times = np.linspace(0.0, 0.1, 26)
    own = simulate_system(system, q, end=0.1, tolerance=1e-10)
    assert {event.kind for event in own.events} <= {"stuck", "slips"}
    assert len(own.events) >= 3
    expected = own.at(times)
    assert np.abs(expected[-1] - q).max() > 1.0
    found = mujoco_system.run(system, q, np.zeros(len(q)), times, step=1e-5)
    assert found.q == pytest.approx(expected, abs=2e-4)
