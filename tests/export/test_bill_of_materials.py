"""Bills of materials: what is counted together, and that nothing is lost or counted twice."""

import json
import math
from io import StringIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from hypothesis import given, settings

from hcsearch import Linkage, Pattern, Scene, bill_of_materials, resolve
from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.export.bill_items import bill_of_case
from hcsearch.export.bill_texts import bill_text
from hcsearch.shape.labels import label_ranges
from hcsearch.shape.mesh import facet_area
from hcsearch.shape.pattern import RIGID_CREASE, Crease
from tests.export.cases import NAMES
from tests.export.exports import MOVING, folded

HINGED = {"flat_pairs": "hinged"}


def names_in(items):
    return sorted(name for item in items for name in item.names)


@pytest.mark.parametrize("name", NAMES)
def test_each_part_is_counted_once(name):
    case = resolve(name, "none.sqlite")
    bill, pattern = bill_of_case(case), case.linkage.pattern
    assert names_in(bill.panels) == sorted(case.labels.panels)
    assert names_in(bill.hinges) == names_in(bill.springs) == sorted(case.labels.hinges)
    area = sum(map(facet_area, pattern.facets))
    assert sum(item.area * len(item.names) for item in bill.panels) == pytest.approx(area)
    assert bill.mass == pytest.approx(547.0 * area * pattern.thickness)
    cut = [math.dist(*pattern.segment(pair)) for pair, crease in pattern.creases.items() if crease.face]
    assert bill.hinge_length == pytest.approx(sum(cut))


@given(folded())
@settings(max_examples=30)
def test_single_panels_of_a_design_are_one_item_and_joined_ones_another(value):
    case = value.case
    bill = bill_of_case(case)
    areas = {len(name.split("+")) for name in case.labels.panels}
    assert {len(item.names[0].split("+")) for item in bill.panels} == areas
    singles = [item for item in bill.panels if "+" not in item.names[0]]
    assert len(singles) <= 1
    for item in bill.hinges:
        for name in item.names:
            hinge = case.linkage.pattern.hinges[case.labels.hinge(name)]
            assert (hinge.face, hinge.crease.fold) == (item.face, item.fold)


def of_polygons(polygons, creases, **scene):
    linkage = Linkage(Pattern.from_polygons(polygons, creases, 0.006))
    return bill_of_materials(linkage, Scene(**scene))


def test_panels_and_their_mirror_images_are_one_item_but_not_panels_of_other_angles():
    # a right triangle, its mirror image, and the isosceles triangle of the same two sides
    triangle = ((0.0, 0.0), (0.4, 0.0), (0.0, 0.3))
    mirrored = ((0.0, 0.0), (0.0, 0.3), (-0.4, 0.0))
    bill = of_polygons((triangle, mirrored), {(0, 1): Crease("top")})
    assert [item.names for item in bill.panels] == [("0", "1")]
    assert bill.panels[0].corners == 3
    assert bill.panels[0].area == pytest.approx(0.06)
    kite = ((0.0, 0.0), (0.0, 0.3), (-0.3, 0.3))
    bill = of_polygons((triangle, kite), {(0, 1): Crease("top")})
    assert [item.names for item in bill.panels] == [("0",), ("1",)]


def test_polygons_with_equal_sides_and_areas_are_told_apart():
    def strip(lengths, left):
        """A rectangle of three facets that are one panel: corners in the middle of its sides count for nothing."""
        edges = np.cumsum([left, *lengths]).tolist()
        return [((a, 0.0), (b, 0.0), (b, 0.1), (a, 0.1)) for a, b in pairwise(edges)]

    first, second = strip((0.1, 0.2, 0.1), 0.0), strip((0.2, 0.1, 0.1), 0.4)
    creases = {(k, k + 1): RIGID_CREASE for k in (0, 1, 3, 4)} | {(2, 3): Crease("bottom")}
    bill = of_polygons((*first, *second), creases)
    assert [(item.corners, item.names) for item in bill.panels] == [(4, ("0", "1"))]
    assert (bill.panels[0].length, bill.panels[0].width) == pytest.approx((0.4, 0.1))


def test_hinges_of_one_line_are_one_hinge_with_the_length_of_its_creases():
    bill = bill_of_materials("square:012222230000:1", db="none.sqlite", flat_pairs="merged")
    assert [(item.face, item.fold, item.length, item.names) for item in bill.hinges] == [
        ("top", "valley", pytest.approx(0.1), ("0+2", "4+10", "6+8")),
        ("bottom", "mountain", pytest.approx(0.1), ("3+11", "5+9")),
    ]


def test_springs_are_counted_by_their_laws_and_free_hinges_have_none():
    springs = {"1": "linear:0.2", "3": "linear:0.2+0.01", "5": "free", "7": "2*linear:0.1"}
    bill = bill_of_materials(MOVING, db="none.sqlite", **HINGED, springs=springs)
    assert [(item.stiffness, len(item.names)) for item in bill.springs] == [
        (0.1, 6),
        (pytest.approx(0.2), 2),
        (pytest.approx(0.2), 1),
    ]
    assert "5" not in names_in(bill.springs)
    assert bill_of_materials(MOVING, db="none.sqlite", spring="free").springs == ()


