"""Crease patterns of other programs as lines: `.cp`, `.opx`, and SVG in the colours of Origami Simulator."""

import json
import math
import random
from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch import save, show
from hcsearch.basics.errors import HcsearchError, InputFileError
from hcsearch.designs.folding import Folding, foldings, representatives
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.search.own_patterns.line_drawings import read_cp, read_opx
from hcsearch.search.own_patterns.svg_drawings import read_svg
from hcsearch.subjects.pattern_files import DrawnDesign, read_pattern_file
from tests.commands import run_here
from tests.export.test_any_panels import strip
from tests.fuzz.mutations import judge, mutated

STRIP = """1 0 0 3 0
1 3 0 3 2
1 3 2 0 2
1 0 2 0 0
2 1 0 1 2
3 2 0 2 2
"""
"""Three panels in a row, as a user drew them in a file `.cp` (cases of the referees, 2026)."""
PARTED = "1 0 0 3 0\n1 3 0 3 2\n1 3 2 0 2\n1 0 2 0 0\n2 1 0 1 1\n3 1 1 1 2\n4 0 1 3 1\n"
"""Panels of which a crease changes where an auxiliary line would part them."""
LETTERS = {1: "B", 2: "M", 3: "V"}
COLOURS = {"B": "#000000", "M": "#ff0000", "V": "#0000ff", "C": "#00ff00", "F": "#ffff00", "U": "#ff00ff"}
SVG = '<svg xmlns="http://www.w3.org/2000/svg" {}>{}</svg>'


def lines_of(text):
    return [tuple(map(float, line.split())) for line in text.splitlines()]


def opx_of(text):
    """The lines of a file `.cp` as ORIPA writes them: properties by name, those that are 0 left out."""
    objects = []
    for kind, *ends in lines_of(text):
        values = {"type": int(kind), **dict(zip(("x0", "y0", "x1", "y1"), ends, strict=True))}
        parts = [
            f'<void property="{name}"><{tag}>{values[name]}</{tag}></void>'
            for name, tag in (("type", "int"), *((name, "double") for name in ("x0", "x1", "y0", "y1")))
            if values[name]
        ]
        objects.append(f'<void index="0"><object class="oripa.OriLineProxy">{"".join(parts)}</object></void>')
    listed = f'<array class="oripa.OriLineProxy" length="{len(objects)}">{"".join(objects)}</array>'
    body = f'<void property="paperSize"><double>400.0</double></void><void property="lines">{listed}</void>'
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<java version="1.5.0" class="java.beans.XMLDecoder">'
    return f'{head}<object class="oripa.DataSet">{body}</object></java>'


def svg_of(text, attributes=""):
    return SVG.format(
        attributes,
        "".join(
            f'<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" stroke="{COLOURS[LETTERS[int(kind)]]}"/>'
            for kind, x1, y1, x2, y2 in lines_of(text)
        ),
    )


def written(folder, name, text):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def shown(drawing):
    """What does not depend on the numbers of faces: areas, and the letters of joints."""
    areas = sorted(
        round(abs(sum(ax * by - bx * ay for (ax, ay), (bx, by) in zip(f, (*f[1:], f[0]), strict=True))), 6)
        for f in drawing.facets
    )
    return areas, Counter(join.assignment for join in drawing.joins.values())


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.cp", STRIP),
        ("b.cp", "\ufeff" + STRIP.replace(" ", "\t").replace("\n", "\r\n\r\n")),
        ("c.CP", STRIP + "4 0.2 -1 2.5 3\n0 0 1 3 1\n7 1 1 1.5 1.5\n"),
        ("a.opx", opx_of(STRIP)),
        ("b.opx", opx_of(STRIP + "4 0 0 1 2\n0 0 1 3 1\n")),
        ("a.svg", svg_of(STRIP)),
        ("b.svg", "\ufeff" + svg_of(STRIP, 'width="100%"')),
        (
            "c.svg",
            '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
            + svg_of(STRIP),
        ),
        (
            "d.svg",
            SVG.format(
                'viewBox="0 0 3 2"',
                "<title>strip</title><style>/* a */ .m,.n{stroke:#D00000;fill:none} path{stroke:blue}</style>"
                '<defs><line y1="1" x2="3" y2="1" stroke="red"/></defs><circle r="1" stroke="red"/><text>1</text>'
                '<g stroke="rgb(0, 0, 0)"><rect width="3" height="2" fill="#eee"/></g>'
                '<g transform="translate(1) scale(1, 2)"><polyline class="m" points="0,0 0,1"/></g>'
                '<path d="m2 0v1L2,2" style="stroke-width:2"/><line x2="3" y2="2" stroke="none"/>'
                '<g style="display:none"><line x2="3" y2="2" stroke="red"/></g><line x2="3" y2="2" stroke="gray"/>',
            ),
        ),
        (
            "e.svg",
            SVG.format(
                "",
                '<polygon points="0 0 30 0 30 20 0 20" stroke="black" transform="matrix(.1,0,0,.1,5,5)"/>'
                '<path id="x" stroke="red" transform="rotate(90 6 5)" d="M6 5h2 M6 5l.5.0z"/>'
                '<path stroke="#00f" d="M7,5V7"/>',
            ),
        ),
    ],
)
def test_a_strip_is_read_from_each_format(name, text, tmp_path):
    drawing = read_pattern_file(written(tmp_path, name, text))
    assert drawing.packed.sentence == "packed state found: all hinges closed"
    reader = {".cp": read_cp, ".opx": read_opx, ".svg": read_svg}[name[1:].lower()]
    assert shown(reader(str(tmp_path / name))) == ([4.0] * 3, Counter("MV"))


