"""Locks by collision: boxes that are left out overlap throughout, as linear programs of their corners say."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from hcsearch.kernels.enclosure.contraction import close_within_box, contract_box
from hcsearch.kernels.enclosure.overlaps import (
    FORM_HEIGHT,
    FORM_INSIDE,
    FORM_LEAN,
    FORM_RISE,
    OVERLAP_AT_MIDDLE,
    OVERLAP_THROUGHOUT,
    TRACE_ALONG,
    TRACE_CROSSING,
    TRACE_LOWER,
    TRACE_UPPER,
    _crossing,
    _form,
    _trace,
    clear_at,
    overlap_in_box,
)
from hcsearch.kernels.enclosure.plates import new_facet_view, view_facet
from hcsearch.kernels.enclosure.refutation import BOX_EMPTY, refutation_with
from hcsearch.motion.collision.panel_prisms import plates_of, two_ways
from hcsearch.motion.locks.enclosures import enclose_ends, rings_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Pattern
from tests.locks.refuting import refute_box
from tests.locks.test_enclosures import box_about, close
from tests.naive import around_the_loop
from tests.planned import SAMPLES, joined, planned

LOCKED = {
    ("hex:0232435051:3", "hinged"): 1e-4,
    ("hex:0233435001:3", "hinged"): 2e-4,
    ("hex:0232435051:3", "rigid"): 1e-4,
}
"""Foldings whose ends closed states join, and margins (m) at which panels keep these apart."""
OPEN = {"hex:0232435051:3": 1.5e-3}
"""Margins (m) at which a path is proved."""


def shrunk(linkage, angles, margin):
    """The corners of each facet less a margin, (m, 3) each: every side of it moved, in the plane, then folded."""
    poses, solids = linkage.poses(angles), []
    for facet, panel in zip(linkage.pattern.facets, linkage.pattern.panel_of, strict=True):
        corners, normals = np.array(facet), []
        for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            along = (end - start) / math.dist(start, end)
            normals.append((-along[1], along[0]))
        levels = (np.array(normals) * corners).sum(axis=1) + margin
        ring = [np.linalg.solve([normals[k - 1], normals[k]], [levels[k - 1], levels[k]]) for k in range(len(corners))]
        flat = np.array([(x, y, z) for z in (margin, linkage.pattern.thickness - margin) for x, y in ring])
        solids.append(flat @ poses[panel][:, :3].T + poses[panel][:, 3])
    return solids


def share_a_point(one, two):
    """Whether the hulls of two sets of points do: a mixture of the one equals a mixture of the other."""
    a, b = len(one), len(two)
    size = np.abs(np.concatenate([one, two])).max()
    sums = np.repeat(np.eye(2), (a, b), axis=1)
    rows = np.vstack([np.hstack([one.T, -two.T]) / size, sums])
    return linprog(np.zeros(a + b), A_eq=rows, b_eq=[0, 0, 0, 1, 1]).status == 0


def collide(linkage, angles, margin):
    """Whether facets overlap whose panels no hinge joins: those that are nearest are looked at first."""
    pattern, solids = linkage.pattern, shrunk(linkage, angles, margin)
    joints = {frozenset((hinge.first, hinge.second)) for hinge in pattern.hinges}
    pairs = [
        (one, two)
        for one, two in combinations(range(len(solids)), 2)
        if len(own := {pattern.panel_of[one], pattern.panel_of[two]}) > 1 and own not in joints
    ]
    pairs.sort(key=lambda pair: math.dist(solids[pair[0]].mean(axis=0), solids[pair[1]].mean(axis=0)))
    return any(share_a_point(solids[one], solids[two]) for one, two in pairs)


def closed_states(rings, low, high, count, rng, work):
    """Closed states in a box, from random ones."""
    for _ in range(count):
        state = low + rng.random(len(low)) * (high - low)
        if close_within_box(rings, low, high, state, work.contraction.expansion, work.newton) < 1e-6:
            yield state


@pytest.mark.parametrize(
    ("name", "way", "margin"),
    [
        ("hex:0233435001:3", "hinged", 1e-4),
        ("square:012233230011:4", "merged", 1e-3),
        ("triangle:01234343450101:0", "rigid", 2e-3),
    ],
)
def test_panels_overlap_throughout_a_box_that_is_left_out(name, way, margin):
    linkage, rng = joined(name, way), np.random.default_rng(1)
    rings, hinges = rings_of(linkage)
    assert hinges.tolist() == list(range(linkage.n_hinges))
    work = refutation_with(rings, plates_of(linkage, margin))
    n, known, checked = len(hinges), [], 0
    for state in closed_states(rings, np.zeros(n), np.full(n, math.pi), 400, rng, work):
        low, high = box_about(state, rng, 10.0 ** rng.uniform(-3, -0.3))
        if contract_box(rings, low, high, work.contraction):
            known.append(overlap_in_box(rings, low, high, work.contraction, work.overlaps))
            if known[-1] == OVERLAP_THROUGHOUT and checked < 60:
                for own in closed_states(rings, low, high, 3, rng, work):
                    checked += 1
                    assert collide(linkage, own, margin)
    assert known.count(OVERLAP_THROUGHOUT) > 10
    assert known.count(OVERLAP_AT_MIDDLE) > 0
    assert checked > 20


@pytest.mark.parametrize("name", ["hex:0232435051:3", "square:012123230301:2", "triangle:01234343450101:0"])
def test_states_count_as_clear_where_no_panels_collide(name):
    linkage, rng = joined(name, "hinged"), np.random.default_rng(2)
    rings, hinges = rings_of(linkage)
    work, n = refutation_with(rings, plates_of(linkage, 1e-4)), len(hinges)
    for end in (linkage.folded, linkage.flat):
        assert clear_at(end, work.overlaps)
        assert not collide(linkage, end, 1e-4)
    said = []
    for state in closed_states(rings, np.zeros(n), np.full(n, math.pi), 60, rng, work):
        said.append((clear_at(state, work.overlaps), collide(linkage, state, 1e-4)))
    # samples of panels miss a few overlaps, and never take panels that are apart for ones that overlap
    assert (False, False) not in said
    assert said.count((False, True)) > 0.9 * (len(said) - said.count((True, False))) - 5


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_no_box_about_a_state_of_a_proved_path_is_left_out(name):
    sample, rng = planned(name), np.random.default_rng(3)
    rings, hinges = rings_of(sample.linkage)
    work = refutation_with(rings, plates_of(sample.linkage, sample.proof.margin))
    states = sample.proof.motion.angles[:, hinges]
    tested = 0
    for _ in range(150):
        state = np.clip(states[rng.integers(len(states))], 0.0, math.pi)
        if close(rings, state, work) > 1e-7:
            continue
        assert clear_at(state, work.overlaps)
        low, high = box_about(state, rng, 10.0 ** rng.uniform(-4, 0))
        assert refute_box(rings, low, high, 50, work)[0] != BOX_EMPTY
        tested += 1
    assert tested > 50


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_what_moves_is_not_enclosed(name):
    sample = planned(name)
    assert not enclose_ends(sample.linkage, 1000, plates_of(sample.linkage, sample.proof.margin)).proved


@pytest.mark.parametrize(("name", "way"), LOCKED)
def test_panels_keep_ends_apart_that_closed_states_join(name, way):
    linkage, margin = joined(name, way), LOCKED[name, way]
    enclosure = enclose_ends(linkage, 20_000, plates_of(linkage, margin))
    assert (enclosure.end, enclosure.margin) == ("packed", margin)
    assert enclosure.faces > enclosure.cubes > 0


@pytest.mark.parametrize("name", OPEN)
def test_with_more_play_they_do_not(name):
    linkage = joined(name, "hinged")
    assert not enclose_ends(linkage, 200_000, plates_of(linkage, OPEN[name])).proved


def naive_pose(plates, way, order, angles):
    """How the second facet of a pair is seen by the first, or (order 1) the first by the second."""
    steps = range(plates.starts[way], plates.starts[way + 1])
    walk = [(k, 1) for k in steps] if order == 0 else [(k, -1) for k in steps[::-1]]
    return around_the_loop(plates.directions, plates.points, walk, angles[plates.hinges])[:3]


def test_closed_loops_place_a_panel_alike_by_both_ways():
    sample = planned("hex:0234550132:4")
    plates, sight = plates_of(sample.linkage, 1e-4), new_facet_view(sample.linkage.n_hinges)
    angles = sample.proof.motion.angles[len(sample.states) // 2]
    for pair in range(len(plates.pairs)):
        for order in range(2):
            poses = []
            for way in range(2):
                radii = np.zeros(len(angles))
                start, end = plates.starts[2 * pair + way : 2 * pair + way + 2]
                radii[plates.hinges[start:end]] = -1.0
                view_facet(plates, pair, order, angles, radii, sight)
                assert sight.length[0] == end - start
                poses.append(sight.pose.copy())
                assert poses[-1] == pytest.approx(naive_pose(plates, 2 * pair + way, order, angles), abs=1e-12)
            assert poses[0] == pytest.approx(poses[1], abs=1e-5)


@given(st.sampled_from(sorted(SAMPLES)), st.floats(0.001, 0.5), st.integers(0, 2**32 - 1))
def test_forms_of_a_piercing_are_what_they_bound(name, width, seed):
    linkage, rng = planned(name).linkage, np.random.default_rng(seed)
    rings, _ = rings_of(linkage)
    plates = plates_of(linkage, 1e-4)
    work, n = refutation_with(rings, plates).overlaps, linkage.n_hinges
    radii = width * rng.random(n) ** 3
    middles = math.pi * rng.random(n)
    pair, order = rng.integers(len(plates.pairs)), rng.integers(2)
    own, other = plates.pairs[pair][[order, 1 - order]]
    samples = plates.samples[other][rng.choice(plates.counts[other, 0], 2, replace=False)]
    along, shift = samples[0] - samples[1], rng.random()
    (x, y, far), height = plates.sides[own, rng.integers(plates.counts[own, 2])], rng.normal()
    side, up = np.array([x, y, 0.0]), np.array([0.0, 0.0, 1.0])

    def places(angles):
        view_facet(plates, pair, order, angles, radii, work.sight)
        pose = work.sight.pose
        upper, lower = (pose[:, :3] @ point + pose[:, 3] for point in samples)
        return upper, lower, upper - shift * (upper - lower), pose[:, :3] @ along

    traced = places(middles)
    for what, place in enumerate(traced):
        _trace(what, tuple(place), float(what != TRACE_ALONG), radii, work)
    forms = (
        (TRACE_UPPER, TRACE_UPPER, up, -height),
        (TRACE_LOWER, TRACE_LOWER, -up, height),
        (TRACE_CROSSING, FORM_HEIGHT, up, -height),
        (TRACE_ALONG, FORM_RISE, up, 0.0),
        (TRACE_CROSSING, FORM_INSIDE, -side, far),
        (TRACE_ALONG, FORM_LEAN, side, 0.0),
    )
    for what, row, normal, value in forms:
        _form(what, row, tuple(normal), value + normal @ traced[what], radii, work)
    value, error = _crossing(work)
    for scale in (1.0, rng.random()):
        d = scale * radii * rng.choice([-1.0, 1.0], n)
        moved = places(middles + d)
        for what, row, normal, start in forms:
            rest = start + normal @ moved[what] - work.values[row] - work.forms[row] @ d
            assert abs(rest) <= work.errors[row] + 1e-14
            assert abs(work.forms[row] @ d) <= work.spreads[row] + 1e-14
        (u, v), (p, q) = (moved[0][2] - height, height - moved[1][2]), (far - side @ place for place in moved[:2])
        assert abs(v * p + u * q - value - work.slopes @ d) <= error + 1e-14


def test_ways_have_no_hinge_in_common():
    linkage = joined("square:012233230011:4", "merged")
    for one, two in combinations(range(linkage.n_panels), 2):
        first, second = two_ways(linkage, one, two)
        assert 0 < len(first) <= len(second) or not second
        assert not {hinge for hinge, _ in first} & {hinge for hinge, _ in second}
        for way in (first, second) if second else (first,):
            panel = one
            for hinge, sign in way:
                joint = linkage.pattern.hinges[hinge]
                assert panel == (joint.first if sign > 0 else joint.second)
                panel = joint.second if sign > 0 else joint.first
            assert panel == two
    lone = Linkage(Pattern.from_polygons((((0.0, 0.0), (0.05, 0.0), (0.05, 0.05)),), {}, 0.006))
    assert plates_of(lone, 1e-4).pairs.shape == (0, 2)
