import json
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.assembly import assembly
from hcsearch.library.assemblies import ASSEMBLIES
from tests.commands import without_progress

SVG = "{http://www.w3.org/2000/svg}"


def run(*words, code=0):
    done = subprocess.run(
        [sys.executable, "-m", "hcsearch", "assembly", *words], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return done


def call(*words):
    result = CliRunner().invoke(assembly, words, catch_exceptions=False)
    assert result.exit_code == 0
    return result.output


def test_the_list_names_every_assembly_with_its_parameters():
    lines = call("list").splitlines()
    assert [line.split()[0] for line in lines] == list(ASSEMBLIES)
    (unit,) = [line for line in lines if line.startswith("unit-ii ")]
    assert "appendix" in unit
    assert unit.endswith("alpha 70 degrees, base 30 mm, thickness 10 mm")
    rows = json.loads(call("list", "--json"))
    assert rows[0]["parameters"] == {"alpha_deg": 70, "base_mm": 30, "thickness_mm": 10}


def test_unit_ii_from_the_shell():
    done = run("unit-ii", "--alpha", "70", "--base", "30", "--thickness", "10", "--json")
    facts = json.loads(done.stdout)
    assert (facts["dof"], facts["nullity_folded"], facts["rank_between"], facts["deployment_ratio"]) == (
        1,
        4,
        23,
        "7:1",
    )
    assert facts["singular_values"][0] == pytest.approx(91.6169, abs=5e-5)
    assert facts["undecided"] == {}
    assert without_progress(done.stderr) == ""


def test_text_holds_the_same_facts_with_units():
    text = call("unit-ii")
    facts = json.loads(call("unit-ii", "--json"))
    lines = {line[:21].strip(): line[21:] for line in text.splitlines()}
    assert lines["dof"] == "1"
    assert lines["deployment ratio"] == "7:1"
    assert lines["package height"] == "90 mm"
    assert lines["flat area"] == f"{facts['flat_area_mm2']:.6g} mm2"
    assert lines["layers"] == "5 9"
    assert lines["singular values"].startswith("91.6169 73.9355")
    assert "slit distance        4.69128 mm at phi_1 = 90 degrees, 4.69128 mm by eq. 5.27" in text
    assert "the thesis           nullity folded 4: agrees" in text
    assert "DIFFERS" not in text


def test_where_the_thesis_differs_it_is_said():
    assert "the thesis           merged joints 14: DIFFERS" in call("fig-5.11b")
    assert "cut through each other at a base angle of 30 degrees: give one from 45 up" in call(
        "element-8r", "--alpha", "30"
    )


def test_sizes():
    facts = json.loads(call("array-6r", "2x3", "--json"))
    assert facts["parameters"]["size"] == [2, 3]


def test_picture(tmp_path):
    file = tmp_path / "unit.svg"
    call("unit-i", "--picture", str(file))
    root = ElementTree.fromstring(file.read_text(encoding="utf-8"))
    kinds = {path.get("class"): path.get("d").count("M") for path in root.iter(f"{SVG}path")}
    assert kinds == {"panel": 21, "mountain": 12, "valley": 12, "slit": 4}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("unit-iv",), "there is no assembly 'unit-iv': see hcsearch assembly list"),
        (("element-8r", "--alpha", "90"), "no base angle of 90 degrees: give one between 0 and 90"),
        (("element-8r", "--alpha", "0"), "give one between 0 and 90"),
        (("unit-ii", "--alpha", "1e-300"), "give one between 0 and 90, from 0.0001 to 89.9999"),
        (("unit-ii", "--base", "1e300"), "give a positive length, from 1e-12 to 1e+09 mm"),
        (("unit-ii", "--base", "1e-300"), "give a positive length, from 1e-12 to 1e+09 mm"),
        (("unit-i", "--thickness", "1e300"), "give a positive length, from 1e-12 to 1e+09 mm"),
        (("array-6r", "100x100"), "give columns and rows whose product is at most 1000"),
        (("modules-iii-pair", "9999x9999"), "give columns and rows whose product is at most 1000"),
        (("element-8r", "--base", "0"), "a base of 0 mm does not exist: give a positive length"),
        (("element-8r", "--thickness", "-1"), "a thickness of -1 mm does not exist: give a positive length"),
        (("element-8r", "--side", "50"), "element-8r does not depend on --side: leave it out"),
        (("element-8r", "2x2"), "element-8r does not depend on SIZE: leave it out"),
        (("array-6r", "2"), "'2' is no size: write columns x rows, such as 3x2"),
        (("array-6r", "0x2"), "0 x 2 is no array: give positive whole numbers"),
        (("list", "--alpha", "60"), "the list has no parameters: give them with the name of an assembly"),
    ],
)
def test_wrong_input_says_what_to_do(words, message):
    result = CliRunner().invoke(assembly, words)
    assert isinstance(result.exception, HcsearchError)
    assert message in str(result.exception)
    assert result.output == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("element-8r", "--alpha", "91"), "no base angle of 91 degrees: give one between 0 and 90"),
        (("element-8r", "--alpha", "wide"), "hcsearch assembly --help)"),
        (("element-8r", "--alpha", "nan"), "nan is not a finite number"),
        (("element-8r", "--base", "inf"), "inf is not a finite number"),
        (("element-8r", "--picture", "nowhere/a.svg"), "there is no folder nowhere: make it, or write to another"),
    ],
)
def test_wrong_input_is_one_line_and_exit_2(words, message):
    done = run(*words, code=2)
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("hcsearch: ")
    assert message in line
