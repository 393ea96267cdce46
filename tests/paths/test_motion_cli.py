"""`hcsearch motion` as a person meets it."""

import json
import math
import re

import numpy as np
import pandas as pd
import pytest

from hcsearch import follow_motion, replay, save
from hcsearch.basics.errors import HcsearchError
from tests.commands import run_here, without_progress

pytestmark = pytest.mark.filterwarnings("default::hcsearch.basics.errors.HcsearchWarning")


@pytest.fixture
def run(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    return lambda *words: run_here(["motion", *words], capfd)


def test_it_lists_branches_states_and_singular_states_and_ends_with_the_outcome(run):
    done = run("unit-ii")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "unit-ii: 21 panels, 24 hinges, 4 loops; from folded, stops at 0 and pi"
    assert "4 first-order motions, 4 second-order equations" in lines[1]
    assert lines[2].startswith("> branch 1: finite; rates -0.093 at 0 2 4")
    assert sum(line.startswith("shaky at arc length") for line in lines) == 3
    assert sum(line.endswith("  shaky") for line in lines) == 3
    assert re.fullmatch(r"flat after \d+ steps; arc length 16\.33\d+ rad along branch 1 of 1; .* 3 shaky", lines[-1])


def test_the_files_hold_the_motion(run, tmp_path):
    names = ["m.csv", "m.json", "m.glb", "m.fold", "m.svg"]
    outputs = [word for name in names for word in ("--output", name)]
    done = run("unit-ii", "--degrees", *outputs, "--picture", "plot.svg", "--json")
    assert done.returncode == 0
    printed = json.loads(done.stdout)
    table, motion = pd.read_csv("m.csv", keep_default_na=False), follow_motion("unit-ii")
    assert list(table) == [
        "arc_length_rad",
        *(f"angle_{k}_deg" for k in range(24)),
        *("closure_residual", "nullity", "least_singular_value", "event", "at_stops"),
    ]
    angles = table[[f"angle_{k}_deg" for k in range(24)]].to_numpy()
    assert np.radians(angles) == pytest.approx(motion.rows.angles, abs=1e-12)
    assert table["nullity"].tolist() == motion.rows.nullities.tolist()
    assert [kind for kind in table["event"] if kind] == ["shaky"] * 3
    assert table["at_stops"].iloc[0].split() == [str(k) for k in range(24)]
    assert table["at_stops"].iloc[20] == ""
    content = json.loads((tmp_path / "m.json").read_text(encoding="utf-8"))
    assert {name: content[name] for name in printed} == printed
    assert [row["event"] for row in content["rows"]] == table["event"].tolist()
    assert content["rows"][3]["angle_1_deg"] == pytest.approx(angles[3, 1], rel=1e-12)
    assert printed["events"][0]["angles_deg"]["0"] == pytest.approx(180.0 - 7.187, abs=1e-3)
    assert (tmp_path / "m.glb").read_bytes()[:4] == b"glTF"
    assert json.loads((tmp_path / "m.fold").read_text(encoding="utf-8"))["file_frames"]
    assert "@keyframes" in (tmp_path / "m.svg").read_text(encoding="utf-8")
    plot = (tmp_path / "plot.svg").read_text(encoding="utf-8")
    assert "@keyframes" not in plot
    for words in ("least singular value", "fold angle, degrees", "shaky, nullity 2"):
        assert words in plot


def test_a_motion_goes_on_from_a_row_of_its_table(run):
    assert run("unit-ii", "--until", "event", "--output", "first.csv").returncode == 0
    on = run("unit-ii", "--from", "first.csv", "--json")
    facts = json.loads(on.stdout)
    last = len(pd.read_csv("first.csv")) - 1
    assert (facts["start"], facts["nullity"], len(facts["branches"])) == (f"row {last} of first.csv", 2, 2)
    assert [event["kind"] for event in facts["events"]] == ["shaky", "shaky"]
    back = json.loads(run("unit-ii", "--from", "first.csv", "--row", "3", "--branch", "2", "--json").stdout)
    assert back["outcome"] == "folded"


def test_angles_may_be_rounded_and_in_degrees(run):
    state = np.degrees(follow_motion("unit-ii").rows.angles[30])
    done = run("unit-ii", "--degrees", "--angles", ",".join(f"{angle:.2f}" for angle in state), "--json")
    facts = json.loads(done.stdout)
    assert (facts["start"], facts["outcome"], facts["nullity"]) == ("the given state", "flat", 1)
    assert facts["greatest_closure_residual"] < 1e-12


def test_without_stops_more_branches_begin_and_are_followed_in_either_sense(run):
    listed = json.loads(run("unit-ii", "--no-stops", "--length", "0.5", "--json").stdout)
    assert [branch["status"] for branch in listed["branches"]] == ["finite"] * 4
    assert listed["outcome"] == "length"
    for branch in ("1", "-1"):
        facts = json.loads(run("unit-ii", "--no-stops", "--length", "0.5", "--branch", branch, "--json").stdout)
        assert (facts["branch"], facts["arc_length_rad"]) == (int(branch), pytest.approx(0.5))


def test_an_exit_code_of_1_means_that_the_goal_was_not_reached(run):
    missed = run("element-8r", "--until", "flat")
    assert missed.returncode == 1
    assert missed.stdout.splitlines()[-1].startswith("stopped, hinges at their stops: ")
    assert run("element-8r").returncode == 0
    locked = run("hex:0234550132:3")
    assert locked.returncode == 1
    assert locked.stdout.splitlines()[-1].startswith("no finite motion was found at the start")


def test_many_branches_are_counted(run):
    done = run("thesis-4x4", "--length", "0.1")
    assert re.search(r"^  and \d+ more, which --json lists$", done.stdout, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nothing",), "no assembly 'nothing'"),
        (("hex:0234550132:2",), "no two-stack folding at crease 2"),
        (("17",), "no hcsearch database"),
        (("unit-ii", "--panel", "50x6"), "leave out --panel"),
        (("unit-ii", "--branch", "2"), "no branch 2 at the start"),
        (("unit-ii", "--branch", "-1"), "give --no-stops, too"),
        (("unit-ii", "--from", "side"), "'side' names no state"),
        (("unit-ii", "--from", "none.csv"), "cannot read the states none.csv"),
        (("unit-ii", "--from", "states.csv"), "has no column angle_1_rad or angle_1_deg"),
        (("element-6r", "--from", "empty.csv"), "empty.csv has no states"),
        (("element-6r", "--from", "wrong.csv", "--row", "0"), "line 2 of wrong.csv has 'x' for angle_5_rad"),
        (("element-6r", "--from", "wrong.csv", "--row", "2"), "wrong.csv has no row 2: its rows are 0 to 1"),
        (("element-6r", "--from", "wrong.csv"), "the loops are not closed"),
        (("element-6r", "--angles", "1,2"), "a state has 6 fold angles"),
        (("element-6r", "--angles", "1,x"), "cannot read --angles '1,x'"),
        (("element-6r", "--angles", "0,0,0,0,0,nan"), "not a finite number"),
        (
            ("element-6r", "--angles", "4,4,3.14159265,4,4,3.14159265"),
            "beyond the stops, 0 and pi, of hinges 0, 1, 3, 4",
        ),
        (("element-6r", "--angles", "0,0,0,0,0,0", "--from", "flat"), "give either --from or --angles"),
        (("element-6r", "--from", "flat", "--row", "1"), "row 1 is one of a table"),
        (("element-6r", "--from", "flat", "--until", "flat"), "the motion begins flat"),
        (("element-6r", "--length", "0"), "--length"),
        (("element-6r", "--output", "a.step"), "a.step is no name for a file of a motion"),
        (("element-6r", "--output", "a.csv", "--output", "nowhere/a.glb"), "there is no folder nowhere"),
        (("element-6r", "--picture", "a.gif"), "a.gif has no known ending"),
        (("hex:0234550132:3", "--output", "a.csv", "--output", "a.glb"), "does not move from folded"),
    ],
)
def test_wrong_input_is_one_line_and_writes_nothing(run, tmp_path, words, message):
    (tmp_path / "states.csv").write_text("angle_0_rad\n0\n", encoding="utf-8")
    heads = ",".join(f"angle_{k}_rad" for k in range(6))
    (tmp_path / "empty.csv").write_text(heads + "\n", encoding="utf-8")
    (tmp_path / "wrong.csv").write_text(f"{heads}\n0,0,0,0,0,x\n1,1,1,1,1,1\n", encoding="utf-8")
    before = sorted(tmp_path.iterdir())
    done = run(*words)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(without_progress(done.stderr).splitlines()) == 1
    assert done.stdout == ""
    assert sorted(tmp_path.iterdir()) == before


