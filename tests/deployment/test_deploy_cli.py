"""`hcsearch deploy` as a person meets it."""

import csv
import json
import math
import re
import shlex
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.deploy import deploy
from tests.commands import without_progress

SMALL = ("hex:023350:1", "--seconds", "0.02")
KEYS = [
    "verdict",
    "reason",
    "clearance",
    "collision_s",
    "collision_panels",
    "margin_mm",
    "min_clearance_mm",
    "least_gap_mm",
    "needed_margin_mm",
    "play",
    "scene",
    "formulation",
    "method",
    "panels",
    "hinges",
    "merged_panels",
    "loops",
    "joints_simulated",
    "seconds",
    "outcome",
    "flat_time_s",
    "end_time_s",
    "other_tolerances",
    "other_outcomes",
    "errors",
    "widest_angle_rad",
    "energy_start_J",
    "energy_damped_J",
    "energy_lost_at_stops_J",
    "energy_drift_J",
    "closure_gap",
    "events",
    "arrivals",
    "steps",
    "rejected_steps",
    "evaluations",
    "left_out",
]


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def call(*words):
    result = CliRunner().invoke(deploy, words, catch_exceptions=False)
    assert result.exit_code in {0, 1}
    assert without_progress(result.stderr) == ""
    return result.stdout


def test_exit_codes_say_what_became_of_it():
    for words, code, verdict in (
        (("hex:0234550132:4",), 0, "deploys"),
        (("hex:02234400:1",), 1, "collides"),
        (SMALL, 1, "undecided"),
        (("hex:023350:1", "--spring", "linear:1e160"), 1, "undecided"),
    ):
        result = CliRunner().invoke(deploy, words)
        assert result.exit_code == code, words
        first, second, *rest = result.stdout.splitlines()
        assert first.split() == ["verdict", verdict]
        assert second.startswith("reason ")
        names = [line[:24].strip() for line in rest]
        assert names.index("clearance") < names.index("outcome")
        if verdict == "collides":
            assert second.split(maxsplit=1)[1].startswith("panels 4 and 7 collide at ")
        else:
            assert (rest[names.index("collision s")]).split() == ["collision", "s", "-"]


def facts_of(*words):
    return json.loads(call(*words, "--json"))


def run(*words, code=0):
    done = subprocess.run(
        [sys.executable, "-m", "hcsearch", "deploy", *words], capture_output=True, text=True, timeout=300, check=False
    )
    assert code is None or done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    return done


@pytest.mark.slow
def test_the_examples_of_its_help_work(tmp_path):
    for example in deploy.epilog.partition("Example: ")[2].splitlines():
        done = run(*shlex.split(example)[2:], code=None)
        name, verdict = done.stdout.splitlines()[0].split()
        assert name == "verdict"
        assert done.returncode == (0 if verdict == "deploys" else 1)
        assert "outcome" in done.stdout
        assert without_progress(done.stderr) == ""
    assert (tmp_path / "angles.svg").exists()
    assert (tmp_path / "unit-i.csv").exists()


def test_json_is_plain_and_complete():
    facts = facts_of(*SMALL)
    assert list(facts) == KEYS
    assert (facts["scene"], facts["formulation"], facts["outcome"]) == ("default", "constrained", "moving")
    assert (facts["panels"], facts["hinges"], facts["loops"], facts["joints_simulated"]) == (4, 4, 1, 4)
    assert facts["end_time_s"] == pytest.approx(0.02)
    assert facts["energy_start_J"] == pytest.approx(4 * 0.05 * (0.999 * math.pi) ** 2, rel=1e-3)
    assert facts["energy_drift_J"] < 1e-5
    assert {row["name"] for row in facts["left_out"]} == {"third dimension", "gravity", "base", "pairs"}
    assert all(set(row) == {"name", "what", "why"} for row in facts["left_out"])


