import math
import re
import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.search.enumeration import enumerate_circuits
from hcsearch.shape.drawing import DRAWING_STYLES, LINE_PIXELS, draw_array, draw_circuit, stylesheet

SIZES = {
    "hex": (6, 8, 10),
    "square": (8, 10, 12),
    "rectangle": (8, 10),
    "triangle": (10, 14, 18),
    "rhombus": (10, 12),
    "kite": (6, 8, 10),
    "right45": (8, 12, 14),
    "right30": (8, 12),
    "obtuse": (12, 16),
}
CIRCUITS = [
    circuit for grid, sizes in SIZES.items() for n in sizes for circuit in enumerate_circuits(grid, n=n, limit=50)
]
circuits = st.sampled_from(CIRCUITS)


def pieces(svg: str, kind: str) -> list[list[tuple[float, float]]]:
    """Corners of the subpaths of one class, as a browser reads them."""
    match = re.search(rf'class="{kind}"[^>]* d="([^"]*)"', svg)
    lines = []
    for part in re.findall(r"M[^M]+", match[1] if match else ""):
        numbers = list(map(int, re.findall(r"-?\d+", part)))
        x, y = numbers[:2]
        line = [(x, y)]
        for dx, dy in zip(numbers[2::2], numbers[3::2], strict=True):
            x, y = x + dx, y + dy
            line.append((x, y))
        lines.append(line)
    return lines


def middle(line):
    return sum(x for x, _ in line) / len(line), sum(y for _, y in line) / len(line)


def extent(line) -> tuple[float, float]:
    (a, b), (c, d) = line[0], line[-1]
    return c - a, d - b


def draw(circuit: Circuit, assignment=None, **options) -> str:
    return draw_circuit(circuit.grid, circuit.cells, assignment, **options)


@given(circuits)
def test_hinges_and_slits_are_those_of_the_circuit(circuit):
    svg = draw(circuit)
    ET.fromstring(svg)
    assert len(pieces(svg, "panel")) == circuit.n
    assert len(pieces(svg, "hinge")) == circuit.n
    assert len(pieces(svg, "slit")) == len(circuit.array.edges()) - circuit.n
    assert len(pieces(svg, "circuit")[0]) == circuit.n


@given(circuits)
def test_every_hinge_lies_where_the_circuit_crosses_it(circuit):
    svg = draw(circuit)
    (centres,) = pieces(svg, "circuit")
    for k, hinge in enumerate(pieces(svg, "hinge")):
        step = [centres[k], centres[(k + 1) % circuit.n]]
        along, across = extent(hinge), extent(step)
        length, distance = math.hypot(*along), math.hypot(*across)
        x, y = (m - start for m, start in zip(middle(step), hinge[0], strict=True))
        assert length > 98
        assert abs(along[0] * across[0] + along[1] * across[1]) < 1.5 * (length + distance)  # at right angles
        assert abs(along[0] * y - along[1] * x) < 2 * length  # halfway between the centres
        assert 0.1 * length < (along[0] * x + along[1] * y) / length < 0.9 * length


@given(circuits)
def test_panels_lie_around_their_centres_in_circuit_order(circuit):
    svg = draw(circuit)
    (centres,) = pieces(svg, "circuit")
    for panel, centre in zip(pieces(svg, "panel"), centres, strict=True):
        assert middle(panel) == pytest.approx(centre, abs=2)


@given(circuits, st.booleans())
def test_a_folding_draws_each_crease_once(circuit, numbers):
    for folding in foldings(circuit):
        svg = draw(circuit, folding.assignment, numbers=numbers)
        for kind in ("mountain", "valley", "flat"):
            assert len(pieces(svg, kind)) == folding.assignment.count(kind)
        assert not pieces(svg, "hinge")
        assert len(pieces(svg, "outer")) == 4
        assert len(pieces(svg, "panel")) == circuit.n - 4
        texts = [text.text for text in ET.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]
        assert texts == ([str(k) for k in range(circuit.n)] if numbers else [])


