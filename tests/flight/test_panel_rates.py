"""Motions of panels by rates of hinges: against differences of poses, and against inverse dynamics of cut loops."""

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene, start_state
from hcsearch.springs.dynamics.inverse import joint_forces
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.flight.deployed_modes import FloatingBase, panel_rates
from hcsearch.springs.flight.torque_margin import closed_rates
from tests.flight.arrays import strip
from tests.linkages import linkage_named

NAMES = ("thesis-4x4", "hex:023224350400:4", "square:0121222323030001:5")
DENSITY = 547.0


def closed_rates_at(linkage, angles, seed=2):
    """Random closed rates at a state."""
    rates = closed_rates(linkage.closure(angles)[1][None])
    basis = rates.bases(np.array([0]), int(rates.ranks[0]))[0]
    return basis @ np.random.default_rng(seed).normal(size=basis.shape[1])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("place", ["flat", "start"])
def test_kinetic_energy_is_that_of_inverse_dynamics(name, place):
    linkage = linkage_named(name)
    compiled = compile_scene(linkage, SCENES["default"], keep=frozenset(OMISSIONS))
    angles = linkage.flat if place == "flat" else start_state(linkage, 0.999)
    v = closed_rates_at(linkage, angles)
    motions = panel_rates(linkage, compiled.setup.density, compiled.setup.held, angles)
    q, speeds = np.zeros((2, 1, compiled.system.n_joints))
    q[0, compiled.joint_of], speeds[0, compiled.joint_of] = angles, v
    kinetic = joint_forces(compiled.system, q, speeds, 0.0 * q).kinetic[0]
    assert 0.5 * v @ motions.mass_matrix @ v == pytest.approx(kinetic, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_panels_move_as_their_poses_change(name):
    linkage = linkage_named(name)
    angles = start_state(linkage, 0.999)
    v = closed_rates_at(linkage, angles)
    motions = panel_rates(linkage, DENSITY, linkage.base, angles)
    step = 1e-6
    before, here, after = (linkage.poses(angles + part * v) for part in (-step, 0.0, step))
    speeds = (after - before) / (2.0 * step)
    moved = motions.maps @ v
    for panel, body in enumerate(panel_bodies(linkage, DENSITY)):
        spin = speeds[panel, :, :3] @ here[panel, :, :3].T
        assert moved[panel, :3] == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-7)
        assert moved[panel, 3:] == pytest.approx(speeds[panel] @ [*body.centre, 1.0], abs=1e-8)


@pytest.mark.parametrize("base", [FloatingBase(), FloatingBase(0.3, (1e-4, 2e-4, 3e-4))])
@pytest.mark.parametrize("name", NAMES[:2])
def test_a_floating_array_has_no_momentum_and_least_energy(name, base):
    linkage = linkage_named(name)
    angles = start_state(linkage, 0.999)
    v = closed_rates_at(linkage, angles)
    floating = panel_rates(linkage, DENSITY, 2, angles, base)
    held = panel_rates(linkage, DENSITY, 2, angles)
    twists = floating.maps @ v
    momenta = np.einsum("pij,pj->pi", floating.inertias, twists)
    scale = np.abs(momenta).max()
    assert momenta[:, 3:].sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12 * scale)
    turning = momenta[:, :3] + np.cross(floating.centres, momenta[:, 3:])
    assert turning.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12 * scale)
    # any other motion of the base has more energy
    least = 0.5 * v @ floating.mass_matrix @ v
    assert least == pytest.approx(0.5 * np.einsum("pi,pi->", twists, momenta))
    for spin, speed in np.random.default_rng(1).normal(size=(20, 2, 3)):
        other = held.maps @ v
        other[:, :3] += spin
        other[:, 3:] += speed + np.cross(spin, held.centres - held.centres[2])
        assert 0.5 * np.einsum("pi,pij,pj->", other, floating.inertias, other) >= least
    # relative to the root both move alike
    relative = twists[:, :3] - twists[2, :3]
    assert relative == pytest.approx((held.maps @ v)[:, :3], abs=1e-9)


def test_what_the_root_gives_is_the_momentum_of_the_others():
    linkage = strip(["top"])
    motions = panel_rates(linkage, DENSITY, 0, linkage.flat)
    body = panel_bodies(linkage, DENSITY)[1]
    point, axis = linkage.points[0], linkage.directions[0]
    speed = np.cross(axis, body.centre - point)
    arm = body.centre - panel_bodies(linkage, DENSITY)[0].centre
    moment = body.inertia @ axis + np.cross(arm, body.mass * speed)
    assert motions.root_momenta(np.ones(1)) == pytest.approx([*moment, *(body.mass * speed)])


def test_there_is_no_panel_beyond_the_last():
    linkage = strip(["top"])
    with pytest.raises(HcsearchError, match="give 0 to 1"):
        panel_rates(linkage, DENSITY, 2, linkage.flat)
