"""Panels as solids, and the formats that hold them, read in plain Python."""

import io
import zipfile
from collections import Counter
from dataclasses import replace
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation, Slerp

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.folding import Folding, foldings
from hcsearch.export.glb import GLB_ANIMATION_SECONDS, glb_of
from hcsearch.export.panel_solids import panel_solid_of, placed_vertices, wanted_panels
from hcsearch.export.print_formats import stl_of, threemf_of
from hcsearch.export.step import step_of
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import RIGID_CREASE, VALLEY_CREASE, Pattern
from hcsearch.subjects.replay_sources import replay_of_path
from tests.export.cases import NAMES, case, merged, replay, volumes
from tests.export.gltf import Scene
from tests.strategies import circuits

SINGLE = 1e-6
"""What single precision leaves of volumes and places, relative or m."""


def volume_of(corners):
    """Volume within triangles, (n, 3, 3), that close: a sixth of a sum of triple products."""
    return float(np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0


def check_closed(solid):
    """Every edge of the mesh lies between two triangles, which run along it in opposite directions."""
    edges = Counter((a, b) for t in solid.triangles.tolist() for a, b in zip(t, (*t[1:], t[0]), strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)


def all_panel_solids(linkage):
    return [panel_solid_of(linkage.pattern, panel) for panel in range(linkage.n_panels)]


@given(circuits(even=True))
def test_solids_of_foldings_are_closed_and_have_the_volume_of_their_facets(circuit):
    for folding in foldings(circuit)[:1]:
        linkage = folding.linkage()
        for solid, volume in zip(all_panel_solids(linkage), volumes(linkage), strict=True):
            check_closed(solid)
            assert volume_of(solid.vertices[solid.triangles]) == pytest.approx(volume, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_solids_of_assemblies_and_of_merged_panels_are_closed(name):
    for linkage in (case(name)[0], merged()[0]):
        for solid, volume in zip(all_panel_solids(linkage), volumes(linkage), strict=True):
            check_closed(solid)
            assert volume_of(solid.vertices[solid.triangles]) == pytest.approx(volume, rel=1e-9)
            assert len(solid.outlines) == 1


def square(cell):
    x, y = cell
    return ((x, y), (x + 1.0, y), (x + 1.0, y + 1.0), (x, y + 1.0))


def ring():
    """Eight squares around a hole, all rigid but for one that folds."""
    cells = ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    creases = {(k, k + 1): RIGID_CREASE for k in range(7)} | {(0, 7): RIGID_CREASE, (2, 8): VALLEY_CREASE}
    return Pattern.from_polygons(tuple(map(square, (*cells, (3, 0)))), creases, 0.25)


def test_a_panel_with_a_hole_has_two_outlines_and_a_wall_that_carries_its_hinge():
    solid = panel_solid_of(ring(), 0)
    check_closed(solid)
    assert [len(walk) for walk in solid.outlines] == [12, 4]
    assert volume_of(solid.vertices[solid.triangles]) == pytest.approx(2.0)
    assert solid.sides.count("valley") == 1
    assert solid.points[solid.wall[solid.sides.index("valley")]].mean(axis=0) == pytest.approx([3.0, 0.5])
    text = step_of(Linkage(ring()), merged()[1], np.zeros(1))
    assert text.count("=FACE_BOUND(") == 2


def test_slits_inside_a_panel_are_closed():
    pattern = replace(ring(), creases={(k, k + 1): RIGID_CREASE for k in range(7)})
    assert panel_solid_of(pattern, 0).wall.tolist() == panel_solid_of(ring(), 0).wall.tolist()


def test_a_panel_that_touches_itself_in_a_corner_is_refused():
    cells = ((0, 0), (-1, 0), (-1, 1), (-1, 2), (0, 2), (1, 2), (1, 1))
    pattern = Pattern.from_polygons(tuple(map(square, cells)), {(k, k + 1): RIGID_CREASE for k in range(6)}, 0.1)
    with pytest.raises(HcsearchError, match="panel 0 touches itself in a corner"):
        panel_solid_of(pattern, 0)


def triangles_in(content):
    count = int.from_bytes(content[80:84], "little")
    assert len(content) == 84 + 50 * count
    records = np.frombuffer(content, np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]), offset=84)
    return records["n"].astype(float), records["c"].astype(float)


@pytest.mark.parametrize("name", NAMES)
def test_stl_holds_the_panels_in_their_state_in_millimetres(name):
    linkage, _ = case(name)
    content = stl_of(linkage, linkage.folded, name)
    assert not content.startswith(b"solid")
    normals, corners = triangles_in(content)
    assert 1e-9 * volume_of(corners) == pytest.approx(sum(volumes(linkage)), rel=SINGLE)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0, abs=SINGLE)
    points = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(linkage.folded)])
    assert 1e-3 * corners.min(axis=(0, 1)) == pytest.approx(points.min(axis=0), abs=SINGLE)
    assert 1e-3 * corners.max(axis=(0, 1)) == pytest.approx(points.max(axis=0), abs=SINGLE)
    _, one = triangles_in(stl_of(linkage, linkage.flat, name, (2,)))
    assert 1e-9 * volume_of(one) == pytest.approx(volumes(linkage)[2], rel=SINGLE)