def test_shaded_panels_are_the_outer_layers():
    circuit, folding = next((c, f) for c in CIRCUITS if c.n == 10 for f in foldings(c))
    svg = draw(circuit, folding.assignment)
    (centres,) = pieces(svg, "circuit")
    outer = [k for k, layer in enumerate(folding.layers) if layer in (0, circuit.n // 2 - 1)]
    for k, panel in zip(outer, pieces(svg, "outer"), strict=True):
        assert middle(panel) == pytest.approx(centres[k], abs=2)


@given(circuits)
def test_everything_is_inside_the_view_box(circuit):
    svg = draw(circuit)
    width, height = map(int, re.search(r'viewBox="0 0 (\d+) (\d+)"', svg).groups())
    for kind in DRAWING_STYLES:
        for x, y in (corner for line in pieces(svg, kind) for corner in line):
            assert 0 < x < width
            assert 0 < y < height


@pytest.mark.parametrize(
    ("grid", "size", "ratio"),
    [("rectangle", None, 1.25), ("square", None, 1.0), ("rectangle", (60, 30), 2.0), ("rectangle", (30, 60), 0.5)],
)
def test_panels_have_the_ratio_of_their_sides(grid, size, ratio):
    (panel,) = pieces(draw_array(GRIDS[grid], [(0, 0)], size=size), "panel")
    width, height = (max(v[i] for v in panel) - min(v[i] for v in panel) for i in (0, 1))
    assert width / height == pytest.approx(ratio, rel=0.02)


@pytest.mark.parametrize("grid", sorted(set(GRIDS) - {"square", "rectangle"}))
def test_other_panels_keep_their_shape_whatever_the_panel_size(grid):
    cells = [(0, 0, kind) for kind in range(GRIDS[grid].kinds)]
    assert draw_array(GRIDS[grid], cells, size=(60, 30)) == draw_array(GRIDS[grid], cells)


@pytest.mark.parametrize("grid", GRIDS)
def test_panels_have_similar_areas_on_a_screen_and_a_shortest_side_of_a_hundred_units(grid):
    svg = draw_array(GRIDS[grid], [(0, 0, kind) for kind in range(GRIDS[grid].kinds)])
    pixels, units = (int(re.search(pattern, svg)[1]) for pattern in (r'width="(\d+)"', r'viewBox="0 0 (\d+)'))
    for panel in pieces(svg, "panel"):
        sides = list(zip(panel, panel[1:] + panel[:1], strict=True))
        area = abs(sum(a * d - b * c for (a, b), (c, d) in sides)) / 2
        assert min(math.dist(*side) for side in sides) == pytest.approx(100, abs=1.5)
        assert 40 < math.sqrt(area) * pixels / units < 66


@pytest.mark.parametrize(
    ("grid", "spec"),
    [
        *(("hex", "3-4-3"), ("triangle", "t3"), ("square", "3x2"), ("rectangle", "3x2"), ("rhombus", "2-3")),
        *(("kite", "t2"), ("right45", "3x2"), ("right30", "s1"), ("obtuse", "h1")),
    ],
)
def test_an_array_draws_its_panels_alone(grid, spec):
    array = parse_array(GRIDS[grid], spec)
    svg = draw_array(array.grid, array.cells)
    assert len(pieces(svg, "panel")) == array.n
    assert [child.tag.rpartition("}")[2] for child in ET.fromstring(svg)] == ["title", "path"]


def test_a_standalone_picture_brings_its_look_and_an_inline_one_leaves_it_to_the_page():
    circuit = CIRCUITS[0]
    alone, inline = draw(circuit), draw(circuit, standalone=False)
    assert 'xmlns="http://www.w3.org/2000/svg"' in alone
    assert "stroke-dasharray" in alone
    assert "http" not in inline
    assert "stroke" not in inline
    for kind in ("panel", "circuit", "hinge"):
        assert pieces(alone, kind) == pieces(inline, kind)
    assert all(f"svg .{kind} {{" in stylesheet() for kind in DRAWING_STYLES)


@given(circuits)
def test_lines_of_standalone_pictures_are_equally_wide_on_all_grids_and_do_not_grow(circuit):
    assignment = next((folding.assignment for folding in foldings(circuit)), None)
    root = ET.fromstring(draw(circuit, assignment, numbers=True))
    lines = [path for path in root.iter() if path.tag.endswith("path")]
    assert lines
    for path in lines:
        look = DRAWING_STYLES[path.get("class")]
        assert path.get("vector-effect") == "non-scaling-stroke"
        assert float(path.get("stroke-width")) == pytest.approx(LINE_PIXELS * float(look["stroke-width"]), rel=0.02)
        dashes = [float(dash) for dash in path.get("stroke-dasharray", "").split()]
        wanted = [LINE_PIXELS * float(dash) for dash in look.get("stroke-dasharray", "").split()]
        assert dashes == pytest.approx(wanted, rel=0.02)
    (numbers,) = [group for group in root.iter() if group.get("class") == "numbers"]
    assert numbers.get("vector-effect") is None  # the rim of a text grows with it


def test_the_title_is_escaped_and_never_restyled():
    title = '</title><script>x</script> class="panel" & "'
    for standalone in (True, False):
        root = ET.fromstring(draw(CIRCUITS[0], title=title, standalone=standalone))
        assert [child.text for child in root if child.tag.endswith("title")] == [title]
        assert not [child for child in root.iter() if child.tag.endswith("script")]
        assert root.get("role") == "img"


def test_mountains_and_valleys_differ_in_colour_and_in_dashes():
    mountain, valley = DRAWING_STYLES["mountain"], DRAWING_STYLES["valley"]
    assert mountain["stroke"] != valley["stroke"]
    assert len(mountain["stroke-dasharray"].split()) == 4  # dash-dot
    assert len(valley["stroke-dasharray"].split()) == 2


def test_a_thumbnail_is_small():
    circuit = next(iter(enumerate_circuits("hex", n=12, limit=1)))
    assert len(draw(circuit, standalone=False)) < 1300
