"""Sheets: areas, closed outlines, layers and colours, as independent readers see them."""

import re
import xml.etree.ElementTree as ET
from collections import Counter, defaultdict

import pytest
import shapely
from hypothesis import given
from hypothesis import settings as profile
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError, HcsearchWarning
from hcsearch.export.cutting_sheets import SHEET_LAYERS, SHEET_MARGIN, chained_edges, digit_strokes
from hcsearch.export.settings import ExportSettings
from hcsearch.library.assemblies import ASSEMBLIES
from tests.export.exports import DESIGN, MOVING, RING, SLITTED, exported, folded, sheet_for, written

SVG = "{http://www.w3.org/2000/svg}"


def drawn(text):
    """Polylines of an SVG by layer: points in millimetres, y downwards, and whether they are closed."""
    root = ET.fromstring(text)
    width, height = (float(re.fullmatch(r"([\d.]+)mm", root.get(name))[1]) for name in ("width", "height"))
    assert list(map(float, root.get("viewBox").split())) == [0, 0, width, height]
    lines = defaultdict(list)
    for group in root.iter(f"{SVG}g"):
        for path in group.iter(f"{SVG}path"):
            points = [tuple(map(float, pair)) for pair in re.findall(r"(-?[\d.]+) (-?[\d.]+)", path.get("d"))]
            assert all(-1e-9 <= x <= width and -1e-9 <= y <= height for x, y in points)
            lines[group.get("id")].append((points, path.get("d").endswith("Z"), path.get("data-label")))
    return lines


def area_of(lines):
    """The area within closed outlines; holes lie in others."""
    assert all(closed for _, closed, _ in lines)
    covered = shapely.Polygon()
    for points, _, _ in lines:
        covered = covered.symmetric_difference(shapely.Polygon(points))
    return covered.area


@given(folded(), st.sampled_from((0.0, 0.2, 1.0)))
@profile(max_examples=25)
def test_panels_apart_have_the_area_of_the_pattern_less_the_kerf(value, kerf):
    lines = drawn(written(value, "svg", ExportSettings(sheet="panels", kerf_mm=kerf)))
    pattern = value.linkage.pattern
    outlines = [shapely.Polygon(points) for points, closed, _ in lines["CUT"] if closed]
    assert len(outlines) == len(lines["CUT"]) == len(pattern.panels)
    kept = [outline.buffer(-0.5 * kerf, join_style="mitre", mitre_limit=10) for outline in outlines]
    assert sum(outline.area for outline in kept) == pytest.approx(1e6 * pattern.area, rel=1e-5)
    # none lies on another one
    assert shapely.union_all(outlines).area == pytest.approx(sum(outline.area for outline in outlines), rel=1e-9)
    assert sorted(label for _, _, label in lines["CUT"]) == sorted(value.labels.panels)


@given(folded())
@profile(max_examples=25)
def test_the_sheet_in_one_piece_has_every_edge_once(value):
    lines = drawn(written(value, "svg"))
    pattern = value.linkage.pattern
    assert area_of(lines["CUT"]) == pytest.approx(1e6 * pattern.area, rel=1e-5)
    folds = Counter(crease.face for crease in pattern.creases.values() if crease.closes)
    assert (len(lines["VALLEY"]), len(lines["MOUNTAIN"])) == (folds["top"], folds["bottom"])
    marks = Counter(crease.face for crease in pattern.creases.values() if crease.face and not crease.closes)
    assert (len(lines["HINGE_TOP"]), len(lines["HINGE_BOTTOM"])) == (marks["top"], marks["bottom"])
    length = 1e3 * sum(
        shapely.LineString(pattern.segment(pair)).length
        for pair in pattern.edges
        if pair not in pattern.creases and pattern.panel_of[pair[0]] != pattern.panel_of[pair[1]]
    )
    assert sum(shapely.LineString(points).length for points, _, _ in lines["SLIT"]) == pytest.approx(length, rel=1e-5)
    assert not any(closed for layer in SHEET_LAYERS[1:] for _, closed, _ in lines[layer])


@pytest.mark.parametrize("name", list(ASSEMBLIES))
def test_sheets_of_assemblies_have_their_area(name):
    value = exported(name)
    area = pytest.approx(1e6 * value.linkage.pattern.area, rel=1e-5)
    assert area_of(drawn(written(value, "svg"))["CUT"]) == area
    outlines = drawn(written(value, "svg", ExportSettings(sheet="panels")))["CUT"]
    assert len(outlines) >= value.linkage.n_panels
    assert area_of(outlines) == area


def test_holes_shrink_by_the_kerf_and_the_outline_grows():
    ring = exported(RING)
    plain, wide = (drawn(written(ring, "svg", ExportSettings(kerf_mm=kerf)))["CUT"] for kerf in (0.0, 1.0))
    areas = [sorted(shapely.Polygon(points).area for points, _, _ in lines) for lines in (plain, wide)]
    assert areas[0] == pytest.approx([100**2, 200**2])
    assert areas[1] == pytest.approx([99**2, 201**2])


