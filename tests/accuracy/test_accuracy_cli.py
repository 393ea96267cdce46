"""`hcsearch accuracy` as a person meets it."""

import json

import pandas as pd
import pytest

from hcsearch import Case, accuracy, resolve
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import INTEGRATORS
from hcsearch.springs.accuracy.work_rows import TOLERANCES
from tests.accuracy.subjects import FOLDING
from tests.commands import run_here, without_progress

QUICK = ("accuracy", FOLDING, "--formulation", "quasistatic")
ROWS = len(INTEGRATORS) * len(TOLERANCES)


def test_a_table_and_the_cheapest_setting(capfd, tmp_path):
    picture, table = tmp_path / "work.svg", tmp_path / "work.csv"
    words = (*QUICK, "--error", "1e-3 rad", "--picture", str(picture), "--output", str(table))
    done = run_here(words, capfd)
    assert done.returncode == 0
    assert without_progress(done.stderr) == ""
    lines = done.stdout.splitlines()
    assert lines[0].startswith("quasistatic: reference ")
    assert " with nothing left out agrees to " in lines[0]
    assert sum(line.startswith("> ") for line in lines) == 1
    assert lines[-1].startswith("cheapest for 0.001 rad: hcsearch deploy --formulation quasistatic --method ")
    rows = pd.read_csv(table)
    assert len(rows) == ROWS
    assert "default" in picture.read_text(encoding="utf-8")


def test_json_has_all_numbers(capfd):
    done = run_here((*QUICK, "--json", "--error", "1e-12"), capfd)
    facts = json.loads(done.stdout)
    assert facts["cheapest"] is None
    assert facts["formulations"][0]["reference"]["angle_doubt_rad"] < 1e-6
    assert len(facts["formulations"][0]["rows"]) == ROWS


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--error", "0"), "0"),
        (("--error", "much"), "not a valid"),
        (("--limit", "-1"), "-1"),
        (("--output", "work.txt"), "no known ending"),
        (("--damping", "0"), "nothing can be measured"),
    ],
)
def test_wrong_input_is_one_line(words, said, capfd):
    done = run_here((*QUICK, *words), capfd)
    assert done.returncode == 2
    lines = without_progress(done.stderr).splitlines()
    assert len(lines) == 1
    assert said in lines[0]


def test_the_function_refuses_what_the_command_refuses():
    with pytest.raises(HcsearchError, match="positive"):
        accuracy(FOLDING, error=0.0)
    with pytest.raises(HcsearchError, match="limit"):
        accuracy(FOLDING, limit=float("nan"))


def test_a_case_is_taken_as_it_is(capfd):
    case = resolve(FOLDING, values={"held": "2"})
    assert isinstance(case, Case)
    measured = accuracy(case, formulation="quasistatic", limit=0.5)
    assert measured.scene == "default"
    assert measured.works[0].reference.first.deployment.compiled.setup.held == case.setup.held