def test_python_has_the_table_the_replay_and_the_exports(tmp_path):
    motion = follow_motion("hex:0234550132:4", panel="100x8")
    assert repr(motion).startswith("<hex:0234550132:4 from folded: stopped, ")
    table = motion.table(degrees=True)
    hinges = [f"angle_{name}_deg" for name in motion.labels.hinges]
    assert list(table)[1 : 1 + len(hinges)] == hinges
    assert table[hinges].to_numpy() == pytest.approx(np.degrees(motion.rows.angles))
    assert str(table["nullity"].dtype) == "Int64"
    played = replay(motion)
    assert played.labels == motion.labels
    assert played.at[[0, -1]].tolist() == [0.0, 1.0]
    assert played.angles[-1] == pytest.approx(motion.rows.angles[-1])
    assert played.at_time(np.array([0.5]))[0] == pytest.approx(
        [np.interp(0.5 * motion.rows.lengths[-1], motion.rows.lengths, column) for column in motion.rows.angles.T],
        abs=2e-3,
    )
    for name in ("a.glb", "a.fold", "a.csv", "a.svg"):
        assert save(played, tmp_path / name) == [tmp_path / name]
    assert list(pd.read_csv(tmp_path / "a.csv")) == list(played.table())
    with pytest.raises(HcsearchError, match="a Replay has its scene"):
        save(played, tmp_path / "b.glb", panel="50x6")
    with pytest.raises(HcsearchError, match="is no name for a file of a motion"):
        save(played, tmp_path / "b.step")
    with pytest.raises(HcsearchError, match="is no name for a file of a motion as csv"):
        save(played, tmp_path / "b.glb", format="csv")
    assert not (tmp_path / "b.glb").exists()


def test_a_motion_that_begins_flat_is_played_towards_flat():
    motion = follow_motion("unit-ii", start="flat")
    played = replay(motion)
    assert played.angles[0] == pytest.approx(motion.linkage.folded)
    assert played.ends_flat
    assert (np.diff(played.at) > 0.0).all()


def test_motions_of_one_call_made_twice_are_equal_and_play_in_notebooks():
    one, two = follow_motion("element-6r"), follow_motion("element-6r")
    assert one == two
    assert one != follow_motion("element-6r", length=1.0)
    assert one._repr_html_().count("<iframe") == 1
    assert follow_motion("hex:0234550132:3")._repr_html_() is None


def test_the_first_step_is_told_before_branches_are_searched_for():
    steps = []
    follow_motion("element-6r", progress=lambda *step: steps.append(step))
    assert steps == [(0, 2, "branches at the start"), (1, 2, "motion")]
    assert math.isclose(follow_motion("element-6r", length=0.25).rows.lengths[-1], 0.25)
