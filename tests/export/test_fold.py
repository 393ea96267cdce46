"""FOLD files: laws of what is written, and that it reads back as what it was."""

import json
import math
from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings

from hcsearch.export import fold
from hcsearch.export.fold import cut_mesh_of
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.search.own_patterns.fold_reading import parse_fold
from tests.export.exports import DESIGN, MOVING, exported, folded, pattern_of, written


def same_pattern(one, two):
    """Whether two patterns are the same but for rounding to nanometres."""
    assert list(one.creases.items()) == list(two.creases.items())
    assert one.thickness == pytest.approx(two.thickness, abs=1e-12)
    assert one.loops == two.loops
    for facet, other in zip(one.facets, two.facets, strict=True):
        np.testing.assert_allclose(facet, other, atol=1e-12)


@given(folded())
@settings(max_examples=60)
def test_what_is_written_reads_back_as_the_same_pattern(value):
    same_pattern(pattern_of(parse_fold(written(value))), value.linkage.pattern)


@pytest.mark.parametrize("name", list(ASSEMBLIES))
def test_assemblies_read_back_as_they_were(name):
    value = exported(name)
    same_pattern(pattern_of(parse_fold(written(value))), value.linkage.pattern)


@given(folded())
@settings(max_examples=40)
def test_slits_are_pairs_of_borders_with_ends_of_their_own(value):
    pattern = value.linkage.pattern
    mesh = cut_mesh_of(pattern)
    assert len(set(map(frozenset, mesh.edges))) == len(mesh.edges)
    beside = Counter(frozenset(side) for face in mesh.faces for side in zip(face, (*face[1:], face[0]), strict=True))
    creases = len(pattern.creases)
    assert all(beside[frozenset(edge)] == 2 for edge in mesh.edges[:creases])
    assert all(beside[frozenset(edge)] == 1 for edge in mesh.edges[creases:])
    assert len(beside) == len(mesh.edges)
    # around each vertex faces hang together by creases: the sheet is a surface, a ring where no panels are merged
    for vertex in range(len(mesh.points)):
        around = [edge for edge in mesh.edges[creases:] if vertex in edge]
        assert len(around) in (0, 2)
    euler = len(mesh.points) - len(mesh.edges) + len(mesh.faces)
    assert euler == len(pattern.facets) - creases + sum(_closed(mesh, v) for v in range(len(mesh.points)))


def _closed(mesh, vertex):
    """Whether creases go all around a vertex."""
    return all(vertex not in edge for edge in mesh.edges[len(mesh.creases) :])


@given(folded())
@settings(max_examples=40)
def test_face_orders_are_the_layers_of_the_stacks(value):
    folding = value.case.folding
    stack = {panel: k for k, stack in enumerate(folding.stacks) for panel in stack}
    orders = {(f, g): s for f, g, s in fold.face_orders(value.linkage)}
    turned = {panel: sign for panel, (sign, _) in enumerate(folding.frames)}
    for f, g in combinations(range(value.circuit.n), 2):
        if stack[f] == stack[g]:
            above = 1 if folding.layers[f] > folding.layers[g] else -1
            assert orders.pop((f, g)) == above * turned[g]
    assert not orders


def test_panels_side_by_side_whose_ends_differ_in_the_last_bit_are_not_one_above_the_other():
    """GEOS 3.14 takes the one for all of the other."""
    linkage = exported("rectangle:012233230011:0").linkage
    assert {sign for *_, sign in fold.face_orders(linkage)} == {-1, 1}


@given(folded())
@settings(max_examples=40)
def test_the_folded_frame_keeps_each_face_and_lays_stacks_onto_each_other(value):
    pattern, mesh = value.linkage.pattern, cut_mesh_of(value.linkage.pattern)
    frame = fold.folded_frame(mesh, value.linkage)
    flat, folded_ = 1e3 * np.array(mesh.points), np.array(frame["vertices_coords"])
    for face in mesh.faces:
        a, b = flat[list(face)], folded_[list(face)]
        np.testing.assert_allclose(_distances(a), _distances(b), atol=1e-6)
    centres = [folded_[list(face)].mean(axis=0) for face in mesh.faces]
    for stack in value.case.folding.stacks:
        ends = np.array([centres[panel] for panel in stack])
        assert np.ptp(ends, axis=0).max() < 2e3 * pattern.size
    for panel, other in zip(value.case.folding.stacks[0], value.case.folding.stacks[0][1:], strict=False):
        one, two = (np.unique(folded_[list(mesh.faces[k])].round(4), axis=0) for k in (panel, other))
        assert len(np.unique(np.concatenate([one, two]), axis=0)) <= max(len(one), len(two)) + 2


def _distances(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


def test_a_slit_that_ends_inside_at_both_ends_has_a_point_in_the_middle_of_each_side():
    pattern = exported("unit-ii").linkage.pattern
    mesh = cut_mesh_of(pattern)
    corners = sum(map(len, pattern.facets))
    assert sum(map(len, mesh.faces)) == corners + 2 * 4
    slits = [pattern.segment(pair) for pair in pattern.edges if pair not in pattern.creases]
    middles = {tuple(0.5 * (a + b) for a, b in zip(*edge, strict=True)) for edge in slits}
    own = [point for point in mesh.points if min(math.dist(point, middle) for middle in middles) < 1e-9]
    assert len(own) == 8


def test_the_file_says_what_only_thick_panels_have():
    data = json.loads(written(exported(DESIGN, flat_pairs="hinged")))
    assert (data["file_spec"], data["frame_unit"], data["hcsearch:thickness"]) == (1.2, "mm", 6.0)
    assert data["hcsearch:notation"] == DESIGN
    folding = exported(DESIGN).case.folding
    assert data["edges_hcsearch:hingeFace"][:10] == list(folding.hinge_faces)
    assert data["edges_hcsearch:hinge"][:10] == [str(k) for k in range(10)]
    assert data["edges_hcsearch:crease"][:11] == [*range(10), None]
    assert data["edges_assignment"][:10] == ["F" if a == "flat" else a[0].upper() for a in folding.assignment]
    assert dict(zip(data["edges_assignment"], data["edges_foldAngle"], strict=True)) == {
        "V": 180,
        "M": -180,
        "F": 0,
        "B": 0,
    }


def test_frames_of_a_motion_are_its_states_by_the_middle_surfaces():
    value = exported(MOVING, by="path")
    data = json.loads(written(value))
    frames = data["file_frames"][2:]
    assert data["file_classes"] == ["singleModel", "animation"]
    assert [frame["hcsearch:pathShare"] for frame in frames] == value.replay.at.tolist()
    assert all((frame["frame_parent"], frame["frame_inherit"]) == (2, True) for frame in frames)
    faces = data["file_frames"][1]["faces_vertices"]
    flat = np.array(frames[-1]["vertices_coords"])
    np.testing.assert_allclose(flat[:, 2], 3.0, atol=1e-2)
    for frame in frames:
        coords = np.array(frame["vertices_coords"])
        for face in faces:
            np.testing.assert_allclose(_distances(coords[face]), _distances(flat[face]), atol=1e-6)
    packed = np.array(data["file_frames"][1]["vertices_coords"])
    np.testing.assert_allclose(packed, frames[0]["vertices_coords"], atol=1e-6)
    heights = {round(z / 3.0) for z in packed[:, 2]}
    assert heights == {1, 3, 5, 7, 9}
    angles = np.radians([frame["hcsearch:hingeAngles"] for frame in frames])
    np.testing.assert_allclose(angles, value.replay.angles, atol=1e-9)
    assert math.isclose(angles[0].max(), math.pi)
