"""Distances of convex hulls and panels: the compiled search against all features, laws, and motions."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from naive_clearance import hull_distance
from naive_distances import feature_distance, overlap_along_all

from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.gjk import exhaustive_gap, hull_gap
from hcsearch.motion.collision.distances import (
    CONTACT_GAP_SHARE,
    Proximity,
    approach_speeds,
    nearest_panels,
    proximal_distances,
)
from hcsearch.scenes import SCENES
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import RIGID_CREASE, Crease, Pattern
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch_bench.kernels.hull_gaps import write_hull_gaps
from tests.linkages import linkage_named, penetration

NOWHERE = (-1, -1, -1, -1)
NO_WAY = (0.0, 0.0, 0.0)


def search(one, two, guess=NO_WAY, corners=NOWHERE):
    gap, way, corner = hull_gap(one, len(one), two, len(two), guess, corners)
    return gap, np.array(way), corner


def gap_of(one, two, way):
    return (two @ way).min() - (one @ way).max()


def size_of(one, two):
    return max(np.abs(one).max(), np.abs(two).max())


def rotation(axis, angle):
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def prism(sides, width, thickness):
    angles = 2 * np.pi * np.arange(sides) / sides
    flat = np.column_stack([np.cos(angles), width * np.sin(angles), 0 * angles])
    return np.concatenate([flat, flat + np.array([0, 0, thickness])])


prisms = st.builds(
    prism,
    sides=st.integers(3, 6),
    width=st.sampled_from((1.0, 1.0, 0.5, 1e-2)),
    thickness=st.sampled_from((0.12, 0.12, 1.0, 1e-3, 1e-7)),
)
steps = st.sampled_from((-2.0, -1.0, -0.5, -math.sqrt(0.75), -0.12, 0.0, 0.12, 0.24, math.sqrt(0.75), 1.0, 2.0))
tiny = st.sampled_from((0.0, 0.0, 1e-16, 1e-13, 1e-10, 1e-8, 1e-5, 1e-3))
axes = st.sampled_from(((1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 2, 3)))
angles = st.one_of(st.sampled_from((0.0, 0.0, math.pi / 3, math.pi / 2, math.pi)), st.floats(-4, 4))
anywhere = st.floats(-2, 2)


@st.composite
def pairs(draw):
    """Two prisms: parallel, touching, coplanar, stacked, a little tilted or apart, or anyhow; all turned and moved."""
    one, two = draw(prisms), draw(prisms)
    two = two @ rotation(draw(axes), draw(angles)).T + [draw(steps), draw(steps), draw(steps)]
    if draw(st.booleans()):
        two = two @ rotation(draw(axes), draw(tiny)).T + draw(tiny)
    if draw(st.booleans()):
        two = two + np.array([draw(anywhere), draw(anywhere), draw(anywhere)])
    if draw(st.booleans()):
        turn, shift = rotation(draw(axes), draw(angles)), [draw(anywhere), draw(anywhere), draw(anywhere)]
        one, two = one @ turn.T + shift, two @ turn.T + shift
    return np.ascontiguousarray(one), np.ascontiguousarray(two)


@given(pairs())
def test_the_distance_is_that_of_the_nearest_features_and_its_direction_proves_it(pair):
    one, two = pair
    size = size_of(one, two)
    gap, way, _ = search(one, two)
    assert np.linalg.norm(way) == pytest.approx(1, abs=1e-14)
    assert gap == pytest.approx(gap_of(one, two, way), abs=1e-13 * size)
    overlap = overlap_along_all(one, two)
    if gap > 0:
        assert gap == pytest.approx(feature_distance(one, two), abs=1e-12 * size)
        assert overlap <= 1e-12 * size
    else:
        # they meet: nothing separates them, and they overlap no more than along this direction
        assert -1e-12 * size <= overlap <= -gap + 1e-12 * size
    assert hull_distance(one, two) == pytest.approx((max(gap, 0.0), *way), abs=0)


@given(pairs(), axes, angles, st.sampled_from((1e-9, 1e-3, 1.0, 1e6)))
def test_swapped_moved_and_scaled_hulls_have_the_same_distance(pair, axis, angle, scale):
    one, two = pair
    size = size_of(one, two)
    gap = max(search(one, two)[0], 0.0)
    back, way, _ = search(two, one)
    assert max(back, 0.0) == pytest.approx(gap, abs=1e-13 * size)
    assert back == pytest.approx(gap_of(two, one, way), abs=1e-13 * size)
    turn = rotation(axis, angle)
    moved, way, _ = search(one @ turn.T + 1.0, two @ turn.T + 1.0)
    assert max(moved, 0.0) == pytest.approx(gap, abs=1e-12 * size)
    scaled, _, _ = search(scale * one, scale * two)
    assert max(scaled, 0.0) == pytest.approx(scale * gap, abs=1e-13 * scale * size)


@pytest.mark.parametrize("length", [2.5805646852368332e-157, 1e-200, 1e200])
def test_directions_whose_squares_are_no_numbers_are_none(length):
    triangle = np.array([[0.0, -1.0, 0.0], [-1.5, -0.1339746, 0.0], [-1.5, -1.8660254, 0.0]])
    up = np.array([0.0, 0.0, 0.12])
    one, two = (np.concatenate([triangle + k * up, triangle + (k + 1) * up]) for k in (0, 2))
    gap, way, _ = search(one, two, (0.0, 0.0, length))
    assert gap == pytest.approx(0.12, abs=1e-14)
    assert gap == pytest.approx(gap_of(one, two, way), abs=1e-14)


@given(pairs(), pairs(), st.tuples(anywhere, anywhere, anywhere))
def test_where_the_search_begins_does_not_change_the_answer(pair, other, guess):
    one, two = pair
    size = size_of(one, two)
    gap, way, corners = search(one, two)
    apart = max(gap, 0.0)
    _, other_way, other_corners = search(*other)
    least = min(len(one), len(two)) << 20
    fits = all(corner < least and corner & 0xFFFFF < len(two) for corner in other_corners)
    for start in (way, -way, other_way, np.array(guess)):
        for at in (NOWHERE, corners, *([other_corners] if fits else [])):
            again, proof, _ = search(one, two, tuple(start), at)
            assert max(again, 0.0) == pytest.approx(apart, abs=2e-14 * size)
            assert again == pytest.approx(gap_of(one, two, proof), abs=1e-13 * size)


@given(pairs())
def test_trying_all_directions_finds_the_same(pair):
    one, two = pair
    gap, way = exhaustive_gap(one, len(one), two, len(two))
    assert gap == pytest.approx(gap_of(one, two, np.array(way)), abs=1e-13 * size_of(one, two))
    assert max(gap, 0.0) == pytest.approx(max(search(one, two)[0], 0.0), abs=1e-12 * size_of(one, two))


@given(
    st.lists(st.tuples(*3 * [st.integers(-2, 2)]), min_size=1, max_size=8),
    st.lists(st.tuples(*3 * [st.integers(-2, 2)]), min_size=1, max_size=8),
    tiny,
)
def test_points_lines_and_flat_hulls_with_points_that_coincide(first, second, off):
    one, two = np.array(first, float), np.array(second, float) + off
    gap, way, _ = search(one, two)
    assert np.linalg.norm(way) == pytest.approx(1, abs=1e-14)
    assert gap == pytest.approx(gap_of(one, two, way), abs=1e-13)
    if gap > 0:
        assert gap == pytest.approx(feature_distance(one, two), abs=1e-13)
    assert max(gap, 0.0) == pytest.approx(max(exhaustive_gap(one, len(one), two, len(two))[0], 0.0), abs=1e-13)


def test_hulls_one_knows():
    box = prism(4, 1.0, 0.5)
    for shift, expected in (
        ((0, 0, 0.5), 0.0),  # one upon the other
        ((0, 0, 0.7), 0.2),
        ((0, 0, -0.75), 0.25),
        ((1, 1, 0), 0.0),  # side by side
        ((1, 1, 0.5), 0.0),  # along an edge
        ((2, 0, 0.5), 0.0),  # at a corner
        ((5, 0, 0), 3.0),
        ((2, 2, 0), math.sqrt(2.0)),
        ((0, 0, 0), 0.0),
        ((0.1, 0, 0.1), 0.0),
    ):
        gap, way, _ = search(box, box + shift)
        assert max(gap, 0.0) == pytest.approx(expected, abs=1e-15)
        if expected:
            assert gap_of(box, box + shift, way) == pytest.approx(expected, abs=1e-15)


def test_pairs_are_searched_one_by_one_and_remembered():
    rng = np.random.default_rng(3)
    solids = rng.normal(size=(2, 50, 8, 3)) + np.array([0, 2.0])[:, None, None, None]
    counts = rng.integers(4, 9, size=(2, 50))
    ways, corners, gaps = np.zeros((50, 3)), np.full((50, 4), -1), np.empty(50)
    write_hull_gaps(solids[0], counts[0], solids[1], counts[1], ways, corners, gaps)
    for k in range(50):
        gap, way, nearest = search(solids[0, k, : counts[0, k]], solids[1, k, : counts[1, k]])
        assert gaps[k] == gap
        assert tuple(ways[k]) == tuple(way)
        assert tuple(corners[k]) == nearest
    again = np.empty(50)
    write_hull_gaps(solids[0], counts[0], solids[1], counts[1], ways, corners, again)
    assert again == pytest.approx(gaps, abs=1e-14)
    assert (gaps > 0).any()


def naive_gaps(linkage, angles, pairs, allowed):
    solids, panels = [solid.reshape(-1, 3) for solid in linkage.solids(angles)], linkage.pattern.panel_of
    gaps = []
    for i, j in pairs:
        least, depth = math.inf, 0.0
        for one in (solid for solid, panel in zip(solids, panels, strict=True) if panel == i):
            for two in (solid for solid, panel in zip(solids, panels, strict=True) if panel == j):
                overlap = overlap_along_all(one, two)
                depth = max(depth, overlap)
                least = min(least, feature_distance(one, two)) if overlap < 0.0 else 0.0
        gaps.append(-depth if depth > allowed else least)
    return np.array(gaps)


def swinging(linkage, n, most, seed):
    """States about the flat one, wider and wider: some far apart, so that what is remembered misleads."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(3, linkage.n_hinges))
    times = np.linspace(0, 3, n)[:, None]
    return most * (np.sin(3 * times) * ways[0] + np.sin(7 * times) * ways[1] + (times > 2) * ways[2])


