"""Replays as plain data, and back."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding
from hcsearch.motion.collision.distances import nearest_panels
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import VALLEY_CREASE, Pattern
from hcsearch.subjects.replay_sources import replay_of_path
from hcsearch.web.player.player_data import angles_in, payload_of, replay_in, stacks_of
from tests.player.motions import linkages_of, random_replays, replay_of, twin_poses

MEASURED = ("error", "nearest", "gaps", "touching")
"""Keys that are computed from angles, which are rounded on the way."""


@settings(max_examples=40)
@given(random_replays())
def test_a_replay_comes_back_within_its_rounding(made):
    _, replay = made
    payload = json.loads(json.dumps(payload_of(replay), allow_nan=False))
    again = replay_in(payload)
    step = 1e-3 * payload["unit"]
    one, two = replay.linkage.pattern, again.linkage.pattern
    assert payload["scale"] / 2 < 1e-4
    assert np.abs(again.angles - replay.angles).max() <= payload["scale"] / 2 * (1 + 1e-9)
    assert np.abs(np.concatenate(two.facets) - np.concatenate(one.facets)).max() <= step * (0.5 + 1e-6)
    assert two.creases == one.creases
    assert two.panels == one.panels
    assert [(h.first, h.second, h.face, h.closes) for h in two.hinges] == [
        (h.first, h.second, h.face, h.closes) for h in one.hinges
    ]
    assert np.abs(again.linkage.points - replay.linkage.points).max() <= step * 0.75
    assert again.at == pytest.approx(replay.at, abs=1e-4 * np.diff(replay.at).min())
    assert replay.error < again.error < replay.error + 1e-4
    for name in ("labels", "axis", "certified", "collision", "margin", "title", "source"):
        assert getattr(again, name) == getattr(replay, name)


@pytest.mark.parametrize("name", ["right45:0101:1", "kite:120210310130:2"])
def test_hinges_that_span_several_creases_come_back_as_one(name):
    linkage = min(linkages_of(Folding.from_notation(name)), key=lambda one: one.n_hinges)
    creases = [crease for crease in linkage.pattern.creases.values() if crease.face is not None]
    states = np.linspace(np.zeros(linkage.n_hinges), linkage.folded, 3)
    again = replay_in(json.loads(json.dumps(payload_of(replay_of_path(linkage, states, name, margin=1e-5)))))
    assert again.linkage.n_hinges == linkage.n_hinges < len(creases)


@settings(max_examples=25)
@given(random_replays())
def test_plain_data_are_the_same_after_a_round_trip(made):
    first = payload_of(made[1])
    second = payload_of(replay_in(first))
    assert {key: second[key] for key in first if key not in MEASURED} == {
        key: first[key] for key in first if key not in MEASURED
    }


@settings(max_examples=40)
@given(random_replays(), st.floats(-0.1, 1.1))
def test_panels_are_placed_by_the_plain_data_alone(made, share):
    _, replay = made
    payload = payload_of(replay)
    again = replay_in(payload)
    at = again.at[0] + share * (again.at[-1] - again.at[0])
    (angles,) = again.at_time(np.array([at]))
    expected = again.linkage.poses(angles)
    poses = twin_poses(payload, at)
    assert poses[:, :3, :3] == pytest.approx(expected[:, :, :3], abs=1e-6)
    # mm, and lines between rounded ends of a hinge are those of the pattern to half a step
    assert poses[:, :3, 3] == pytest.approx(1e3 * expected[:, :, 3], abs=1e-3)


@pytest.mark.parametrize("name", ["unit-ii", "hex:0234550132:4"])
def test_loops_stay_closed_to_what_a_screen_shows(name):
    replay = replay_of(name)
    payload = payload_of(replay)
    for at, angles in zip(replay.at, replay.angles, strict=True):
        exact = replay.linkage.poses(angles)
        assert twin_poses(payload, at)[:, :3, 3] == pytest.approx(1e3 * exact[:, :, 3], abs=0.2)


@settings(max_examples=40)
@given(random_replays())
def test_facets_of_both_stacks_are_told_apart(made):
    folding, _ = made
    for linkage in linkages_of(folding):
        stacks = stacks_of(linkage)
        assert stacks is not None
        assert stacks[0] == 0
        assert {frozenset(np.flatnonzero(np.array(stacks) == side)) for side in (0, 1)} == set(
            map(frozenset, folding.stacks)
        )


def test_what_folds_into_other_shapes_has_no_stacks():
    assert stacks_of(replay_of("unit-ii").linkage) is None


@settings(max_examples=20)
@given(random_replays())
def test_facets_share_the_corners_of_shared_edges(made):
    pattern, facets = made[1].linkage.pattern, payload_of(made[1])["facets"]
    for i, j in pattern.edges:
        assert len(set(facets[i]) & set(facets[j])) >= 2
    sides = [(a, b) for facet in facets for a, b in zip(facet, [*facet[1:], facet[0]], strict=True)]
    shared = {tuple(sorted(side)) for side in sides if side[::-1] in set(sides)}
    assert len(shared) == len(pattern.edges)


def test_the_nearest_pairs_are_those_of_the_states():
    replay = replay_of("thesis-4x4")
    payload = payload_of(replay)
    near = nearest_panels(replay.linkage, replay.angles)
    assert payload["nearest"] == near.pairs.ravel().tolist()
    assert payload["touching"] == near.touching.tolist()
    assert np.array(payload["gaps"]) * 1e-3 == pytest.approx(1e3 * near.gaps, abs=0.6e-3)


def test_two_panels_have_no_nearest_pair():
    payload = payload_of(replay_of_two())
    assert payload["nearest"] == [-1, -1, -1, -1]
    assert payload["touching"] == payload["gaps"] == [0, 0]


def replay_of_two():
    squares = (((0, 0), (1, 0), (1, 1), (0, 1)), ((1, 0), (2, 0), (2, 1), (1, 1)))
    small = tuple(tuple((2e-3 * x, 2e-3 * y) for x, y in square) for square in squares)
    linkage = Linkage(Pattern.from_polygons(small, {(0, 1): VALLEY_CREASE}, 2e-4))
    return replay_of_path(linkage, np.array([[np.pi], [0.0]]), "two", margin=None)


def test_small_panels_have_finer_steps():
    payload = payload_of(replay_of_two())
    assert payload["unit"] == 0.001
    assert payload["thickness"] == 200
    assert replay_in(payload).linkage.pattern.facets[1][2] == pytest.approx((4e-3, 2e-3), abs=1e-12)


def test_a_motion_is_about_two_thousand_characters():
    payload = payload_of(replay_of("hex:0234550132:4"))
    sizes = {key: len(json.dumps(value, separators=(",", ":"))) for key, value in payload.items()}
    assert sum(sizes[key] for key in ("angles", "at", "nearest", "gaps", "touching")) < 2200
    assert sum(sizes.values()) < 4000


def test_another_version_is_refused():
    payload = payload_of(replay_of_two()) | {"version": 2}
    with pytest.raises(HcsearchError, match="version 2 cannot be read: write it anew"):
        replay_in(payload)


def test_merged_panels_keep_their_names():
    folding = Folding.from_notation("square:0122333011:1")
    linkage = folding.linkage(flat_pairs="merged")
    replay = replay_of_path(linkage, np.stack([linkage.folded, linkage.flat]), folding.notation, margin=None)
    payload = payload_of(replay)
    assert any("+" in name for name in payload["labels"]["panels"])
    assert replay_in(payload).labels == replay.labels
    assert angles_in(payload)[1].tolist() == [0.0] * linkage.n_hinges
