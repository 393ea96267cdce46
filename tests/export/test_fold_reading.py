"""Drawings of other programs: what is read, what is recognised, and what is said of what is not."""

import cmath
import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.search.own_patterns.fold_reading import parse_fold, read_fold
from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design
from tests.export.exports import DESIGN, exported, folded, pattern_of, written
from tests.strategies import circuits, congruences


def drawn(circuit, letters, *, turn=0.0, scale=1.0, shift=(0.0, 0.0), size=(1.0, 1.0), **changes):
    """A circuit as a person draws it: an edge once, slits as C, and no faces."""
    places: dict[tuple[int, int], int] = {}
    coords, edges, marks = [], {}, {}
    for k, cell in enumerate(circuit.cells):
        corners = []
        for x, y in circuit.grid.corners(cell):
            key = (round(1e4 * x), round(1e4 * y))
            if key not in places:
                places[key] = len(coords)
                point = scale * cmath.rect(1.0, turn) * complex(size[0] * x, size[1] * y) + complex(*shift)
                coords.append([point.real, point.imag])
            corners.append(places[key])
        for side in zip(corners, [*corners[1:], corners[0]], strict=True):
            edges.setdefault(frozenset(side), []).append(k)
    n = circuit.n
    for side, beside in edges.items():
        marks[side] = "B" if len(beside) == 1 else "C"
        if len(beside) == 2 and (beside[1] - beside[0]) in (1, n - 1):
            marks[side] = letters[beside[0] if beside[1] - beside[0] == 1 else beside[1]]
    return {
        "file_spec": 1.1,
        "vertices_coords": coords,
        "edges_vertices": [sorted(side) for side in edges],
        "edges_assignment": [marks[side] for side in edges],
        **changes,
    }


def letters_of(folding):
    return "".join("F" if fold == "flat" else fold[0].upper() for fold in folding.assignment)


@st.composite
def drawings(draw):
    """A folding, and a drawing of it in any position, order, direction and scale, perhaps of the other side."""
    circuit = draw(circuits(even=True).filter(foldings))
    moved = draw(congruences(circuit))
    folding = draw(st.sampled_from(foldings(moved)))
    letters = letters_of(folding)
    if draw(st.booleans()):
        letters = letters.translate(str.maketrans("MV", "VM"))
    size = (5.0, 4.0) if circuit.grid.name == "rectangle" else (1.0, 1.0)
    turn = 0.0 if circuit.grid.name == "rectangle" else draw(st.floats(-4.0, 4.0))
    place = {"turn": turn, "scale": draw(st.floats(0.01, 100.0)), "shift": draw(st.tuples(*[st.floats(-50, 50)] * 2))}
    return circuit, folding, drawn(moved, letters, size=size, **place)


@given(drawings())
@settings(max_examples=80)
def test_a_drawing_in_any_position_is_recognised_with_its_folding(case):
    circuit, folding, data = case
    design = recognise_design(parse_fold(json.dumps(data)))
    assert design.circuit == circuit
    assert design.has_assignments
    # the same folding, up to the symmetries of the circuit
    kinds = sorted(letters_of(folding))
    assert len(design.creases) == 1
    assert sorted(letters_of(design.foldings[0])) in (
        kinds,
        sorted("".join(kinds).translate(str.maketrans("MV", "VM"))),
    )


@given(folded())
@settings(max_examples=40)
def test_files_of_this_program_are_recognised_however_flat_pairs_are_joined(value):
    drawing = parse_fold(written(value))
    design = recognise_design(drawing)
    assert design.circuit == value.circuit
    assert [value.case.folding] == list(design.foldings)
    panel = "50x40x6" if value.circuit.grid.name == "rectangle" else "50x50x6"
    assert drawn_panel_size(design, drawing) == panel


@pytest.mark.parametrize("axis", [0, 1])
def test_a_drawing_may_stand_upright_as_programs_with_y_upwards_write_it(axis):
    data = json.loads(written(exported(DESIGN)))
    data["vertices_coords"] = [[*p[:axis], 3.0, *p[axis:]] for p in data["vertices_coords"]]
    assert [folding.notation for folding in recognise_design(parse_fold(json.dumps(data))).foldings] == [DESIGN]
    data["vertices_coords"][0][axis] += 1.0
    with pytest.raises(HcsearchError, match="it is folded"):
        parse_fold(json.dumps(data))


