"""Bounds of torques and impulses at latches, against springs that are simulated."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hcsearch.designs.folding import Folding
from hcsearch.motion.kinematics.local import local_at
from hcsearch.scenes import SCENES
from hcsearch.scenes.laws import law_named
from hcsearch.scenes.setup import setup_of_scene
from hcsearch.springs.deployment.agreement import hinge_arrivals
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.flight.latching import available_energy, latch_bounds, latch_torques
from hcsearch.springs.flight.mass_matrix import mass_matrix
from tests.flight.arrays import strip

NAMES = ("hex:0234550132:4", "square:0122333011:1", "hex:0233340501:3")


def test_the_torque_of_one_latch_is_that_of_a_mass_on_two_springs():
    """A body on a spring that starts at pi, and a latch that is there beyond flat: the bound is reached."""
    spring, preload, latch, inertia = 0.1, 0.02, 50.0, 1e-4
    law = law_named(f"linear:{spring}+{preload}")

    def motion(_, state):
        angle, rate = state
        moment = preload + spring * max(angle, 0.0) + latch * min(angle, 0.0)
        return [rate, -moment / inertia]

    path = solve_ivp(motion, (0.0, 1.0), [math.pi, 0.0], max_step=1e-4, rtol=1e-9, atol=1e-12)
    torque = -latch * path.y[0].min()
    (bound,) = latch_torques([law], np.array([latch]), law.energy(math.pi))
    assert torque <= bound
    assert torque == pytest.approx(bound, rel=1e-3)


def test_latches_without_stiffness_bear_nothing_that_is_known():
    laws = [law_named("linear:0.1")] * 2
    torques = latch_torques(laws, np.array([0.0, 8.0]), 1.0)
    assert torques.tolist() == [0.0, 4.0]


def test_other_latches_give_what_their_preload_does():
    preloaded = [law_named("linear:0.1+0.3")] * 2
    alone, both = (latch_torques(preloaded, np.array([8.0, other]), 1.0)[0] for other in (0.0, 2.0))
    assert both**2 - 2.0 * 0.3 * both == pytest.approx(2.0 * 8.0 * (1.0 + 0.3**2 / 4.0))
    assert alone < both


@pytest.mark.parametrize("name", NAMES)
def test_arrivals_of_simulated_deployments_stay_below_the_bounds(name):
    folding = Folding.from_notation(name)
    for way in ("rigid", "hinged"):
        linkage = folding.linkage(flat_pairs=way)
        deployment = simulate_deployment(linkage, SCENES["default"], certified=False)
        setup = deployment.compiled.setup
        latches = np.full(linkage.n_hinges, 100.0)
        bounds = latch_bounds(linkage, setup, latches, linkage.folded, None)
        for arrival in hinge_arrivals(deployment):
            if arrival.stop != "flat":
                continue
            state = deployment.angles[np.searchsorted(deployment.motion.times, arrival.time)]
            basis = local_at(linkage, state).null_space()
            mobility = basis @ np.linalg.solve(
                basis.T @ mass_matrix(linkage, state, setup.density, setup.held) @ basis, basis.T
            )
            for hinge in arrival.hinges:
                if mobility[hinge, hinge] > 1e-9:
                    inertia = 1.0 / mobility[hinge, hinge]
                    assert 0.5 * inertia * arrival.speed**2 <= bounds.energy
                    assert arrival.speed * math.sqrt(100.0 * inertia) <= bounds.torque


@pytest.mark.parametrize("name", NAMES[:2])
def test_compliant_latches_bear_less_than_the_bound(name):
    """Stops that are springs, in the formulation `compliant`: the deepest turn beyond flat gives the torque."""
    linkage = Folding.from_notation(name).linkage(flat_pairs="hinged")
    stiffness = 20.0
    scene = replace(
        SCENES["default"], stop_stiffness=stiffness, stop_damping=0.0, damping_time=0.0, damping=1e-6, seconds=0.4
    )
    deployment = simulate_deployment(linkage, scene, "compliant", certified=False)
    torques = -stiffness * np.minimum(deployment.angles, 0.0).min(axis=0)
    setup = setup_of_scene(scene, linkage)
    bounds = latch_bounds(linkage, setup, np.full(linkage.n_hinges, stiffness), linkage.folded, None)
    assert 0.05 * bounds.torque < torques.max() <= bounds.torque


def test_energy_counts_springs_and_gravity():
    linkage = strip(["top", "bottom"])
    setup = setup_of_scene(replace(SCENES["default"], spring="linear:0.2"), linkage)
    start = np.array([math.pi, 0.5 * math.pi])
    springs = 0.1 * (start**2).sum()
    assert available_energy(linkage, setup, start) == pytest.approx(springs, rel=5e-2)
    assert available_energy(linkage, setup, start) >= springs
    pulled = replace(setup, gravity=(0.0, 0.0, -9.81))
    assert available_energy(linkage, pulled, start) > available_energy(linkage, setup, start)


def test_the_impulse_is_that_of_the_energy_and_the_inertia():
    linkage = strip(["top"])
    setup = setup_of_scene(SCENES["default"], linkage)
    state = np.array([0.01])
    inertia = mass_matrix(linkage, state, setup.density, 0)[0, 0]
    bounds = latch_bounds(linkage, replace(setup, restitution=0.5), np.zeros(1), linkage.folded, state)
    assert bounds.impulse == pytest.approx(1.5 * math.sqrt(2.0 * bounds.energy * inertia))
    assert (bounds.torque, bounds.torque_hinge, bounds.impulse_hinge) == (None, None, 0)
