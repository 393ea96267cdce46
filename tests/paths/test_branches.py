import math
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.library.assemblies.eight_r import eight_r, joint_parts, unit_i, unit_ii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.library.assemblies.squares import element_6r
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.kinematics.local import local_at
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.paths.branches import find_branches
from hcsearch.motion.paths.following import PathLimits, follow_path
from hcsearch.motion.paths.quadrics import second_order_forms, solve_quadrics
from hcsearch.shape.linkage import Linkage
from tests.strategies import circuits

BUILD = {"8R": eight_r, "I": unit_i, "II": unit_ii, "6R": element_6r}


@cache
def linkage(name):
    return Linkage(BUILD[name](Parameters()))


@cache
def branches_at(name, state, stops):
    it = linkage(name)
    return find_branches(it, getattr(it, state), stops=stops)


def skew(name, state):
    """Direction of the exact motion (thesis 5.24) at one of its ends."""
    it = linkage(name)
    legs, c = joint_parts(it.pattern) == 1, math.cos(Parameters().alpha)
    way = -np.where(legs, 1.0, c) if state == "folded" else np.where(legs, c, 1.0)
    return way / np.linalg.norm(way)


def laws(it, state, result):
    """What every branch obeys: null space and second-order equations."""
    local = local_at(it, state)
    for branch in result.branches:
        v = branch.direction
        assert np.linalg.norm(v) == pytest.approx(1)
        assert np.abs(local.jacobian @ v).max() < 1e-12
        bend = it.bend(local.jacobian, v)
        assert np.abs(local.jacobian @ local.geodesic_acceleration(v) + bend).max() < 1e-9
        if result.keeps_stops:
            assert v[state <= 1e-9].min(initial=0) > -1e-9
            assert v[state >= math.pi - 1e-9].max(initial=0) < 1e-9


@pytest.mark.parametrize("name", BUILD)
@pytest.mark.parametrize("state", ["folded", "flat"])
@pytest.mark.parametrize("stops", [False, True])
def test_branches_obey_the_equations_of_first_and_second_order(name, state, stops):
    result = branches_at(name, state, stops)
    assert result.branches
    laws(linkage(name), getattr(linkage(name), state), result)


def test_members_to_which_closed_states_lead_obey_them_too():
    """As far as a step of 0.04 rad tells, they do to 1e-3 only."""
    it = Linkage(foldings(Circuit.from_notation("hex:0234451512"))[0].pattern((0.05, 0.05, 0.006)))
    result = find_branches(it, it.folded, stops=True)
    laws(it, it.folded, result)
    directions = [branch.direction for branch in result.branches]
    assert len(directions) > 2
    assert min(np.linalg.norm(one - two) for one, two in combinations(directions, 2)) > 1e-3


@settings(max_examples=12)
@given(st.data())
def test_branches_of_designs_obey_them_too(data):
    circuit = data.draw(circuits(("hex", "square", "triangle"), even=True))
    options = foldings(circuit)
    if not options:
        return
    folding = data.draw(st.sampled_from(options))
    it = Linkage(folding.pattern((0.05, 0.05, 0.006)))
    if not it.loops or it.n_hinges > 12:
        return
    state = data.draw(st.sampled_from([it.folded, it.flat]))
    result = find_branches(it, state, stops=data.draw(st.booleans()))
    laws(it, state, result)
    if result.keeps_stops and result.finite and any(branch.within_stops for branch in result.finite):
        assert not lock_at(it, state).locked


# thesis 5.2.4: "nullity of four, but only one finite mechanism". It holds with stops; hinges that turn either way
# have more: isolated directions, and families of a dimension, of which so many are finite
BILATERAL = {
    ("I", "folded"): (3, [], 2),
    ("I", "flat"): (3, [], 3),
    ("II", "folded"): (4, [], 4),
    ("II", "flat"): (1, [1], None),
}


@pytest.mark.parametrize(("name", "state"), BILATERAL)
def test_finite_mechanisms_at_the_ends_of_the_units(name, state):
    isolated, families, finite = BILATERAL[name, state]
    free = branches_at(name, state, False)
    assert (free.nullity, free.stresses) == (4, 4)
    assert [b.dimension for b in free.branches].count(0) == isolated
    assert sorted({b.dimension for b in free.branches} - {0}) == families
    assert len(free.finite) == (len(free.branches) if finite is None else finite)
    held = branches_at(name, state, True)
    (only,) = held.branches
    assert (only.status, only.within_stops) == ("finite", True)
    assert only.direction == pytest.approx(skew(name, state), abs=1e-6)
    assert "1 of 1 nudged are finite" in held.sentence


def test_other_branches_of_unit_ii_are_motions_with_panels_through_each_other():
    it = linkage("II")
    for branch in branches_at("II", "folded", False).finite:
        for sign in (1, -1):
            path = follow_path(
                it,
                it.folded,
                sign * branch.direction,
                limits=PathLimits(stops=False, goal="none", length=0.5, events=False),
            )
            assert path.outcome == "length"
            assert path.residuals.max() <= 1e-12
            beyond = path.end.max() > math.pi + 0.01
            exact = np.abs(np.abs(branch.direction @ skew("II", "folded")) - 1) < 1e-6
            assert beyond != (exact and np.sign(sign * branch.direction @ skew("II", "folded")) > 0)