def test_unassigned_creases_allow_every_folding():
    circuit = Circuit.from_notation("hex:0234435011")
    design = recognise_design(parse_fold(json.dumps(drawn(circuit, "U" * 10))))
    assert (design.has_assignments, design.creases) == (False, (1, 3, 4))
    data = drawn(circuit, "U" * 10)
    del data["edges_assignment"]
    with pytest.raises(HcsearchError, match=r"panel 1 at \(.*\) has 5 creases, to panels 0, 2, 3, 4, 5"):
        recognise_design(parse_fold(json.dumps(data)))


def test_fold_angles_stand_in_for_assignments():
    data = json.loads(written(exported(DESIGN)))
    del data["edges_assignment"]
    assert [folding.notation for folding in recognise_design(parse_fold(json.dumps(data))).foldings] == [DESIGN]
    del data["edges_foldAngle"], data["edges_vertices"]
    assert recognise_design(parse_fold(json.dumps(data))).creases == (1,)  # which the folded forms show
    del data["file_frames"]
    assert recognise_design(parse_fold(json.dumps(data))).creases == (1, 3, 4)


def test_edges_within_a_panel_and_points_on_edges_are_no_panels_of_their_own():
    square = {
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1], [0.5, 0], [0.5, 1]],
        "edges_vertices": [[0, 6], [6, 1], [1, 2], [2, 3], [3, 4], [4, 7], [7, 5], [5, 0], [1, 4], [6, 7]],
        "edges_assignment": [*"BBBBBBBB", "V", "J"],
    }
    drawing = parse_fold(json.dumps(square))
    assert [len(facet) for facet in drawing.facets] == [4, 4]
    assert [join.assignment for join in drawing.joins.values()] == ["V"]
    square["faces_vertices"] = [[0, 6, 7, 5], [6, 1, 4, 7], [1, 2, 3, 4]]
    assert [len(facet) for facet in parse_fold(json.dumps(square)).facets] == [4, 4]
    assert pattern_of(parse_fold(json.dumps({**square, "frame_unit": "cm"})), 0.002).area == pytest.approx(2e-4)


def test_a_sheet_drawn_from_below_is_turned_over():
    value = {
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "faces_vertices": [[0, 5, 4, 1], [1, 4, 3, 2]],
        "edges_vertices": [[1, 4]],
        "edges_assignment": ["V"],
    }
    drawing = parse_fold(json.dumps(value))
    assert [join.assignment for join in drawing.joins.values()] == ["V"]
    assert min(x for facet in drawing.facets for x, _ in facet) == -2


