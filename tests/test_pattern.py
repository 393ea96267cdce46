"""Flat patterns: facets, panels, hinges, moving and laying together."""

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import PatternError
from hcsearch.designs.folding import foldings
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import components, facet_area
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, Pattern, overlay
from tests.strategies import circuits


def size(grid, unit=1.0):
    """Panels of 50 mm, or 50 x 40 mm, and 6 mm thick."""
    return (0.05 * unit, (0.04 if grid.name == "rectangle" else 0.05) * unit, 0.006 * unit)


def square(x, y, side=1.0):
    return ((x, y), (x + side, y), (x + side, y + side), (x, y + side))


DIAMOND = ((0.5, 0.0), (1.0, 0.5), (0.5, 1.0), (0.0, 0.5))


def row(n, creases, thickness=0.1):
    """Squares side by side, joined in turn."""
    return Pattern.from_polygons(
        tuple(square(float(k), 0.0) for k in range(n)), {(k, k + 1): c for k, c in enumerate(creases)}, thickness
    )


@given(st.integers(1, 12).flatmap(lambda n: st.tuples(st.just(n), st.sets(st.tuples(*2 * [st.integers(0, n - 1)])))))
def test_components_are_those_of_networkx(drawn):
    n, pairs = drawn
    graph = nx.empty_graph(n)
    graph.add_edges_from(pairs)
    assert components(range(n), pairs) == list(nx.connected_components(graph))


def test_rigid_creases_make_panels():
    pattern = row(4, [RIGID_CREASE, VALLEY_CREASE, RIGID_CREASE])
    assert pattern.panels == ((0, 1), (2, 3))
    assert pattern.panel_of == (0, 0, 1, 1)
    (hinge,) = pattern.hinges
    assert (hinge.first, hinge.second, hinge.face) == (0, 1, "top")
    assert {hinge.start, hinge.end} == {(2.0, 0.0), (2.0, 1.0)}
    assert pattern.kutzbach == 1
    assert pattern.area == pytest.approx(4.0)


def test_creases_between_two_panels_on_one_line_are_one_hinge():
    facets = (*(square(float(x), 0.0) for x in range(2)), *(square(float(x), 1.0) for x in range(2)))
    pattern = Pattern.from_polygons(
        facets, {(0, 1): RIGID_CREASE, (2, 3): RIGID_CREASE, (0, 2): VALLEY_CREASE, (1, 3): VALLEY_CREASE}, 0.1
    )
    (hinge,) = pattern.hinges
    assert math.dist(hinge.start, hinge.end) == pytest.approx(2.0)
    assert pattern.hinge_of((0, 2)) == pattern.hinge_of((3, 1)) == 0
    other_faces = pattern.with_creases({(1, 3): MOUNTAIN_CREASE})
    assert len(other_faces.hinges) == 2


def test_the_first_panel_of_a_hinge_lies_on_its_left():
    for hinge in (row(2, [VALLEY_CREASE]).hinges[0], row(2, [MOUNTAIN_CREASE]).moved(math.pi).hinges[0]):
        assert (hinge.first, hinge.second) == (0, 1)
    up = row(2, [VALLEY_CREASE]).hinges[0]
    assert up.end[1] > up.start[1]
    down = row(2, [VALLEY_CREASE]).moved(math.pi).hinges[0]
    assert down.end[1] < down.start[1]


@pytest.mark.parametrize(
    ("make", "remedy"),
    [
        (lambda: row(2, [VALLEY_CREASE], thickness=0.0), "positive thickness"),
        (
            lambda: Pattern.from_polygons((square(0.0, 0.0), square(5.0, 0.0)), {(0, 1): VALLEY_CREASE}, 0.1),
            "neighbours, given in rising order",
        ),
        (lambda: overlay([row(2, [VALLEY_CREASE]), row(2, [MOUNTAIN_CREASE])]), "different ways"),
        (lambda: overlay([row(2, [VALLEY_CREASE]), row(2, [VALLEY_CREASE], thickness=0.2)]), "one"),
        (lambda: overlay([row(1, []), Pattern.from_polygons((DIAMOND,), {}, 0.1)]), "coincide, or lie apart"),
        (lambda: Pattern.from_polygons((square(0.0, 0.0), square(0.0, 0.0)), {}, 0.1).edges, "overlap"),
    ],
)
def test_what_cannot_be_made_is_one_line_with_a_remedy(make, remedy):
    with pytest.raises(PatternError, match=remedy) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_corners_that_differ_by_rounding_are_one_vertex():
    third = 1 / 3
    pattern = Pattern.from_polygons(
        (square(0.0, 0.0, third), square(third + 1e-12, -1e-12, third)), {(0, 1): VALLEY_CREASE}, 0.1
    )
    assert len(pattern.vertices) == 6
    assert pattern.faces == ((0, 1, 2, 3), (1, 4, 5, 2))
    assert pattern.edges == {(0, 1): (1, 2)}
    assert pattern.segment((0, 1)) == ((third, 0.0), (third, third))
    apart = (square(0.0, 0.0, third), square(third + 1e-6, 0.0, third))
    assert len(Pattern.from_polygons(apart, {}, 0.1).vertices) == 8


