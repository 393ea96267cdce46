"""`hcsearch tune` as a person meets it."""

import json
import shlex
import signal
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace
from itertools import chain
from pathlib import Path
from unittest.mock import Mock

import click
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.scenes import SCENES
from hcsearch.shape.labels import Labels
from hcsearch.springs.deployment.outcomes import DeploymentCheck
from hcsearch.springs.tuning.choice import SpringSet
from hcsearch.springs.tuning.robustness import Robustness
from hcsearch.springs.tuning.spring_tuning import Tuning
from hcsearch.store import open_readonly, select

DESIGN = "hex:0233340501:3"
QUICK = ("--evaluations", "30", "--samples", "4")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HCSEARCH_DB", raising=False)
    return tmp_path


def run(*words, code=0):
    result = CliRunner().invoke(hcsearch, words, catch_exceptions=False)
    assert result.exit_code == code
    return result.stdout


def test_a_tuning_is_told_stored_and_replayed(folder):
    words = ("tune", DESIGN, *QUICK, "--catalogue", "0.07,0.10", "--output", "found.toml", "--json")
    printed = json.loads(run(*words))
    assert printed["formulation"] == "constrained"
    assert not printed["interrupted"]
    for name in ("best", "rounded"):
        one = printed[name]
        assert one["confirmed"]
        assert one["certified"] == "clear"
        assert one["samples"] == 4
        low, high = one["collision_interval_95"]
        assert low <= one["collision_probability"] <= high
    again = json.loads(run(*words))
    assert again["known_before"] == again["evaluations"] == printed["evaluations"]
    assert again["best"] == printed["best"]
    assert printed["evaluations"] <= 30
    assert again["samples_known_before"] == again["samples"] == printed["samples"]
    at_hinges = printed["buy"]["at_hinges_N_m_rad"]
    assert list(map(sum, at_hinges)) == pytest.approx(printed["rounded"]["stiffness_N_m_rad"])
    counts = Counter(chain.from_iterable(at_hinges))
    assert {one["stiffness_N_m_rad"]: one["count"] for one in printed["buy"]["springs"]} == counts
    assert (folder / "found.toml").read_text().startswith("# buy: ")
    text = run(*words[:-1])
    (used,) = [line for line in text.splitlines() if line.startswith("catalogue  ")]
    replayed_reason = json.loads(run("deploy", "found.toml", "--json"))["reason"]
    assert used.split(maxsplit=1)[1].startswith(f"{replayed_reason}, certified clear")
    replayed = json.loads(run("deploy", "found.toml", "--json"))
    assert replayed["outcome"] == "flat"
    assert replayed["clearance"] == "clear"
    # printed with the digits that several tolerances agree on
    assert replayed["flat_time_s"] == pytest.approx(printed["rounded"]["flat_time_s"], rel=1e-3)
    with open_readonly(str(folder / "hcsearch.sqlite")) as database:
        rows = select(database, "outcome=flat clear", columns="subject,springs,clearance", view="evaluations").rows
    assert rows
    assert all(json.loads(row[0])["design"] == DESIGN for row in rows)


def test_text_tells_each_set_and_each_hinge():
    text = run("tune", DESIGN, *QUICK)
    lines = text.splitlines()
    assert lines[0].startswith("use                     tuned springs")
    assert lines[1].split() == ["formulation", "constrained"]
    assert lines[2].split() == ["springs,", "N", "m/rad", "0.001", "to", "0.2"]
    assert lines[3].split() == ["seconds", "1"]
    assert any(line.startswith("tuned") and "certified clear" in line and "of 4 samples" in line for line in lines)
    table = lines[lines.index("") + 1 :]
    assert table[0].split() == ["hinge", "panels", "start", "tuned", "N", "m/rad"]
    assert len(table) == 1 + 8
    again = run("tune", DESIGN, *QUICK).splitlines()
    (counted,) = [line for line in again if line.startswith("evaluations")]
    assert counted.endswith("of them known before")
    assert again[:4] + again[5:] == lines[:4] + lines[5:]


