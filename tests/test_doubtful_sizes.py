"""Sizes of panels that are probably not meant: in another unit, in another order, or with one forgotten."""

import hashlib
import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

from hcsearch import Circuit, Folding, Scene, deploy, enumerate_into, save
from hcsearch.basics.errors import HcsearchWarning, SceneError
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel, panel_size_doubt, read_panel
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import SCENES
from hcsearch.scenes.scene import with_size
from hcsearch.subjects.linkage_cases import LENGTH_PARAMETERS, parameters_of
from tests import forking

MOVING = "hex:0234550132:4"


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Databases of six panels."""
    folder = tmp_path_factory.mktemp("stored")
    for grid in ("hex", "rectangle"):
        words = ("enumerate", "--grid", grid, "--n", "6", "--until", "mobility", "--db", f"{grid}.sqlite")
        assert forking.run(words, cwd=folder).returncode == 0
    return folder


@pytest.mark.parametrize(
    ("text", "likely"),
    [
        ("1x0.02", "1000x20"),  # metres
        ("0.05x0.006", "50x6"),
        ("0.08x0.04x0.006", "80x40x6"),
        ("6x50", "50x6"),  # the thickness first
        ("3x50", "50x3"),
        ("6x40x80", "80x40x6"),
        ("80x6x40", "80x40x6"),
        ("0.02x1", "1000x20"),  # both
        ("50000x6000", "50x6"),  # micrometres
        ("1000000x20000", "1000x20"),
    ],
)
def test_the_likely_size_is_named(text, likely):
    doubt = panel_size_doubt(read_panel(text))
    assert doubt.startswith(f"panels of {text} mm have a ")
    assert doubt.endswith(f": sizes are in mm, sides first, then the thickness; did you mean {likely}?")
    assert panel_size_doubt(read_panel(likely)) is None


@pytest.mark.parametrize("text", ["50x6", "5x2.5", "80x40x6", "40x80x20", "1000x20", "20000x1", "50x0.2", "80x40"])
def test_other_sizes_are_in_no_doubt(text):
    assert panel_size_doubt(read_panel(text)) is None


@pytest.mark.parametrize(
    ("text", "end"),
    [
        ("50x40", "half their side: sizes are in mm, sides first, then the thickness; a thickness is missing where "
         "both are sides, as in 50x40x6"),
        ("4.9x0.5", "less than 5 mm: sizes are in mm, sides first, then the thickness"),
        ("80x40x30", "half their side: sizes are in mm, sides first, then the thickness"),
        ("80x50x40", "half their side: sizes are in mm, sides first, then the thickness"),
    ],
)  # fmt: skip
def test_no_size_is_named_that_would_be_in_doubt_itself(text, end):
    assert panel_size_doubt(read_panel(text)).endswith(end)


@pytest.mark.parametrize(
    ("grid", "side"), [("hex", 1 / 3**0.5), ("triangle", 2 / 3**0.5), ("square", 1.0), ("rhombus", 2 / 3**0.5)]
)
def test_widths_across_flats_are_named_as_such(grid, side):
    for text, likely in (("1x0.02", "1000x20"), ("20x1000", "1000x20"), ("0.02x1", "1000x20")):
        size = read_panel(f"across {text}", grid)
        assert size[0] == pytest.approx(1e-3 * float(text.partition("x")[0]) * side)
        doubt = panel_size_doubt(size, grid, across=True)
        assert doubt.startswith(f"panels of {text} mm across flats have ")
        assert doubt.endswith(f"did you mean {likely}?")
        assert panel_size_doubt(read_panel(f"across {likely}", grid), grid, across=True) is None


@pytest.mark.parametrize(
    ("grid", "shortest"), [("kite", 1 / 3**0.5), ("right30", 0.5), ("right45", 1.0), ("obtuse", 1.0), ("rhombus", 1.0)]
)
def test_the_shortest_side_of_a_panel_is_compared_with_its_thickness(grid, shortest):
    thick, thin = (f"100x{100 * share * shortest:.3f}" for share in (0.51, 0.49))
    side = "side" if shortest == 1.0 else "shortest side"
    assert f"a thickness of more than half their {side}: " in panel_size_doubt(read_panel(thick, grid), grid)
    assert panel_size_doubt(read_panel(thin, grid), grid) is None
    with pytest.warns(HcsearchWarning, match=f"half their {side}"):
        with_size(SCENES["default"], thick, grid)
    assert panel_size_doubt(default_panel(grid), grid) is None


@pytest.mark.parametrize(
    ("grid", "edge"), [("kite", "longer side"), ("right30", "hypotenuse"), ("right45", "leg"), ("obtuse", "leg")]
)
def test_panels_with_sides_of_several_lengths_have_no_width_across_flats(grid, edge):
    with pytest.raises(SceneError, match=f"the {grid} grid have no width .* --panel 50x6, where 50 is the {edge}$"):
        read_panel("across 1000x20", grid)
    with pytest.raises(
        SceneError, match=f"panels of the {grid} grid have one given length: .* where SIDE is the {edge}$"
    ):
        with_size(SCENES["default"], "50x40x6", grid)
    assert with_size(SCENES["default"], "80x6", grid).panel == pytest.approx((0.08, 0.08, 0.006))


@pytest.mark.parametrize("grid", GRIDS)
def test_panels_with_sides_of_several_lengths_have_a_given_edge(grid):
    corners = GRIDS[grid].corners((0, 0, GRIDS[grid].kinds - 1))
    lengths = [math.dist(corners[k - 1], corners[k]) for k in range(len(corners))]
    assert min(abs(length - 1.0) for length in lengths) < 1e-12
    assert (max(lengths) - min(lengths) > 0.1) == bool(GRIDS[grid].given_edge)


def only_warning(done):
    (line,) = [line for line in done.stderr.splitlines() if "sizes are in mm" in line]
    assert line.startswith("hcsearch: warning: panels of ")
    return line


COMMANDS = [
    ("deploy", MOVING, "--seconds", "0.01"),
    ("export", MOVING, "--output", "a.fold"),
    ("export", MOVING, "--output", "a.svg", "--sheet", "panels"),
    ("show", MOVING),
    ("check", "hex:024"),
    ("enumerate", "--grid", "hex", "--n", "6", "--until", "twist"),
    ("enumerate", "--grid", "hex", "--array", "3-4-3", "--until", "twist", "--dry-run"),
]


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
@pytest.mark.parametrize("given", ["panel", "across", "scene", "scene name"])
def test_each_command_warns_in_one_line_and_does_what_it_is_asked_to(run, words, given):
    Path("small.toml").write_text("panel_mm = '1x0.02'\n", encoding="utf-8")
    options = {
        "panel": ("--panel", "1x0.02"),
        "across": ("--across", "1x0.02"),
        "scene": ("--scene", "small.toml"),
        "scene name": ("--scene", "1x0.02"),
    }[given]
    done, plain = run(*words, *options), run(*words)
    assert only_warning(done).endswith("did you mean 1000x20?")
    assert "warning" not in plain.stderr
    assert done.returncode in {0, 1}
    assert done.stdout
    assert "warning" not in done.stdout


@pytest.mark.parametrize("command", ["query", "rank", "report", "show", pytest.param("serve", marks=pytest.mark.extra)])
def test_a_scene_that_is_not_there_may_be_one_of_other_sizes(run, stored, command):
    words = (command, *(("1",) if command == "show" else ()), "--db", str(stored / "hex.sqlite"))
    for options in (("--panel", "6x50"), ("--across", "6x50"), ("--scene", "6x50")):
        done = run(*words, *options)
        assert done.returncode == 2
        assert done.stdout == ""
        assert only_warning(done).endswith("did you mean 50x6?")
        assert "hcsearch: no verdicts of the scene '" in done.stderr


@pytest.mark.parametrize(
    ("words", "likely"),
    [
        (("unit-ii", "--base", "0.03", "--thickness", "0.01"), "30x10"),
        (("thesis-4x4", "--side", "50", "--width", "6", "--thickness", "40"), "50x40x6"),
        (("module-i", "--side", "6", "--thickness", "50"), "50x6"),
    ],
)
def test_sizes_of_assemblies_are_in_doubt_too(run, words, likely):
    done = run("assembly", *words)
    assert only_warning(done).endswith(f"did you mean {likely}?")
    assert (done.returncode, "warning" in done.stdout) == (0, False)


def test_sizes_of_the_thesis_are_in_no_doubt(recwarn):
    for assembly in ASSEMBLIES.values():
        given = {
            name: 1e3 * getattr(assembly.defaults, name)
            for name in LENGTH_PARAMETERS
            if name in assembly.parameter_names
        }
        parameters_of(assembly, given)
    parameters_of(ASSEMBLIES["unit-ii"], {"alpha": 70, "base": 30, "thickness": 10})
    assert not recwarn.list


RECTANGLES = [
    ("enumerate", "--grid", "rectangle", "--n", "6"),
    ("enumerate", "--grid", "rectangle", "--array", "3x2", "--dry-run"),
    ("deploy", "rectangle:0123:0"),
    ("tune", "rectangle:0123:0"),
    ("drive", "rectangle:0123:0"),
    ("check", "rectangle:0123"),
    ("export", "rectangle:0123:0", "--output", "a.svg"),
    ("show", "rectangle:0123"),
]


@pytest.mark.parametrize("words", RECTANGLES, ids=" ".join)
def test_two_numbers_are_no_rectangle_wherever_they_are_given(run, stored, words):
    Path("wall.toml").write_text("name = 'wall'\npanel_mm = '80x40'\n", encoding="utf-8")
    Path("table.toml").write_text("name = 'wall'\n[scene]\npanel = '80x40'\n", encoding="utf-8")
    database = stored / "rectangle.sqlite"
    before = hashlib.sha256(database.read_bytes()).digest()
    sizes = [
        ("--panel", "80x40"),
        *(("--scene", scene) for scene in ("80x40", "earth, 80x40", "wall.toml", "table.toml")),
    ]
    for options in sizes:
        done = run(*words, "--db", str(database), *options)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == (
            "hcsearch: '80x40' is no rectangle, which has a length, a width and a thickness: write three numbers in "
            "mm, such as 80x40x6\n"
        )
    assert hashlib.sha256(database.read_bytes()).digest() == before
    assert sorted(path.name for path in Path().iterdir()) == ["table.toml", "wall.toml"]


def test_two_numbers_are_a_hexagon_in_the_same_files(run):
    Path("wall.toml").write_text("name = 'wall'\npanel_mm = '80x20'\n", encoding="utf-8")
    words = ("enumerate", "--n", "6", "--until", "twist", "--scene", "wall.toml", "--dry-run")
    done = run(*words, "--grid", "hex")
    assert (done.returncode, done.stderr) == (0, "")
    assert "is no rectangle" in run(*words, "--grid", "rectangle").stderr


@pytest.mark.parametrize("text", ["1x0.02", "6x50", "50x6"])
def test_the_example_of_a_rectangle_is_in_no_doubt(text):
    with pytest.raises(SceneError) as refused:
        read_panel(text, "rectangle")
    assert panel_size_doubt(read_panel(str(refused.value).rpartition(" ")[2], "rectangle")) is None


@pytest.mark.parametrize(
    ("unit", "likely"),
    [("m", None), ("cm", None), ("mm", "did you mean 1000x120?"), ("unit", None)],
)
def test_a_drawing_in_the_wrong_unit_is_in_doubt(run, unit, likely):
    cells = Circuit.from_notation("square:0123").cells
    outlines = [[tuple(np.round(corner, 9).tolist()) for corner in GRIDS["square"].corners(cell)] for cell in cells]
    points = sorted({corner for outline in outlines for corner in outline})
    sides = [(one, two) for outline in outlines for one, two in zip(outline, outline[1:] + outline[:1], strict=True)]
    sides = sorted({tuple(sorted(map(points.index, side))) for side in sides})
    drawing = {"file_spec": 1.2, "vertices_coords": points, "edges_vertices": sides, "frame_unit": unit}
    Path("a.fold").write_text(json.dumps(drawing), encoding="utf-8")
    done = run("show", "a.fold")
    assert "square:0123" in done.stdout
    if likely is None:
        assert "warning" not in done.stderr
    else:
        assert only_warning(done).endswith(likely)


def test_python_warns_of_sizes_in_texts_and_scenes(tmp_path):
    folding = Folding.from_notation(MOVING)
    db = str(tmp_path / "d.sqlite")
    calls = {
        "1000x20": [
            lambda: deploy(folding, panel="1x0.02", seconds=0.01),
            lambda: deploy(folding, panel="across 1x0.02", seconds=0.01),
            lambda: enumerate_into(db, grid="hex", n=6, until="twist", panel="1x0.02"),
            lambda: folding.linkage("1x0.02"),
            lambda: save(folding, tmp_path / "a.svg", panel="20x1000"),
        ],
        "50x6": [
            lambda: deploy(folding, Scene(panel=(50.0, 50.0, 6.0)), seconds=0.01),
            lambda: enumerate_into(db, grid="hex", n=6, until="twist", scene=Scene(panel=(0.006, 0.006, 0.05))),
        ],
    }
    for likely, made in calls.items():
        for call in made:
            with pytest.warns(HcsearchWarning, match=f"did you mean {likely}"):
                call()
    with pytest.raises(SceneError, match="'80x40' is no rectangle"):
        deploy("rectangle:0123:0", panel="80x40")
    with pytest.raises(SceneError, match="'80x40' is no rectangle"):
        Folding.from_notation("rectangle:0123:0").linkage("80x40")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        deploy(folding, panel="1000x20", seconds=0.01)
