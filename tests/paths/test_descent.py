import math
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from hcsearch import enumerate_circuits
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import folding_of, foldings
from hcsearch.designs.twisting import twist
from hcsearch.library.assemblies.eight_r import unit_i, unit_ii
from hcsearch.library.assemblies.named_assembly import Parameters
from hcsearch.library.assemblies.squares import element_6r
from hcsearch.motion.kinematics.within_stops import UNMOVED_HINGE_TURN, close_within_stops, least_energy
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.paths.descent import descend_energy, descent_springs, find_descent
from hcsearch.motion.paths.motions import joined_paths, reversed_path
from hcsearch.shape.linkage import Linkage
from tests.strategies import circuits

SIZE = (0.05, 0.05, 0.006)


def designed(circuit, crease, **options):
    return Linkage(folding_of(Circuit.from_notation(circuit), crease).pattern(SIZE, **options))


@cache
def untwisted(grid, n):
    return [f for circuit in enumerate_circuits(grid, n=n) for f in foldings(circuit) if not twist(f)]


def laws(path):
    """What every descent obeys."""
    assert path.residuals.max() <= 1e-10
    assert path.angles.min() >= 0.0
    assert path.angles.max() <= math.pi
    if path.energies is not None:
        assert (np.diff(path.energies) <= 0).all()
    assert path.lengths[-1] == pytest.approx(np.linalg.norm(np.diff(path.angles, axis=0), axis=1).sum())
    if path.outcome == "flat":
        assert (path.end == 0.0).all()
    if path.outcome == "stuck":
        assert "local minimum" in path.sentence
        assert set(path.stopped_hinges) == set(np.flatnonzero(np.minimum(path.end, math.pi - path.end) <= 1e-9))


def connected(linkage, path, pieces=8):
    """Whether closed states lead from each state to the next in small steps."""
    for one, two in zip(path.angles, path.angles[1:], strict=False):
        before = one
        for share in np.arange(1, pieces) / pieces:
            closed, _ = close_within_stops(linkage, before + (two - before) / (pieces - share * pieces + 1))
            assert closed is not None
            assert np.linalg.norm(closed.angles - before) <= 3 / pieces * np.linalg.norm(two - one)
            before = closed.angles
        assert np.linalg.norm(two - before) <= 3 / pieces * np.linalg.norm(two - one)


@settings(max_examples=20)
@given(st.data())
def test_descents_go_down_over_closed_states_within_the_stops(data):
    circuit = data.draw(circuits(("hex", "square", "triangle"), even=True))
    options = foldings(circuit)
    assume(options)
    folding = data.draw(st.sampled_from(options))
    linkage = Linkage(folding.pattern(SIZE, flat_pairs=data.draw(st.sampled_from(["rigid", "hinged"]))))
    seed = data.draw(st.integers(0, 100))
    springs = 0.01 ** np.random.default_rng(seed).uniform(size=linkage.n_hinges)
    path = descend_energy(linkage, springs=springs)
    laws(path)
    if path.outcome == "flat":
        connected(linkage, path)
        assert not lock_at(linkage, linkage.folded).locked
        assert not lock_at(linkage, linkage.flat).locked


def test_how_many_hexagon_designs_open():
    # 40 untwisted foldings of ten hexagons, flat pairs rigid: 18 reach flat with equal springs (rounding may make it
    # one more or less), 14 others are proved locked at an end
    linkages = [Linkage(folding.pattern(SIZE)) for folding in untwisted("hex", 10)]
    ends = [descend_energy(linkage).outcome for linkage in linkages]
    assert len(ends) == 40
    assert 17 <= ends.count("flat") <= 19
    assert ends.count("flat") + ends.count("stuck") == 40
    locked = [any(lock_at(it, state).locked for state in (it.folded, it.flat)) for it in linkages]
    assert sum(locked) == 14
    assert not any(lock and end == "flat" for lock, end in zip(locked, ends, strict=True))


@pytest.mark.parametrize("folding", untwisted("triangle", 10), ids=str)
@pytest.mark.parametrize("hinged", [False, True])
def test_ten_triangles_open(folding, hinged):
    linkage = Linkage(folding.pattern(SIZE, flat_pairs="hinged" if hinged else "rigid"))
    path = descend_energy(linkage)
    assert path.outcome == "flat"
    connected(linkage, path)