def test_json_tells_events_and_clearance():
    facts = facts_of("hex:0234550132:4")
    assert facts["outcome"] == "flat"
    assert facts["flat_time_s"] == facts["end_time_s"] == 0.141
    assert facts["reason"] == "flat after 0.1410 s"
    assert facts["other_tolerances"] == pytest.approx([1e-7, 1e-8])
    assert facts["other_outcomes"] == ["flat", "flat"]
    hit = facts["events"][0]
    assert set(hit) == {"time_s", "hinges", "kind", "speed_rad_s"}
    assert hit["kind"] == "hit"
    assert facts["merged_panels"] == ["0+9", "4+5"]
    assert {hinge for event in facts["events"] for hinge in event["hinges"]} <= {0, 1, 2, 3, 5, 6, 7, 8}
    assert [facts[key] for key in ("clearance", "collision_s", "collision_panels")] == ["clear", None, None]
    # panels as built overlap, which is what the smallest gap says, too: 0.575 mm is where others come back to
    assert facts["min_clearance_mm"] == facts["least_gap_mm"] == pytest.approx(-0.1989, abs=1e-3)
    assert facts["margin_mm"] == facts["needed_margin_mm"] == 0.1
    assert facts["play"].startswith("leave 0.2 mm between faces: certified clear with panels 0.1 mm smaller")
    facts = facts_of("hex:02234400:1")
    assert [facts[key] for key in ("clearance", "collision_panels", "min_clearance_mm")] == ["collides", [4, 7], None]
    assert [facts[key] for key in ("least_gap_mm", "needed_margin_mm", "play")] == [None] * 3
    assert 0.0 < facts["collision_s"] < facts["flat_time_s"]


@pytest.mark.parametrize("spring", ["linear:1e300", "linear:1e160", "quadratic:0,1e300"])
def test_json_stays_plain_where_numbers_overflow(spring):
    facts = facts_of("hex:023350:1", "--spring", spring)
    assert facts["outcome"] == "diverged"


def test_text_has_the_facts_of_json():
    text, facts = call(*SMALL), facts_of(*SMALL)
    lines = {line[:24].strip(): line[24:] for line in text.splitlines()}
    for name in ("outcome", "reason", "panels", "steps"):
        assert lines[name] == str(facts[name])
    assert lines["flat time s"] == "-"
    assert lines["end time s"] == "0.02"
    assert lines["stops hit"] == "0"
    assert "left out" not in lines


def test_text_tells_which_hinges_came_to_their_stops():
    text = call("thesis-4x4", "--seconds", "0.14")
    (line,) = [line.strip() for line in text.splitlines() if " s: hinge " in line]
    assert line == "0.129578 s: hinge 1, 10 flat at 18 rad/s"


def test_explain_lists_what_was_left_out_with_numbers():
    text = call("thesis-4x4", "--seconds", "0.02", "--explain")
    after = text.partition("left out\n")[2]
    assert "  half                  half of the array: 4 panels: pattern, springs, dampers, gravity and" in after
    assert re.search(
        r"joints 12 -> 7, closure equations 6 -> 3, evaluations \d+ -> \d+, milliseconds \S+ -> \S+ \(", after
    )
    facts = facts_of(*SMALL, "--explain")
    assert [saved["name"] for saved in facts["saved"]] == [omission["name"] for omission in facts["left_out"]]
    assert all(saved["within"] for saved in facts["saved"])
    (saved,) = (saved for saved in facts["saved"] if saved["name"] == "third dimension")
    assert saved["closure_equations"] == [6, 3]
    assert saved["outcomes"] == ["moving", "moving"]
    assert set(facts) == {*KEYS, "saved"}


def states(path):
    if path.endswith(".csv"):
        with Path(path).open(newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        return {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(rows[0])}
    if path.endswith(".npz"):
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name].tolist() for name in file}
    return pd.read_parquet(path).to_dict("list")


@pytest.mark.parametrize("ending", [".csv", ".npz", pytest.param(".parquet", marks=pytest.mark.extra)])
def test_states_come_back_from_files(ending):
    facts = facts_of(*SMALL, "--output", f"states{ending}")
    found = states(f"states{ending}")
    books = ["kinetic_J", "stored_J", "height_J", "in_stops_J", "damped_J", "lost_J"]
    hinges = [f"angle_{k}_rad" for k in (0, 2, 3, 5)] + [f"rate_{k}_rad_s" for k in (0, 2, 3, 5)]
    assert list(found) == ["time_s", *books, *hinges]
    assert len(found["time_s"]) == facts["steps"] + 1
    assert found["time_s"][-1] == facts["end_time_s"]
    assert found["damped_J"][-1] == facts["energy_damped_J"]
    assert max(abs(found[f"angle_{k}_rad"][-1]) for k in (0, 2, 3, 5)) == facts["widest_angle_rad"]
    call(*SMALL, "--output", "again.csv")
    assert states("again.csv") == found