@pytest.mark.parametrize("name", ["thesis-4x4", "element-8r", "hex:02234400:1", "triangle:0123434501:1"])
def test_gaps_of_panels_are_those_of_their_facets(name):
    linkage = linkage_named(name)
    states = swinging(linkage, 8, 1.0, len(name))
    proximity = proximal_distances(linkage, states)
    hinged = {(hinge.first, hinge.second) for hinge in linkage.pattern.hinges}
    assert not hinged & set(map(tuple, proximity.pairs))
    assert len(proximity.pairs) + len(hinged) == math.comb(linkage.n_panels, 2)
    size = linkage.pattern.size
    for k, angles in enumerate(states):
        assert proximity.gaps[:, k] == pytest.approx(
            naive_gaps(linkage, angles, proximity.pairs, 1e-6 * size), abs=1e-12
        )
    assert (proximity.gaps > 0).any()
    assert (proximity.gaps < 0).any()
    assert proximity.collision == np.flatnonzero((proximity.gaps < 0).any(axis=0))[0]
    assert (proximity.distances == np.where(proximity.gaps > 0, proximity.gaps, 0)).all()


@pytest.mark.parametrize("name", ["thesis-4x4", "hex:02234400:1"])
def test_packed_and_flat_panels_touch_and_do_not_collide(name):
    linkage = linkage_named(name)
    states = np.array([linkage.folded, linkage.flat, linkage.folded])
    proximity = proximal_distances(linkage, states)
    assert proximity.collision is None
    assert not approach_speeds(proximity, np.arange(3.0)).any()
    touching = proximity.gaps < 1e-12
    assert touching[:, 0].sum() > 3
    assert (touching[:, 0] == touching[:, 2]).all()
    for k in range(2):
        expected = naive_gaps(linkage, states[k], proximity.pairs, 1e-9)
        assert proximity.gaps[:, k] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", ["thesis-4x4", "hex:02234400:1"])
