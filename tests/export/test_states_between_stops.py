"""States that files give between the stops of hinges: closed, planned from, deployed from, exported and read again."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import check, prove, save
from hcsearch.basics.errors import HcsearchError, PatternError
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from hcsearch.motion.kinematics.within_stops import close_within_stops
from hcsearch.motion.locks.enclosures import enclose_ends
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.planning.ends import EndClosure
from hcsearch.motion.planning.motion_search import plan_linkage_motion
from hcsearch.motion.planning.planner import Forest, Planner
from hcsearch.motion.planning.problems import group_of_all, loops_of
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from hcsearch.subjects.resolve import resolve
from hcsearch.web.report.sheet_drawings import stowed_drawing
from tests.commands import run_here
from tests.export.exports import MOVING
from tests.export.test_any_panels import drawing_of, packed_of, strip, written
from tests.export.test_folded_forms import with_form


def stated(name, angles, path):
    """Write the pattern of an assembly or folding in a state that has the fold angles of some hinges (degrees)."""
    linkage = resolve(name, "none.sqlite").linkage
    (file,) = save(name, path, db="none.sqlite")
    data = json.loads(file.read_text())
    number = {label: k for k, label in enumerate(labels_of(linkage).hinges)}
    for edge, hinge in enumerate(data["edges_hcsearch:hinge"]):
        if hinge is not None:
            on_top = data["edges_hcsearch:hingeFace"][edge] == "top"
            data["edges_assignment"][edge] = "V" if on_top else "M"
            data["edges_foldAngle"][edge] = float(angles[number[hinge]]) * (1 if on_top else -1)
    data["file_frames"] = []
    file.write_text(json.dumps(data))
    return file


def six_triangles(turns, letters):
    """Six triangles around a point, (polygons, creases); turns : rad."""
    corners = [(math.cos(turn), math.sin(turn)) for turn in np.cumsum([0.0, *turns[:-1]])]
    polygons = [[(0.0, 0.0), corners[k], corners[(k + 1) % 6]] for k in range(6)]
    return polygons, {tuple(sorted((k, (k + 1) % 6))): letter for k, letter in enumerate(letters)}


MIDDLE_8R = np.array([122.4, 63.6, 121.6, 64.9, 122.9, 64.5, 123.7, 63.2])
"""A state on the way of the 8R element, nearly closed, degrees."""


@pytest.fixture(scope="module")
def element(tmp_path_factory):
    return stated("element-8r", MIDDLE_8R, tmp_path_factory.mktemp("between") / "element.fold")


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.floats(1.0, 3.0), st.floats(5.0, 175.0)), min_size=1, max_size=3))
def test_a_path_leads_from_the_stated_state_of_a_chain_to_flat(panels):
    widths, sizes = zip((1.5, 0.0), *panels, strict=True)
    marks = [("V" if k % 2 else "M", size if k % 2 else -size) for k, size in enumerate(sizes[1:])]
    packed = packed_of(strip(widths, marks))
    assert packed.packed
    linkage = Linkage(packed.pattern)
    assert np.allclose(np.degrees(linkage.folded), sizes[1:])
    motion = plan_linkage_motion(linkage)
    assert motion.margin is not None
    assert np.allclose(motion.proof.motion.angles[[0, -1]], [linkage.folded, linkage.flat])


def test_a_search_leaves_a_state_between_the_stops_either_way():
    linkage = Linkage(packed_of(strip([2.0, 1.5, 1.8], [("M", -60.0), ("V", 75.0)])).pattern)
    planner = Planner(linkage, 1e-5)
    ends = np.array([linkage.folded, linkage.flat])
    forest = Forest(planner.space, ends, planner.stack, planner.work)
    assert all(forest.fan_out(0))
    states = forest.clouds()[0][1:]
    assert (states > linkage.folded).any(axis=0).all()
    assert (states < linkage.folded).any(axis=0).all()


def test_a_stated_state_of_a_loop_is_closed_and_deploys(element):
    (checked,) = check(str(element)).verdicts
    assert "8 of 8 hinges between 0 and 180 degrees, after hinges turn by up to" in checked.packed.sentence
    folded = np.degrees(checked.linkage.folded)
    assert 0.0 < np.abs(np.sort(folded) - np.sort(MIDDLE_8R)).max() < 1.0
    assert np.abs(checked.linkage.closure(checked.linkage.folded)[0]).max() <= 1e-12
    assert (checked.status, checked.dof_packed, checked.motion.proof.exact) == ("deploys", 2, False)
    assert np.array_equal(checked.motion.proof.motion.angles[0], checked.linkage.folded)
    assert np.allclose(checked.deployment.angles[0], checked.linkage.folded, atol=0.01)


@pytest.mark.parametrize("ending", [".fold", ".xml", ".urdf"])
def test_an_export_states_the_same_state(ending, element, tmp_path):
    (file, *_) = save(str(element), tmp_path / f"again{ending}")
    exported, again = (resolve(str(path)).linkage for path in (element, file))
    assert np.allclose(np.sort(again.folded), np.sort(exported.folded), atol=1e-4 if ending == ".urdf" else 1e-8)


def test_frames_of_a_motion_inherit_the_packed_frame(element, tmp_path):
    (file,) = save(str(element), tmp_path / "motion.fold", motion="path")
    frames = json.loads(file.read_text())["file_frames"]
    assert frames[0]["frame_title"].startswith("packed")
    assert {frame["frame_parent"] for frame in frames[1:]} == {1}


UNIT_II_ANGLES = np.tile([146.0889, 96.5766], 12)
"""Near a state on the way of unit II, whose loops close at exact sizes only, degrees."""


def rounded(file, decimals, turn=0.3):
    """Turn and round the points of a drawing (mm)."""
    data = json.loads(file.read_text())
    points = np.array(data["vertices_coords"]) @ [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
    data["vertices_coords"] = points.round(decimals).tolist()
    file.write_text(json.dumps(data))
    return file


def test_loops_that_close_at_exact_sizes_only_need_points_with_many_decimals(tmp_path):
    linkage = resolve("unit-ii", "none.sqlite").linkage
    closed, _ = close_within_stops(linkage, np.radians(UNIT_II_ANGLES))
    file = stated("unit-ii", np.degrees(closed.angles), tmp_path / "unit.fold")
    folded = resolve(str(file)).linkage.folded
    assert np.allclose(np.sort(folded), np.sort(closed.angles), atol=1e-6)
    packed = packed_of(json.loads(rounded(file, 4).read_text()))
    assert not packed.packed
    assert "close at exact sizes only: give points with more decimals" in packed.sentence


@pytest.mark.parametrize("decimals", [2, 4, 6])
@pytest.mark.parametrize("turn", [0.3, 1.1])
def test_panels_of_a_grid_are_moved_to_their_places(decimals, turn, tmp_path):
    angles = [40.107, 40.107, 180.0, 40.107, 40.107, 180.0]
    file = rounded(stated("element-6r", angles, tmp_path / "element.fold"), decimals, turn)
    linkage = resolve(str(file)).linkage
    assert np.allclose(np.sort(np.degrees(linkage.folded)), np.sort(angles))
    assert np.abs(linkage.closure(linkage.folded)[0]).max() < 1e-14
    assert (rank_at(linkage, linkage.folded).nullity, generic_rank(linkage).nullity) == (1, 1)


def test_a_state_in_which_closure_has_full_rank_is_locked(tmp_path):
    turns, letters = np.radians([50, 70, 60, 55, 65, 60]), "VMMVMM"
    polygons, creases = six_triangles(turns, letters)
    faces = {pair: Crease("top" if letter == "V" else "bottom") for pair, letter in creases.items()}
    linkage = Linkage(Pattern.from_polygons(polygons, faces, 0.05))
    local, _ = close_within_stops(linkage, np.array([0.9, 1.776, 1.316, 0.9, 1.825, 1.365]))
    changes = [
        (linkage.closure(local.angles + 1e-6 * way)[0] - linkage.closure(local.angles - 1e-6 * way)[0]) / 2e-6
        for way in np.eye(6)
    ]
    assert np.linalg.svd(np.array(changes), compute_uv=False)[-1] > 1e-3
    lock = lock_at(linkage, local.angles)
    assert (lock.order, lock.between, lock.exact) == (1, True, False)
    degrees = np.degrees(local.angles)
    marks = {
        pair: (letter, degrees[linkage.pattern.hinge_of(pair)] * (1 if letter == "V" else -1))
        for pair, letter in creases.items()
    }
    size = {"hcsearch:thickness": 0.05}
    (checked,) = check(written(tmp_path, drawing_of(polygons, marks, **size))).verdicts
    assert (checked.status, checked.dof, checked.dof_packed) == ("locked", 0, 0)
    assert "closure has full rank" in checked.locks["packed"]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_hinges_between_their_stops_leave_a_singular_end_either_way(sense):
    linkage = resolve("element-6r", "none.sqlite").linkage
    state = np.array([0.7, 0.7, math.pi, 0.7, 0.7, math.pi])
    end = EndClosure(linkage, state, group_of_all(loops_of(linkage)))
    assert not end.regular
    direction = end.direction(sense * np.array([1.0, 0.9, 0.0, 1.0, 0.9, 0.0]))
    assert np.abs(end.equations(direction)[0]).max() < 1e-12
    assert direction == pytest.approx(sense * np.array([1.0, 1.0, 0.0, 1.0, 1.0, 0.0]))


def test_a_design_is_checked_from_a_state_that_its_file_gives(tmp_path):
    linkage = resolve(MOVING, "none.sqlite").linkage
    states = plan_linkage_motion(linkage).states
    middle = states[len(states) // 2]
    (checked,) = check(str(stated(MOVING, np.degrees(middle), tmp_path / "design.fold"))).verdicts
    assert np.allclose(np.sort(checked.linkage.folded), np.sort(middle), atol=1e-6)
    assert checked.motion.margin is not None


def test_a_design_is_checked_from_packed_where_no_closed_state_is_near(tmp_path, capfd):
    count = resolve(MOVING, "none.sqlite").linkage.n_hinges
    file = stated(MOVING, np.linspace(20.0, 160.0, count), tmp_path / "design.fold")
    result = run_here(["show", str(file)], capfd)
    assert result.returncode == 0
    assert result.stderr.count("the design is checked from its packed states") == 1


CROSS = [
    [(float(x), float(y)), (x + w, float(y)), (x + w, y + h), (float(x), y + h)]
    for x, w, y, h in ((0, 1.0, 0, 1.0), (1, 1.3, 0, 1.0), (0, 1.0, 1, 1.1), (1, 1.3, 1, 1.1))
]
"""Two by two rectangles."""


def crossed(*angles):
    """The cross with fold angles of its creases 0 1, 0 2, 1 3 and 2 3 (degrees), three valleys and a mountain."""
    pairs, letters = [(0, 1), (0, 2), (1, 3), (2, 3)], "VMVV"
    return drawing_of(CROSS, dict(zip(pairs, zip(letters, angles, strict=True), strict=True)))


def test_a_state_in_the_cube_of_the_flat_one_is_no_lock():
    linkage = Linkage(packed_of(crossed(5, 0, 0, 0)).pattern)
    assert np.degrees(linkage.folded) == pytest.approx([2.5, 0.0, 0.0, 2.5], abs=0.01)
    assert np.count_nonzero(linkage.folded) == 2
    assert not enclose_ends(linkage, 100_000).proved


@pytest.mark.parametrize("angle", [-0.011, -0.4])
def test_a_state_that_is_nearly_flat_is_no_packed_state(angle):
    packed = packed_of(strip([2.0, 1.5, 1.8], [("M", angle), ("V", 0.0)]))
    assert not packed.packed


@pytest.mark.parametrize(
    ("marks", "message"),
    [
        ([("M", -30.0), ("F", 45.0)], r"has the fold angle 45, and a flat edge \(F\) has 0"),
        ([("M", -200.0), ("V", 10.0)], r"has the fold angle -200, and hinges turn by up to 180 degrees"),
    ],
)
def test_fold_angles_that_no_hinge_has_are_refused(marks, message):
    with pytest.raises(PatternError, match=message):
        packed_of(strip([2.0, 1.5, 1.8], marks))


@pytest.mark.parametrize("other", [90.0, 0.0])
def test_two_creases_of_one_hinge_have_one_fold_angle(other):
    whole = [(1.0, 0.0), (2.3, 0.0), (2.3, 2.1), (1.0, 2.1), (1.0, 1.0)]
    left = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], [(0.0, 1.0), (1.0, 1.0), (1.0, 2.1), (0.0, 2.1)]
    marks = {(0, 1): "F", (0, 2): ("V", 60.0), (1, 2): ("V", other)}
    with pytest.raises(PatternError, match=r"and another one on its line 60: give both the same"):
        packed_of(drawing_of([*left, whole], marks))


def test_the_drawing_of_the_packed_array_has_the_outlines_of_tilted_panels():
    squares = [[(float(k), 0.0), (k + 1.0, 0.0), (k + 1.0, 1.0), (float(k), 1.0)] for k in range(2)]
    size = {"frame_unit": "mm", "hcsearch:thickness": 0.1}
    linkage = Linkage(packed_of(drawing_of(squares, {(0, 1): ("V", 90.0)}, **size)).pattern)
    polygons = [
        [tuple(map(float, point.split(","))) for point in text.split()]
        for text in re.findall(r'class="stowed" points="([^"]*)"', stowed_drawing(linkage))
    ]
    spans = sorted(np.ptp(np.array(polygon), axis=0).round(2).tolist() for polygon in polygons)
    assert spans == [[0.1, 1.0], [0.1, 1.0], [1.0, 0.1], [1.0, 1.0]]


def test_states_in_which_thick_panels_penetrate_each_other_are_no_packed_state():
    packed = packed_of(strip([2.0, 2.0, 2.0, 2.0, 2.0], [("V", 90), ("V", 90), ("V", 90), ("V", 60)]))
    assert not packed.packed
    assert "penetrate each other" in packed.sentence


def test_no_certificate_begins_between_the_stops(tmp_path):
    squares = [[(float(k), 0.0), (k + 1.0, 0.0), (k + 1.0, 1.0), (float(k), 1.0)] for k in range(3)]
    file = written(tmp_path, with_form(drawing_of(squares, {(0, 1): "M", (1, 2): "V"}), [-90.0, 45.0]))
    with pytest.raises(HcsearchError, match=r"own\.fold states a packed state with hinges between 0 and 180 degrees"):
        prove(file, tmp_path / "path.json")