def test_what_an_svg_holds_beside_its_lines_is_named(tmp_path, capfd):
    text = svg_of(STRIP).replace("</svg>", '<circle r="1"/><text>1</text><line x2="3" y2="2" stroke="gray"/></svg>')
    result = run_here(["show", written(tmp_path, "a.svg", text)], capfd)
    assert result.returncode == 0
    assert "a.svg: left out are lines of the colour gray and circle, text\n" in result.stderr


def test_drawings_are_as_they_are_seen_on_the_screen_where_y_points_down(tmp_path):
    bent = STRIP.replace("3 2 0 2 2", "3 2 0 2.5 2")
    places = []
    for name, text in (("a.cp", bent), ("a.opx", opx_of(bent)), ("a.svg", svg_of(bent))):
        drawing = read_pattern_file(written(tmp_path, name, text)).packed.pattern
        places.append(sorted((round(1e3 * x, 6), round(1e3 * y, 6)) for x, y in drawing.vertices))
    assert places[0] == places[1] == places[2]
    assert min(y for _, y in places[0]) < 0.0 == max(y for _, y in places[0])


@pytest.mark.parametrize("name", ["square:01222300:1", "hex:0234550132:4", "rectangle:01222300:1", "kite:23203030:3"])
@pytest.mark.parametrize("flat_pairs", ["rigid", "hinged"])
def test_a_sheet_for_origami_simulator_is_read_back_as_its_folding(name, flat_pairs, tmp_path):
    path = tmp_path / "a.svg"
    save(name, path, profile="simulator", flat_pairs=flat_pairs)
    drawn = read_pattern_file(str(path))
    assert isinstance(drawn, DrawnDesign)
    (folding,) = drawn.design.foldings
    known, exported = foldings(folding.circuit), Folding.from_notation(name)
    congruent = representatives(known, [0] * len(known), default_panel(folding.circuit.grid.name))
    assert congruent[known.index(folding)] == congruent[known.index(exported)]
    assert drawn.panel == ("50x40x6" if name.startswith("rect") else "50x50x6")


@pytest.mark.parametrize("name", ["ten-triangles", "element-8r", "module-i", "fig-5.11b"])
def test_a_sheet_of_an_assembly_is_read_back_with_its_hinges(name, tmp_path):
    path = tmp_path / "a.svg"
    save(name, path, profile="simulator")
    pattern, own = read_pattern_file(str(path)).packed.pattern, ASSEMBLIES[name].build(ASSEMBLIES[name].defaults)
    hinges = [Counter((hinge.face, hinge.crease.closes) for hinge in p.hinges) for p in (pattern, own)]
    assert hinges[0] == hinges[1]
    assert pattern.area == pytest.approx(own.area)


def test_fold_angles_are_the_opacity_of_lines_there_and_back(tmp_path):
    data = strip([2.0, 1.5, 1.8], [("M", -120), ("V", 75.5)])
    fold, svg = written(tmp_path, "a.fold", json.dumps(data)), str(tmp_path / "a.svg")
    save(fold, svg, profile="simulator")
    angles = sorted(show(svg).linkage.folded.tolist())
    assert angles == pytest.approx([math.radians(75.5), math.radians(120.0)], abs=1e-9)


@pytest.mark.parametrize(
    ("look", "angle"),
    [
        ('opacity="0.5"', 90.0),
        ('stroke-opacity="50%"', 90.0),
        ('style="opacity:.5;stroke-opacity:0.5"', 45.0),
        ('opacity="0"', 0.0),
    ],
)
def test_the_opacity_of_a_fold_is_its_angle(look, angle, tmp_path):
    text = svg_of(STRIP).replace('stroke="#ff0000"', f'stroke="#ff0000" {look}')
    (mountain, valley) = sorted(read_svg(written(tmp_path, "a.svg", text)).joins.values(), key=lambda j: j.assignment)
    assert (mountain.angle, valley.angle) == (-angle, 180.0)


