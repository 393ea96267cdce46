"""Drawings as other programs write them: every line with ends of its own, off by a little, split, crossed, tilted."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError, InputFileError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS
from hcsearch.search.own_patterns.drawn_lines import CrossingError, PointNumbers, in_plane, place_text, split_lines
from hcsearch.search.own_patterns.fold_reading import parse_fold, read_fold
from hcsearch.search.own_patterns.recognition import drawn_panel_size, recognise_design
from hcsearch.shape.mesh import without_spurs, without_straight_corners
from tests.export.test_fold_reading import drawn, letters_of
from tests.strategies import circuits

DRAWINGS = Path(__file__).parent / "drawings"
SIX = ("square:012230", (1,))
EXPECTED = {
    "base": SIX,
    "base_listed_faces": SIX,
    "crossing_lines": ("square:01222300", (0, 1, 2, 3)),
    "flat_tilted": SIX,
    "flat_with_noise": SIX,
    "frame_of_frame_1": SIX,
    "line_ends_in_listed_face": SIX,
    "line_ends_in_panel": SIX,
    "rounded_hexagons": ("hex:02333333333500000000", ()),
    "stray_line": SIX,
    "unsnapped_lines": SIX,
}


def base(**changes):
    return json.loads((DRAWINGS / "base.fold").read_text()) | changes


def read(data):
    design = recognise_design(parse_fold(json.dumps(data), "mine.fold"))
    return design.circuit.notation, design.creases


@pytest.mark.parametrize("name", EXPECTED)
def test_files_of_other_programs_show_the_design_that_a_person_sees(name):
    design = recognise_design(read_fold(str(DRAWINGS / f"{name}.fold")))
    assert (design.circuit.notation, design.creases) == EXPECTED[name]


def lines_of(data):
    points = data["vertices_coords"]
    return [
        ([points[a], points[b]], mark)
        for (a, b), mark in zip(data["edges_vertices"], data["edges_assignment"], strict=True)
    ]


def as_lines(lines):
    """A drawing in which every line has points of its own."""
    return {
        "vertices_coords": [list(point) for ends, _ in lines for point in ends],
        "edges_vertices": [[2 * k, 2 * k + 1] for k in range(len(lines))],
        "edges_assignment": [mark for _, mark in lines],
    }


def along(ends, share):
    return [a + share * (b - a) for a, b in zip(*ends, strict=True)]


def unsnapped(lines, rng, side):
    off = rng.choice([1e-5, 1e-4, 1e-3]) * side
    return as_lines([(np.array(ends) + rng.uniform(-off, off, (2, 2)), mark) for ends, mark in lines])


def in_parts(lines, rng, side):
    parts = []
    for ends, mark in lines:
        count = int(rng.integers(1, 6))
        parts += [([along(ends, k / count), along(ends, (k + 1) / count)], mark) for k in range(count)]
    return as_lines(parts)


def twice(lines, rng, side):
    """Some lines again, whole and backwards or a part of them."""
    again = [(lines[k][0][::-1], lines[k][1]) for k in rng.integers(0, len(lines), 4)]
    for k in rng.integers(0, len(lines), 4):
        first, last = sorted(rng.uniform(size=2))
        again.append(([along(lines[k][0], first), along(lines[k][0], last)], lines[k][1]))
    return as_lines([*lines, *again])


def with_specks(lines, rng, side):
    """More lines than there are others that are shorter than what a drawing may be off."""
    specks = []
    for k in rng.integers(0, len(lines), 2 * len(lines)):
        point = np.array(along(lines[k][0], rng.uniform()))
        way = rng.uniform(-1.0, 1.0, 2) * 10.0 ** rng.uniform(-6, -3.5) * side
        specks.append(([point, point + way], str(rng.choice(list("BUMV")))))
    return as_lines([*specks, *lines])


def tilted(lines, rng, side):
    """In any plane, with noise square to it, and points that no line uses."""
    data = as_lines(lines)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    noise = rng.uniform(-1e-3, 1e-3, (len(data["vertices_coords"]), 1)) * side
    points = np.column_stack([data["vertices_coords"], noise]) @ turn + 3.0 * side
    return data | {"vertices_coords": [*points.tolist(), *(rng.normal(size=(3, 3)) * 9.0 * side).tolist()]}


def overshooting(lines, rng, side):
    """Borders that go on a little beyond their ends."""
    longer = []
    for ends, mark in lines:
        out = 0.0 if mark != "B" else 2e-3
        longer.append(([along(ends, -out), along(ends, 1.0 + out)], mark))
    return as_lines(longer)


@pytest.mark.parametrize("change", [unsnapped, in_parts, twice, with_specks, tilted, overshooting])
@given(circuits(even=True).filter(foldings), st.data())
@settings(max_examples=15)
def test_a_drawing_that_is_changed_a_little_shows_the_same_folding(change, circuit, data):
    folding = data.draw(st.sampled_from(foldings(circuit)))
    side = data.draw(st.sampled_from([0.013, 1.0, 470.0]))
    rectangle = circuit.grid.name == "rectangle"
    turn = 0.0 if rectangle else data.draw(st.floats(-4.0, 4.0))
    plain = drawn(circuit, letters_of(folding), turn=turn, scale=side, size=(1.25, 1.0) if rectangle else (1.0, 1.0))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    design = recognise_design(parse_fold(json.dumps(change(lines_of(plain), rng, side))))
    words = [circuit]
    if rectangle and change is tilted:  # which side is the length is seen along the axes alone
        words.append(Circuit(circuit.grid, tuple((d + 1) % 4 for d in circuit.word)).canonical())
    assert design.circuit in words
    letters = [letters_of(own) for own in (folding, *design.foldings)]
    assert len(design.creases) == 1
    assert len({tuple(sorted(map(own.count, "MV"))) for own in letters}) == 1
    assert design.length == pytest.approx(side, rel=3e-3) or rectangle


def test_panels_that_touch_where_a_corner_has_two_images_are_not_joined():
    circuit = Circuit(GRIDS["kite"], (4, 3, 7, 10, 14, 19, 16, 14, 19, 23, 3, 7))
    folding = foldings(circuit)[0]
    lines = lines_of(drawn(circuit, letters_of(folding), turn=0.0, scale=0.013))
    drawing = parse_fold(json.dumps(unsnapped(lines, np.random.default_rng(493), 0.013)))
    assert len(drawing.joins) == circuit.n
    assert recognise_design(drawing).circuit == circuit


@pytest.mark.parametrize("turn", [0.0, 0.2254, 1.1, 2.9])
@pytest.mark.parametrize(("grid", "columns", "side"), [("hex", 9, 100.0), ("hex", 15, 60.0), ("square", 40, 60.0)])
def test_long_rows_that_are_rounded_are_read(grid, columns, side, turn):
    there, up, back, down = ("0", "1", "3", "4") if grid == "hex" else ("0", "1", "2", "3")
    word = there * (columns - 1) + up + back * (columns - 1) + down
    circuit = Circuit.from_notation(f"{grid}:{word}")
    data = drawn(circuit, "U" * circuit.n, turn=turn, scale=side)
    data["vertices_coords"] = [[round(x, 1) for x in point] for point in data["vertices_coords"]]
    design = recognise_design(parse_fold(json.dumps(data)))
    assert design.circuit == circuit.canonical()
    assert design.length == pytest.approx(side, rel=1e-3)


@pytest.mark.parametrize("columns", [4, 60])
def test_lines_across_the_whole_sheet_are_split_where_they_cross(columns):
    lines = [([[0, y], [columns, y]], "B") for y in (0, 2)] + [([[x, 0], [x, 2]], "B") for x in (0, columns)]
    lines += [([[x, 0], [x, 2]], "U") for x in range(1, columns)]
    lines += [([[0, 1], [1, 1]], "U"), ([[1, 1], [columns - 1, 1]], "C"), ([[columns - 1, 1], [columns, 1]], "U")]
    design = recognise_design(parse_fold(json.dumps(as_lines(lines))))
    assert design.circuit.array.canonical().n == 2 * columns
    assert design.length == pytest.approx(1.0)


def test_faces_may_have_spurs_and_sides_in_parts_and_run_in_either_sense():
    listed = json.loads((DRAWINGS / "line_ends_in_listed_face.fold").read_text())
    points, faces = listed["vertices_coords"], listed["faces_vertices"]
    assert faces[0] == [0, 12, 0, 1, 2, 3]
    faces[0] = [12, 0, 1, 2, 3, 0]
    faces[1] = faces[1][::-1]
    points.append([100.0, 50.0])  # on the edge between faces 0 and 1, at which face 0 alone has a corner
    faces[0].insert(2, 13)
    assert read(listed) == SIX


def test_frames_inherit_from_frames_that_inherit():
    pattern = base()
    del pattern["file_spec"]
    chain = [
        {"frame_classes": ["creasePattern"], "frame_inherit": True, "frame_parent": 2},
        {"frame_inherit": True, "frame_parent": 3, "frame_unit": "cm"},
        {key: pattern[key] for key in ("vertices_coords", "edges_vertices")} | {"frame_inherit": True},
    ]
    whole = {"file_spec": 1.1, "edges_assignment": pattern["edges_assignment"], "file_frames": chain}
    assert read(whole) == SIX
    assert parse_fold(json.dumps(whole)).unit == 0.01
    chain[2] |= {"frame_parent": 1}
    with pytest.raises(HcsearchError, match="frame 1 from frame 2 from frame 3 from frame 1 inherits in a circle"):
        read(whole)
    chain[2] |= {"frame_parent": 7}
    with pytest.raises(HcsearchError, match="frame 3 inherits from 7, which is no frame"):
        read(whole)
    chain[2] |= {"frame_inherit": False}
    with pytest.raises(HcsearchError, match=r"has \d creases|has one crease|has no crease"):
        read(whole)  # without the assignments of the key frame


def test_files_without_frames_and_with_one_unclassed_frame_are_read():
    assert read(base(file_frames=None)) == SIX
    pattern = base()
    assert read({"file_spec": 1.1, "file_frames": [pattern]}) == SIX
    folded = {"frame_classes": ["foldedForm"], "vertices_coords": [[0, 0, 0], [1, 0, 0], [0, 1, 1]]}
    assert read(folded | {"file_frames": [folded, pattern]}) == SIX


def test_frames_that_show_no_panels_are_passed_over():
    pattern = base()
    points = {"vertices_coords": pattern.pop("vertices_coords")}
    assert read(points | {"file_frames": [pattern | {"frame_inherit": True}]}) == SIX
    short = {"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": []}
    line = {"vertices_coords": [[0, 0], [1, 0]], "edges_vertices": [[0, 1]]}
    linkages = [line | {"frame_classes": [name]} for name in ("graph", "linkage")]
    for first in (short, *linkages):
        assert read(first | {"file_frames": [points | pattern]}) == SIX
    with pytest.raises(HcsearchError, match=r"^frame 1 of mine.fold is no flat pattern: its edges bound no panel"):
        read(short | {"file_frames": [line]})
    with pytest.raises(HcsearchError, match=r"^the first frame of mine.fold is no flat pattern: its edges bound no"):
        read(linkages[0] | {"file_frames": [{}]})
    with pytest.raises(HcsearchError, match=r"^frame 1 of mine.fold is no flat pattern: it has neither edges nor"):
        read({"edges_vertices": [[0, 1]], "file_frames": [short]})


@pytest.mark.parametrize("nothing", [None, []])
def test_keys_without_a_value_are_missing(nothing):
    assert read(base(edges_foldAngle=nothing, faces_vertices=nothing, frame_inherit=nothing)) == SIX
    child = {"frame_inherit": True, "frame_parent": nothing, "edges_assignment": nothing, "faces_vertices": nothing}
    assert read(base(file_frames=[child | {"frame_classes": ["creasePattern"]}])) == SIX
    unassigned = base()
    del unassigned["edges_assignment"]
    assert parse_fold(json.dumps(base(edges_assignment=nothing))) == parse_fold(json.dumps(unassigned))


@pytest.mark.parametrize(
    ("unit", "metres"),
    [("inch", 0.0254), ("MM", 1e-3), ("Millimeters", 1e-3), ("µm", 1e-6), ("ft", 0.3048), ("unit", None), (None, None)],
)
def test_units_are_understood_by_their_names(unit, metres):
    drawing = parse_fold(json.dumps(base(frame_unit=unit)))
    assert (drawing.unit, drawing.remarks) == (metres, ())


def test_a_unit_that_is_none_is_named():
    drawing = parse_fold(json.dumps(base(frame_unit="parsec")))
    assert drawing.unit is None
    assert drawn_panel_size(recognise_design(drawing), drawing) is None
    assert drawing.remarks == (
        "frame_unit 'parsec' is no unit of length: sizes are not taken from the file; write "
        "in, ft, pt, m, cm, mm, um, nm",
    )


def test_a_line_that_ends_nowhere_is_named():
    drawing = read_fold(str(DRAWINGS / "line_ends_in_panel.fold"))
    assert drawing.remarks == (
        "edge 17 from (100, 0) to (57, 53) ends at no other edge; lines that lead to no other are left out",
    )


def test_messages_name_edges_and_their_places():
    data = base()
    data["edges_vertices"].append([1, 0])
    data["edges_assignment"].append("M")
    with pytest.raises(HcsearchError, match=r"edge 17 \(M\) lies on edge 0, .* \(V\), from \(100, 0\) to \(100, 100\)"):
        read(data)
    data["edges_assignment"][-1] = "U"  # which says nothing
    assert read(data) == SIX
    folded = base()
    folded["vertices_coords"] = [[x, y, 30.0 * (k == 6)] for k, (x, y) in enumerate(folded["vertices_coords"])]
    with pytest.raises(HcsearchError, match=r"it is folded: vertex \d+ at \(.*\) is .* off the plane"):
        read(folded)


def test_places_are_rounded_to_a_thousandth_of_a_side():
    assert place_text([-7.105e-15, 3.553e-15], 50.0) == "(0, 0)"
    assert place_text([12345.67891, -0.5], 50.0) == "(12345.68, -0.5)"


@given(st.integers(0, 2**32))
def test_a_plane_keeps_distances_and_is_seen_from_above(seed):
    rng = np.random.default_rng(seed)
    flat = rng.normal(size=(9, 2))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    points = flat @ turn[:2] + 5.0
    own, off = in_plane(points)
    assert off.max() < 1e-12
    np.testing.assert_allclose(
        np.linalg.norm(own[:, None] - own, axis=2), np.linalg.norm(flat[:, None] - flat, axis=2), atol=1e-12
    )
    # the x and y of the plane with the way up make a right-handed frame
    basis = np.linalg.lstsq(points - points.mean(axis=0), own - own.mean(axis=0), rcond=None)[0].T
    normal = np.cross(basis[0], basis[1])
    assert normal[np.abs(normal).argmax()] > 0.0


def test_split_lines_meet_at_their_ends_only():
    points = np.array([[0, 0], [4, 0], [1, -1], [1, 1], [2, 0.001], [2, 3], [4, 0.001], [0, 0.0]])
    lines = [(0, 1), (2, 3), (4, 5), (6, 7), (0, 7)]
    split = split_lines(points, lines, 0.01, 100)
    ways = [[split.points[v] for v in way] for way in split.places_along]
    assert [len(way) for way in ways] == [4, 3, 2, 4, 0]
    assert ways[0] == ways[3][::-1]
    assert ways[0][1] == ways[1][1] == pytest.approx((1.0, 0.0), abs=1e-3)


def hatched(n):
    """n lines each way, a unit apart, each with loose ends of half a unit."""
    upright = [[k, y] for k in range(n) for y in (-0.5, n - 0.5)]
    edges = [[2 * k, 2 * k + 1] for k in range(2 * n)]
    points = upright + [[y, x] for x, y in upright]
    return {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": ["M"] * 2 * n}


def test_lines_that_bound_too_many_faces_are_refused_before_all_are_split(monkeypatch):
    numbered = []
    number = PointNumbers.number
    monkeypatch.setattr(PointNumbers, "number", lambda own, point: numbered.append(point) or number(own, point))
    assert len(parse_fold(json.dumps(hatched(32))).facets) == 31 * 31
    numbered.clear()
    message = "too many lines for a pattern: they cross at more than 3,600 places, and so bound more than 1,000 faces"
    with pytest.raises(InputFileError, match=message):
        parse_fold(json.dumps(hatched(300)))
    assert len(numbered) < 5000  # of 90,000 crossings


def test_lines_that_bound_no_faces_may_cross_more_often():
    points = np.array(hatched(70)["vertices_coords"])
    lines = hatched(70)["edges_vertices"]
    assert len(split_lines(points, lines, 0.01, 5000).points) == 70 * 70 + 280
    with pytest.raises(CrossingError, match="cross at more than 3,140 places"):
        split_lines(points, lines, 0.01, 5000, range(140))
    assert split_lines(points, lines, 0.01, 5000, range(70)).points  # these do not cross each other
    with pytest.raises(CrossingError, match="cross more than 4,000 times"):
        split_lines(points, lines, 0.01, 4000)


def test_a_speck_beside_a_corner_splits_neither_line_that_meets_there():
    points = np.array([[0, 0], [4, 0], [3, 1], [0.05, 0.007], [0.051, 0.007]])
    split = split_lines(points, [(3, 4), (0, 1), (0, 2)], 0.01, 100)
    assert [len(way) for way in split.places_along] == [0, 2, 2]


def test_spurs_and_straight_corners_are_taken_off():
    assert without_spurs([0, 9, 8, 9, 0, 1, 1, 2, 3]) == [0, 1, 2, 3]
    assert sorted(without_spurs([8, 9, 0, 1, 2, 3, 0, 9])) == [0, 1, 2, 3]
    assert without_spurs([0, 1, 0]) in ([0], [1])
    ring = [(math.cos(0.5 * math.pi * k), math.sin(0.5 * math.pi * k)) for k in range(4)]
    points = [tuple(along([ring[k // 50], ring[(k // 50 + 1) % 4]], k % 50 / 50)) for k in range(200)]
    assert without_straight_corners(range(200), points, 5e-3) == [0, 50, 100, 150]