def test_a_hinge_gap_takes_half_of_it_off_panels_along_hinges():
    value = exported(SLITTED, flat_pairs="hinged")
    outlines = drawn(written(value, "svg", ExportSettings(sheet="panels", hinge_gap_mm=2.0)))["CUT"]
    assert len(outlines) == 12
    turns = [value.circuit.turns[int(label)] for _, _, label in outlines]
    # a hinge on each of two sides: opposite ones of a panel that the circuit runs straight through
    for turn, (points, _, _) in zip(turns, outlines, strict=True):
        assert shapely.Polygon(points).area == pytest.approx(50 * 48 if turn == 0 else 49 * 49)


def test_a_gap_that_is_too_wide_is_refused():
    with pytest.raises(HcsearchError, match=r"leaves panel 0\+1 not in one piece"):
        sheet_for(exported(SLITTED), ExportSettings(sheet="panels", hinge_gap_mm=200.0))


@pytest.mark.parametrize(("name", "gap"), [(MOVING, 60.0), ("triangle:012343454545012121:2", 20.0), ("unit-ii", 5.0)])
def test_marks_and_numbers_stay_on_panels_that_a_gap_trims(name, gap):
    sheet = sheet_for(exported(name), ExportSettings(sheet="panels", hinge_gap_mm=gap))
    panels = shapely.union_all([shapely.Polygon(line.points) for line in sheet.lines["CUT"]])
    marks = [line for layer in ("HINGE_TOP", "HINGE_BOTTOM", "ENGRAVE") for line in sheet.lines[layer]]
    assert all(panels.covers(shapely.LineString(line.points)) for line in marks)


def test_a_kerf_that_closes_a_hole_is_refused():
    # around a hole of an edge of 0.5 mm
    with pytest.warns(HcsearchWarning, match="a side of less than 5 mm"):
        ring = exported(RING, panel="0.5x0.06")
    assert len(sheet_for(ring, ExportSettings(kerf_mm=0.9)).lines["CUT"]) == 2
    with pytest.raises(HcsearchError, match=r"a kerf of 1\.1 mm closes a hole or a notch"):
        sheet_for(ring, ExportSettings(kerf_mm=1.1))


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"hinge_gap_mm": 1.0}, "add --sheet panels"),
        ({"profile": "simulator", "sheet": "panels"}, "leave out --sheet"),
        ({"profile": "simulator", "kerf_mm": 0.1}, "leave out --sheet and --kerf"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(given_, message):
    with pytest.raises(HcsearchError, match=message):
        sheet_for(exported(DESIGN), ExportSettings(**given_))


def test_the_simulator_has_its_colours_and_no_groups():
    root = ET.fromstring(written(exported(DESIGN, flat_pairs="hinged"), "svg", ExportSettings(profile="simulator")))
    lines = [child for child in root if child.tag != f"{SVG}title"]
    assert {child.tag for child in lines} == {f"{SVG}line"}
    assert Counter(child.get("stroke") for child in lines) == {
        "#000000": 26,
        "#00ff00": 7,
        "#ff0000": 4,
        "#0000ff": 4,
        "#ff00ff": 2,
    }


def test_panels_apart_have_marks_on_the_face_of_each_hinge():
    value = exported(DESIGN)
    sheet = sheet_for(value, ExportSettings(sheet="panels"))
    faces = value.case.folding.hinge_faces
    for layer, face in (("HINGE_TOP", "top"), ("HINGE_BOTTOM", "bottom")):
        own = [str(k) for k in range(10) if faces[k] == face and k not in (1, 6)]
        assert sorted(line.label for line in sheet.lines[layer]) == sorted(own * 2)
    assert not sheet.lines["SLIT"]
    panels = {line.label: shapely.Polygon(line.points) for line in sheet.lines["CUT"]}
    assert set(panels) == {"0", "1+2", "3", "4", "5", "6+7", "8", "9"}
    marks = [line for layer in ("HINGE_TOP", "HINGE_BOTTOM", "ENGRAVE") for line in sheet.lines[layer]]
    whole = shapely.union_all(list(panels.values()))
    assert all(whole.covers(shapely.LineString(line.points)) for line in marks)
    assert min(x for lines in sheet.lines.values() for line in lines for x, _ in line.points) == pytest.approx(
        SHEET_MARGIN
    )


def test_edges_are_joined_to_lines_as_long_as_they_go():
    path = [((0, 0), (1, 0)), ((2, 0), (1, 0)), ((2, 0), (3, 0)), ((2, 0), (2, 1))]
    assert sorted(map(len, chained_edges(path))) == [2, 2, 3]
    ring = [((0, 0), (1, 0)), ((1, 0), (1, 1)), ((1, 1), (0, 0))]
    (closed,) = chained_edges(ring)
    assert closed[0] == closed[-1]
    assert len(closed) == 4


def test_numbers_are_as_high_as_they_should_be_and_about_their_point():
    points = [point for stroke in digit_strokes("10+8", (3.0, -1.0), 2.0) for point in stroke]
    assert {min(y for _, y in points), max(y for _, y in points)} == {-2.0, 0.0}
    assert min(x for x, _ in points) + max(x for x, _ in points) == pytest.approx(6.0, abs=0.2)
    assert len(digit_strokes("6", (0, 0), 1.0, underlined=True)) == len(digit_strokes("6", (0, 0), 1.0)) + 1
