"""Deployments that friction slows and holds: where they stick by the linear program of torque margins, and how."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import VALLEY_CREASE, Pattern
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.outcomes import reason_of_motion
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled, simulate_deployment
from hcsearch.springs.dynamics.time_integration import simulate_system
from tests.linkages import linkage_named

DEFAULT = SCENES["default"]


def chain(panels):
    """An open chain of square panels in a row, 50 mm wide; hinges on the top and bottom faces by turns."""
    squares = tuple(
        ((0.05 * x, 0.0), (0.05 * (x + 1), 0.0), (0.05 * (x + 1), 0.05), (0.05 * x, 0.05)) for x in range(panels)
    )
    creases = {
        (k, k + 1): VALLEY_CREASE if k % 2 == 0 else replace(VALLEY_CREASE, face="bottom") for k in range(panels - 1)
    }
    return Linkage(Pattern.from_polygons(squares, creases, 0.006))


MECHANISMS = {
    "chain of 2": lambda: chain(2),
    "chain of 3": lambda: chain(3),
    "chain of 4": lambda: chain(4),
    **{
        name: lambda name=name: linkage_named(name)
        for name in (
            "element-6r",
            "element-8r",
            "ten-triangles",
            "thesis-4x4",
            "array-6r",
            "module-i",
            "square:012230:1",
            "square:012233230011:4",
            "hex:0234550132:4",
            "hex:023224350400:4",
        )
    },
}


def torque_margin(linkage, angles, torques, friction):
    """The least factor of friction that holds the springs, by the linear program in rates of closing and opening."""
    n = len(angles)
    _, jacobian = linkage.closure(angles)
    jacobian = np.asarray(jacobian, float).reshape(-1, n)
    ways = [(0.0, 0.0 if angle > math.pi - 1e-9 else None) for angle in angles]
    ways += [(0.0, 0.0 if angle < 1e-9 else None) for angle in angles]
    _, sizes, right = np.linalg.svd(jacobian) if len(jacobian) else (None, np.zeros(0), np.eye(n))
    rows = right[: np.count_nonzero(sizes > 1e-9 * sizes.max(initial=1.0))]
    closed = {"A_eq": np.hstack([rows, -rows]), "b_eq": np.zeros(len(rows))} if len(rows) else {}
    losses = np.r_[friction, friction][None]
    found = linprog(np.r_[torques, -torques], losses, [1.0], bounds=ways, method="highs", **closed)
    assert found.status == 0
    return -found.fun


@pytest.mark.parametrize("start", [0.999, 0.7])
@pytest.mark.parametrize("name", MECHANISMS)
def test_the_friction_that_just_holds_an_array_is_that_of_the_linear_program(name, start):
    linkage = MECHANISMS[name]()
    rng = np.random.default_rng(7)
    friction = rng.uniform(0.5, 1.5, linkage.n_hinges)
    laws = tuple(f"linear:{stiffness:.3f}" for stiffness in rng.uniform(0.02, 0.2, linkage.n_hinges))
    springs = tuple(zip(labels_of(linkage).hinges, laws, strict=True))
    setup = setup_of_scene(replace(DEFAULT, start=start, springs=springs), linkage)

    def compiled(factor):
        resistance = tuple((factor * friction).tolist())
        return compile_scene(linkage, replace(setup, friction=resistance), keep=frozenset({"stops"}))

    first = compiled(0.0)
    angles, _ = first.of_hinges(first.start[None], np.zeros((1, len(first.start))))
    torques = np.array([law.straight.moment(angle) for law, angle in zip(setup.laws, angles[0], strict=True)])
    margin = torque_margin(linkage, angles[0], torques, friction)
    assert margin > 0.01

    def sticks(factor):
        scene = compiled(factor)
        motion = simulate_system(scene.system, scene.start, end=1.0, max_steps=2)
        return motion.ending == "stuck" and len(motion.times) == 1

    low, high = 0.0, 2.0 * margin
    assert sticks(high)
    assert not sticks(low)
    while high - low > 1e-8 * margin:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if sticks(middle) else (middle, high)
    assert high == pytest.approx(margin, rel=1e-6)


@pytest.mark.parametrize("name", ["hex:0234550132:4", "thesis-4x4", "hex:023224350400:4"])
def test_a_stuck_array_is_one_that_the_linear_program_holds(name):
    linkage = linkage_named(name)
    friction = np.full(linkage.n_hinges, 0.03)
    found = simulate_deployment(linkage, replace(DEFAULT, friction=0.03), certified=False)
    assert found.outcome == "stuck"
    assert not found.deploys
    angles = found.angles[-1]
    setup = found.compiled.setup
    torques = np.array([law.straight.moment(angle) for law, angle in zip(setup.laws, angles, strict=True)])
    assert 0.0 < torque_margin(linkage, angles, torques, friction) < 1.0 + 1e-6
    assert (found.rates[-1] == 0.0).all()
    assert found.motion.drift < 1e-5 * found.motion.largest_energy
    labels = labels_of(linkage).hinges
    start = f"stuck from {found.motion.times[-1]:.4g} s on: friction or harness is used most in hinges "
    assert found.reason.startswith(start)
    used, _, remedy = found.reason.removeprefix(start).partition(": ")
    *named, torques = used.split(", ")
    assert set(named) <= set(labels)
    assert re.fullmatch(r"0\.0\d+ of 0\.03 N m", torques)
    assert remedy == "give stiffer springs, or less friction or harness"


@pytest.mark.parametrize("friction", [0.01, 0.03, 0.1, 0.28, 0.31])
@pytest.mark.parametrize(
    "name", ["thesis-4x4", "unit-i", "square:01222300:0", "square:011122233300:0", "square:012222230000:0"]
)
def test_arrays_that_creep_or_slip_many_times_end_stuck_where_the_linear_program_holds_them(name, friction):
    linkage = linkage_named(name)
    found = simulate_deployment(linkage, replace(DEFAULT, friction=friction), certified=False)
    assert found.outcome == "stuck"
    assert found.motion.drift < 1e-5 * found.motion.largest_energy
    assert found.motion.evaluations < 15_000
    angles, setup = found.angles[-1], found.compiled.setup
    torques = np.array([law.straight.moment(angle) for law, angle in zip(setup.laws, angles, strict=True)])
    assert torque_margin(linkage, angles, torques, np.full(linkage.n_hinges, friction)) < 1.001


def test_a_harness_holds_as_friction_does():
    linkage = linkage_named("hex:0234550132:4")
    one = simulate_deployment(linkage, replace(DEFAULT, friction=0.02, harness=0.01), certified=False)
    other = simulate_deployment(linkage, replace(DEFAULT, friction=0.03), certified=False)
    assert np.array_equal(one.motion.q, other.motion.q)


def test_without_friction_nothing_is_computed_for_it():
    linkage = linkage_named("hex:0234550132:4")
    found = simulate_deployment(linkage, replace(DEFAULT, friction=0.0), certified=False)
    assert found.compiled.system.mechanism.hinges.friction.shape == (0,)
    assert {event.kind for event in found.motion.events} == {"hit", "released"}


@pytest.mark.parametrize("friction", [0.003, 0.02])
@pytest.mark.parametrize("name", ["thesis-4x4", "square:012230:1"])
def test_half_of_an_array_sticks_where_the_whole_does(name, friction):
    linkage, scene = linkage_named(name), replace(DEFAULT, friction=friction, seconds=0.3)
    half = simulate_compiled(compile_scene(linkage, scene), tolerance=1e-9, certified=False)
    whole = simulate_compiled(compile_scene(linkage, scene, keep=frozenset({"half"})), tolerance=1e-9, certified=False)
    assert half.compiled.factor == 2.0
    assert whole.compiled.factor == 1.0
    assert half.outcome == whole.outcome
    assert half.motion.times[-1] == pytest.approx(whole.motion.times[-1], rel=1e-5)
    assert half.angles[-1] == pytest.approx(whole.angles[-1], abs=1e-5)
    assert 2.0 * half.motion.damped[-1] == pytest.approx(whole.motion.damped[-1], rel=1e-5)


def test_unequal_friction_of_mirror_hinges_needs_the_whole_array():
    linkage = linkage_named("thesis-4x4")
    setup = setup_of_scene(DEFAULT, linkage)
    friction = [0.01] * linkage.n_hinges
    assert compile_scene(linkage, replace(setup, friction=tuple(friction))).factor == 2.0
    friction[2] = 0.02
    assert compile_scene(linkage, replace(setup, friction=tuple(friction))).factor == 1.0


def test_quick_checks_find_what_deployments_do():
    names = ("hex:0234550132:4", "hex:023224350400:4")
    scenes = [
        compile_scene(linkage_named(name), replace(DEFAULT, friction=friction))
        for name in names
        for friction in (0.0, 0.003, 0.03)
    ]
    found = check_deployments(scenes)
    assert {check.outcome for check in found} == {"flat", "stuck"}
    for scene, check in zip(scenes, found, strict=True):
        whole = simulate_compiled(scene).check
        assert (check.outcome, check.verdict, check.end_time) == (whole.outcome, whole.verdict, whole.end_time)
        assert check.drift == whole.drift
    stuck = next(check for check in found if check.outcome == "stuck")
    assert stuck.reason(labels_of(scenes[0].linkage)).startswith("stuck at ")


@pytest.mark.parametrize("formulation", ["compliant", "penalty", "quasistatic"])
def test_other_formulations_refuse_friction(formulation):
    with pytest.raises(HcsearchError, match="take the constrained formulation, or a scene without friction"):
        compile_scene(linkage_named("thesis-4x4"), replace(DEFAULT, friction=0.01), formulation)


def test_the_hinge_whose_friction_is_used_most_is_named():
    linkage = chain(3)
    setup = replace(setup_of_scene(DEFAULT, linkage), friction=(0.5, 0.4))
    compiled = compile_scene(linkage, setup)
    motion = simulate_compiled(compiled, certified=False).motion
    assert motion.ending == "stuck"
    torque = 0.1 * motion.q[0].max()
    hinge = labels_of(linkage).hinges[1]
    expected = f"stuck from 0 s on: friction or harness is used most in hinges {hinge}, {torque:.3g} of 0.4 N m"
    assert reason_of_motion(compiled, motion).startswith(expected)