def test_within_reach_gaps_are_exact_and_beyond_it_bounds(name):
    linkage = linkage_named(name)
    states = swinging(linkage, 60, 1.0, 5)
    exact = proximal_distances(linkage, states).gaps
    for reach in (1e-3, 2e-2, 1e-1):
        gaps = proximal_distances(linkage, states, reach=reach).gaps
        near = exact < reach
        assert gaps[near] == pytest.approx(exact[near], abs=1e-13)
        assert (gaps[~near] >= reach - 1e-13).all()
        assert (gaps[~near] <= exact[~near] + 1e-13).all()
        assert near.any()
        assert not near.all()


def test_a_state_alone_has_the_gaps_that_it_has_among_others():
    linkage = linkage_named("thesis-4x4")
    states = swinging(linkage, 40, 1.0, 9)
    together = proximal_distances(linkage, states).gaps
    for k, angles in enumerate(states):
        assert proximal_distances(linkage, angles[None]).gaps[:, 0] == pytest.approx(together[:, k], abs=1e-13)


def test_panels_of_several_facets_with_different_numbers_of_corners():
    square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    middle = ((1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0))
    triangle = ((2.0, 0.0), (3.0, 0.5), (2.0, 1.0))
    last = ((2.0, 1.0), (3.0, 0.5), (3.0, 2.0))
    creases = {(0, 1): Crease("top"), (1, 2): Crease("bottom"), (2, 3): RIGID_CREASE}
    linkage = Linkage(Pattern.from_polygons((square, middle, triangle, last), creases, thickness=0.1))
    assert linkage.n_panels == 3
    states = np.array([(a, b) for a in (-0.3, 0.5, 2.5) for b in (-2.9, 1.0, 3.0)])
    proximity = proximal_distances(linkage, states)
    assert proximity.pairs.tolist() == [[0, 2]]
    for k, angles in enumerate(states):
        assert proximity.gaps[:, k] == pytest.approx(naive_gaps(linkage, angles, proximity.pairs, 1e-6), abs=1e-12)
    assert proximal_distances(linkage, states, {(0, 2)}).gaps.shape == (0, 9)


