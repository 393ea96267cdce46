"""Folded forms: a second frame of a FOLD file, from which the packed state is read."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import check, save
from hcsearch.basics.errors import PatternError
from hcsearch.search.own_patterns.fold_reading import parse_fold
from hcsearch.subjects.resolve import resolve
from tests.export.test_any_panels import packed_of, strip, written


def _turned(points, start, end, angle):
    """Points turned about a line, rad."""
    axis = (end - start) / np.linalg.norm(end - start)
    arms = points - start
    along = np.outer(arms @ axis, axis)
    return start + along + math.cos(angle) * (arms - along) + math.sin(angle) * np.cross(axis, arms)


def with_form(data, angles, place=lambda points: points, **keys):
    """A strip with a folded form. angles : of its creases, degrees, positive for valleys."""
    points = np.array([[*point, 0.0] for point in data["vertices_coords"]])
    faces = data["faces_vertices"]
    for k, angle in enumerate(angles):
        crease = sorted(set(faces[k]) & set(faces[k + 1]), key=lambda v: data["vertices_coords"][v][1])
        beyond = sorted({v for face in faces[k + 1 :] for v in face} - set(crease))
        points[beyond] = _turned(points[beyond], *points[crease], -math.radians(angle))
    form = {"frame_classes": ["foldedForm"], "frame_inherit": True, "frame_parent": 0}
    return data | {"file_frames": [form | {"vertices_coords": place(points).tolist()} | keys]}


def _moved(points):
    """Points in another place of space, with rounded coordinates."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    return np.round(points @ (turn * np.linalg.det(turn)) + [3.0, -2.0, 7.0], 4)


@settings(max_examples=20)
@given(st.lists(st.tuples(st.floats(1.0, 3.0), st.floats(5.0, 175.0), st.sampled_from("MVU")), min_size=1, max_size=5))
def test_the_angles_of_a_folded_form_are_those_with_which_it_was_folded(panels):
    widths, sizes, letters = zip((1.5, 0.0, "M"), *panels, strict=True)
    signed = [size if letter == "V" else -size for size, letter in zip(sizes[1:], letters[1:], strict=True)]
    data = with_form(strip(widths, letters[1:]), signed, _moved)
    joins = parse_fold(json.dumps(data)).joins.values()
    assert [join.assignment for join in joins] == ["V" if angle > 0.0 else "M" for angle in signed]
    assert np.allclose([join.angle for join in joins], signed, atol=0.05)


def test_a_closed_folded_form_states_which_hinges_close_and_leaves_their_faces_open():
    packed = packed_of(with_form(strip([2.0, 1.5, 1.8], "UU"), [179.9, 0.1]))
    assert [hinge.closes for hinge in packed.pattern.hinges] == [True, False]
    assert "stated by the file: 1 of 2 hinges flat" in packed.sentence


def test_a_partly_closed_folded_form_is_checked(tmp_path):
    (checked,) = check(written(tmp_path, with_form(strip([2.0, 1.5, 1.8], "MV"), [-90.0, 45.0]))).verdicts
    assert np.allclose(checked.linkage.folded, [math.pi / 2, math.pi / 4])
    assert checked.dof_packed == 2


def test_a_step_of_an_animation_is_no_packed_state_unless_all_hinges_are_at_stops():
    steps = {"file_classes": ["singleModel", "animation"]}
    on_the_way, packed = (
        packed_of(with_form(strip([2.0, 1.5, 1.8], "MV"), form) | steps) for form in ([-90, 45], [-180, 0])
    )
    assert [hinge.closes for hinge in on_the_way.pattern.hinges] == [True, True]
    assert [hinge.closes for hinge in packed.pattern.hinges] == [True, False]


@pytest.mark.parametrize("name", ["unit-ii", "element-6r"])
def test_the_packed_frame_of_an_export_states_its_packed_state(name, tmp_path):
    (path,) = save(name, tmp_path / "a.fold")
    data = json.loads(path.read_text())
    del data["edges_foldAngle"]
    del data["file_frames"][0]
    packed = packed_of(data)
    assert "stated by the file" in packed.sentence
    hinges, others = packed.pattern.hinges, resolve(name).linkage.pattern.hinges
    assert [(hinge.face, hinge.closes) for hinge in hinges] == [(hinge.face, hinge.closes) for hinge in others]


def test_a_pattern_without_listed_faces_has_no_folded_form():
    data = with_form(strip([2.0, 1.5], "M"), [-90.0])
    faces = data.pop("faces_vertices")
    data["file_frames"][0]["faces_vertices"] = faces
    assert packed_of(data).pattern.hinges[0].folded_angle == math.pi


def test_fold_angles_come_before_a_folded_form():
    data = with_form(strip([2.0, 1.5], [("M", -180)]), [-30.0])
    assert packed_of(data).pattern.hinges[0].closes


_PAIR = strip([2.0, 1.5], "M")
_FLAT_PAIR = strip([2.0, 1.5, 1.2], "FM")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (with_form(_PAIR, [-40.0], lambda points: points * [1.0, 1.0, 1.1]), "face 1 is not congruent to that of the"),
        (with_form(_PAIR, [40.0]), "edge . is a mountain, and its faces turn by 40 degrees as at a valley"),
        (with_form(_FLAT_PAIR, [40.0, -50.0]), r"edge . stays flat \(F\), and its faces turn by 40 degrees"),
        (with_form(_PAIR, [-40.0], faces_vertices=[[0, 1, 2, 3]]), "it has 1 faces, and the pattern lists 2"),
        (with_form(_PAIR, [-40.0], faces_vertices=[[0, 1, 2, 3], [1, 2, 4]]), "face 1 has 3 corners, and 4 in"),
        (with_form(_PAIR, [-40.0], faces_vertices=[[0, 1, 2, 9]]), "no flat pattern: 9 is no vertex"),
    ],
)
def test_a_folded_form_that_is_no_state_of_the_panels_is_refused(data, message):
    with pytest.raises(PatternError, match=f"^frame 1 of the text is .*{message}"):
        packed_of(data)


def test_a_folded_form_without_panels_in_space_is_ignored():
    flat = with_form(_PAIR, [-180.0], lambda points: points[:, :2])
    assert packed_of(flat).sentence.startswith("packed state found")
