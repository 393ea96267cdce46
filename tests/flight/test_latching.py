"""Loads of latching: bounds by energy against simulations, hinges that bounce on springs, and simple models."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_at, foldings
from hcsearch.scenes import SCENES
from hcsearch.scenes.laws import law_named
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_compiled, simulate_deployment
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.flight.deployed_modes import FloatingBase, panel_rates
from hcsearch.springs.flight.latching import arrival_loads, latch_bounds, panel_reach, released_energy
from hcsearch_bench.subjects.foldings import search_of, untwisted
from tests.flight.arrays import SIDE, THICKNESS, strip
from tests.linkages import linkage_named
from tests.strategies import rewritten

DEFAULT = SCENES["default"]
LATCH = 100.0
PRELOADED = {"spring": "linear:0.1+0.05"}
FLOATING = {"held": "free", "base_mass": 0.05, "base_inertia": (1e-4, 2e-4, 3e-4)}
LAWS = (
    "free",
    "linear:0.1",
    "linear:0.1-0.05",
    "quadratic:0.02,0.03",
    "table:0.1@0,-0.3@1,0.2@3",
    "tape:0.2@0.05,0.03@0.01",
)


def bounds_of(deployment, latch=LATCH):
    """The bounds for a simulated deployment."""
    linkage, setup = deployment.compiled.linkage, deployment.compiled.setup
    return latch_bounds(
        linkage,
        setup.laws,
        np.full(linkage.n_hinges, latch),
        setup.density,
        setup.held,
        deployment.angles[0],
        gravity=setup.gravity,
        restitution=setup.restitution,
        base=FloatingBase(setup.base_mass, setup.base_inertia) if setup.free else None,
    )


def assert_within(deployment):
    """Whether no load of a simulated deployment is above the bounds; the number of arrivals."""
    bounds = bounds_of(deployment)
    loads = arrival_loads(deployment, np.full(deployment.angles.shape[1], LATCH))
    for load in loads:
        assert load.energy <= bounds.energy
        assert (load.torques <= bounds.torques)[list(load.hinges)].all()
        assert load.base_impulse <= bounds.base_impulse
        assert load.base_moment <= bounds.base_moment
    return len(loads)


@pytest.mark.parametrize(("grid", "cells", "every"), [("hex", "8", 1), ("hex", "10", 3), ("square", "12", 4)])
def test_no_simulated_arrival_exceeds_the_bounds(grid, cells, every):
    counts = []
    for circuits, batch in untwisted(search_of(grid, cells), every):
        for i in range(len(batch)):
            deployment = simulate_deployment(folding_at(circuits, batch, i).linkage(), DEFAULT, certified=False)
            if deployment.outcome == "flat":
                counts.append(assert_within(deployment))
    assert min(counts) > 0


@pytest.mark.parametrize("change", [PRELOADED, FLOATING, {"gravity": (0.0, -3.0, 0.5)}, {"restitution": 0.4}])
@pytest.mark.parametrize("name", ["thesis-4x4", "hex:023224350400:4"])
def test_no_simulated_arrival_exceeds_the_bounds_in_other_scenes(name, change):
    assert assert_within(simulate_deployment(linkage_named(name), replace(DEFAULT, **change), certified=False)) > 3


@pytest.mark.parametrize(("spring", "stiffness"), [("linear:0.1", 1.0), ("linear:0.1+0.05", 300.0)])
def test_stops_of_springs_take_no_more_than_the_bounds(spring, stiffness):
    """The compliant formulation has such latches, one-sided, at both stops."""
    scene = replace(DEFAULT, spring=spring, stop_stiffness=stiffness, stop_damping=0.0, damping=0.0, seconds=0.25)
    deployment = simulate_compiled(
        compile_scene(linkage_named("hex:023224350400:4"), scene, "compliant"), certified=False, tolerance=1e-5
    )
    torques = stiffness * -deployment.angles.min(axis=0)
    assert torques.max() > 0.2
    assert (torques <= bounds_of(deployment, stiffness).torques).all()


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.3), st.floats(5.0, 1000.0), st.floats(0.5, math.pi))
def test_the_bound_is_nearly_reached_by_one_panel_on_a_stiff_latch(preload, latch, start):
    linkage, stiffness = strip(["top"]), 0.01
    law = law_named(f"linear:{stiffness}+{preload!r}")
    bound = latch_bounds(linkage, [law], np.array([latch]), 547.0, 0, np.array([start])).torque
    inertia = float(panel_rates(linkage, 547.0, 0, linkage.flat).mass_matrix[0, 0])

    def forces(_, y):
        return [y[1], (-law.straight.moment(y[0]) - latch * min(y[0], 0.0)) / inertia]

    def turning_back(_, y):
        return y[1]

    turning_back.terminal, turning_back.direction = True, 1.0
    solution = solve_ivp(forces, (0.0, 100.0), [start, 0.0], events=turning_back, rtol=1e-9, atol=1e-12, max_step=1e-2)
    torque = -latch * solution.y[0].min()
    assert torque <= bound * (1.0 + 1e-6)
    assert torque >= bound * (1.0 - 2.0 * stiffness / latch) * (1.0 - 1e-6)


def test_a_hinge_that_arrives_alone_loses_what_the_simulation_loses():
    """Stops of the simulation have impulses of their own; states before and after show what they gave."""
    deployment = simulate_deployment(linkage_named("hex:023224350400:4"), DEFAULT, certified=False)
    setup, times, checked = deployment.compiled.setup, deployment.motion.times, 0
    for load in arrival_loads(deployment, np.full(deployment.angles.shape[1], LATCH)):
        states = np.flatnonzero(times == load.time)
        if len(states) != 2 or np.count_nonzero(deployment.angles[states[0]] <= 1e-6) > 1:
            continue
        motions = panel_rates(deployment.compiled.linkage, setup.density, setup.held, deployment.angles[states[0]])
        before, after = (deployment.rates[state] for state in states)
        lost = 0.5 * (before @ motions.mass_matrix @ before - after @ motions.mass_matrix @ after)
        given = motions.root_momenta(before - after)
        assert load.energy == pytest.approx(lost, rel=1e-6)
        assert load.base_impulse == pytest.approx(np.linalg.norm(given[3:]), rel=1e-6)
        assert load.base_moment == pytest.approx(np.linalg.norm(given[:3]), rel=1e-6)
        assert load.impulse * load.speeds[0] == pytest.approx(2.0 * lost, rel=1e-6)
        checked += 1
    assert checked >= 1


def test_impulse_and_torque_of_one_panel_follow_from_its_inertia():
    linkage = strip(["top"])
    deployment = simulate_deployment(linkage, replace(DEFAULT, restitution=0.25), certified=False)
    (load, *_) = arrival_loads(deployment, np.array([LATCH]))
    mass = deployment.compiled.setup.density * SIDE**2 * THICKNESS
    inertia = mass * (SIDE**2 + THICKNESS**2) / 3.0
    speed = load.speeds[0]
    assert load.hinges == (0,)
    assert speed == pytest.approx(abs(deployment.rates[-1, 0]))
    assert load.impulse == pytest.approx(1.25 * inertia * speed)
    assert load.torques[0] == pytest.approx(speed * math.sqrt(LATCH * inertia))
    assert load.base_impulse == pytest.approx(1.25 * mass * speed * math.hypot(SIDE, THICKNESS) / 2.0)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(LAWS), st.floats(0.0, math.pi)), min_size=1, max_size=4))
def test_released_energy_is_the_stored_one_less_the_least(hinges):
    laws, start = [law_named(text) for text, _ in hinges], np.array([angle for _, angle in hinges])
    angles = np.linspace(0.0, math.pi, 2001)
    expected = 0.0
    for law, angle in zip(laws, start, strict=True):
        branches = [branch for branch in (law.straight, law.bent) if branch is not None]
        expected += law.energy(angle) - min(branch.energy(x) for branch in branches for x in angles)
    found = released_energy(laws, start)
    assert expected - 1e-12 <= found <= expected + 1e-5


@pytest.mark.parametrize("name", ["thesis-4x4", "hex:023224350400:4"])
@pytest.mark.parametrize("root", [0, 5])
def test_no_state_takes_a_panel_beyond_its_reach_or_gives_more_by_gravity(name, root):
    deployment = simulate_deployment(linkage_named(name), DEFAULT, certified=False)
    linkage, gravity = deployment.compiled.linkage, np.array([1.0, -3.0, 0.5])
    bodies = panel_bodies(linkage, 547.0)
    reach = panel_reach(linkage, root, np.array([body.centre for body in bodies]))
    start = deployment.angles[0]
    laws, latches = [law_named("free")] * linkage.n_hinges, np.zeros(linkage.n_hinges)
    energy = latch_bounds(linkage, laws, latches, 547.0, root, start, gravity=gravity).energy
    masses = np.array([body.mass for body in bodies])

    def arms(angles):
        centres = panel_rates(linkage, 547.0, root, angles).centres
        turn = linkage.poses(angles)[root, :, :3]
        return (centres - centres[root]) @ turn  # in the axes of the root

    first = arms(start)
    for angles in deployment.angles[::10]:
        assert (np.linalg.norm(arms(angles), axis=1) <= reach * (1.0 + 1e-9)).all()
        assert masses @ (arms(angles) - first) @ gravity <= energy
    assert reach[root] == 0.0


@pytest.mark.parametrize("backwards", [False, True])
def test_bounds_do_not_depend_on_how_a_design_is_written(backwards):
    circuit = Circuit.from_notation("hex:0234550132")
    own = rewritten(circuit, circuit.grid.point_group[1], 3, backwards)
    linkage = foldings(own)[0].linkage(flat_pairs="hinged")
    twin, latches = linkage.twin, np.random.default_rng(1).uniform(0.0, 50.0, linkage.n_hinges)
    laws = [law_named(f"linear:{0.1 + 0.01 * hinge:.2f}+0.02") for hinge in range(linkage.n_hinges)]
    order = np.argsort(twin.hinges)
    one = latch_bounds(linkage, laws, latches, 547.0, 3, linkage.folded)
    other = latch_bounds(
        twin.linkage, [laws[hinge] for hinge in order], latches[order], 547.0, twin.panels[3], linkage.folded[order]
    )
    assert one.torques[order] == pytest.approx(other.torques, rel=1e-12)
    assert (one.energy, one.base_impulse) == pytest.approx((other.energy, other.base_impulse), rel=1e-12)


def test_hinges_without_latches_have_no_torque():
    linkage = Folding.from_notation("hex:023224350400:4").linkage()
    laws, latches = [law_named("linear:0.1")] * linkage.n_hinges, np.zeros(linkage.n_hinges)
    assert latch_bounds(linkage, laws, latches, 547.0, 0, linkage.folded).torque is None
    latches[2] = 1.0
    bounds = latch_bounds(linkage, laws, latches, 547.0, 0, linkage.folded)
    assert np.flatnonzero(np.isfinite(bounds.torques)).tolist() == [2]
    assert bounds.torque == pytest.approx(math.sqrt(2.0 * bounds.energy))


@pytest.mark.parametrize("latches", [np.ones(2), np.array([-1.0]), np.array([math.nan])])
def test_wrong_latches_are_refused(latches):
    with pytest.raises(HcsearchError, match="give 1, and 0 for no latch"):
        latch_bounds(strip(["top"]), [law_named("free")], latches, 547.0, 0, np.zeros(1))
