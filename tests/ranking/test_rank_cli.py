"""`hcsearch rank` as a person meets it."""

import csv
import io
import json
import sqlite3
import subprocess
from contextlib import closing
from functools import partial

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.store.schema import SCHEMA_REVISION
from tests import forking, next_schema

NAMES = [quantity.name for quantity in RANKING_CRITERIA if quantity.weight]


def call(path, *words):
    """Standard output and standard error."""
    result = CliRunner().invoke(hcsearch, ["rank", "--db", str(path), *words], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout, result.stderr


def refused(path, *words, run=forking.run):
    """What a real process says; the database must stay as it is."""
    before = path.read_bytes()
    done = run(["rank", "--db", path, *words])
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("hcsearch: ")
    assert done.stderr.count("\n") == 1
    assert path.read_bytes() == before
    return done.stderr


def records(text):
    return list(csv.DictReader(io.StringIO(text)))


def scores(path, scene="default"):
    with closing(sqlite3.connect(path)) as connection:
        return dict(connection.execute("SELECT design_id, score FROM score WHERE scene = ?", (scene,)))


def test_formats_agree(path):
    out, err = call(path, "untwisted", "--format", "csv")
    rows = records(out)
    assert list(rows[0]) == ["rank", "id", "circuit", "score", "pareto", *NAMES]
    left_out = 25 - len(rows)
    assert left_out > 0
    assert err == f"left out: {left_out} designs that are known not to deploy\n"
    data = json.loads(call(path, "untwisted", "--format", "json")[0])
    assert [{k: "" if v is None else str(v) for k, v in row.items()} for row in data] == rows
    table = call(path, "untwisted")[0].splitlines()
    markdown = call(path, "untwisted", "--format", "markdown")[0].splitlines()
    assert len(table) == len(markdown) == len(rows) + 2
    for head in (table[0], markdown[0]):
        assert "min_clearance (mm)" in head
        assert "deploy_time (s)" in head
    assert " - " in "\n".join(table)


def test_a_query_that_leaves_nobody_out_says_nothing_more(path):
    assert call(path, "deployable")[1] == ""


def test_limit_and_front(path):
    rows = records(call(path, "--format", "csv")[0])
    front = [row for row in rows if row["pareto"] == "1"]
    assert 1 < len(front) < len(rows)
    assert records(call(path, "--pareto", "--format", "csv")[0]) == front
    assert records(call(path, "--pareto", "--limit", "1", "--format", "csv")[0]) == front[:1]
    assert records(call(path, "--limit", "3", "--format", "csv")[0]) == rows[:3]
    assert records(call(path, "--limit", "0", "--format", "csv")[0]) == []


def test_weights_change_scores_and_columns(path):
    rows = records(call(path, "--weight", "dof=2.5", "--weight", "symmetry=0", "--format", "csv")[0])
    assert "symmetry" not in rows[0]
    plain = {row["id"]: row["score"] for row in records(call(path, "--format", "csv")[0])}
    assert {row["id"]: row["score"] for row in rows} != plain
    again = records(call(path, "--weight", "dof=1", "--format", "csv")[0])
    assert {row["id"]: row["score"] for row in again} == plain


def test_nothing_to_rank_is_a_result(path):
    assert json.loads(call(path, "n=99", "--format", "json")[0]) == []
    out, err = call(path, "status=locked", "--format", "csv")
    assert records(out) == []
    assert err.startswith("left out: ")


def test_without_save_nothing_is_written(path):
    before = path.read_bytes()
    call(path)
    assert path.read_bytes() == before
    assert scores(path) == {}


def test_save_stores_every_ranked_design_also_those_not_printed(path):
    rows = records(call(path, "--format", "csv")[0])
    out, err = call(path, "--save", "--pareto", "--limit", "1", "--format", "csv")
    assert len(records(out)) == 1
    assert err.endswith(f"scores saved: {len(rows)} designs in {path}\n")
    assert {str(k): str(v) for k, v in scores(path).items()} == {row["id"]: row["score"] for row in rows}


def test_a_scene_is_ranked_and_saved_beside_the_default_one(path):
    call(path, "--save")
    before = scores(path)
    rows = records(call(path, "deployable", "--scene", "solar", "--save", "--format", "csv")[0])
    assert rows != records(call(path, "deployable", "--format", "csv")[0])
    assert {row["deploy_time"] for row in rows} == {"0.5"}
    assert scores(path) == before
    assert {str(k): str(v) for k, v in scores(path, "solar").items()} == {row["id"]: row["score"] for row in rows}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--weight", "doff=1"), "no criterion 'doff' (did you mean dof?): weigh symmetry, "),
        (("--weight", "status=1"), "no criterion 'status'"),
        (("--weight", "dof=-1"), "the weight -1.0 of dof is out of range: give 0 or more"),
        (("--weight", "dof=nan"), "the weight nan of dof is out of range"),
        (("--weight", "dof=1e999"), "the weight inf of dof is out of range"),
        (("--weight", "dof=heavy"), "cannot read the weight 'dof=heavy': write NAME=W, such as dof=2"),
        (("--weight", "dof"), "cannot read the weight 'dof': write NAME=W"),
        (("--weight", "=2"), "no criterion ''"),
        (("--weight", ""), "cannot read the weight ''"),
        (("--weight", "dof=1", "--weight", "dof=2"), "the weight of dof is given twice: give it once"),
        ([part for name in NAMES for part in ("--weight", f"{name}=0")], "give one criterion a positive weight"),
        (("size=3",), "no column 'size' in designs"),
        (("n=ten",), "n is compared with a number"),
        (("--limit", "-1"), "--limit"),
        (("--format", "parquet"), "'parquet' is not one of"),
        (("--save", "--weight", "dof=x"), "cannot read the weight"),
        (("--save", "--scene", "moon"), "no verdicts of the scene 'moon' in "),
    ],
)
def test_bad_input_is_one_line_and_changes_nothing(path, words, message):
    assert message in refused(path, *words)


def test_databases_that_cannot_be_used(tmp_path, path):
    for words in ((), ("--save",)):
        done = forking.run(["rank", "--db", "none.sqlite", *words], cwd=tmp_path)
        assert done.returncode == 2
        assert "there is no hcsearch database at none.sqlite: make one with `hcsearch enumerate`" in done.stderr
    assert not (tmp_path / "none.sqlite").exists()
    ahead = next_schema.program_ahead(tmp_path / "migrations")
    words = partial(subprocess.run, capture_output=True, text=True, check=False)
    assert f"has the older schema {SCHEMA_REVISION}" in refused(path, run=lambda rest: words([*ahead, *rest]))


def test_a_file_that_cannot_be_written_is_ranked_but_takes_no_scores(path, monkeypatch):
    # The superuser, whom tests may run as, is refused nothing; so the answer of the system is made up.
    monkeypatch.setattr("hcsearch.store.location.os.access", lambda *_: False)
    assert records(call(path, "--format", "csv")[0])
    result = CliRunner().invoke(hcsearch, ["rank", "--db", str(path), "--save"])
    assert "cannot be written: allow writing to" in str(result.exception)
    assert result.output == ""
    assert scores(path) == {}


def test_help_tells_unit_and_direction_of_each_criterion():
    text = CliRunner().invoke(hcsearch, ["rank", "--help"]).output
    for quantity in RANKING_CRITERIA:
        line = next(line for line in text.splitlines() if line.split()[:1] == [quantity.name])
        assert f"{quantity.better} is better" in line
        assert quantity.unit in line
        assert line.endswith("weight 0 unless given") == (not quantity.weight)