@pytest.mark.parametrize(
    "words", [SMALL, ("hex:0234535012:4",), ("hex:02234400:1",), (*SMALL, "--formulation", "penalty")]
)
def test_pictures(tmp_path, words):
    call(*words, "--picture", "a.svg")
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert ElementTree.fromstring(text).tag == "{http://www.w3.org/2000/svg}svg"
    assert not re.search(r"[ML] nan", text)


@pytest.mark.parametrize(("ending", "head"), [("png", b"\x89PNG"), ("pdf", b"%PDF")])
def test_pictures_of_other_kinds(tmp_path, ending, head):
    call(*SMALL, "--picture", f"a.{ending}")
    assert (tmp_path / f"a.{ending}").read_bytes().startswith(head)


def write(text, name="scene.toml"):
    Path(name).write_text(text, encoding="utf-8")
    return name


def test_a_picture_of_a_file_with_dollar_signs_in_its_name(tmp_path):
    call(write('design = "hex:023350:1"\nscene = { seconds = 0.02 }\n', "$\\foo$.toml"), "--picture", "a.svg")
    assert "foo" in (tmp_path / "a.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("top", "inside", "end"),
    [
        ('held = "5+4"\n', "", '[springs]\n2 = "linear:0.3"\n'),
        ("held = 5\n", "", '[springs]\n"02" = "linear:0.3"\n'),
        ("", 'held = 5\nsprings = { 2 = "linear:0.3" }\n', ""),
    ],
)
def test_a_file_says_what_the_command_line_says(top, inside, end):
    name = write(
        f'design = "square:012230:1"\npanel_mm = "50x30x5"\n{top}'
        f'[scene]\nspring = "linear:0.2"\ngravity = [0, -9.81, 0]\n{inside}'
        f"seconds = 0.02\nstart = 0.99\nrestitution = 0.5\ndamping = 0.001\n{end}"
    )
    words = ("--panel", "50x30x5", "--spring", "linear:0.2", "--springs", "2=linear:0.3", "--gravity", "0,-9.81,0")
    words += ("--held", "4", "--seconds", "0.02", "--start", "0.99", "--restitution", "0.5", "--damping", "0.001")
    facts = facts_of(name)
    assert facts == facts_of("square:012230:1", *words) | {"scene": "default"}
    assert facts["energy_start_J"] != facts_of("square:012230:1", "--seconds", "0.02")["energy_start_J"]


def test_dampers_of_single_hinges_come_from_the_file_and_the_command_line():
    of_file = 'design = "square:012230:1"\n[scene]\nseconds = 0.02\n[hinges]\n3 = { damping = 0.02, friction = 1e-4 }\n'
    name = write(of_file + "2 = { damping = 0.03 }\n")
    facts = facts_of(name)
    assert facts == facts_of(write(of_file), "--dampers", "2=0.03")
    assert facts == facts_of(name, "--dampers", "2=0.03", "--dampers", "3=0.02")
    assert facts["energy_damped_J"] != facts_of(name, "--dampers", "3=0")["energy_damped_J"]
    every = [word for hinge in (0, 2, 3, 5) for word in ("--dampers", f"{hinge}=0.001")]
    plain = ("square:012230:1", "--seconds", "0.02")
    assert facts_of(*plain, *every) == facts_of(*plain, "--damping", "0.001")


def test_the_command_line_goes_before_the_file():
    name = write('design = "hex:023350:1"\n[scene]\nname = "earth"\nseconds = 0.02\n')
    assert facts_of(name)["scene"] == "earth"
    assert facts_of(name, "--scene", "satellite")["scene"] == "satellite"
    assert facts_of(name, "--seconds", "0.01")["end_time_s"] == pytest.approx(0.01)