@pytest.mark.parametrize("name", NAMES)
def test_3mf_places_an_object_for_each_panel_by_its_pose(name):
    linkage, labels = case(name)
    content = threemf_of(linkage, labels, linkage.folded, name)
    assert content == threemf_of(linkage, labels, linkage.folded, name)
    model = Xml.fromstring(zipfile.ZipFile(io.BytesIO(content)).read("3D/3dmodel.model"))
    space = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    assert model.get("unit") == "millimeter"
    poses = linkage.poses(linkage.folded)
    things, items = model.findall(".//m:object", space), model.findall(".//m:item", space)
    assert [thing.get("name") for thing in things] == [f"panel {panel}" for panel in labels.panels]
    for panel, (thing, item) in enumerate(zip(things, items, strict=True)):
        corners = np.array([[float(v.get(c)) for c in "xyz"] for v in thing.findall(".//m:vertex", space)])
        triangles = np.array(
            [[int(t.get(c)) for c in ("v1", "v2", "v3")] for t in thing.findall(".//m:triangle", space)]
        )
        assert 1e-9 * volume_of(corners[triangles]) == pytest.approx(volumes(linkage)[panel], rel=1e-9)
        numbers = np.array(item.get("transform").split(), float).reshape(4, 3)
        expected = 1e3 * placed_vertices(poses[panel], panel_solid_of(linkage.pattern, panel).vertices)
        assert corners @ numbers[:3] + numbers[3] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_glb_places_panels_at_all_times_as_the_linkage_does(name):
    linkage, labels = case(name)
    chance = np.random.default_rng(1)
    states = np.vstack([linkage.folded, chance.uniform(0.0, np.pi, (3, linkage.n_hinges)), linkage.flat])
    motion = replay(name, states)
    scene = Scene(glb_of(motion))
    assert scene.times[[0, -1]] == pytest.approx([0.0, GLB_ANIMATION_SECONDS])
    places = np.interp(scene.times, [0.0, GLB_ANIMATION_SECONDS], motion.at[[0, -1]])
    middles = 0.5 * (scene.times[:-1] + scene.times[1:])
    for time, place in [
        *zip(scene.times, places, strict=True),
        *((t, np.interp(t, scene.times, places)) for t in middles),
    ]:
        poses = linkage.poses(motion.at_time(np.array([place]))[0])
        corners_of = scene.vertices(time)
        assert set(corners_of) == {f"panel {panel}" for panel in labels.panels}
        for panel, label in enumerate(labels.panels):
            solid = panel_solid_of(linkage.pattern, panel)
            expected = placed_vertices(poses[panel], solid.vertices)
            apart = np.linalg.norm(corners_of[f"panel {label}"][:, None] - expected, axis=2)
            assert apart.min(axis=1).max() < SINGLE
            assert apart.min(axis=0)[solid.wall[:, 0]].max() < SINGLE


