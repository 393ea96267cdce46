"""Regions of few boxes around an end, which closed states do not leave, and what they are laid by."""

import math

import numpy as np
import pytest

from hcsearch.kernels.enclosure.refutation import BOX_CLOSED, BOX_EMPTY, estimate_box_count, new_refutation
from hcsearch.kernels.enclosure.wandering import MAX_WALK_STEP, climb_angles
from hcsearch.motion.locks import boxes, regions
from hcsearch.motion.locks.boxes import MAX_BOX_ANGLE, BoxFace, box_faces, states_in
from hcsearch.motion.locks.enclosures import rings_of
from hcsearch.motion.locks.regions import Region
from hcsearch.motion.searching import Budget
from tests.locks.refuting import refute_box
from tests.planned import SAMPLES, joined, open_by, planned, region_of, walks_of


def boxes_of(region):
    """The boxes of a region."""
    return list(zip(*region.bounds, strict=True))


def held(region, states):
    """Which states a region holds."""
    return np.array([any(len(states_in(box, state[None])) for box in boxes_of(region)) for state in states])


LEFT = [
    ("hex:0234340511:3", 0),
    ("hex:0233545012:2", 0),
    ("hex:0233534001:3", 0),
    ("hex:0233435001:2", 1),
    ("hex:0223445511:4", 1),
    ("hex:0223335500:4", 1),
    ("hex:0223435501:2", 0),
]
"""Foldings, and the side of a region that is proved soon: of one box, and of several."""


@pytest.mark.parametrize(("name", "side"), LEFT)
def test_a_region_is_left_by_no_walk(name, side):
    linkage = joined(name, "hinged")
    region = region_of(linkage, side)
    assert region.run(Budget(200_000))
    rings, walks = walks_of(linkage, 60_000)
    assert held(region, walks[side][::7]).all()
    assert not held(region, walks[1 - side][::7]).any()
    # each face is proved anew, whole: the region's were searched in parts
    faces, work = box_faces(boxes_of(region), MAX_BOX_ANGLE), new_refutation(rings)
    assert faces
    assert all(refute_box(rings, face.low.copy(), face.high.copy(), 10**6, work)[0] == BOX_EMPTY for face in faces)


def test_some_regions_consist_of_several_boxes():
    region = region_of(joined("hex:0223335500:4", "hinged"), 1)
    assert region.run(Budget(20_000))
    assert region.cubes > 1
    low, high = region.bounds
    assert (low < high).all()


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_no_region_holds_an_end_alone_of_what_moves(name):
    for side in (0, 1):
        assert not region_of(planned(name).linkage, side, 5_000).run(Budget(20_000))


def test_a_region_is_laid_anew_around_what_is_met_on_its_faces(monkeypatch):
    # without climbs, a short walk shows little of its part
    linkage = joined("hex:0233545012:2", "hinged")
    region, met = region_of(linkage, 0, 100, climbs=0), []
    take_in = Region._take_in
    monkeypatch.setattr(Region, "_take_in", lambda own, state, face: (met.append(state), take_in(own, state, face)))
    assert region.run(Budget(200_000))
    assert met
    assert open_by_states(linkage, np.array(met)).max() < 1e-6
    _, walks = walks_of(linkage, 60_000)
    assert held(region, walks[0][::7]).all()
    assert not held(region, walks[1][::7]).any()


def open_by_states(linkage, states):
    """By how much loops are open at states of the hinges in loops."""
    angles = np.tile(linkage.folded, (len(states), 1))
    angles[:, rings_of(linkage)[1]] = states
    return open_by(linkage, angles)


