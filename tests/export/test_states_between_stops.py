"""States that files give between the stops of hinges: closed, planned from, deployed from, exported and read again."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import check, prove, save
from hcsearch.basics.errors import HcsearchError
from hcsearch.cases.resolve import resolve
from hcsearch.motion.kinematics.within_stops import close_within_stops
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.planning.ends import EndClosure
from hcsearch.motion.planning.motion_search import plan_linkage_motion
from hcsearch.motion.planning.problems import group_of_all, loops_of
from hcsearch.shape.labels import labels_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import Crease, Pattern
from tests.commands import run_here
from tests.export.exports import MOVING
from tests.export.test_any_panels import drawing_of, packed_of, strip, written
from tests.export.test_folded_forms import with_form


def stated(name, angles, path):
    """Write the pattern of an assembly or folding in a state that has the fold angles of some hinges (degrees)."""
    linkage = resolve(name, "none.sqlite").linkage
    (file,) = save(name, path, db="none.sqlite")
    data = json.loads(file.read_text())
    number = {label: k for k, label in enumerate(labels_of(linkage, design=":" in name).hinges)}
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


def test_a_stated_state_of_a_loop_is_closed_and_deploys(element):
    checked = check(str(element))
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


def test_a_drawing_rounded_where_loops_close_at_exact_sizes_only_keeps_its_state(tmp_path):
    angles = np.tile([146.0889, 96.5766], 12)
    linkage = resolve("unit-ii", "none.sqlite").linkage
    closed, _ = close_within_stops(linkage, np.radians(angles))
    file = stated("unit-ii", np.degrees(closed.angles), tmp_path / "unit.fold")
    folded = resolve(str(file)).linkage.folded
    assert np.allclose(np.sort(folded), np.sort(closed.angles), atol=1e-6)


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
    checked = check(written(tmp_path, drawing_of(polygons, marks, **size)))
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
    checked = check(str(stated(MOVING, np.degrees(middle), tmp_path / "design.fold")))
    assert np.allclose(np.sort(checked.linkage.folded), np.sort(middle), atol=1e-6)
    assert checked.motion.margin is not None


def test_a_design_is_checked_from_packed_where_no_closed_state_is_near(tmp_path, capfd):
    count = resolve(MOVING, "none.sqlite").linkage.n_hinges
    file = stated(MOVING, np.linspace(20.0, 160.0, count), tmp_path / "design.fold")
    result = run_here(["show", str(file)], capfd)
    assert result.returncode == 0
    assert result.stderr.count("the design is checked from its packed states") == 1


def test_states_in_which_thick_panels_penetrate_each_other_are_no_packed_state():
    packed = packed_of(strip([2.0, 2.0, 2.0, 2.0, 2.0], [("V", 90), ("V", 90), ("V", 90), ("V", 60)]))
    assert not packed.packed
    assert "penetrate each other" in packed.sentence


def test_no_certificate_begins_between_the_stops(tmp_path):
    squares = [[(float(k), 0.0), (k + 1.0, 0.0), (k + 1.0, 1.0), (float(k), 1.0)] for k in range(3)]
    file = written(tmp_path, with_form(drawing_of(squares, {(0, 1): "M", (1, 2): "V"}), [-90.0, 45.0]))
    with pytest.raises(HcsearchError, match=r"own\.fold states a packed state with hinges between 0 and 180 degrees"):
        prove(file, tmp_path / "path.json")