def test_flat_pairs_and_mirror_pairs():
    name = write('design = "square:012230:1"\nflat_pairs = "hinged"\n[scene]\nseconds = 0.01\n')
    plain = facts_of("square:012230:1", "--seconds", "0.01")
    assert (plain["panels"], plain["hinges"]) == (4, 4)
    assert (facts_of(name)["panels"], facts_of(name)["hinges"]) == (6, 6)
    name = write('design = "square:012230:1"\nflat_pairs = "merged"\n[scene]\nseconds = 0.01\n')
    facts = facts_of(name)
    assert (facts["panels"], facts["loops"]) == (3, 0)
    assert "closure" in {row["name"] for row in facts["left_out"]}


def test_parameters_of_an_assembly():
    name = write(
        'assembly = "element-8r"\n[parameters]\nalpha = 70\nbase = 40\nthickness = 8\n[scene]\nseconds = 0.01\n'
    )
    facts = facts_of(name)
    assert (facts["panels"], facts["hinges"], facts["outcome"]) == (8, 8, "moving")
    assert facts["widest_angle_rad"] != facts_of("element-8r", "--seconds", "0.01")["widest_angle_rad"]
    name = write('assembly = "array-6r"\nparameters = { size = "2x3" }\nscene = { seconds = 1e-3 }\n')
    assert facts_of(name)["panels"] > 6


def test_a_table_of_a_spring_is_read_from_a_file():
    write("moment_N_mm,angle_deg\n0,0\n314.159265358979,180\n", "spring.csv")
    table, linear = (facts_of(*SMALL, "--spring", spring) for spring in ("table:spring.csv", "linear:0.1"))
    assert table["energy_start_J"] == pytest.approx(linear["energy_start_J"], rel=1e-12)
    assert table["widest_angle_rad"] == pytest.approx(linear["widest_angle_rad"], rel=1e-9)


@pytest.mark.parametrize(
    "spring",
    [
        '[scene]\nspring = "table:spring.csv"',
        '[scene]\nsprings = { 0 = "table:spring.csv", 2 = "table:spring.csv", 3 = "2*table:spring.csv" }',
        '[springs]\n0 = "table:../folder/spring.csv"\n3 = "2*table:spring.csv+0.01"',
    ],
)
def test_files_that_a_scene_file_names_count_from_its_folder(spring):
    Path("folder").mkdir()
    write("angle_rad,moment_N_m\n0,0\n1.5,0.3\n", "folder/spring.csv")
    write("angle_rad,moment_N_m\n0,0\n1.5,0.1\n", "spring.csv")
    own = f"{spring}\n" if "[scene]" in spring else f"[scene]\nseconds = 0.02\n{spring}\n"
    name = write(f'design = "hex:023350:1"\n{own}', "folder/scene.toml")
    expected = write(f'design = "hex:023350:1"\n{own.replace("folder/", "").replace("../", "")}', "scene.toml")
    write("angle_rad,moment_N_m\n0,0\n1.5,0.3\n", "spring.csv")
    there = facts_of(expected, "--seconds", "0.02")
    write("angle_rad,moment_N_m\n0,0\n1.5,0.1\n", "spring.csv")
    assert facts_of(name, "--seconds", "0.02")["energy_start_J"] == there["energy_start_J"]
    Path("spring.csv").unlink()
    assert facts_of(name, "--seconds", "0.02")["energy_start_J"] == there["energy_start_J"]


def test_a_design_with_one_folding_needs_no_crease():
    assert facts_of("hex:023350", "--seconds", "0.02") == facts_of(*SMALL)


