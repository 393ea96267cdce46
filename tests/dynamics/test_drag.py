"""Drag of panels: the kernel against plain matrices, the quadrature against integrals, and deployments in air."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive_dynamics import Twin, random_system

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.multibody import accelerations, sweeps
from hcsearch.kernels.multibody.drag import drag_power
from hcsearch.kernels.multibody.hinges import lost_power
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes import Scene
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.quick_check import check_deployments
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.dynamics.inverse import joint_forces
from hcsearch.springs.dynamics.panels import facet_drag
from hcsearch.springs.dynamics.system import FacetDrag
from tests.linkages import linkage_named

HEXAGON = [(math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)) for k in range(6)]


def in_air(seed, **options):
    """A random system without loops, each body with a facet of some points; its state."""
    system, rng = random_system(seed, welds=0, **options)
    facets = []
    for body in range(system.n_joints):
        normal = rng.normal(size=3)
        points, weights = rng.normal(size=(4, 3)), rng.uniform(0.1, 1.0, 4)
        facets.append(FacetDrag(body, normal / np.linalg.norm(normal), points, weights))
    n = system.n_joints
    return replace(system, drags=tuple(facets)), 0.5 * rng.normal(size=n), rng.normal(size=n)


@pytest.mark.parametrize("seed", range(15))
def test_drag_is_that_of_plain_matrices(seed):
    system, q, v = in_air([7, seed])
    twin, mechanism, n = Twin(system), system.mechanism, system.n_joints
    work, found = work_for(mechanism.tree), np.empty(n)
    hold = accelerations.discrete_state_for(mechanism, q)
    scale = accelerations.largest_pivot(mechanism, q, work)
    accelerations.accelerate(mechanism, hold, q, v, scale, True, work, found)
    expected, _ = twin.accelerations(q, v, np.zeros(n, bool))
    assert found == pytest.approx(expected, rel=1e-7, abs=1e-7 * max(1.0, np.abs(expected).max()))
    sweeps.place_bodies(mechanism.tree, q, work)
    sweeps.move_bodies(mechanism.tree, v, work)
    lost = lost_power(mechanism.hinges, mechanism.struts, q, v, work) + drag_power(mechanism.drag, work)
    assert lost == pytest.approx(twin.lost_power(q, v), rel=1e-8)


@pytest.mark.parametrize("name", ["hex:0234550132:4", "element-8r"])
def test_inverse_dynamics_has_the_drag_of_the_kernel(name):
    linkage = linkage_named(name)
    rng = np.random.default_rng(3)
    systems = [compile_scene(linkage, Scene(drag=drag), keep=frozenset({"half"})).system for drag in (0.0, 5.0)]
    n = systems[0].n_joints
    q, v = rng.uniform(0.2, 2.0, n), rng.normal(size=n)
    still, moved = (joint_forces(system, q[None], v[None], np.zeros((1, n))).joints[0] for system in systems)
    pushed = Twin(systems[1]).pushed(q)
    expected = sum(w * abs(nn @ j @ v) * (nn @ j @ v) * (j.T @ nn) for j, nn, w in pushed)
    assert moved - still == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_a_plate_that_turns_about_its_edge_has_the_moment_of_the_integral():
    length, width, drag, rate = 0.3, 0.2, 1.4, 5.0
    facet = facet_drag(0, [(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)], 0.006, drag)
    arms = facet.points[:, 0]
    moment = (facet.weights * (rate * arms) ** 2 * arms).sum()
    assert moment == pytest.approx(0.5 * drag * rate**2 * width * length**4 / 4.0, rel=1e-12)
    assert facet.weights.sum() == pytest.approx(0.5 * drag * length * width, rel=1e-12)
    assert (facet.points[:, 2] == 0.003).all()


@given(angle=st.floats(0.0, 2.0 * math.pi), offset=st.floats(-1.2, 1.2))
def test_a_facet_that_turns_about_a_line_across_it_has_nearly_the_moment_of_a_fine_sum(angle, offset):
    facet = facet_drag(0, HEXAGON, 0.0, 2.0)
    across = np.array([math.cos(angle), math.sin(angle)])
    ticks = np.arange(-1.0, 1.0, 0.01) + 0.005
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    inside = (np.abs(grid[:, 1]) < math.sqrt(0.75)) & (np.abs(grid[:, 0]) + np.abs(grid[:, 1]) / math.sqrt(3.0) < 1.0)
    fine = grid[inside] @ across - offset
    expected = (np.abs(fine) ** 3).mean() * 1.5 * math.sqrt(3.0)
    arms = facet.points[:, :2] @ across - offset
    assert (facet.weights * np.abs(arms) ** 3).sum() == pytest.approx(expected, rel=0.02)


def test_mirror_images_of_facets_have_the_mirror_images_of_the_points():
    corners = [(0.0, 0.0), (0.9, 0.2), (1.1, 0.8), (0.1, 0.6)]
    one = facet_drag(0, corners, 0.01, 1.0)
    other = facet_drag(0, [(-x, y) for x, y in reversed(corners)], 0.01, 1.0)
    rows, images = (
        sorted(np.column_stack([facet.points * [sign, 1, 1], facet.weights]).round(12).tolist())
        for facet, sign in ((one, -1), (other, 1))
    )
    assert np.array(rows) == pytest.approx(np.array(images), abs=1e-11)


@pytest.mark.parametrize("method", ["dormand-prince", "implicit"])
def test_the_energy_balance_counts_what_drag_takes(method):
    linkage = linkage_named("hex:0234550132:4")
    motion = simulate_deployment(linkage, Scene(drag=20.0, damping=1e-4), method=method, certified=False).motion
    free = simulate_deployment(linkage, Scene(damping=1e-4), method=method, certified=False).motion
    assert motion.ending == free.ending == "flat"
    assert motion.drift < 2e-4 * motion.largest_energy
    assert motion.damped[-1] > 5.0 * free.damped[-1]
    assert (np.diff(motion.damped) >= 0.0).all()
    assert motion.times[-1] > free.times[-1]


def test_a_half_moves_as_the_whole_does_in_air():
    linkage = linkage_named("thesis-4x4")
    scene = Scene(drag=30.0, seconds=0.1)
    half, whole = (
        simulate_deployment(linkage, scene, keep=keep, tolerance=1e-9, certified=False)
        for keep in (frozenset(), frozenset({"half"}))
    )
    assert "half" in {omission.name for omission in half.compiled.omissions}
    times = np.linspace(0.0, 0.1, 30)
    assert half.angles_at(times) == pytest.approx(whole.angles_at(times), abs=1e-6)
    assert half.compiled.factor * half.motion.damped[-1] == pytest.approx(whole.motion.damped[-1], rel=1e-6)


def test_a_scene_in_a_vacuum_has_no_facets_and_batches_have_the_drag_of_each_scene():
    linkage = linkage_named("hex:0234550132:4")
    compiled = [compile_scene(linkage, Scene(drag=drag)) for drag in (0.0, 3.0, 30.0)]
    assert not compiled[0].system.drags
    checks = check_deployments(compiled)
    for check, one in zip(checks, compiled, strict=True):
        alone = simulate_deployment(linkage, one.setup, certified=False)
        assert check.flat_time == pytest.approx(alone.flat_time, rel=1e-9)
    assert checks[0].flat_time < checks[1].flat_time < checks[2].flat_time


def test_the_base_of_a_floating_array_feels_air():
    linkage = linkage_named("hex:0234550132:4")
    free = Scene(held="free", base_mass=0.01, base_inertia=(1e-5, 1e-5, 1e-5), drag=5.0)
    compiled = compile_scene(linkage, free)
    panels = {facet.body for facet in compiled.system.drags}
    assert int(np.flatnonzero(~compiled.hinged)[-1]) in panels
    assert len(compiled.system.drags) == len(linkage.pattern.facets)
    motion = simulate_deployment(linkage, free, certified=False).motion
    assert motion.drift < 1e-4 * motion.largest_energy


def test_quasistatic_motion_has_no_drag():
    with pytest.raises(HcsearchError, match="quasistatic motion has no drag"):
        simulate_deployment(linkage_named("hex:0234550132:4"), Scene(drag=1.0), "quasistatic")
