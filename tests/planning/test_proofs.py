"""Proofs of paths: closed states, stops and gaps at ten thousand moments of each sample, and paths that are none."""

import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.kernels.collision.gaps import deepest_overlap
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.planning.closed_states import close_state, new_closing
from hcsearch.kernels.planning.tubes import Track, prove_tube
from hcsearch.motion.collision.panel_prisms import kept_apart, prisms_of, solid_pairs
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover, _beyond
from hcsearch.motion.planning.planner import Planner
from hcsearch.motion.planning.problems import group_of_all, loops_of
from hcsearch.motion.planning.stretches import MAX_STRETCH_HALVINGS
from hcsearch.motion.searching import Budget
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests.planned import SAMPLES, Planned, along, cubic, joined, open_by, planned


def moments(sample, count):
    motion = sample.proof.motion
    return along(sample, np.linspace(0, motion.times[-1], count))


def closed_beside(linkage, states):
    """The nearest closed states, by Newton."""
    loops = loops_of(linkage)
    work, closed = new_closing(loops), states.copy()
    for state in closed:
        assert close_state(loops, state, 1e-13, 1.0, 40, work)
    return closed


@pytest.mark.parametrize("name", SAMPLES)
def test_every_sample_is_proved_from_packed_to_flat(name):
    sample = planned(name)
    proof = sample.proof
    assert proof.margin in CERTIFIED_MARGINS
    assert proof.closed
    assert proof.exact
    assert proof.end_distances == (0.0, 0.0)
    assert (proof.motion.angles[0] == sample.linkage.folded).all()
    assert (proof.motion.angles[-1] == 0).all()
    assert proof.slack < 0.05 * CERTIFIED_MARGINS[0] * Prover(sample.linkage).scale
    assert proof.stop_excess * Prover(sample.linkage)._spread <= proof.margin


@pytest.mark.parametrize("name", SAMPLES)
def test_ten_thousand_moments_are_closed_within_the_slack_and_the_stops(name):
    sample = planned(name)
    states = moments(sample, 10_000)
    closed = closed_beside(sample.linkage, states)
    # the nearest closed state is no further than the one that is proved to be there
    assert np.linalg.norm(closed - states, axis=1).max() <= sample.wander
    assert max(-closed.min(), closed.max() - math.pi) <= sample.proof.stop_excess
    assert open_by(sample.linkage, closed[::500]).max() < 1e-12
    chain, prisms = sample.linkage.chain, prisms_of(sample.linkage, sample.proof.margin)
    pairs = solid_pairs(sample.linkage, prisms_of(sample.linkage), kept_apart(sample.linkage)).prisms
    assert deepest_overlap(chain, prisms, np.ascontiguousarray(pairs), closed) == 0


@pytest.mark.extra
@pytest.mark.parametrize("name", SAMPLES)
def test_coal_finds_shrunk_panels_apart_at_ten_thousand_moments(name):
    from hcsearch_bench.peers.coal_distances import CoalScene

    sample = planned(name)
    linkage = sample.linkage
    prisms = prisms_of(linkage, sample.proof.margin)
    pairs = solid_pairs(linkage, prisms_of(linkage), kept_apart(linkage)).prisms
    shapes = [prisms.vertices[f, : prisms.counts[f, 0]] for f in range(len(prisms.panels))]
    scene = CoalScene(shapes, pairs, moving=True)
    poses = [linkage.poses(state)[prisms.panels] for state in closed_beside(linkage, moments(sample, 10_000))]
    places = [scene.coordinates(panels[..., :3], panels[..., 3]) for panels in poses]
    scene.follow(places[:1])
    gaps = []
    for place in places:
        scene.pin.computeDistances(scene.model, scene.data, scene.shapes, scene.geometry, place)
        gaps.append(scene.distances().min())
    assert min(gaps) > 0


@settings(max_examples=30)
@given(st.sampled_from(sorted(SAMPLES)), st.integers(0, 2**32))
def test_what_cubics_overshoot_is_found(name, seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.1, 1, 4))
    angles, rates = rng.uniform(0, math.pi, (4, 3)), rng.choice([0.0, 1.0, 30.0]) * rng.normal(size=(4, 3))
    angles[rng.random((4, 3)) < 0.2] = 0.0
    rates[rng.random((4, 3)) < 0.2] = 0.0
    motion = Course(times, angles, rates, np.zeros_like(angles), True)
    sample = Planned(planned(name).linkage, angles, planned(name).proof)
    object.__setattr__(sample, "proof", type(sample.proof)(motion, *[None] * 7))
    shares = np.linspace(0, 1, 2001)[:, None] ** np.arange(4)
    values = np.concatenate([shares @ cubic(sample, k).T for k in range(3)])
    dense = max(0.0, -values.min(), values.max() - math.pi)
    assert dense - 1e-12 <= _beyond(motion) <= dense + 1e-4 * (1 + dense)


def broken(name):
    sample = planned(name)
    return sample, Prover(sample.linkage), sample.states.copy()


@pytest.mark.parametrize("name", sorted(SAMPLES)[:2])
def test_a_state_off_closure_beyond_a_stop_or_another_begin_is_refused(name):
    sample, prover, states = broken(name)
    k, far = len(states) // 2, np.abs(states).sum(axis=0).argmax()
    off = states.copy()
    off[k, far] += 0.05
    elsewhere = states.copy()
    elsewhere[k] = np.linspace(0, math.pi, states.shape[1])
    beyond = states.copy()
    beyond[k, states[k].argmin()] = -0.05
    nowhere = states.copy()
    nowhere[k] = math.nan
    for path in (off, elsewhere, beyond, nowhere, states[1:], states[:-1], states[::-1], states[:1], states[:0]):
        proof = prover.prove(path, CERTIFIED_MARGINS)
        assert proof.margin is None
        assert not proof.closed
    assert sample.proof.margin is not None