WRONG_WORDS = [
    (("--spring", "linear"), "cannot read the law 'linear': write free, linear:0.1"),
    (("--spring", ""), "cannot read the law '': write free"),
    (("--spring", "linear:nan"), "cannot read the law 'linear:nan': write free"),
    (("--spring", "linear:1e999"), "inf is no moment or angle: give finite numbers"),
    (("--spring", "tape:0.2@0.05,0.15@0.01"), "give a low moment of at most half the peak"),
    (("--spring", "table:0@0,209@120"), "has an angle of 120 rad, and hinges turn from 0 (flat) to pi"),
    (("--springs", "3=table:0@0,209@120"), "has an angle of 120 rad, and hinges turn from 0 (flat) to pi"),
    (("--spring", "table:missing.csv"), "cannot read the table missing.csv: No such file or directory; name a file"),
    (("--springs", "3"), "cannot read --springs '3': write HINGE=LAW, such as 3=linear:0.2"),
    (("--springs", "x=free"), "cannot read --springs 'x': write HINGE=LAW"),
    (("--springs", "+8=free"), "cannot read --springs '+8': write HINGE=LAW"),
    (("--springs", "99=free"), "there is no hinge 99: the hinges are 0, 2, 3, 5"),
    (("--dampers", "3"), "cannot read --dampers '3': write HINGE=C, such as 3=0.01"),
    (("--dampers", "3=stiff"), "damping cannot be 'stiff': give a number from 0 to 1e+12"),
    (("--dampers", "99=0.1"), "there is no hinge 99: the hinges are 0, 2, 3, 5"),
    (("--dampers", "3=0.1", "--dampers", "3=0.2"), "--dampers names a hinge twice: leave one out"),
    (("--damping", "nan"), "damping cannot be nan: give a number from 0 to 1e+12"),
    (("--damping", "-1"), "damping cannot be -1.0: give a number from 0 to 1e+12"),
    (("--damping", "1e300"), "damping cannot be 1e+300: give a number from 0 to 1e+12"),
    (("--seconds", "1e300"), "seconds cannot be 1e+300: give a number from 1e-09 to 1e+12"),
    (("--gravity", "0,0,-1e300"), "gravity cannot be '0,0,-1e300': give numbers from -1e+12 to 1e+12"),
    (("--gravity", "1,2"), "gravity cannot be '1,2': give x,y,z in m/s^2, such as 0,0,-9.81"),
    (("--gravity", "nan,0,0"), "gravity cannot be 'nan,0,0': give numbers from -1e+12 to 1e+12"),
    (("--gravity", "0,0,inf"), "gravity cannot be '0,0,inf': give numbers from -1e+12 to 1e+12"),
    (("--gravity", "down"), "gravity cannot be 'down': give x,y,z"),
    (("--springs", "1=free"), "crease 1 carries no hinge here, its panels are one, 1+2: the hinges are 0, 2, 3, 5"),
    (("--springs", "0+2=free"), "there is no hinge 0+2: the hinges are 0, 2, 3, 5"),
    (("--held", "6"), "there is no panel 6: the panels are 0, 1+2, 3, 4+5"),
    (("--held", "top"), "held cannot be 'top': give bottom, free, or the number of a panel"),
    (("--held", "1.5"), "held cannot be '1.5': give bottom, free, or the number of a panel"),
    (("--merge", "--flat-pairs", "hinged"), "a merged flat pair has no hinge: leave out --merge"),
    (("--start", "0"), "no deployment starts at 0 of the folded angles: give a share above 0, up to 1"),
    (("--start", "1.5"), "start cannot be 1.5: give a number from 0 to 1"),
    (("--start", "nan"), "start cannot be nan: give a number from 0 to 1"),
    (("--restitution", "2"), "restitution cannot be 2.0: give a number from 0 to 1"),
    (("--restitution", "-0.5"), "restitution cannot be -0.5: give a number from 0 to 1"),
    (("--seconds", "0"), "seconds cannot be 0.0: give a number from 1e-09 to 1e+12"),
    (("--springs", "0=free", "--springs", "0=linear:0.1"), "--springs names a hinge twice: leave one out"),
    (("--spring", "table:0@0,1@1e-320"), "sort it, each angle once"),
    (("--spring", "quadratic:0,1e308"), "1e+308 is no moment or angle: give finite numbers"),
    (("--panel", "1e300x1e300x1e300"), "length x width x thickness, from 0.001 to 1e+07 mm"),
    (("--seconds", "inf"), "seconds cannot be inf: give a number from 1e-09 to 1e+12"),
    (("--tolerance", "-1"), "a tolerance of -1 is out of range: give one from 1e-13 to 0.1"),
    (("--tolerance", "nan"), "a tolerance of nan is out of range: give one from 1e-13 to 0.1"),
    (("--scene", "moon"), "there is no scene 'moon': choose one of default, earth, thesis, satellite"),
    (("--panel", "50"), "'50' is no panel: write length x width x thickness in mm, such as 50x40x6"),
    (("--panel", "0x0x6"), "'0x0x6' is no panel: write length x width x thickness, from 0.001 to"),
    (("--panel", "nanxnanx6"), "'nanxnanx6' is no panel: write length x width x thickness in mm"),
    (("--panel", "50x40x6"), "panels of the hex grid have one side: write --panel SIDExTHICKNESS in mm"),
    (("--output", "a.txt"), "a.txt has no known ending: write .csv, .npz, .parquet"),
    (("--output", "nowhere/a.csv"), "there is no folder nowhere: make it, or write to another"),
    (("--picture", "a.xyz"), "a.xyz has no known ending: write .svg, .png, .pdf"),
    (("--picture", "nowhere/a.svg"), "there is no folder nowhere: make it, or write to another"),
    (("--output", "a.csv", "--picture", "a"), "a has no known ending: write .svg, .png, .pdf"),
    (("--output", "a.csv", "--start", "0"), "give a share above 0"),
    (("--formulation", "quasistatic", "--damping", "0"), "quasistatic motion has only dampers to set its speed"),
    (("--formulation", "quasistatic", "--spring", "free"), "quasistatic motion has only dampers to set its speed"),
    (("--formulation", "quasistatic", "--springs", "2=free"), "quasistatic motion has only dampers to set its speed"),
    (("--formulation", "quasistatic", "--scene", "satellite"), "and hold a panel, or take the constrained"),
    (("--scene", ""), "a scene has a name: write --scene default"),
    (("--scene", "hinged, mountains last"), "there is no scene 'hinged, mountains last': choose one of default"),
    (("--panel", ""), "'' is no panel: write length x width x thickness"),
    (("--across", "50"), "'50' is no width across flats: write width x thickness in mm"),
]