def test_the_opacity_of_a_group_holds_for_its_folds(tmp_path):
    text = svg_of(STRIP).replace("<line", '<g opacity="0.5"><g style="opacity:50%"><line', 1)
    drawing = read_svg(written(tmp_path, "a.svg", text.replace("</svg>", "</g></g></svg>")))
    assert sorted(join.angle for join in drawing.joins.values()) == [-45.0, 45.0]


def test_shapes_without_a_stroke_are_named(tmp_path, capfd):
    text = svg_of(STRIP).replace("</svg>", '<rect width="9" height="9" fill="red"/></svg>')
    result = run_here(["show", written(tmp_path, "a.svg", text)], capfd)
    assert "a.svg: left out are rect without a stroke\n" in result.stderr


@pytest.mark.parametrize("name", ["a.cp", "a.opx"])
def test_auxiliary_lines_that_are_left_out_are_named(name, tmp_path, capfd):
    for text, said in ((STRIP, False), (STRIP + "4 0 0 1 2\n", True)):
        path = written(tmp_path, name, opx_of(text) if name == "a.opx" else text)
        result = run_here(["show", path], capfd)
        assert (f"{path}: left out are auxiliary lines, of other types than 1, 2 and 3\n" in result.stderr) == said


def test_a_drawing_fits_into_both_sides_of_its_page(tmp_path):
    path = written(tmp_path, "a.svg", svg_of(STRIP, 'width="90cm" height="6cm" viewBox="0 0 3 2"'))
    assert show(path).facts["longest_edge_mm"] == pytest.approx(60.0)


def test_a_physical_width_of_an_svg_gives_the_size_of_panels(tmp_path):
    path = written(tmp_path, "a.svg", svg_of(STRIP, 'width="9cm" height="6cm" viewBox="0 0 3 2"'))
    assert show(path).facts["longest_edge_mm"] == pytest.approx(60.0)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.cp", "", "has no line"),
        ("a.cp", "hello\n", "line 1: 'hello' is no line of a file .cp: write type x1 y1 x2 y2"),
        ("a.cp", "1 0 0 1\n", "line 1"),
        ("a.cp", "1 0 0 nan 1\n", "line 1"),
        ("a.cp", "1 0 0 1e300 1\n", "line 1"),
        ("a.cp", "-1 0 0 1 1\n", "line 1"),
        ("a.cp", "1 0 0 1 1\n", "edges bound no panel"),
        ("a.cp", "1 0 0 1 1\n4 0 0 1 0\n", "bound no panel.*; left out are auxiliary lines, of other types than 1, 2"),
        ("a.cp", PARTED, "has two assignments: .*; left out are auxiliary lines, of other types than 1, 2 and 3"),
        ("a.opx", opx_of(PARTED), "has two assignments: .*; left out are auxiliary lines"),
        ("a.opx", "x", "is no XML"),
        ("a.opx", "<java/>", "has no line"),
        ("a.opx", opx_of("1 0 0 3 7\n").replace("7.0", "x"), "y1 of line 0 is no number"),
        ("a.svg", "<html/>", "outermost element is html"),
        ("a.svg", '<!DOCTYPE svg [<!ENTITY a "b">]><svg>&a;</svg>', "declares entities"),
        ("a.svg", SVG.format("", '<line x2="1" stroke="#888"/>'), "no line in the colours .* lines of the colour #888"),
        ("a.svg", svg_of(STRIP).replace("#0000ff", "#1c5fd4"), "colour #1c5fd4, which has no meaning .* valleys blue"),
        ("a.svg", svg_of(STRIP).replace("#0000ff", "royalblue"), "colour royalblue"),
        ("a.svg", SVG.format("", '<path stroke="red" d="M0 0C1 1 2 2 3 0"/>'), "has a curve .command C"),
        ("a.svg", SVG.format("", '<path stroke="red" d="M0 0L1"/>'), "has 1 numbers after the command L"),
        (
            "a.svg",
            SVG.format("", '<line x2="5em" stroke="red"/>'),
            "'5em' where numbers are due; write numbers without a unit",
        ),
        (
            "a.svg",
            SVG.format("", '<line x2="43.3mm" stroke="red"/>'),
            "'43.3mm' where numbers are due; write numbers without a unit, and the size as width='90mm' and viewBox",
        ),
        ("a.svg", SVG.format("", '<line x2="five" stroke="red"/>'), "'five' where numbers are due; write numbers, or"),
        ("a.svg", SVG.format("", '<line x2="1" stroke="red" transform="spin(3)"/>'), "has the transform 'spin'"),
        ("a.svg", SVG.format("", '<line x2="1" stroke="red" opacity="2"/>'), "opacity '2', which is not from 0 to 1"),
        ("a.svg", SVG.format("", "<style>g>a{stroke:red}</style>"), "selector 'g>a': write strokes as attributes"),
        ("a.svg", SVG.format("", "<style>@media screen{.a{stroke:red}}</style>"), "the rule '@media screen': write"),
        ("a.svg", svg_of(STRIP).replace("#0000ff", "rgba(0,0,255,.5)"), "the colour rgba.0,0,255,.5., which has no"),
        ("a.svg", SVG.format("", '<svg x="5"><line x2="1" stroke="red"/></svg>'), "is a drawing within the drawing"),
    ],
)
def test_what_is_no_crease_pattern_is_refused_in_one_line(name, text, message, tmp_path, capfd):
    result = run_here(["check", written(tmp_path, name, text)], capfd)
    assert (result.returncode, result.stdout, len(result.stderr.splitlines())) == (2, "", 1)
    with pytest.raises(InputFileError, match=message):
        read_pattern_file(str(tmp_path / name))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.dxf", "a drawing whose lines have no folds: draw it as a crease pattern, as .fold, .cp or a coloured .svg"),
        ("2 a.STL", "solids or meshes without hinges: draw the flat crease pattern, as .fold"),
        ("c:a.orh", "a file of Orihime or Oriedita: export it there, as .fold, .cp"),
        ("a.png", "a picture: draw it"),
        ("a.csv", "a table or data: name the design"),
        ("a.fold.gz", "a compressed file: unpack it first, and name what it holds, as .fold, .cp or a coloured .svg"),
        ("a.svgz", "a compressed file: unpack it first"),
    ],
)
@pytest.mark.parametrize("command", ["check", "show", "motion", "deploy", "export", "prove"])
def test_files_of_other_kinds_are_refused_with_the_way_to_a_pattern(command, name, message, tmp_path, capfd):
    output = ["--output", str(tmp_path / "b.json")] if command in ("export", "prove") else []
    result = run_here([command, name, *output], capfd)
    assert (result.returncode, result.stderr.count("\n")) == (2, 1)
    assert f"{name} is no crease pattern but {message}" in result.stderr