def test_files_give_the_scene_and_the_formulation():
    Path("scene.toml").write_text(
        f'design = "{DESIGN}"\nformulation = "compliant"\n[scene]\nseconds = 0.05\nspring = "linear:0.05"\n'
    )
    printed = json.loads(run("tune", "scene.toml", "--evaluations", "4", "--samples", "0", "--json", code=1))
    assert printed["formulation"] == "compliant"
    assert set(printed["start"]["stiffness_N_m_rad"]) == {0.05}
    assert not printed["best"]["confirmed"]
    assert printed["use"].startswith("none: no set that was tried becomes flat, certified clear")
    assert printed["seconds"] == 0.05
    assert printed["spring_range_N_m_rad"] == [0.0005, 0.1]


def advised(confirmed, failures, samples=64):
    """What `tune` says first of a set with some failures among its samples."""
    chance = None if samples is None else Robustness(samples, failures, failures)
    check = DeploymentCheck("flat", 0.2, True, None, None, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1, 1, 1)
    one = replace(SpringSet((0.1,), check), robustness=chance, deployment=Mock(deploys=confirmed))
    return Tuning(SCENES["default"], "constrained", (), one, one, None, 1, 0, False).advice


@pytest.mark.parametrize(
    ("catalogue", "stiffnesses", "line"),
    [
        ((0.1, 0.2), (0.0, 0.1, 0.4, 0.2, 0.4), "1 x 0.1, 5 x 0.2 N m/rad (none at hinge 0; two each at hinges 4, 8)"),
        (
            (0.07, 0.1),
            (0.17, 0.07, 0.14, 0.1, 0.17),
            "5 x 0.07, 3 x 0.1 N m/rad (two each at hinge 4; 0.07 and 0.1 at hinges 0, 8)",
        ),
        ((0.1,), (0.1,) * 5, "5 x 0.1 N m/rad"),
        ((0.1,), (0.0,) * 5, "no springs (none at hinges 0, 3, 4, 6, 8)"),
    ],
)
def test_what_to_buy_is_counted_by_hinges(catalogue, stiffnesses, line):
    check = DeploymentCheck("flat", 0.2, True, None, None, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1, 1, 1)
    one = SpringSet(stiffnesses, check, deployment=Mock(deploys=True))
    labels = Labels(("0",), ("0", "3", "4", "6", "8"))
    tuning = Tuning(SCENES["default"], "constrained", (), one, one, one, 1, 0, False, labels, catalogue=catalogue)
    assert tuning.purchase == line
    unsure = replace(one, deployment=None)
    assert "none is certified clear" in replace(tuning, rounded=unsure).purchase
    assert "give more --evaluations" in replace(tuning, rounded=None).purchase


def test_a_verdict_in_doubt_does_not_shine():
    assert advised(True, 0) == "tuned springs: flat, certified clear, in all 64 samples too"
    assert advised(True, 0, None) == "tuned springs: flat, certified clear"
    assert advised(True, 9).startswith("tuned springs, with care: 9 of 64 samples within the tolerances fail")
    assert advised(True, 55).startswith("none as built: 55 of 64 samples within the tolerances fail")
    assert advised(False, 0).startswith("none: no set that was tried")