@pytest.mark.parametrize("name", sorted(SAMPLES)[:2])
def test_a_path_is_proved_only_where_its_states_are_near(name):
    _, prover, states = broken(name)
    ends = states[[0, -1]]
    assert prover.prove(ends, CERTIFIED_MARGINS).margin is None
    assert prover.prove(states[[0, len(states) // 2, -1]], CERTIFIED_MARGINS).margin is None


@settings(max_examples=12)
@given(st.sampled_from(sorted(SAMPLES)), st.floats(0.2, 0.8), st.floats(1e-5, 1e-2), st.integers(0, 2**32))
def test_a_tube_through_an_open_state_is_refused(name, place, far, seed):
    sample = planned(name)
    motion, linkage = sample.proof.motion, sample.linkage
    k = int(place * (len(motion.times) - 3)) + 1
    own = slice(k - 1, k + 2)
    angles, rng = motion.angles[own].copy(), np.random.default_rng(seed)
    _, jacobian = linkage.closure(angles[1])
    angles[1] += far * jacobian.T @ rng.normal(size=len(jacobian))
    coarse = Track(motion.times[own], angles, motion.rates[own], np.zeros(3), np.array([3]))
    m = linkage.n_hinges
    fine = Track(np.zeros(500), np.zeros((500, m)), np.zeros((500, m)), np.zeros(500), np.zeros(1, np.int64))
    ends = np.zeros((2, 1 + m))
    ends[1, 0] = 1.0
    limit = Prover(linkage).limit(CERTIFIED_MARGINS[0])
    if open_by(linkage, angles[1]) > 1e-5:
        assert not prove_tube(
            loops_of(linkage),
            group_of_all(loops_of(linkage)),
            coarse,
            ends,
            limit,
            MAX_STRETCH_HALVINGS,
            fine,
            np.zeros(2),
        )


def test_a_path_through_a_panel_is_not_clear():
    linkage = joined("hex:02234400:1", "hinged")
    states = planner_without_pairs(linkage).plan(Budget(100)).states
    proof = Prover(linkage).prove(states, CERTIFIED_MARGINS)
    assert proof.margin is None
    assert proof.closed  # as a linkage without panels may move
    assert proof.clearance.kind == "collides"
    assert proof.overlap > 8e-4


def planner_without_pairs(linkage):
    from hcsearch.kernels.planning.space import new_space_work, new_state_stack
    from hcsearch.motion.planning.planner import PLANNER_STACK_DEPTH

    planner = Planner(linkage, 1e-5)
    planner.space = planner.space._replace(pairs=planner.space.pairs[:0].copy())
    planner.stack, planner.work = new_state_stack(planner.space, PLANNER_STACK_DEPTH), new_space_work(planner.space)
    return planner


def twice(linkage):
    """Two copies side by side that are not joined: a linkage of two loops."""
    pattern = linkage.pattern
    one, two = (np.mean(facet, axis=0) for facet in pattern.facets[:2])
    right, up = 8 * (two - one)  # the copy lies on the same lattice
    facets = (*pattern.facets, *(tuple((x + right, y + up) for x, y in facet) for facet in pattern.facets))
    n = len(pattern.facets)
    creases = {}
    for hinge in pattern.hinges:
        a, b = sorted((hinge.first, hinge.second))
        creases[a, b] = creases[a + n, b + n] = Crease(hinge.face, closes=hinge.closes)
    return Linkage(Pattern.from_polygons(facets, creases, pattern.thickness))


def test_two_loops_are_proved_as_one_is():
    one = planned("hex:0234550132:4")
    linkage = twice(one.linkage)
    assert linkage.n_rows == 12
    order = {}
    n = len(one.linkage.pattern.facets)
    for k, hinge in enumerate(one.linkage.pattern.hinges):
        order[tuple(sorted((hinge.first, hinge.second)))] = k
    both = [order[tuple(sorted((h.first % n, h.second % n)))] for h in linkage.pattern.hinges]
    assert (
        Prover(linkage).prove(one.states[:, both], CERTIFIED_MARGINS).margin is None
    )  # nothing holds the copies near each other
    prover = Prover(linkage)
    prover.__dict__["_longest_path"] = Prover(one.linkage)._longest_path  # though no hinge moves both
    proof = prover.prove(one.states[:, both], CERTIFIED_MARGINS)
    assert proof.closed
    assert proof.margin == one.proof.margin


def test_a_chain_without_a_loop_has_only_panels_to_keep_apart():
    facets = tuple(
        ((0.03 * k, 0.0), (0.03 * k + 0.03, 0.0), (0.03 * k + 0.03, 0.05), (0.03 * k, 0.05)) for k in range(3)
    )
    linkage = Linkage(Pattern.from_polygons(facets, {(0, 1): Crease("top"), (1, 2): Crease("bottom")}, 0.004))
    assert not linkage.loops
    states = Planner(linkage, 1e-5).plan(Budget(100)).states
    proof = Prover(linkage).prove(states, CERTIFIED_MARGINS)
    assert proof.margin is not None
    assert proof.slack == 0
    assert proof.exact
    assert proof.motion.angles[0] == pytest.approx([math.pi] * 2)


def test_a_proof_along_singular_states_is_given_up_soon():
    linkage = joined("square:0112223300:0", "hinged")
    begin = time.process_time()
    for seed in range(2):
        states = Planner(linkage, 1e-5).plan(Budget(40, seed=seed)).states
        assert states is not None
        assert Prover(linkage).prove(states, CERTIFIED_MARGINS).margin is None
    assert time.process_time() - begin < 20
