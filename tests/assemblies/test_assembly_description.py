import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hcsearch.library.assemblies import ASSEMBLIES, Assembly, Parameters
from hcsearch.library.assemblies.description import compare_facts, describe_assembly, stated_parameters
from hcsearch.library.assemblies.eight_r import eight_r, skew_symmetric_angles
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern

GOLDEN = json.loads((Path(__file__).parents[1] / "golden" / "thesis_assemblies.json").read_text("utf-8"))["assemblies"]

NULLABLE = {"merged_joints", "singular_values", "slit", "rank_gap"}


@pytest.mark.parametrize("name", GOLDEN)
def test_what_the_thesis_states(name):
    assembly, entry = ASSEMBLIES[name], GOLDEN[name]
    parameters = assembly.defaults
    if "base_angle_deg" in entry:
        assert math.degrees(parameters.alpha) == pytest.approx(entry["base_angle_deg"])
    facts = describe_assembly(assembly, parameters)
    expected = entry["facts"] | entry.get("differs", {})
    assert {key: facts[key] for key in expected} == expected
    disagreeing = {key for key, row in facts["published"].items() if row["agree"] is not True}
    assert disagreeing == set(entry.get("differs", {}))


@pytest.mark.parametrize("name", ASSEMBLIES)
def test_descriptions_are_plain_data_without_holes(name):
    facts = describe_assembly(ASSEMBLIES[name], ASSEMBLIES[name].defaults)
    assert json.loads(json.dumps(facts, allow_nan=False)) == facts
    missing = {key for key, value in facts.items() if value is None}
    assert missing - NULLABLE <= set(facts["undecided"])
    assert set(facts["parameters"]) <= {"alpha_deg", "base_mm", "thickness_mm", "side_mm", "width_mm", "size"}
    assert all(set(row) == {"thesis", "here", "agree"} for row in facts["published"].values())


def test_units_of_measure():
    facts = describe_assembly(ASSEMBLIES["element-8r"], Parameters(alpha=math.radians(60), base=0.030, thickness=0.010))
    assert facts["parameters"] == {"alpha_deg": 60, "base_mm": 30, "thickness_mm": 10}
    triangle = math.sqrt(3) / 4 * 30**2
    assert facts["flat_area_mm2"] == pytest.approx(10 * triangle)
    assert facts["footprint_area_mm2"] == pytest.approx(2 * triangle)
    assert facts["package_height_mm"] == pytest.approx(50)
    assert len(facts["singular_values"]) == 8
    middle = facts["slit"][2]
    assert middle["phi_1_deg"] == 90
    assert middle["stated_mm"] == pytest.approx(middle["measured_mm"])


def test_singular_values_depend_on_size_only_through_their_unit():
    """Rows of rotation are pure numbers, rows of position millimetres: of a panel much larger, others count more."""
    one = describe_assembly(ASSEMBLIES["element-8r"], Parameters())["singular_values"]
    two = describe_assembly(ASSEMBLIES["element-8r"], Parameters(base=0.3, thickness=0.1))["singular_values"]
    assert two[0] == pytest.approx(10 * one[0], rel=0.01)


@pytest.mark.parametrize("name", ["element-8r", "unit-i", "unit-ii", "fig-5.11b", "ten-triangles"])
def test_below_45_degrees_panels_interfere(name):
    assembly = ASSEMBLIES[name]
    facts = describe_assembly(assembly, replace(assembly.defaults, alpha=math.radians(40)))
    assert facts["feasible"] is False
    assert "base angle of 40 degrees" in facts["hindrances"][0]
    facts = describe_assembly(assembly, replace(assembly.defaults, alpha=math.radians(45)))
    assert facts["feasible"] is True
    assert facts["hindrances"] == []


def test_published_at_defaults_only_there():
    assembly = ASSEMBLIES["unit-ii"]
    assert "singular_values" in describe_assembly(assembly, assembly.defaults)["published"]
    same = Parameters(alpha=math.radians(70), base=30 * 1e-3, thickness=10 * 1e-3)
    assert "singular_values" in describe_assembly(assembly, same)["published"]
    assert "singular_values" not in describe_assembly(assembly, replace(assembly.defaults, base=0.031))["published"]


def test_a_pattern_that_does_not_fold_says_so():
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    squares = tuple(tuple((x + a, y + b) for a, b in corners) for x, y in corners)
    creases = {(0, 1): VALLEY_CREASE, (1, 2): VALLEY_CREASE, (2, 3): VALLEY_CREASE, (0, 3): MOUNTAIN_CREASE}
    assembly = Assembly(
        "four", "Four squares", "none", ("thickness",), lambda _: Pattern.from_polygons(squares, creases, 0.1)
    )
    facts = describe_assembly(assembly, Parameters())
    assert facts["deployment_ratio"] is None
    assert "no folded state" in facts["undecided"]["deployment_ratio"]
    assert facts["feasible"] is False
    assert facts["hindrances"] == [facts["undecided"]["layers"]]


def test_panels_so_slender_that_rounding_hides_the_folded_state():
    facts = describe_assembly(ASSEMBLIES["unit-ii"], Parameters(alpha=math.radians(89.999)))
    assert facts["feasible"] is False
    assert "less slender panels" in facts["hindrances"][0]


def test_an_undecided_rank_has_no_value_but_a_reason():
    """So near to the flat state three singular values are neither zero nor clear of the noise."""
    unit = ASSEMBLIES["unit-ii"]

    def between(parameters):
        return skew_symmetric_angles(unit.build(parameters), parameters.alpha, math.pi - 1e-11)

    facts = describe_assembly(replace(unit, generic_angles=between), unit.defaults)
    assert facts["dof"] is None
    assert facts["rank_between"] is None
    assert "above the noise" in facts["undecided"]["dof"]
    assert facts["published"]["dof"]["agree"] is None


@pytest.mark.parametrize("values", [Parameters(thickness=1e-15), Parameters(alpha=math.radians(89.99))])
def test_no_rank_is_decided_where_rounding_hides_how_thick_panels_are(values):
    facts = describe_assembly(ASSEMBLIES["unit-ii"], values)
    assert facts["dof"] is None
    assert "may hide singular values" in facts["undecided"]["dof"]


def test_comparison():
    facts = {"a": 1, "b": [1.0, 2.0, 3.0], "c": "7:1", "d": 0.0}
    rows = compare_facts({"a": 1, "b": (1.00001, 2.0), "c": "7:2", "d": 0.0}, facts)
    assert [row["agree"] for row in rows.values()] == [True, True, False, True]
    assert not compare_facts({"b": (1.0, 2.1)}, facts)["b"]["agree"]
    assert not compare_facts({"b": (1.0, 2.0, 3.0, 4.0)}, facts)["b"]["agree"]


def test_parameters_as_stated():
    assembly = replace(ASSEMBLIES["element-8r"], parameter_names=("alpha", "size"), build=eight_r)
    assert stated_parameters(assembly, Parameters(alpha=math.radians(70), size=(2, 3))) == {
        "alpha_deg": 70.0,
        "size": [2, 3],
    }
    assert stated_parameters(assembly, Parameters(alpha=0.5))["size"] is None


def test_names_are_words_of_the_command_line():
    for name, assembly in ASSEMBLIES.items():
        assert name == assembly.name
        assert name != "list"
        assert set(name) <= set("abcdefghijklmnopqrstuvwxyz0123456789.-")
        assert assembly.title
        assert assembly.source
        assert np.isfinite(assembly.build(assembly.defaults).area)