def test_the_range_of_springs_can_be_given():
    words = ("tune", DESIGN, "--evaluations", "4", "--samples", "0", "--json", "--spring-range", "0.05,0.15")
    result = CliRunner().invoke(hcsearch, words, catch_exceptions=False)
    printed = json.loads(result.stdout)
    assert result.exit_code == (0 if printed["best"]["confirmed"] else 1)
    assert printed["spring_range_N_m_rad"] == [0.05, 0.15]
    assert all(0.05 <= value <= 0.15 for value in printed["best"]["stiffness_N_m_rad"])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (f"{DESIGN} --catalogue springs", "is no catalogue"),
        (f"{DESIGN} --catalogue 0.5", "up to 0.2 N m/rad: add --spring-range 0.001,0.5"),
        (f"{DESIGN} --catalogue 0.1,-0.2", "springs above 0 N m/rad"),
        (f"{DESIGN} --catalogue 0.1,0.4 --spring-range 0.01,0.3", "up to 0.3 N m/rad: add --spring-range 0.01,0.4"),
        (f"{DESIGN} --spread length=0.1", "is no tolerance"),
        (f"{DESIGN} --spread mass=-0.1", "is no tolerance"),
        (f"{DESIGN} --output found.csv", "write .toml"),
        (f"{DESIGN} --output nowhere/found.toml", "there is no folder"),
        (f"{DESIGN} --output folder.toml", "folder.toml is a folder: name a file"),
        (f"{DESIGN} --spread mass=0.1 --spread mass=0.2", "--spread mass is given twice"),
        (f"{DESIGN} --seconds 1e-300", "seconds cannot be 1e-300: give a number from 1e-09 to 1e+12"),
        (f"{DESIGN} --panel 1e-300x1x1", "from 0.001 to 1e+07 mm"),
        (f"{DESIGN} --held free", "with a panel held"),
        (f"{DESIGN} --spring-range 0.2,0.1", "the softest and the stiffest"),
        (f"{DESIGN} --spring-range 0.001,0.05", "are no start of a search from 0.001 to 0.05"),
        ("nothing", "there is no assembly"),
    ],
)
def test_wrong_words_say_what_to_do(folder, words, message):
    (folder / "folder.toml").mkdir()
    result = CliRunner().invoke(hcsearch, ["tune", *shlex.split(words)])
    assert isinstance(result.exception, HcsearchError), result.exception
    assert message in str(result.exception)
    assert result.stdout == ""
    assert list(folder.glob("*.toml")) == [folder / "folder.toml"]


@pytest.mark.parametrize("law", ["linear:0.1+0.02", "tape:0.2@0.05,0.03@0.01"])
def test_springs_that_are_not_linear_are_refused(law):
    Path("scene.toml").write_text(f'design = "{DESIGN}"\n[scene]\nspring = "{law}"\n')
    result = CliRunner().invoke(hcsearch, ["tune", "scene.toml"])
    assert "linear, without a preload" in str(result.exception)


def test_ctrl_c_ends_it_as_other_commands_and_tells_what_was_found(folder):
    words = ("--samples", "100000", "--most-damping", "1", "--db", "t.sqlite")
    process = subprocess.Popen(
        [sys.executable, "-m", "hcsearch", "tune", DESIGN, *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # a test run in the background ignores the interrupt, and its children would too
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509 - no threads here
    )
    deadline = time.monotonic() + 120
    while evaluations(folder / "t.sqlite") < 64:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    printed, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said.splitlines()[-1].startswith("hcsearch: interrupted; the same command continues")
    assert "Traceback" not in said
    lines = printed.splitlines()
    assert any(line.startswith("tuned") for line in lines)
    assert len(lines[lines.index("") + 1 :]) == 1 + 8


def evaluations(path):
    """How many are stored."""
    if not path.exists():
        return 0
    try:
        with open_readonly(str(path)) as database:
            return len(select(database, "", columns="subject", view="evaluations").rows)
    except HcsearchError:  # still being made
        return 0


def test_ctrl_c_before_the_first_sets_are_known_tells_the_start(monkeypatch):
    from hcsearch.springs.tuning.spring_search import SpringSearch

    def pressed(self, start, first):
        raise KeyboardInterrupt

    monkeypatch.setattr(SpringSearch, "run", pressed)
    result = CliRunner().invoke(hcsearch, ["tune", DESIGN, *QUICK, "--json"], standalone_mode=False)
    assert isinstance(result.exception, click.Abort)
    printed = json.loads(result.stdout)
    assert printed["interrupted"]
    assert printed["best"] == printed["start"]


def test_ctrl_c_leaves_what_was_found(monkeypatch):
    from hcsearch.springs.tuning.evaluation import DatabaseMemory

    record, calls = DatabaseMemory.record, []

    def pressed(self, checks):
        record(self, checks)
        calls.append(checks)
        if len(calls) == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(DatabaseMemory, "record", pressed)
    result = CliRunner().invoke(hcsearch, ["tune", DESIGN, *QUICK, "--output", "found.toml"], standalone_mode=False)
    assert isinstance(result.exception, click.Abort)
    assert "tuned" in result.stdout
    monkeypatch.setattr(DatabaseMemory, "record", record)
    assert json.loads(run("deploy", "found.toml", "--json"))["outcome"] == "flat"
    printed = json.loads(run("tune", DESIGN, *QUICK, "--json"))
    assert printed["known_before"] + printed["samples_known_before"] >= sum(map(len, calls))