@pytest.mark.parametrize("build", [unit_i, unit_ii, element_6r])
@pytest.mark.parametrize("goal", ["flat", "folded"])
def test_assemblies_of_many_loops_open_and_fold(build, goal):
    linkage = Linkage(build(Parameters()))
    path = descend_energy(linkage, goal=goal)
    assert path.outcome == goal
    assert (path.end == getattr(linkage, goal)).all()
    assert path.residuals.max() <= 1e-10
    assert (np.diff(path.energies) <= 0).all()


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_descents_know_no_unit_of_length(scale):
    paths = [descend_energy(Linkage(untwisted("hex", 10)[1].pattern(tuple(s * x for x in SIZE)))) for s in (1.0, scale)]
    assert [path.outcome for path in paths] == ["flat", "flat"]
    assert np.abs(paths[0].angles[:5] - paths[1].angles[:5]).max() < 1e-6


def test_a_locked_folding_stays_folded():
    linkage = designed("hex:0234550132", 3)
    assert lock_at(linkage, linkage.folded).locked
    path = descend_energy(linkage)
    assert (path.outcome, path.steps) == ("stuck", 0)
    laws(path)
    search = find_descent(linkage, random=1)
    assert not search.success
    assert {how for _, how in search.attempts} == {"stuck"}


def test_a_search_goes_on_to_other_springs_and_then_backwards():
    search = find_descent(designed("square:012233230011", 0))
    assert search.success
    assert search.backwards
    assert search.attempts[0] == ("uniform", "stuck")
    name, how = search.attempts[-1]
    assert (name.split(", ")[-1], how) == ("backwards", "folded")
    assert search.path.outcome == "flat"
    assert (search.path.angles[0] == math.pi).all()
    laws(search.path)


def test_flat_pairs_may_be_held():
    linkage = designed("hex:0234550132", 4, flat_pairs="hinged")
    held = np.array([not hinge.closes for hinge in linkage.pattern.hinges])
    path = descend_energy(linkage, held=held)
    assert path.outcome == "flat"
    assert np.abs(path.angles[:, held]).max() == 0.0


def test_a_path_reversed_twice_is_the_path():
    path = descend_energy(designed("triangle:0123434501", 1), goal="folded")
    assert path.outcome == "folded"
    back = reversed_path(path, "flat")
    assert (back.outcome, back.steps) == ("flat", path.steps)
    assert (back.angles[0] == path.end).all()
    assert back.lengths[0] == 0.0
    assert (reversed_path(back, "folded").angles == path.angles).all()
    round_trip = joined_paths(path, back)
    assert round_trip.steps == 2 * path.steps
    assert (round_trip.end == path.angles[0]).all()
    assert (np.diff(round_trip.lengths) > 0).all()


def test_descents_that_cannot_go_on_say_why():
    linkage = designed("triangle:0123434501", 1)
    assert descend_energy(linkage, max_steps=2).outcome == "out of budget"
    rng = np.random.default_rng(0)
    lost = descend_energy(linkage, rng.uniform(0, math.pi, 8) * np.array([0, 0, 0, 0, 0, 0, 0, 1]))
    assert lost.outcome in {"flat", "lost closure"}
    laws(lost)


def test_spring_sets_are_the_same_every_time_and_within_bounds():
    linkage = designed("hex:0234550132", 4)
    one, two = (list(descent_springs(linkage, 3)) for _ in range(2))
    assert [name for name, _ in one] == ["uniform", "outside in", "inside out", "random 0", "random 1", "random 2"]
    for (_, first), (_, second) in zip(one, two, strict=True):
        assert (first == second).all()
        assert first.min() >= 0.01 - 1e-12
        assert first.max() <= 1.0
    assert (one[1][1] * one[2][1]) == pytest.approx(0.01)


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_the_least_energy_is_that_of_a_general_solver(seed):
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 9)), int(rng.integers(1, 4))
    m = min(m, n)
    basis = np.linalg.qr(rng.standard_normal((n, m)))[0]
    springs, angles = rng.uniform(0.01, 1, n), rng.uniform(0, 3, n)
    low, high = -rng.uniform(0, 0.5, n), rng.uniform(0, 0.5, n)
    low[rng.random(n) < 0.3] = 0.0

    def energy(v):
        return 0.5 * springs @ (angles + v) ** 2

    velocity = least_energy(basis, springs, angles, low, high)
    assert (velocity >= low).all()
    assert (velocity <= high).all()
    room = np.minimum(velocity - low, high - velocity)  # what is at a bound but for rounding is at it
    assert ((room == 0.0) | (room > 0.5 * UNMOVED_HINGE_TURN)).all()
    assert np.abs(velocity - basis @ (basis.T @ velocity)).max() < 1e-7
    walls = [
        {"type": "ineq", "fun": lambda z: basis @ z - low},
        {"type": "ineq", "fun": lambda z: high - basis @ z},
    ]
    other = minimize(lambda z: energy(basis @ z), np.zeros(m), constraints=walls, method="SLSQP", tol=1e-12)
    if other.success:
        assert energy(velocity) <= other.fun + 1e-7
