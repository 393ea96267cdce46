from xml.etree import ElementTree

import pytest

from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.shape.drawing import DRAWING_STYLES
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, Pattern
from hcsearch.shape.pattern_drawing import draw_pattern

SVG = "{http://www.w3.org/2000/svg}"


def subpaths(text):
    """Lines of each kind, each a list of points."""
    root = ElementTree.fromstring(text)
    drawn = {}
    for path in root.iter(f"{SVG}path"):
        lines = path.get("d").replace("z", "").split("M")[1:]
        drawn[path.get("class")] = [[tuple(map(int, p.split(","))) for p in line.split()] for line in lines]
    return root, drawn


def squares(*places):
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    return tuple(tuple((x + a, y + b) for a, b in corners) for x, y in places)


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_every_line_is_drawn_once_and_within_the_picture(name):
    pattern = ASSEMBLIES[name].build(ASSEMBLIES[name].defaults)
    root, drawn = subpaths(draw_pattern(pattern))
    faces = [(crease.face, crease.closes) for crease in pattern.creases.values()]
    assert len(drawn.get("valley", ())) == faces.count(("top", True))
    assert len(drawn.get("mountain", ())) == faces.count(("bottom", True))
    assert len(drawn.get("hinge", ())) == faces.count(("top", False)) + faces.count(("bottom", False))
    slits = [
        pair for pair in pattern.edges if pair not in pattern.creases and len({pattern.panel_of[k] for k in pair}) == 2
    ]
    assert len(drawn.get("slit", ())) == len(slits)
    assert len(drawn["panel"]) == len(pattern.panels)
    _, _, width, height = map(int, root.get("viewBox").split())
    assert all(0 <= x <= width and 0 <= y <= height for lines in drawn.values() for line in lines for x, y in line)
    assert root.find(f"{SVG}title").text == "pattern"
    assert all(path.get("stroke") == DRAWING_STYLES[path.get("class")]["stroke"] for path in root.iter(f"{SVG}path"))


def test_seen_from_above_with_y_upwards():
    pattern = Pattern.from_polygons(squares((0, 0), (0, 1)), {(0, 1): VALLEY_CREASE}, 0.1)
    _, drawn = subpaths(draw_pattern(pattern))
    lower, upper = drawn["panel"]
    assert min(y for _, y in lower) == max(y for _, y in upper)


def test_rigid_creases_are_not_drawn_and_edges_within_a_panel_neither():
    block = squares((0, 0), (1, 0), (1, 1), (0, 1))
    pattern = Pattern.from_polygons(block, {(0, 1): RIGID_CREASE, (1, 2): RIGID_CREASE, (2, 3): RIGID_CREASE}, 0.1)
    _, drawn = subpaths(draw_pattern(pattern))
    (outline,) = drawn["panel"]
    assert set(drawn) == {"panel"}
    assert len(outline) == 8  # corners and middles of the block's sides


def test_a_panel_around_a_hole_has_two_outlines():
    ring = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    creases = {(k, k + 1): RIGID_CREASE for k in range(7)}
    _, drawn = subpaths(draw_pattern(Pattern.from_polygons(squares(*ring), creases, 0.1)))
    assert sorted(map(len, drawn["panel"])) == [4, 12]


def test_flat_hinges_and_titles():
    pattern = Pattern.from_polygons(
        squares((0, 0), (1, 0), (2, 0)), {(0, 1): Crease("top", closes=False), (1, 2): MOUNTAIN_CREASE}, 0.1
    )
    root, drawn = subpaths(draw_pattern(pattern, "a < b"))
    assert {kind: len(lines) for kind, lines in drawn.items()} == {"panel": 3, "hinge": 1, "mountain": 1}
    assert root.find(f"{SVG}title").text == "a < b"
