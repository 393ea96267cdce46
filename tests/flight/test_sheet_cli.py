"""`hcsearch sheet`, and `hcsearch tune --rule`, as users type them."""

import json
import re

import pytest

from tests.commands import run_here, without_progress
from tests.documents import ROOT

NAME = "hex:0234550132:4"
SCENE = """
[scene]
spring = "linear:0.1+0.02"
friction = 0.002
harness = 0.001
envelope = "3U"
"""


@pytest.fixture
def solar(tmp_path):
    path = tmp_path / "solar.toml"
    path.write_text(SCENE)
    return str(path)


@pytest.fixture
def run(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *words: run_here(words, capfd)


def test_a_sheet_lists_rules_and_its_exit_code_tells_whether_they_pass(run, solar):
    done = run("sheet", NAME, "--scene", solar)
    assert done.returncode == 1
    assert re.search(r"verdict +fail", done.stdout)
    asked = " +at least 7\\.5 +fail"
    assert re.search(r"torque of springs over resistance +4\.7\.5\.3\.1 +6\.667 +simulated" + asked, done.stdout)
    failed = r"the same, one spring failed +4\.7\.5\.3\.2 f +4\.7\d+ +simulated, from below"
    assert re.search(failed + asked, done.stdout)
    assert "Sensitivities" in done.stdout
    assert without_progress(done.stderr) == ""


def test_the_example_of_the_readme_passes(run, tmp_path):
    (sentence,) = (
        line for line in (ROOT / "README.md").read_text("utf-8").splitlines() if "--scene flight.toml`" in line
    )
    given = re.findall(r"`(\w+ = [^`]+)`", sentence)
    assert len(given) == 4
    (tmp_path / "flight.toml").write_text("\n".join([given[0], "[scene]", *given[1:]]))
    done = run("sheet", NAME, "--scene", "flight.toml")
    assert (done.returncode, without_progress(done.stderr)) == (0, "")
    assert re.search(r"verdict +pass", done.stdout)


def test_springs_that_pass_are_written_to_a_file_whose_sheet_passes_those_rules(run, solar, tmp_path):
    done = run("tune", NAME, "--rule", "ecss", "--scene", solar, "--output", "chosen.toml")
    assert done.returncode == 0
    assert re.search(r"torque margin +7\.5\d*, at least 7\.5 is required, with any one spring failed", done.stdout)
    reviewed = json.loads(run("sheet", "chosen.toml", "--json").stdout)
    verdicts = {one["rule"]: one["verdict"] for one in reviewed["rules"]}
    assert verdicts["torque of springs over resistance"] == "pass"
    assert verdicts["the same, one spring failed"] == "pass"
    assert verdicts["room in the envelope"] == "pass"
    assert (tmp_path / "chosen.toml").read_text().count("linear:0.1+0.02") >= 4
    facts = json.loads(run("tune", NAME, "--rule", "ecss", "--scene", solar, "--json").stdout)
    assert facts["torque_margin"] >= facts["required"] == 7.5
    assert facts["no_smaller_total_passes_N_m"] <= facts["total_preload_N_m"]


def test_a_sheet_without_unknown_figures_passes_with_exit_code_0(run, tmp_path):
    rules = 'title = "A"\nissue = "1"\n[motorisation]\nclause = "1"\noverall = 1\nsprings = 1\nfriction = 1\n'
    (tmp_path / "mild.toml").write_text(rules + "harness = 1\nfriction_measured = 1\nharness_measured = 1\n")
    (tmp_path / "solar.toml").write_text(SCENE)
    done = run("sheet", NAME, "--scene", "solar.toml", "--rules", "mild.toml")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"verdict +pass", done.stdout)


@pytest.mark.parametrize(
    ("suffix", "mark"), [("md", "|:"), ("tex", "\\toprule"), ("txt", "----"), ("html", "<!DOCTYPE html>")]
)
def test_files_of_all_formats(run, solar, tmp_path, suffix, mark):
    done = run("sheet", NAME, "--scene", solar, "--output", f"sheet.{suffix}")
    assert (done.returncode, done.stdout) == (1, f"sheet.{suffix}\n")
    text = (tmp_path / f"sheet.{suffix}").read_text()
    assert mark in text
    assert "4.7.5.3.2 f" in text


def test_the_page_has_its_drawings_and_no_scripts(run, tmp_path):
    (tmp_path / "a.toml").write_text(
        SCENE.replace("[scene]", 'name = "sun"\n[scene]\ncraft = [[-0.02, -0.02, -0.1, 0.04, 0.04, 0.09]]')
    )
    run("sheet", NAME, "--scene", "a.toml", "--output", "sheet.html")
    page = (tmp_path / "sheet.html").read_text()
    titles = ("Torque margin along the travel", "Sensitivities of torque margin", "Packed", "Swept volume")
    assert all(title in page for title in titles)
    assert 'class="envelope"' in page
    assert 'class="craft"' in page
    assert re.search(r"A box of [\d.]+ x [\d.]+ x [\d.]+ mm holds all panels at all times\.", page)
    assert "<script>" not in page
    assert "script-src;" not in page


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("sheet", NAME, "--rules", "nasa"), "there are no rules 'nasa'"),
        (("sheet", NAME, "--rules", "none.toml"), "cannot read none.toml"),
        (("sheet", NAME, "--output", "sheet.pdf"), "sheet.pdf"),
        (("sheet", "thesis-4x4"), "is an assembly"),
        (("sheet", NAME, "--friction", "-1"), "friction cannot be -1"),
        (("tune", NAME, "--rule", "ecss"), "nothing resists the springs"),
        (("tune", NAME, "--rule", "ecss", "--catalogue", "0.1"), "leave out --catalogue"),
        (("tune", NAME, "--offer", "linear:0.1"), "apply to a rule: add --rule ecss"),
        (("tune", NAME, "--rule", "ecss", "--friction", "0.001", "--offer", "bend:3"), "cannot read the law"),
    ],
)
def test_wrong_input_is_one_line_with_a_remedy(run, tmp_path, words, message):
    done = run(*words)
    assert (done.returncode, done.stdout) == (2, "")
    assert without_progress(done.stderr).count("\n") == 1
    assert message in done.stderr
    assert not list(tmp_path.iterdir())
