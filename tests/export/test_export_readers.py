"""Files read by programs of other people: the npm packages fold and rabbit-ear, ezdxf, and Chromium."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import shapely

from hcsearch.export.settings import ExportSettings
from tests.export.cases import PARTS
from tests.export.exports import DESIGN, MOVING, RING, exported, sheet_for, written
from tests.report.browser import chromium, complaints

pytestmark = pytest.mark.extra

TRIANGLES, RECTANGLES = "triangle:012343454545012121:2", "rectangle:012233300121:5"
PACKAGES = ("fold@0.12.0", "rabbit-ear@0.9.32")


@pytest.fixture(scope="session")
def readers(tmp_path_factory):
    """A folder with the packages, and the program that reads files with them."""
    folder = tmp_path_factory.mktemp("npm")
    quiet = ("--no-audit", "--no-fund", "--no-save", "--silent")
    subprocess.run(["npm", "install", "--prefix", folder, *quiet, *PACKAGES], check=True, timeout=300)
    return Path(shutil.copy(Path(__file__).with_name("readers.mjs"), folder))


CASES = [
    (DESIGN, {}),
    (DESIGN, {"flat_pairs": "hinged"}),
    (MOVING, {"by": "path"}),
    (RING, {}),
    (TRIANGLES, {}),
    (RECTANGLES, {}),
    *((name, {}) for name in PARTS),
]


@pytest.mark.parametrize(("name", "request_"), CASES, ids=str)
def test_fold_and_rabbit_ear_read_the_pattern_and_fold_it_as_it_is_folded(readers, tmp_path, name, request_):
    value = exported(name, **request_)
    place = tmp_path / "design.fold"
    place.write_text(written(value), encoding="utf-8")
    done = subprocess.run(["node", readers, place], check=True, capture_output=True, text=True, timeout=120)
    reading, data = json.loads(done.stdout.splitlines()[-1]), json.loads(place.read_text(encoding="utf-8"))
    counts = [len(data[key]) for key in ("vertices_coords", "edges_vertices", "faces_vertices")]
    assert reading["counts"] == reading["fold"]["counts"] == counts
    assert (reading["summary"], reading["fold"]["again"]) == ("valid", True)
    n, borders = value.circuit.n, counts[1] - value.circuit.n
    kinds = reading["fold"]["kinds"]
    assert kinds == {
        "mountainEdges": value.case.folding.assignment.count("mountain"),
        "valleyEdges": value.case.folding.assignment.count("valley"),
        "flatEdges": 2,
        "boundaryEdges": borders,
        "unassignedEdges": 0,
        "cutEdges": 0,
        "joinEdges": 0,
    }
    assert reading["fold"]["edgesFaces"] == [2] * n + [1] * borders
    assert reading["missed"] < 1e-6
    check_orders(value, reading, data)


@pytest.mark.parametrize("name", ["unit-ii", "module-ii", "thesis-4x4"])
def test_assemblies_fold_as_they_do_in_rabbit_ear(readers, tmp_path, name):
    place = tmp_path / "assembly.fold"
    place.write_text(written(exported(name)), encoding="utf-8")
    done = subprocess.run(["node", readers, place], check=True, capture_output=True, text=True, timeout=120)
    reading, data = json.loads(done.stdout.splitlines()[-1]), json.loads(place.read_text(encoding="utf-8"))
    assert reading["summary"] == "valid"
    assert reading["missed"] < 1e-6
    check_orders(exported(name), reading, data)


def check_orders(value, reading, data):
    """Layers are among those that the solver finds possible: above each other as it says, or all turned over."""
    linkage = value.linkage
    turned = np.sign(linkage.poses(linkage.folded)[list(linkage.pattern.panel_of), 2, 2])
    ours = {f"{f} {g}": s * turned[g] for f, g, s in data["file_frames"][0]["faceOrders"]}
    signs = {ours[pair] * order for pair, order in reading["orders"].items()}
    assert len(reading["orders"]) > 0
    assert len(signs) == 1
    (sign,) = signs
    solved = set(reading["orders"])
    for branches in reading["branches"]:
        fitting = [way for way in branches if all(ours[pair] == sign * order for pair, order in way.items())]
        assert fitting
        solved |= set(fitting[0])
    assert solved == set(ours)


@pytest.mark.parametrize(
    "settings", [ExportSettings(), ExportSettings(sheet="panels", kerf_mm=0.2, hinge_gap_mm=1.0)], ids=str
)
@pytest.mark.parametrize("name", [DESIGN, RING, TRIANGLES, RECTANGLES, *PARTS, "unit-ii"])
def test_ezdxf_finds_no_fault_and_every_line_where_it_is(name, settings):
    import ezdxf

    value = exported(name)
    document = ezdxf.read(StringIO(written(value, "dxf", settings)))
    audit = document.audit()
    assert (audit.errors, audit.fixes) == ([], [])
    assert document.header["$INSUNITS"] == 4
    sheet = sheet_for(value, settings)
    for layer, lines in sheet.lines.items():
        drawn = list(document.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]'))
        assert len(drawn) == len(lines)
        for entity, line in zip(drawn, lines, strict=True):
            np.testing.assert_allclose([point[:2] for point in entity.get_points()], line.points, atol=1e-9)
            assert entity.closed == line.closed == (layer == "CUT")
    outlines = [shapely.Polygon(line.points) for line in sheet.lines["CUT"]]
    assert all(outline.is_valid for outline in outlines)


@pytest.mark.parametrize("settings", [ExportSettings(), ExportSettings(sheet="panels")], ids=str)
@pytest.mark.parametrize(("name", "panel"), [(DESIGN, None), (DESIGN, "1000x20"), (RING, "6x0.5"), ("unit-ii", None)])
def test_a_dxf_opens_with_the_whole_drawing_in_view(name, panel, settings):
    import ezdxf

    value = exported(name, panel=panel)
    document = ezdxf.read(StringIO(written(value, "dxf", settings)))
    lines = [line for drawn in sheet_for(value, settings).lines.values() for line in drawn]
    points = np.concatenate([line.points for line in lines])
    low, high = points.min(axis=0), points.max(axis=0)
    header, space = document.header, document.modelspace().dxf
    for corners in ((header["$EXTMIN"], header["$EXTMAX"]), (space.extmin, space.extmax)):
        np.testing.assert_allclose([(corner[0], corner[1]) for corner in corners], [low, high], atol=1e-9)
    (view,) = document.viewports.get("*Active")
    np.testing.assert_allclose((view.dxf.center[0], view.dxf.center[1]), 0.5 * (low + high), atol=1e-9)
    for shape in (4 / 3, 16 / 9):  # of a window: width over height
        shown = np.array([view.dxf.height * shape, view.dxf.height])
        assert (shown >= high - low).all()
    assert view.dxf.height <= 1.25 * max(high - low)


def test_dxf_files_of_one_design_are_equal_at_any_time_and_in_any_process(tmp_path):
    words = ("export", DESIGN, "--output")
    contents = [written(exported(DESIGN), "dxf").encode()]
    for seed in "12":
        second = int(time.time())
        while int(time.time()) == second:  # times in files are of whole seconds
            time.sleep(0.01)
        command = [sys.executable, "-m", "hcsearch", *words, f"{seed}.dxf"]
        subprocess.run(command, cwd=tmp_path, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
        contents.append((tmp_path / f"{seed}.dxf").read_bytes())
    assert contents[0] == contents[1] == contents[2]


LENGTHS = """
const probe = {lengths: {}}, drawing = document.querySelector("svg");
for (const group of drawing.querySelectorAll("g")) {
    probe.lengths[group.id] = [...group.querySelectorAll("path")].map((path) => path.getTotalLength());
}
const {width, height} = drawing.getBoundingClientRect();
probe.size = [width, height];
const place = document.createElement("pre");
place.id = "probe";
place.textContent = JSON.stringify(probe);
document.body.append(place);
"""


@pytest.mark.parametrize(
    "settings", [ExportSettings(), ExportSettings(sheet="panels", kerf_mm=0.2, hinge_gap_mm=1.0)], ids=str
)
@pytest.mark.parametrize("name", [DESIGN, RING, TRIANGLES, RECTANGLES, *PARTS, "unit-ii"])
def test_chromium_draws_every_line_of_a_sheet_in_millimetres(name, settings, tmp_path):
    value = exported(name)
    sheet, drawing = sheet_for(value, settings), written(value, "svg", settings).partition("\n")[2]
    page = tmp_path / "sheet.html"
    page.write_text(f"<!doctype html><body>{drawing}<script>{LENGTHS}</script></body>", encoding="utf-8")
    opened = chromium(page, "--dump-dom")
    assert complaints(opened) == []
    probe = json.loads(re.search(r'<pre id="probe">(.*?)</pre>', opened.stdout, re.DOTALL)[1])
    assert probe["size"] == pytest.approx([sheet.width * 96 / 25.4, sheet.height * 96 / 25.4], abs=0.05)
    assert set(probe["lengths"]) == {layer for layer, lines in sheet.lines.items() if lines}
    for layer, lengths in probe["lengths"].items():
        shapes = [shapely.LinearRing if line.closed else shapely.LineString for line in sheet.lines[layer]]
        ours = [shape(line.points).length for shape, line in zip(shapes, sheet.lines[layer], strict=True)]
        assert lengths == pytest.approx(ours, rel=1e-4, abs=1e-3)