@pytest.mark.parametrize("faces", [((0, 1, 2), (1, 3, 2)), ((0, 1, 5),), ((0, 1, 3),)])
def test_faces_name_every_vertex_and_no_other(faces):
    vertices = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0))
    if len(faces) == 2:
        assert Pattern(vertices, faces, {(0, 1): VALLEY_CREASE}, 0.1).facets[1] == ((1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    else:
        with pytest.raises(PatternError, match="numbers 0 to 3"):
            Pattern(vertices, faces, {}, 0.1)


def test_the_outline_of_a_panel_leaves_out_what_lies_between_its_facets():
    ring = ((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    creases = {(k, k + 1): RIGID_CREASE for k in range(7)}  # the slit between the first and the last is closed, too
    pattern = Pattern.from_polygons([square(float(x), float(y)) for x, y in (*ring, (3, 0))], creases, 0.1)
    (outer, hole), (alone,) = pattern.outlines
    assert [len(outer), len(hole), len(alone)] == [12, 4, 4]
    assert [_area(pattern, walk) for walk in (outer, hole, alone)] == pytest.approx([9.0, -1.0, 1.0])


@given(st.data())
def test_outlines_enclose_the_area_of_their_panels(data):
    circuit = data.draw(circuits(even=True).filter(foldings))
    pattern = data.draw(st.sampled_from(foldings(circuit))).pattern(
        size(circuit.grid), flat_pairs=data.draw(st.sampled_from(["rigid", "merged"]))
    )
    for panel, outline in zip(pattern.panels, pattern.outlines, strict=True):
        area = pattern.area * len(panel) / circuit.n
        assert sum(_area(pattern, walk) for walk in outline) == pytest.approx(area)


def _area(pattern, walk):
    return facet_area([pattern.vertices[v] for v in walk])


@given(st.data())
def test_a_folding_has_the_vertices_that_its_corners_have(data):
    circuit = data.draw(circuits(even=True).filter(foldings))
    pattern = foldings(circuit)[0].pattern(size(circuit.grid))
    found = Pattern.from_polygons(pattern.facets, pattern.creases, pattern.thickness)
    assert (found.vertices, found.faces) == (pattern.vertices, pattern.faces)


def test_a_hinge_within_a_panel_is_refused():
    facets = (square(0.0, 0.0), square(1.0, 0.0), square(1.0, 1.0), square(0.0, 1.0))
    rigid = {(0, 1): RIGID_CREASE, (1, 2): RIGID_CREASE, (2, 3): RIGID_CREASE}
    with pytest.raises(PatternError, match="one panel"):
        Pattern.from_polygons(facets, {**rigid, (0, 3): VALLEY_CREASE}, 0.1)


def test_laying_a_pattern_onto_itself_changes_nothing():
    pattern = row(3, [VALLEY_CREASE, MOUNTAIN_CREASE])
    assert overlay([pattern, pattern]) == pattern


def test_overlay_merges_what_coincides():
    first = row(3, [VALLEY_CREASE, RIGID_CREASE])
    second = row(3, [RIGID_CREASE, MOUNTAIN_CREASE]).moved(shift=(1.0, 0.0))
    union = overlay([first, second])
    assert union.panels == ((0,), (1, 2), (3,))
    assert [hinge.face for hinge in union.hinges] == ["top", "bottom"]


@given(st.data())
def test_panels_of_a_folding_follow_its_circuit(data):
    circuit = data.draw(circuits(even=True).filter(foldings))
    folding = data.draw(st.sampled_from(foldings(circuit)))
    hinged = folding.pattern(size(circuit.grid), flat_pairs="hinged")
    assert len(hinged.panels) == len(hinged.hinges) == circuit.n
    assert hinged.kutzbach == 6 * (circuit.n - 1) - 5 * circuit.n
    assert [hinge.face for hinge in hinged.hinges] == list(folding.hinge_faces)
    rigid = folding.pattern(size(circuit.grid))
    assert len(rigid.panels) == circuit.n - 2
    # two dominoes of squares meet along one line
    assert len(rigid.hinges) == (circuit.n - 2 if circuit.n > 4 else 1)


@given(st.data())
def test_moving_a_pattern_moves_its_panels_along(data):
    """The sheet turned, shifted or turned over is the same linkage: folded alike, all distances are the same."""
    circuit = data.draw(circuits(even=True).filter(foldings))
    pattern = data.draw(st.sampled_from(foldings(circuit))).pattern(size(circuit.grid))
    shift = data.draw(st.tuples(st.floats(-1, 1), st.floats(-1, 1)))
    moved = pattern.moved(data.draw(st.floats(-4, 4)), shift, over=data.draw(st.booleans()))
    angles = np.linspace(0.1, 1.0, len(pattern.hinges))
    one, two = (_centres(Linkage(p).solids(angles)) for p in (pattern, moved))
    assert one == pytest.approx(two, abs=1e-9)


def _centres(solids):
    """Distances between the middles of all facets."""
    middles = np.array([solid.mean(axis=(0, 1)) for solid in solids])
    return np.linalg.norm(middles[:, None] - middles, axis=2)


def test_a_crease_turned_over_twice_is_itself():
    for crease in (VALLEY_CREASE, MOUNTAIN_CREASE, RIGID_CREASE, Crease("top", closes=False)):
        assert crease.inverted.inverted == crease
    assert VALLEY_CREASE.inverted == MOUNTAIN_CREASE