def test_an_infinitesimal_motion_leads_nowhere():
    it = linkage("I")
    (lost,) = [b for b in branches_at("I", "folded", False).branches if b.status == "infinitesimal"]
    path = follow_path(it, it.folded, lost.direction, limits=PathLimits(stops=False, goal="none"))
    assert path.outcome == "lost closure"
    assert "no motion" in path.sentence


def test_the_8r_element_has_two_degrees_of_freedom_at_its_ends():
    for state in ("folded", "flat"):
        result = branches_at("8R", state, True)
        assert (result.nullity, result.stresses) == (3, 1)
        assert {b.dimension for b in result.branches} == {1}
        assert all(b.status == "finite" for b in result.branches)


def test_the_6r_element_leaves_its_flat_state_in_two_ways():
    # rows fold first, or columns: two motions within the stops (thesis 6.1 has two stages)
    result = branches_at("6R", "flat", True)
    assert len(result.finite) == len(result.branches) == 2
    assert abs(result.branches[0].direction @ result.branches[1].direction) < 1e-9


def test_the_6r_element_branches_between_its_two_stages():
    it = linkage("6R")
    first = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 0.0])
    path = follow_path(it, it.folded, -first, limits=PathLimits(stops=False, goal="none", length=8.0))
    assert path.outcome == "length"
    (event,) = [event for event in path.events if event.kind == "bifurcation"]
    assert event.angles == pytest.approx(math.pi * (1 - first), abs=1e-8)
    ways = find_branches(it, event.angles, zero_below=1e-6)
    # on along the planar 4R, its other branch, and the stage in which the two other joints open
    assert len(ways.finite) == len(ways.branches) == 3
    assert follow_path(it, it.folded, -first).outcome == "stopped"


def test_a_shaky_state_on_the_way_has_one_motion():
    it = linkage("II")
    path = follow_path(it, it.folded, skew("II", "folded"))
    for event in path.events:
        result = find_branches(it, event.angles, zero_below=1e-6)
        (only,) = result.branches
        assert (result.nullity, only.status) == (2, "finite")


def test_a_state_in_general_position_has_all_its_first_order_motions():
    it = linkage("8R")
    state = close_linkage(it, np.linspace(1.0, 1.8, 8)).angles
    result = find_branches(it, state)
    assert (result.nullity, result.stresses) == (2, 0)
    assert {b.dimension for b in result.branches} == {1}
    assert len(result.finite) == len(result.branches)


def test_an_undecided_rank_has_no_branches():
    it = Linkage(unit_ii(Parameters(thickness=1e-9 * 0.03)))
    result = find_branches(it, it.folded)
    assert (result.nullity, result.branches) == (-1, ())
    assert "not decided" in result.sentence


def test_forms_are_the_work_of_the_bend_on_self_stresses():
    it = linkage("I")
    local = local_at(it, it.flat)
    basis = local.null_space()
    forms = second_order_forms(local, basis)
    stresses = np.linalg.svd(local.jacobian)[0][:, local.kept_rank :]
    rng = np.random.default_rng(0)
    for _ in range(5):
        z = rng.standard_normal(basis.shape[1])
        work = stresses.T @ it.bend(local.jacobian, basis @ z)
        assert np.linalg.norm(np.einsum("i,kij,j->k", z, forms, z)) == pytest.approx(np.linalg.norm(work))


QUADRICS = {
    "a cone": ([np.diag([1.0, 1.0, -1.0])], [1]),
    "four lines": ([np.diag([1.0, -1.0, 0.0]), np.diag([0.0, 1.0, -1.0])], [0, 0, 0, 0]),
    "two planes": ([np.diag([1.0, -1.0, 0.0])], [1]),
    "a double plane": ([np.diag([1.0, 0.0, 0.0])], [1]),
    "a point": ([np.diag([1.0, 1.0, 0.0])], [0]),
    "nothing": ([np.eye(3)], []),
    "everything": ([np.zeros((3, 3))], [2]),
}


@pytest.mark.parametrize("name", QUADRICS)
def test_common_points_of_known_quadrics(name):
    forms, dimensions = QUADRICS[name]
    solutions, _ = solve_quadrics(np.array(forms))
    if 0 in dimensions or not dimensions:
        assert sorted(s.dimension for s in solutions) == dimensions
    else:
        assert {s.dimension for s in solutions} == set(dimensions)
    for solution in solutions:
        assert np.abs(np.einsum("i,kij,j->k", solution.vector, np.array(forms), solution.vector)).max() < 1e-9


@given(st.integers(0, 1000))
@settings(max_examples=20)
def test_solutions_keep_to_their_cone(seed):
    rng = np.random.default_rng(seed)
    forms = rng.standard_normal((1, 4, 4))
    cone = rng.standard_normal((2, 4))
    for solution in solve_quadrics(forms + forms.transpose(0, 2, 1), cone, both=False)[0]:
        assert (cone @ solution.vector).min() > -1e-9