@pytest.mark.parametrize(
    ("name", "side", "many", "steps"), [("hex:0233435001:2", 1, 100, 20_000), ("hex:0234535012:4", 0, 0, 1_000)]
)
def test_a_region_does_not_hang_on_how_often_it_is_interrupted(name, side, many, steps, monkeypatch):
    monkeypatch.setattr(regions, "MAX_NESTED_MET_STATES", many)
    linkage = joined(name, "hinged")
    whole, parts = (region_of(linkage, side, steps, climbs=steps // 20) for _ in range(2))
    assert whole.run(Budget(10**6))
    calls = 1
    while not parts.run(Budget(parts.efforts + 100)):
        calls += 1
        assert calls < 10_000
    assert calls > 10
    assert parts.efforts == whole.efforts
    assert np.array_equal(parts.bounds, whole.bounds)


def test_climbs_lead_further_than_a_walk_from_one_state_to_the_next():
    linkage = joined("hex:023244401502:5", "hinged")
    rings, walks = walks_of(linkage, 5_000)
    n, walk = rings.hinge_count, walks[0]
    climbed = climb_angles(rings, walk, np.zeros(n), np.full(n, math.pi), 500, 1, new_refutation(rings))
    assert np.array_equal(climbed[: len(walk)], walk)
    assert open_by_states(linkage, climbed).max() < 1e-6
    assert climbed.min(axis=0).sum() < walk.min(axis=0).sum() - 0.1
    gaps = [np.abs(climbed[:k] - climbed[k]).max(axis=1).min() for k in range(len(walk), len(climbed))]
    assert max(gaps) <= 1.5 * MAX_WALK_STEP


def test_climbs_stay_within_their_box():
    linkage = joined("hex:0233545012:2", "hinged")
    rings, walks = walks_of(linkage, 2_000)
    low, high = np.maximum(walks[0][0] - 0.5, 0.0), np.minimum(walks[0][0] + 0.5, math.pi)
    climbed = climb_angles(rings, walks[0][:1], low, high, 300, 1, new_refutation(rings))
    assert len(climbed) > 10
    assert (low <= climbed).all()
    assert (climbed <= high).all()


def test_the_number_of_boxes_is_estimated():
    linkage = joined("hex:0223445511:4", "hinged")
    region = region_of(linkage, 0)
    assert region.run(Budget(20_000))
    rings, work = region.rings, new_refutation(region.rings)
    ratios = []
    for face in box_faces(boxes_of(region), MAX_BOX_ANGLE):
        verdict, boxes = refute_box(rings, face.low.copy(), face.high.copy(), 10**6, work)
        expected, known, tested = estimate_box_count(rings, face.low, face.high, 2000, 3, work)
        assert verdict == known == BOX_EMPTY
        assert tested >= 2000
        ratios.append(expected / boxes)
    assert len(ratios) > 2
    assert 0.7 < min(ratios) <= max(ratios) < 1.4


def test_an_estimate_ends_at_a_closed_state():
    linkage = joined("hex:0223445511:4", "hinged")
    rings, walks = walks_of(linkage, 5_000)
    state, work = walks[0][2000], new_refutation(rings)
    face = BoxFace(2, np.maximum(state - 0.3, 0.0), np.minimum(state + 0.3, math.pi))
    face.low[2] = face.high[2] = state[2]
    assert estimate_box_count(rings, face.low, face.high, 50, 1, work)[1] == BOX_CLOSED
    assert open_by_states(linkage, work.state[None]).max() < 1e-6
    assert work.state[2] == state[2]


@pytest.mark.parametrize(
    ("name", "side", "anew", "at_once"),
    [("hex:0234535012:4", 0, 8, 60), ("hex:0223335500:4", 1, 8, 60), ("hex:0223445511:4", 0, 1, 2)],
)
def test_cuts_enclose_an_end_too(name, side, anew, at_once, monkeypatch):
    monkeypatch.setattr(regions, "MAX_NESTED_MET_STATES", 0)
    monkeypatch.setattr(regions, "MAX_STATES_BEFORE_RECUT", at_once)
    monkeypatch.setattr(boxes, "MAX_RECUTS", anew)
    linkage = joined(name, "hinged")
    region, met = region_of(linkage, side, 1_000, climbs=100 if anew > 1 else 0), []
    take_in = Region._take_in
    monkeypatch.setattr(Region, "_take_in", lambda own, state, face: (met.append(state), take_in(own, state, face)))
    assert region.run(Budget(600_000))
    assert met
    rings, walks = walks_of(linkage, 60_000)
    assert held(region, walks[side][::7]).all()
    assert not held(region, walks[1 - side][::7]).any()
    faces, work = box_faces(boxes_of(region), MAX_BOX_ANGLE), new_refutation(rings)
    assert all(refute_box(rings, face.low.copy(), face.high.copy(), 10**6, work)[0] == BOX_EMPTY for face in faces)


def test_cuts_follow_where_no_boxes_within_boxes_leave_out_the_other_end(monkeypatch):
    tried = []
    monkeypatch.setattr(regions, "region_around", lambda own, others, reach: tried.append((own, others)))
    region = region_of(joined("hex:0233545012:2", "hinged"), 0, 1_000, climbs=100)
    assert region.run(Budget(200_000))
    assert len(tried) == 1
    assert held(region, tried[0][0]).all()


def test_what_a_region_is_expected_to_take_is_known_after_a_state_is_met_in_its_search():
    region = region_of(joined("hex:0233545012:2", "hinged"), 0, 3_000)
    while not region.faces:
        region.run(Budget(region.efforts + 100))
    before = region.boxes_expected
    region._take_in(region._parts.states[0][0].copy(), region._searched.face)
    region._lay_out()
    assert 0.5 * before < region.boxes_expected < math.inf