def refused(message, *words):
    """The command refuses some words with a message of one line, prints nothing and writes nothing."""
    before = sorted(Path().iterdir())
    result = CliRunner().invoke(deploy, words)
    assert isinstance(result.exception, HcsearchError), result.exception
    assert message in str(result.exception)
    assert "\n" not in str(result.exception)
    assert result.output == ""
    assert sorted(Path().iterdir()) == before


@pytest.mark.parametrize(("words", "message"), WRONG_WORDS)
def test_wrong_words_say_what_to_do(words, message):
    refused(message, *SMALL, *words)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nope",), "there is no assembly 'nope': see hcsearch assembly list, or name DESIGN:CREASE"),
        (("",), "there is no assembly '': see hcsearch assembly list"),
        (("17:4",), "there is no hcsearch database at hcsearch.sqlite: make one with `hcsearch enumerate`"),
        (("17:4", "--db", "other.sqlite"), "there is no hcsearch database at other.sqlite"),
        (
            ("triangle:012345",),
            "triangle:012345 does not fold into two stacks: choose among hcsearch query 'two_stack'",
        ),
        (("hex:0234550132",), "hex:0234550132 has 2 foldings: name one as hex:0234550132:CREASE; its creases are 3, 4"),
        (("hex:0234550132:0",), "has no two-stack folding at crease 0: its creases are 3, 4"),
        (("hex:0234550132:4:4",), "write an id or a circuit notation, then :CREASE if wanted"),
        (("unit-i:4",), "unknown grid 'unit-i': use one of triangle, square, rectangle, hex"),
        (("unit-i", "--panel", "50x50x6"), "unit-i is an assembly with sizes of its own: leave out --panel"),
        (("unit-i", "--merge"), "unit-i is an assembly with sizes of its own"),
        (("unit-i", "--flat-pairs", "hinged"), "unit-i is an assembly with sizes of its own"),
        (("missing.toml",), "cannot read missing.toml: No such file or directory; name a file that is there"),
        ((".toml",), "cannot read .toml"),
    ],
)
def test_wrong_subjects_say_what_to_do(words, message):
    refused(message, *words)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("design = hex:023350:1", "scene.toml is no TOML: "),
        ("", "must name a design, an assembly or a pattern: write design = 'hex:0234550132:4'"),
        ("design = 'hex:023350:1'\nassembly = 'unit-i'", "must name one design, assembly or pattern"),
        ("design = 17", "scene.toml has design = 17: write design = 'hex:0234550132:4'"),
        ("design = ''", "there is no assembly ''"),
        ("assembly = 'unit-iv'", "there is no assembly 'unit-iv': see hcsearch assembly list"),
        ("design = 'hex:023350:1'\nspeed = 3", "has the unknown key 'speed': see docs/reference/scenes.md"),
        (
            "design = 'hex:023350:1'\nflat_pairs = 'loose'",
            "flat_pairs cannot be 'loose': write 'rigid', 'hinged', 'merged' or 'either'",
        ),
        ("design = 'hex:023350:1'\nmerge = true", "has the unknown key 'merge': see docs/reference/scenes.md"),
        ("design = 'hex:023350:1'\npanel_mm = [50, 50, 6]", "write panel_mm = '50x50x6'"),
        ("design = 'hex:023350:1'\nscene = 'earth'", "write a table [scene] with lines such as spring = 'linear:0.1'"),
        ("design = 'hex:023350:1'\nparameters = 3", "write a table [parameters] with lines such as alpha = 70"),
        ("design = 'hex:023350:1'\n[parameters]\nalpha = 70", "which has no parameters: leave out [parameters]"),
        ("assembly = 'unit-i'\n[parameters]\nalpha = 'wide'", "alpha = 'wide': write a number, such as alpha = 70"),
        ("assembly = 'unit-i'\n[parameters]\nalpha = nan", "give one between 0 and 90"),
        ("assembly = 'unit-i'\n[parameters]\nbeta = 70", "assemblies have no 'beta': they have alpha, size"),
        ("assembly = 'array-6r'\n[parameters]\nsize = 3", "size = 3: write size = '3x2'"),
        ("assembly = 'unit-i'\npanel_mm = '50x50x6'", "unit-i is an assembly with sizes of its own"),
        ("design = 'hex:023350:1'\n[scene]\nname = ['earth']", "choose one of default, earth"),
        ("design = 'hex:023350:1'\n[scene]\nname = 'moon'", "there is no scene 'moon': choose one of default"),
        ("design = 'hex:023350:1'\n[scene]\nspeed = 3", "a scene has no 'speed': it has areal_mass, base_inertia"),
        ("design = 'hex:023350:1'\n[scene]\nheld = [1]", "held cannot be [1]: give bottom, free, or the number"),
        ("design = 'hex:023350:1'\n[scene]\nheld = true", "held cannot be True: give bottom, free, or the number"),
        ("design = 'hex:023350:1'\n[scene]\ndensity = 0", "density cannot be 0: give a number from 1e-09 to 1e+12"),
        (
            "design = 'hex:023350:1'\n[scene]\ndensity = 'heavy'",
            "density cannot be 'heavy': give a number from 1e-09 to 1e+12",
        ),
        ("design = 'hex:023350:1'\n[scene]\ngravity = 9.81", "gravity cannot be 9.81: give x,y,z"),
        ("design = 'hex:023350:1'\n[scene]\nbase_inertia = [1, -1, 1]", "base_inertia cannot be [1, -1, 1]"),
        (
            "design = 'hex:023350:1'\n[scene]\nsprings = 'linear:1'",
            "springs cannot be 'linear:1': write { 3 = 'linear:0.2' }",
        ),
        (
            "design = 'hex:023350:1'\n[scene.springs]\nx = 'free'",
            "springs cannot be {'x': 'free'}: write { 3 = 'linear:0.2' }",
        ),
        ("design = 'hex:023350:1'\n[scene.springs]\n0 = 5", "springs cannot be {'0': 5}: write { 3 = 'linear:0.2' }"),
    ],
)
def test_wrong_files_say_what_to_do(text, message):
    refused(message, write(text), "--output", "a.csv")


def test_a_file_that_is_no_text(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"\xff\xfe\x00")
    refused("cannot read a.toml: it is no text file; save it as UTF-8 text", "a.toml")
    (tmp_path / "folder.toml").mkdir()
    refused("cannot read folder.toml: Is a directory; name a file that is there", "folder.toml")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((*SMALL, "--output", "nowhere/a.csv"), "there is no folder nowhere: make it, or write to another"),
        ((*SMALL, "--start", "far"), "hcsearch deploy --help)"),
        ((*SMALL, "--method", "euler"), "hcsearch deploy --help)"),
        ((*SMALL, "--formulation", "exact"), "hcsearch deploy --help)"),
        ((), "hcsearch deploy --help)"),
    ],
)
def test_wrong_input_is_one_line_and_exit_2(words, message):
    done = run(*words, code=2)
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith("hcsearch: ")
    assert message in line