def test_laws_are_rounded_in_texts_and_exact_in_data():
    law = "2*linear:0.0437281928374651+0.0123456789"
    bill = bill_of_materials(MOVING, db="none.sqlite", springs={"1": law})
    for style in ("text", "markdown"):
        assert "2*linear:0.04373+0.01235" in bill_text(bill, style)
        assert law not in bill_text(bill, style)
    for style in ("csv", "json"):
        assert law in bill_text(bill, style)


def test_latches_and_mounted_mass_are_those_of_the_scene(tmp_path):
    path = tmp_path / "array.toml"
    path.write_text(
        f'design = "{MOVING}"\n[scene]\nequipment = 2.0\n[hinges.3]\nlatch_stiffness = 5.0\n', encoding="utf-8"
    )
    bill, bare = bill_of_materials(str(path)), bill_of_materials(MOVING, db="none.sqlite")
    assert [(item.stiffness, item.names) for item in bill.latches] == [(5.0, ("3",))]
    assert bill.mass == pytest.approx(bare.mass + 2.0 * sum(item.area * len(item.names) for item in bill.panels))
    assert bare.latches == ()


def test_dampers_are_those_that_the_scene_gives():
    own = {"3": {"damping": 0.02}, "7": {"damping": 0.0}}
    bill = bill_of_materials(MOVING, db="none.sqlite", hinges=own)
    assert [(item.damping, item.names) for item in bill.dampers] == [(0.02, ("3",))]
    assert "damping (N m s/rad)" in bill_text(bill, "text")
    every = bill_of_materials(MOVING, db="none.sqlite", damping=0.01, hinges=own)
    assert [(item.damping, len(item.names)) for item in every.dampers] == [(0.01, 6), (0.02, 1)]
    assert bill_of_materials(MOVING, db="none.sqlite").dampers == ()


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        return CliRunner().invoke(hcsearch, words)

    return call


def test_a_drive_file_has_its_drives_with_their_greatest_torques(run):
    assert run("drive", MOVING, "--flat-pairs", "hinged", "--output", "drive.toml").exit_code == 0
    case = resolve("drive.toml")
    bill = bill_of_case(case)
    assert names_in(bill.drives) == sorted(case.labels.hinges[hinge] for hinge in case.drives.hinges)
    for item in bill.drives:
        column = case.drives.hinges.index(case.labels.hinge(item.names[0]))
        assert item.torque == np.abs(case.drives.torques[:, column]).max()
        assert item.travel == np.ptp(case.drives.angles[:, column])
    assert [item.torque for item in bill.drives] == sorted((item.torque for item in bill.drives), reverse=True)


def test_each_style_has_the_same_items(run):
    for ending in ("csv", "md", "txt", "json"):
        result = run("export", MOVING, "--format", "bom", "--flat-pairs", "hinged", "--output", f"bill.{ending}")
        assert result.exit_code == 0, result.output
    bill = bill_of_materials(MOVING, db="none.sqlite", **HINGED)
    table = pd.read_csv(StringIO(Path("bill.csv").read_text(encoding="utf-8")))
    assert table["count"].groupby(table["kind"]).sum().to_dict() == {"panels": 10, "hinges": 10, "springs": 10}
    np.testing.assert_allclose(table["total_mass_g"].sum(), 1e3 * bill.mass)
    data = json.loads(Path("bill.json").read_text(encoding="utf-8"))
    assert data["panels"][0]["panels"] == label_ranges(bill.panels[0].names)
    assert (data["title"], data["scene"], data["mass_g"]) == (MOVING, "default", pytest.approx(1e3 * bill.mass))
    for ending, count in (("md", 3), ("txt", 0)):
        text = Path(f"bill.{ending}").read_text(encoding="utf-8")
        assert text.count("\n## ") == count
        assert f"{MOVING}, scene default: 10 panels of 213.2 g together, 10 hinges of 500 mm together" in text
        assert [line.split()[-1] for line in text.splitlines() if "linear:0.1" in line] == ["9" if count == 0 else "|"]
    with pytest.raises(HcsearchError, match="no style 'latex': choose text, markdown, csv or json"):
        bill_text(bill, "latex")


def test_the_table_of_pandas_has_a_row_for_each_item():
    table = bill_of_materials("thesis-4x4", db="none.sqlite").table()
    assert list(table["kind"].unique()) == ["panels", "hinges", "springs"]
    assert table["names"].notna().all()
    assert table.loc[table["kind"] == "hinges", "mass_g"].isna().all()


def test_bills_of_a_query_are_csv_in_a_folder(run):
    assert run("enumerate", "--grid", "hex", "--n", "8", "--until", "mobility").exit_code == 0
    assert run("export", "untwisted", "--format", "bom", "--output", "bills").exit_code == 0
    assert all(path.read_text(encoding="utf-8").startswith("kind,count,") for path in Path("bills").glob("*-*.csv"))
    assert len(list(Path("bills").glob("*-*.csv"))) == 1
