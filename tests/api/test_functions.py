"""The functions of Python do what the commands do."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch import (
    SCENES,
    Circuit,
    Folding,
    check,
    deploy,
    describe,
    enumerate_into,
    open_database,
    open_readonly,
    rank,
    read,
    replay,
    show,
    tune,
)
from hcsearch.basics.errors import HcsearchError, QueryError
from hcsearch.cli import hcsearch as command_line
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.subjects.resolve import resolve

SMALL = "hex:023350:1"


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HCSEARCH_DB", raising=False)


def printed(*words):
    result = CliRunner().invoke(command_line, words, catch_exceptions=False)
    assert result.exit_code in {0, 1}, result.output
    return result.stdout


def same(one, two):
    """Whether two deployments are the same, but for what names the scene."""
    return {name: value for name, value in one.items() if name != "scene"} == {
        name: value for name, value in two.items() if name != "scene"
    }


def test_deploy_is_the_command():
    folding = Folding.from_notation(SMALL)
    expected = json.loads(printed("deploy", SMALL, "--seconds", "0.02", "--springs", "0=linear:0.2", "--json"))
    values = {"seconds": 0.02, "springs": {0: "linear:0.2"}}
    for what in (SMALL, folding, folding.circuit, folding.linkage()):
        assert same(json.loads(json.dumps(deploy(what, **values).facts())), expected)
    scene = SCENES["default"]
    assert same(deploy(folding, scene, **values).facts(), expected)
    assert same(deploy(folding, "default", **values).facts(), expected)


def test_what_is_deployed_shows_its_states(tmp_path):
    deployed = deploy("hex:02234400:1")
    assert repr(deployed) == f"<hex:02234400:1: collides, {deployed.reason}>"
    assert deployed.reason.startswith("panels 4 and 7 collide at 0.01282 s; flat after ")
    assert (deployed.verdict, deployed.flat_time) == ("collides", deployed.facts()["flat_time_s"])
    assert list(deployed.table())[7:13] == [f"angle_{k}_rad" for k in (0, 2, 3, 4, 6, 7)]
    deployed.picture("a.svg")
    assert "collides, panels 4 and 7 collide at 0.01282 s" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    shown = replay(deployed)
    assert (shown.title, shown.labels.panels) == ("hex:02234400:1", ("0", "1+2", "3", "4", "5+6", "7"))
    assert shown.collision == deployed.deployment.check.collision


def test_a_case_is_shown_and_checked_as_its_name_is():
    enumerate_into("designs.sqlite", grid="hex", n=8, panel="60x60x5")
    best = read("designs.sqlite", "untwisted", columns="id", panel="60x60x5")["id"][0]
    case = resolve(str(best), "designs.sqlite")
    shown, named = show(case), show(f"{best}:{case.folding.crease}", db="designs.sqlite")
    assert shown.foldings == named.foldings == [case.folding]
    assert shown.panel == (0.06, 0.06, 0.005)
    assert shown.stored.scene == "60x60x5"
    assert list(shown.sentences(case.folding)) == list(named.sentences(case.folding))
    checked, by_name = check(case), check(case.folding.notation, panel="60x60x5")
    assert checked.funnel == by_name.funnel
    assert [verdict.folding for verdict in checked.verdicts] == [case.folding]
    alone = resolve("hex:0234550132:3")
    assert show(alone).stored is None
    assert [folding.crease for folding in show(alone).foldings] == [3]
    assert show(resolve("thesis-4x4")).facts == show("thesis-4x4").facts == describe("thesis-4x4")
    with pytest.raises(HcsearchError, match="thesis-4x4 is no"):
        check(resolve("thesis-4x4"))


def test_circuits_with_several_foldings_have_to_be_told_which():
    with pytest.raises(HcsearchError, match=r"has 2 foldings: name one as hex:02334051:CREASE"):
        deploy(Circuit.from_notation("hex:02334051"))


def test_wrong_names_of_hinges_are_one_line():
    with pytest.raises(HcsearchError, match="crease 1 carries no hinge here"):
        deploy(SMALL, springs={1: "free"})
    with pytest.raises(HcsearchError, match="there is no panel 99"):
        deploy(Folding.from_notation(SMALL).linkage(), held=99)
    with pytest.raises(HcsearchError, match="a scene has no 'speed'"):
        deploy(SMALL, speed=3)


def test_replays_are_paths_or_what_springs_do():
    folding = Folding.from_notation("hex:0234435011:1")
    path = replay(folding)
    assert (path.axis, path.title) == ("path", folding.notation)
    assert replay(folding, motion="springs").axis == "time"


def test_tune_is_the_command_and_goes_on_where_it_stopped(tmp_path):
    design = "hex:0233340501:3"
    expected = json.loads(printed("tune", design, "--evaluations", "8", "--samples", "0", "--json", "--db", "a.sqlite"))
    tuning = tune(Folding.from_notation(design), evaluations=8, samples=0, keep_in="b.sqlite")
    assert json.loads(json.dumps(tuning.facts())) == expected
    assert expected["hinges"] == [0, 1, 2, 4, 5, 6, 7, 9]
    assert expected["merged_panels"] == ["3+4", "8+9"]
    assert list(tuning.springs.values()) == list(tuning.chosen.stiffnesses)
    assert tune(design, evaluations=8, samples=0, keep_in="b.sqlite").recalled == tuning.evaluations
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.sqlite", "b.sqlite"]


def test_springs_that_were_tuned_are_those_of_a_deployment():
    tuning = tune("hex:0233340501:3", evaluations=8, samples=0)
    again = deploy("hex:0233340501:3", springs={name: f"linear:{k!r}" for name, k in tuning.springs.items()})
    assert np.array_equal(again.deployment.angles, tuning.chosen.deployment.angles)


def test_enumerate_into_is_the_command():
    funnel = enumerate_into("a.sqlite", grid="hex", n=8, until="twist")
    out = printed("enumerate", "--grid", "hex", "--n", "8", "--until", "twist", "--db", "b.sqlite")
    assert [int(line.split()[-1]) for line in out.splitlines()[1:6]] == [
        funnel.fixed_circuits, funnel.circuits, funnel.arrays, funnel.two_stack, funnel.untwisted
    ]  # fmt: skip
    assert read("a.sqlite").equals(read("b.sqlite"))
    assert enumerate_into("a.sqlite", grid="hex", n=np.int64(8), until="twist") == funnel
    wall = parse_array(GRIDS["hex"], "3-4-3")
    with open_database("c.sqlite", create=True) as database:
        assert enumerate_into(database, array=wall, until="twist") == enumerate_into(
            "d.sqlite", grid=GRIDS["hex"], array="3-4-3", until="twist"
        )
        assert set(read(database).array) == {wall.canonical().notation}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"n": 8}, "name a grid"),
        ({"grid": "hex"}, "either"),
        ({"grid": "hex", "n": 8, "array": "3-4-3"}, "either"),
        ({"grid": "hex", "n": 8, "jobs": 10**6}, "more than four processes a core"),
        ({"grid": "hex", "n": 8, "until": "sorting"}, "sorting"),
    ],
)
def test_runs_that_cannot_be_are_refused_before_a_database_is_made(tmp_path, words, message):
    with pytest.raises(HcsearchError, match=message):
        enumerate_into("a.sqlite", **words)
    assert list(tmp_path.iterdir()) == []


def test_tables_have_the_kinds_of_their_columns():
    enumerate_into("a.sqlite", grid="hex", n=8, until="twist")
    table = read("a.sqlite", "two_stack", columns=("id", "circuit", "dof", "needed_margin", "untwisted"), limit=2)
    assert [str(kind) for kind in table.dtypes] == ["Int64", "string", "Int64", "Float64", "boolean"]
    assert table["dof"].isna().all()
    folded = read("a.sqlite", view="foldings")
    assert len(folded) == read("a.sqlite", sql="SELECT count(*) AS n FROM foldings")["n"][0]
    with pytest.raises(QueryError, match="a SELECT stands alone"):
        read("a.sqlite", "untwisted", sql="SELECT 1")


def test_ranks_are_those_of_the_command():
    enumerate_into("a.sqlite", grid="hex", n=8, until="mobility")
    words = ("rank", "--db", "a.sqlite", "--weight", "dof=2", "--format", "json")
    expected = json.loads(printed(*words))
    ranked = rank("a.sqlite", weights={"dof": 2.0})
    assert ranked["circuit"].tolist() == [row["circuit"] for row in expected]
    assert ranked["score"].tolist() == pytest.approx([row["score"] for row in expected])
    front = rank("a.sqlite", weights={"dof": 2.0}, pareto=True, limit=1)
    assert front["pareto"].all()
    assert len(front) == 1
    with open_readonly("a.sqlite") as database:
        assert rank(database).equals(rank("a.sqlite"))
    rank("a.sqlite", save=True)
    assert read("a.sqlite", "score>=0", columns="score")["score"].notna().any()
