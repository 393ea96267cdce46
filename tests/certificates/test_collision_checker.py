"""The checker of locks by collision: its forms against the places that they bound, its overlaps against programs."""

import math

import numpy as np
import pytest

from hcsearch.kernels.enclosure.refutation import refutation_with
from hcsearch.motion.certificates.certificate_data import array_data
from hcsearch.motion.certificates.certificate_grammar import Clock
from hcsearch.motion.certificates.collision_checker import Traced, least, overlaps, pairs_of, part
from hcsearch.motion.certificates.lock_checker import Array, Equations, centred
from hcsearch.motion.collision.panel_prisms import plates_of
from hcsearch.motion.locks.enclosures import rings_of
from tests.locks.test_enclosures import box_about
from tests.locks.test_overlaps import closed_states, collide
from tests.planned import SAMPLES, joined, planned


def checked_pairs(linkage, margin):
    """The array of a linkage as the checker has it, and its pairs of facets less a margin (m)."""
    array = Array(array_data(linkage))
    return array, pairs_of(array, plates_of(linkage, margin).pairs.tolist(), repr(margin), Clock())


@pytest.mark.parametrize("name", ["hex:0232435051:3", "square:012123230301:2", "triangle:01234343450101:0"])
def test_forms_bound_where_points_of_facets_are(name):
    linkage, rng = joined(name, "hinged"), np.random.default_rng(1)
    array, pairs = checked_pairs(linkage, 1e-4)
    n, count = linkage.n_hinges, 20
    used = 0.0
    for pair in pairs[::7]:
        for way in pair.ways:
            middles, radii = rng.random((count, n)) * math.pi, 10.0 ** rng.uniform(-4, -0.5, (count, 1))
            boxes = Equations(array.loops, middles, np.tile(radii, (1, n)))
            axes, places, seen = way.seen(pair.points, middles)
            offsets = rng.uniform(-1, 1, (count, n)) * boxes.radii
            moved = way.seen(pair.points, middles + offsets)[2]
            normal = rng.normal(size=3)
            normal /= np.linalg.norm(normal)
            for fixed, place, after in (
                (True, seen[:, 0], moved[:, 0]),
                (False, seen[:, 0] - seen[:, -1], moved[:, 0] - moved[:, -1]),
            ):
                value, slopes, error = Traced(way, axes, places, place, fixed, boxes)(normal, 0.25)
                away = np.abs(after.mid[..., 0] @ normal + 0.25 - value - (slopes * offsets).sum(1))
                assert (away <= error).all()
                used = max(used, float((away / error).max()))
    assert used > 0.2  # the bounds are not idle


def test_forms_are_least_at_closed_states():
    linkage, rng = joined("hex:0232435051:3", "hinged"), np.random.default_rng(2)
    rings, hinges = rings_of(linkage)
    work, array = refutation_with(rings, plates_of(linkage, 1e-4)), Array(array_data(linkage))
    n, sharper = len(hinges), 0
    for state in closed_states(rings, np.zeros(n), np.full(n, math.pi), 100, rng, work):
        low, high = box_about(state, rng, 10.0 ** rng.uniform(-3, -1))
        closure = Equations(array.loops, *centred(low[None], high[None]))
        slopes = rng.normal(size=(1, n))
        below, _ = least(closure, np.zeros(1), slopes, np.zeros(1))
        # Newton's method leaves a residual of a millionth, and slopes have a norm of some
        assert below[0] <= slopes[0] @ (state - closure.middles[0]) + 1e-4
        sharper += below[0] > -(np.abs(slopes) * closure.radii).sum() * 0.9
    assert sharper > 5


@pytest.mark.parametrize(("name", "margin"), [("hex:0233435001:3", 1e-4), ("square:012123230301:2", 1e-4)])
def test_facets_overlap_in_boxes_that_are_left_out(name, margin):
    linkage, rng = joined(name, "hinged"), np.random.default_rng(3)
    rings, hinges = rings_of(linkage)
    assert hinges.tolist() == list(range(linkage.n_hinges))
    work = refutation_with(rings, plates_of(linkage, margin))
    array, pairs = checked_pairs(linkage, margin)
    n, proved = len(hinges), 0
    for state in closed_states(rings, np.zeros(n), np.full(n, math.pi), 400, rng, work):
        low, high = box_about(state, rng, 10.0 ** rng.uniform(-3, -0.3))
        if overlaps(pairs, Equations(array.loops, *centred(low[None], high[None])), Clock())[0][0]:
            proved += 1
            for own in closed_states(rings, low, high, 2, rng, work):
                assert collide(linkage, own, margin)
    assert proved > 5


@pytest.mark.parametrize("name", ["hex:0234550132:4", "square:012123230301:1", "triangle:012343454505012321:3"])
def test_no_box_about_a_state_of_a_proved_path_is_left_out(name):
    assert name in SAMPLES
    sample, rng = planned(name), np.random.default_rng(4)
    array, pairs = checked_pairs(sample.linkage, sample.proof.margin)
    states = np.clip(sample.proof.motion.angles, 0.0, math.pi)
    boxes = [
        box_about(state, rng, 10.0 ** rng.uniform(-3, -0.3)) for state in states[rng.integers(len(states), size=300)]
    ]
    low, high = (np.array(side) for side in zip(*boxes, strict=True))
    # closed states are near those of the path, which closes loops to a millionth
    closure = Equations(array.loops, *centred(low - 1e-5, high + 1e-5))
    assert not overlaps(pairs, closure, Clock())[0].any()


def test_parts_of_equations_are_those_of_their_boxes():
    linkage, rng = joined("hex:0232435051:3", "hinged"), np.random.default_rng(5)
    loops = Array(array_data(linkage)).loops
    middles, radii = rng.random((6, linkage.n_hinges)) * math.pi, np.full((6, linkage.n_hinges), 0.05)
    some = np.array([1, 4])
    own, alone = part(Equations(loops, middles, radii), some), Equations(loops, middles[some], radii[some])
    for name, value in vars(alone).items():
        np.testing.assert_allclose(vars(own)[name], value, rtol=0, atol=1e-12)