def test_what_is_allowed_only_touches():
    linkage = linkage_named("thesis-4x4")
    states = swinging(linkage, 30, 0.5, 2)
    proximity = proximal_distances(linkage, states, allowed=0.0)
    deepest = -proximity.gaps.min()
    assert 0 < deepest < 0.1
    assert deepest == pytest.approx(-min(proximity.gaps[:, k].min() for k in range(30)))
    less = proximal_distances(linkage, states, allowed=0.5 * deepest)
    assert less.gaps.min() == pytest.approx(-deepest)
    cut = less.gaps[proximity.gaps < 0]
    assert set(np.unique(cut < 0)) == {False, True}
    assert (cut[proximity.gaps[proximity.gaps < 0] > -0.5 * deepest] == 0).all()
    most = proximal_distances(linkage, states, allowed=1.1 * deepest)
    assert most.collision is None


def test_datasets_of_a_deployment():
    linkage = linkage_named("thesis-4x4")
    deployment = simulate_deployment(linkage, SCENES["default"], certified=False, tolerance=1e-4)
    times, states = deployment.motion.times, deployment.angles
    proximity = proximal_distances(linkage, states)
    first = next(k for k in range(len(states)) if (proximity.gaps[:, k] < 0).any())
    assert proximity.collision == first > 2
    assert all(penetration(linkage, states[k]) >= -1e-9 - proximity.gaps[:, k].min() for k in range(first + 1))
    speeds = approach_speeds(proximity, times)
    d = proximity.distances
    for p, speed in enumerate(speeds):
        if proximity.gaps[p, first] < 0:
            assert speed == (d[p, first - 2] - d[p, first - 1]) / (times[first - 1] - times[first - 2])
        else:
            assert speed == 0.0
    assert speeds.max() > 0


def test_speeds_need_two_states_before_a_collision():
    pairs = np.array([[0, 2], [1, 3]])
    gaps = np.array([[0.3, 0.2, 0.1, -0.1], [0.3, 0.1, 0.0, 0.0]])
    assert approach_speeds(Proximity(pairs, gaps), np.array([0.0, 0.5, 1.0, 1.1])).tolist() == [pytest.approx(0.2), 0.0]
    assert approach_speeds(Proximity(pairs, gaps[:, :3]), np.arange(3.0)).tolist() == [0.0, 0.0]
    with pytest.raises(HcsearchError, match="collide at state 1 already"):
        approach_speeds(Proximity(pairs, gaps[:, 2:]), np.arange(2.0))


@pytest.mark.parametrize("name", ["thesis-4x4", "hex:02234400:1"])
def test_the_nearest_pair_is_the_deepest_overlap_or_the_least_gap(name):
    linkage = linkage_named(name)
    states = np.concatenate([[linkage.folded], swinging(linkage, 40, 1.0, 5), [linkage.flat]])
    near, distances = nearest_panels(linkage, states), proximal_distances(linkage, states)
    number = {tuple(pair): k for k, pair in enumerate(distances.pairs.tolist())}
    for state, pair in enumerate(near.pairs.tolist()):
        column = distances.gaps[:, state]
        apart = column[np.abs(column) > CONTACT_GAP_SHARE * linkage.pattern.size]
        assert near.gaps[state] == column[number[tuple(pair)]] == apart.min()
        assert near.touching[state] == len(column) - len(apart)
    assert (near.gaps < 0).any()
    assert (near.gaps > 0).any()
    assert near.touching[0] > 3


def test_panels_of_one_hinge_have_no_nearest_pair():
    square, beside = ((0, 0), (1, 0), (1, 1), (0, 1)), ((1, 0), (2, 0), (2, 1), (1, 1))
    linkage = Linkage(Pattern.from_polygons((square, beside), {(0, 1): Crease("top")}, 0.1))
    near = nearest_panels(linkage, np.array([[math.pi], [0.0]]))
    assert near.pairs.tolist() == [[-1, -1], [-1, -1]]
    assert np.isnan(near.gaps).all()
    assert not near.touching.any()


def test_bad_input_is_refused_with_a_remedy():
    linkage = linkage_named("thesis-4x4")
    with pytest.raises(HcsearchError, match="fold angles"):
        proximal_distances(linkage, linkage.flat)
    with pytest.raises(HcsearchError, match="positive length"):
        proximal_distances(linkage, linkage.flat[None], reach=0.0)
    with pytest.raises(HcsearchError, match="0 or more"):
        proximal_distances(linkage, linkage.flat[None], allowed=-1.0)
    assert proximal_distances(linkage, np.empty((0, linkage.n_hinges))).gaps.shape[1] == 0