HEX = Circuit.from_notation("hex:012345")
DRAWN = Circuit.from_notation("hex:0234435011")
SQUARES = Circuit.from_notation("square:00112233")
UNASSIGNED = {key: value for key, value in drawn(HEX, "UUUUUU").items() if key != "edges_assignment"}
BENT = {"vertices_coords": [[0, 0], [3, 0], [0, 1]], "faces_vertices": [[0, 1, 2]]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is no FOLD file, which is JSON"),
        ("[" * 100_000, "is no FOLD file, which is JSON"),
        ("1" * 5000, "which is JSON: a number in it has thousands of digits; export it as FOLD"),
        ("[]", "it holds no object"),
        ("{}", "it has no vertices_coords"),
        ('{"vertices_coords": [[0, 0], [1, 0]]}', "neither edges nor faces"),
        (
            '{"vertices_coords": [[0, 0], [1e400, 0]], "edges_vertices": [[0, 1]]}',
            "vertex 1 in vertices_coords is not two",
        ),
        ('{"vertices_coords": [[0, 0], ["a", 0]], "edges_vertices": [[0, 1]]}', "is no sound FOLD file"),
        ('{"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": [[0, 2]]}', "2 is no vertex"),
        ('{"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": [[0, -1]]}', "-1 is no vertex"),
        ('{"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": 3}', "is no sound FOLD file"),
        ('{"vertices_coords": [[0, 0], [1, 0]], "faces_vertices": [[0, 1]]}', "is no polygon"),
        (
            '{"vertices_coords": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], "faces_vertices": [[0, 1, 2, 3]]}',
            "put the flat crease",
        ),
        ('{"file_frames": [7]}', "file_frames is not a list of frames"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"edges_assignment": ["B"] * 3}), "has 3 values for 30 edges"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"vertices_coords": [[0, 0], [1]]}), "vertex 1 in vertices_coords"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"vertices_coords": [[math.nan, 0]]}), "vertex 0 in vertices_coords"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"edges_vertices": [[0, 1, 2]]}), "edge 0 has not two ends"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"edges_vertices": [[True, 0]]}), "True is no vertex"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"faces_vertices": [[]]}), "face 0 is no polygon: it has 0 corners"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"hcsearch:thickness": -1}), "hcsearch:thickness is not a length"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"hcsearch:loops": [[1]]}), "hcsearch:loops are not lists of pairs"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"edges_vertices": [[0, 1]] * 200_001}), "more than 200000 values"),
        (json.dumps(UNASSIGNED | {"edges_foldAngle": ["up"] * 30}), "fold angle 'up', which is no number"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"edges_foldAngle": [10**400] * 30}), "fold angle 10*, which is no number"),
        (json.dumps(drawn(HEX, "VMVMVM") | {"vertices_coords": [[10**400, 0]]}), "vertex 0 in vertices_coords"),
        ('{"vertices_coords": [[0, 0], [1, 0], [1, 1]], "edges_vertices": [[0, 1], [1, 2]]}', "bound no panel"),
        (
            json.dumps(BENT),
            r"panel 0 at \(.*\) is no 30-60-90 triangle: draw equal equilateral triangles, rec",
        ),
        (json.dumps(drawn(HEX, "VMVMXM")), "assignment 'X'"),
        (json.dumps(drawn(DRAWN, "VMVMVMVMVM")), "of no two-stack folding"),
        (json.dumps(drawn(SQUARES, "VVCVVVVV")), "has one crease: a circuit has two"),
        (json.dumps(drawn(SQUARES, "UUUUUUUU") | {"edges_assignment": ["U"] * 24}), "has 3 creases"),
    ],
)
def test_what_is_no_design_is_said_in_one_line(text, message):
    with pytest.raises(HcsearchError, match=message) as error:
        recognise_design(parse_fold(text, "mine.fold"))
    assert "\n" not in str(error.value)


def test_two_closed_walks_are_no_circuit():
    one, two = drawn(HEX, "UUUUUU"), drawn(HEX, "UUUUUU", shift=(5 * math.sqrt(3), 0.0))
    count = len(one["vertices_coords"])
    both = {
        "vertices_coords": one["vertices_coords"] + two["vertices_coords"],
        "edges_vertices": one["edges_vertices"] + [[a + count, b + count] for a, b in two["edges_vertices"]],
        "edges_assignment": one["edges_assignment"] + two["edges_assignment"],
    }
    with pytest.raises(HcsearchError, match="more than one closed walk: one runs through 6 of 12 panels"):
        recognise_design(parse_fold(json.dumps(both)))


def test_panels_off_the_grid_are_no_tiling():
    data = drawn(SQUARES, "UUUUUUUU")
    coords = data["vertices_coords"]
    bent = [[x + 0.2 * y * y, y] for x, y in coords]
    with pytest.raises(HcsearchError, match="is no cell of the"):
        recognise_design(parse_fold(json.dumps({**data, "vertices_coords": bent})))
    rough = [[x + 1e-4 * (k % 3 - 1), y] for k, (x, y) in enumerate(coords)]
    assert recognise_design(parse_fold(json.dumps({**data, "vertices_coords": rough}))).circuit == SQUARES.canonical()


def test_files_that_are_not_there_are_said(tmp_path):
    with pytest.raises(HcsearchError, match="name a file that is there"):
        read_fold(str(tmp_path / "none.fold"))