def test_a_sheet_for_a_laser_cutter_is_refused_with_the_remedy(tmp_path):
    save("square:01222300:1", tmp_path / "a.svg")
    with pytest.raises(InputFileError, match=r"is a sheet for a laser cutter.*--profile simulator"):
        read_pattern_file(str(tmp_path / "a.svg"))


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32))
def test_mutated_drawings_are_read_or_refused(tmp_path_factory, seed):
    chance = random.Random(seed)
    name, text = chance.choice([("a.cp", STRIP), ("a.opx", opx_of(STRIP)), ("a.svg", svg_of(STRIP))])
    path = tmp_path_factory.mktemp("mutated") / name
    path.write_text(mutated(chance, text), encoding="utf-8", errors="replace")
    judge(str(path), {".cp": read_cp, ".opx": read_opx, ".svg": read_svg}[path.suffix])


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(0.3, 3.0), min_size=2, max_size=6), st.randoms())
def test_strips_of_any_widths_are_the_same_in_all_formats(tmp_path_factory, widths, chance):
    folder, places = tmp_path_factory.mktemp("strips"), [0.0]
    for width in widths:
        places.append(round(places[-1] + width, 6))
    sides = [(1, places[0], 0, places[-1], 0), (1, places[0], 2, places[-1], 2)]
    sides += [(1, x, 0, x, 2) for x in (places[0], places[-1])]
    sides += [(chance.choice((2, 3)), x, 0, x, 2) for x in places[1:-1]]
    chance.shuffle(sides)
    text = "\n".join(" ".join(map(str, side)) for side in sides)
    drawings = [
        read(written(folder, name, content))
        for read, name, content in (
            (read_cp, "a.cp", text),
            (read_opx, "a.opx", opx_of(text)),
            (read_svg, "a.svg", svg_of(text)),
        )
    ]
    areas = sorted(round(2 * 2 * (b - a), 6) for a, b in pairwise(places))
    assert shown(drawings[0])[0] == pytest.approx(areas)
    assert shown(drawings[0]) == shown(drawings[1]) == shown(drawings[2])


def test_a_missing_file_is_named(tmp_path):
    for name in ("a.cp", "a.opx", "a.svg"):
        with pytest.raises(HcsearchError, match=f"cannot read .*{name}"):
            read_pattern_file(str(tmp_path / name))
