"""Foldings that no simulation decides: counted by how their simulations end, wherever designs are counted."""

import json

import pytest
from click.testing import CliRunner

from hcsearch.basics.simulation_summaries import (
    UNDECIDED_REMEDIES,
    undecided_counts,
    undecided_ending,
    undecided_sentences,
)
from hcsearch.basics.vocabulary import ENDINGS
from hcsearch.cli import hcsearch
from hcsearch.springs.deployment.agreement import SimulationFindings, agreement_of_simulations
from hcsearch.springs.deployment.outcomes import reason_of_check

LINES = "not decided by simulation: 4 foldings (moving 4)", "these may decide: moving: a scene with more seconds"


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("clear", [True, None])
def test_the_ending_is_read_from_the_reason_of_a_check(ending, clear):
    expected = "contact not decided" if ending == "flat" else ending
    assert undecided_ending(reason_of_check(ending, 0.5, clear, None, None)) == expected
    assert expected in UNDECIDED_REMEDIES


@pytest.mark.parametrize(
    ("outcome", "verdict", "loose", "ending"),
    [
        ("flat", "undecided", 0.0, "contact not decided"),
        ("moving", "undecided", 0.0, "branch-singular"),
        ("flat", "deploys", 0.5, "branch-singular"),
    ],
)
def test_the_ending_is_read_from_the_reason_of_an_agreement(outcome, verdict, loose, ending):
    first = SimulationFindings(1e-6, "flat", "deploys", 0.5, loose)
    agreement = agreement_of_simulations([first, SimulationFindings(1e-7, outcome, verdict, 0.5, loose)])
    assert agreement.verdict == "undecided"
    assert undecided_ending(agreement.reason) == ending


def test_sentences_count_and_name_what_may_decide():
    reasons = {1: "out of steps at 1 s, clear until then", 2: "diverged at 1 s: x", 3: "out of steps at 2 s, clear"}
    counts = undecided_counts(reasons)
    assert counts == {"out of steps": 2, "diverged": 1}
    line, remedies = undecided_sentences(counts)
    assert line == "not decided by simulation: 3 foldings (out of steps 2, diverged 1)"
    assert "out of steps: hcsearch deploy with --formulation compliant" in remedies
    assert undecided_sentences({}) == ()
    assert undecided_sentences({"stuck": 1})[1].endswith("stuck: stiffer springs, or less friction or harness")


def call(*words):
    result = CliRunner().invoke(hcsearch, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A database with verdicts in a scene that is too short for any folding to open, and what its search printed."""
    folder = tmp_path_factory.mktemp("short")
    scene = folder / "short.toml"
    scene.write_text("[scene]\nseconds = 0.001\n", encoding="utf-8")
    words = ("enumerate", "--grid", "square", "--n", 8, "--keep", "untwisted", "--until", "deployment")
    words = (*words, "--scene", scene, "--jobs", 1)
    return folder / "designs.sqlite", words, call(*words, "--db", folder / "designs.sqlite").stdout


def test_searches_count_what_no_simulation_decides(searched):
    path, words, text = searched
    for line in LINES:
        assert line in text.splitlines()
    again = call(*words, "--db", path).stdout
    assert "0 done" in again
    dry = call(*words, "--dry-run").stdout
    for line in LINES:
        assert line in again.splitlines()
        assert line in dry.splitlines()


def test_queries_count_what_no_simulation_decides_beside_their_rows(searched):
    path, _, _ = searched
    result = call("query", "untwisted", "--scene", "short", "--db", path)
    assert result.stderr.splitlines() == list(LINES)
    as_json = call("query", "untwisted", "--scene", "short", "--db", path, "--format", "json")
    assert json.loads(as_json.stdout)
    assert as_json.stderr == ""
    without_rows = call("query", "n_foldings<2", "--scene", "short", "--db", path).stderr
    assert without_rows == "no design: the least n_foldings here is 4\n"


def test_reports_count_what_no_simulation_decides(searched, tmp_path):
    path, _, _ = searched
    call("report", "untwisted", "--scene", "short", "--db", path, "--output", tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Not decided by simulation: 4 foldings (moving 4)." in page
