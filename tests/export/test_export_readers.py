"""Files read by programs of other people: the npm packages fold and rabbit-ear, and ezdxf."""

import json
import shutil
import subprocess
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import shapely

from hcsearch.export import dxf, fold
from hcsearch.export.settings import Settings
from hcsearch.export.sheets import sheet_of
from tests.export.exports import DESIGN, MOVING, RING, exported

pytestmark = pytest.mark.extra

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
    ("triangle:012343454545012121:2", {}),
    ("rectangle:012233300121:5", {}),
]


@pytest.mark.parametrize(("name", "request_"), CASES, ids=str)
def test_fold_and_rabbit_ear_read_the_pattern_and_fold_it_as_it_is_folded(readers, tmp_path, name, request_):
    value = exported(name, **request_)
    place = tmp_path / "design.fold"
    place.write_text(fold.write(value, Settings()), encoding="utf-8")
    done = subprocess.run(["node", readers, place], check=True, capture_output=True, text=True, timeout=120)
    found, data = json.loads(done.stdout.splitlines()[-1]), json.loads(place.read_text(encoding="utf-8"))
    counts = [len(data[key]) for key in ("vertices_coords", "edges_vertices", "faces_vertices")]
    assert found["counts"] == found["fold"]["counts"] == counts
    assert (found["summary"], found["fold"]["again"]) == ("valid", True)
    n, borders = value.circuit.n, counts[1] - value.circuit.n
    kinds = found["fold"]["kinds"]
    assert kinds == {
        "mountainEdges": value.folding.assignment.count("mountain"),
        "valleyEdges": value.folding.assignment.count("valley"),
        "flatEdges": 2,
        "boundaryEdges": borders,
        "unassignedEdges": 0,
        "cutEdges": 0,
        "joinEdges": 0,
    }
    assert found["fold"]["edgesFaces"] == [2] * n + [1] * borders
    assert found["missed"] < 1e-6
    check_orders(value, found, data)


@pytest.mark.parametrize("name", ["unit-ii", "module-ii", "thesis-4x4"])
def test_assemblies_fold_as_they_do_in_rabbit_ear(readers, tmp_path, name):
    place = tmp_path / "assembly.fold"
    place.write_text(fold.write(exported(name), Settings()), encoding="utf-8")
    done = subprocess.run(["node", readers, place], check=True, capture_output=True, text=True, timeout=120)
    found, data = json.loads(done.stdout.splitlines()[-1]), json.loads(place.read_text(encoding="utf-8"))
    assert found["summary"] == "valid"
    assert found["missed"] < 1e-6
    check_orders(exported(name), found, data)


def check_orders(value, found, data):
    """Layers are among those that the solver finds possible: above each other as it says, or all turned over."""
    linkage = value.linkage
    turned = np.sign(linkage.poses(linkage.folded)[list(linkage.pattern.panel_of), 2, 2])
    ours = {f"{f} {g}": s * turned[g] for f, g, s in data["file_frames"][0]["faceOrders"]}
    signs = {ours[pair] * order for pair, order in found["orders"].items()}
    assert len(found["orders"]) > 0
    assert len(signs) == 1
    (sign,) = signs
    solved = set(found["orders"])
    for branches in found["branches"]:
        fitting = [way for way in branches if all(ours[pair] == sign * order for pair, order in way.items())]
        assert fitting
        solved |= set(fitting[0])
    assert solved == set(ours)


@pytest.mark.parametrize("settings", [Settings(), Settings(sheet="panels", kerf_mm=0.2, hinge_gap_mm=1.0)], ids=str)
@pytest.mark.parametrize("name", [DESIGN, RING, "unit-ii"])
def test_ezdxf_finds_no_fault_and_every_line_where_it_is(name, settings):
    import ezdxf

    value = exported(name)
    document = ezdxf.read(StringIO(dxf.write(value, settings)))
    audit = document.audit()
    assert (audit.errors, audit.fixes) == ([], [])
    assert document.header["$INSUNITS"] == 4
    sheet = sheet_of(value, settings)
    for layer, lines in sheet.lines.items():
        drawn = list(document.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]'))
        assert len(drawn) == len(lines)
        for entity, line in zip(drawn, lines, strict=True):
            np.testing.assert_allclose([point[:2] for point in entity.get_points()], line.points, atol=1e-9)
            assert entity.closed == line.closed == (layer == "CUT")
    outlines = [shapely.Polygon(line.points) for line in sheet.lines["CUT"]]
    assert all(outline.is_valid for outline in outlines)