@pytest.mark.parametrize("name", ["square:0123:0", "rectangle:0123:0", "hex:0234550132:4", "unit-ii"])
def test_hinges_of_a_glb_turn_by_an_eighth_at_most_between_keys_and_keep_to_the_motion(name):
    linkage, labels = case(name)
    halfway = np.linspace(0.9, 0.1, linkage.n_hinges)[:, None] * [0.3, 1.0]
    motion = replay(name, np.vstack([linkage.folded, (halfway * np.pi).T, linkage.flat]))
    scene = Scene(glb_of(motion))
    times = np.linspace(0.0, GLB_ANIMATION_SECONDS, 101)
    angles = motion.at_time(np.interp(times, [0.0, GLB_ANIMATION_SECONDS], motion.at[[0, -1]]))
    assert len(scene.tracks) == linkage.n_panels - 1
    for number, (keys, turns) in scene.tracks.items():
        facts = scene.nodes[number]["extras"]
        dots = np.einsum("ki,ki->k", turns[:-1], turns[1:])
        assert np.rad2deg(2.0 * np.arccos(np.minimum(dots, 1.0))).max() < 45.01
        true = angles[:, labels.hinges.index(facts["hinge"])]
        # as viewers do that do not keep to the sphere: the four numbers for themselves
        plain = Rotation.from_quat(np.column_stack([np.interp(times, keys, part) for part in turns.T]))
        for turned, near in ((Slerp(keys, Rotation.from_quat(turns))(times), 1e-3), (plain, 0.15)):
            missed = turned * Rotation.from_rotvec(-true[:, None] * np.array(facts["axis"]))
            assert np.rad2deg(missed.magnitude()).max() < near


def test_glb_names_what_it_shows_and_has_faces_of_all_kinds():
    motion = replay("hex:0234550132:4", np.stack([case("hex:0234550132:4")[0].folded, np.zeros(8)]))
    document = Scene(glb_of(motion)).document
    assert document["extras"]["notation"] == "hex:0234550132:4"
    names = [node["name"] for node in document["nodes"]]
    assert {"panel 0+9", "panel 4+5", "hinge 0", "hinge 3"} <= set(names)
    left_out = document["extras"]["hinges_that_close_loops"]
    assert len(left_out) == 1
    assert not {f"hinge {name}" for name in left_out} & set(names)
    used = {p["material"] for mesh in document["meshes"] for p in mesh["primitives"]}
    assert {document["materials"][k]["name"] for k in used} == {"top", "bottom", "side", "valley", "mountain"}


def test_glb_calls_hinges_that_stay_flat_neither_mountain_nor_valley():
    linkage = Folding.from_notation("hex:0234550132:4").linkage(flat_pairs="hinged")
    motion = replay_of_path(linkage, np.stack([linkage.folded, linkage.flat]), "hinged", margin=None)
    extras = [node.get("extras", {}) for node in Scene(glb_of(motion)).document["nodes"]]
    folds = {own["hinge"]: own["crease"] for own in extras if "hinge" in own}
    assert {name for name, fold in folds.items() if fold == "flat"} == {"4", "9"} & set(folds)
    assert {"4", "9"} & set(folds)
    assert set(folds.values()) == {"flat", "mountain", "valley"}


def test_step_writes_numbers_with_points_and_quotes_doubled():
    linkage, labels = case("thesis-4x4")
    text = step_of(linkage, labels, linkage.folded, "it's 4x4 — é")
    assert text.startswith("ISO-10303-21;\n")
    assert text.endswith("END-ISO-10303-21;\n")
    assert "'it''s 4x4 ? ?'" in text
    assert text.isascii()
    entities = [line for line in text.splitlines() if line.startswith("#")]
    assert [int(line[1 : line.index("=")]) for line in entities] == list(range(1, len(entities) + 1))


def test_a_panel_is_named_as_pictures_name_it():
    labels = case("hex:0234550132:4")[1]
    assert wanted_panels(labels, "4+5") == (labels.panels.index("4+5"),)
    assert wanted_panels(labels, None) is None
    assert wanted_panels(labels, "4") == wanted_panels(labels, "4+5")
    with pytest.raises(HcsearchError, match=r"there is no panel 14: the panels are 0\+9, 1 to 3, 4\+5, 6 to 8"):
        wanted_panels(labels, "14")


def test_glb_says_where_the_motion_ends_and_where_panels_collide():
    linkage, labels = case(NAMES[0])
    motion = replay(NAMES[0], np.linspace(1.0, 0.0, 5)[:, None] * linkage.folded)
    short = replace(motion, angles=motion.angles + 0.5, collision=(0.25, (0, 2)))
    documents = [Scene(glb_of(value)).document for value in (motion, short)]
    assert [document["animations"][0]["name"] for document in documents] == [
        "packed to flat",
        "from packed, not as far as flat",
    ]
    assert [document["extras"]["ends_flat"] for document in documents] == [True, False]
    collision = {"at": 0.25, "panels": [labels.panels[0], labels.panels[2]]}
    assert [document["extras"]["collision"] for document in documents] == [None, collision]
