"""`hcsearch drive` as a person meets it."""

import json
import math
import subprocess
import sys

import pandas as pd
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli.deploy import deploy
from hcsearch.cli.drive import drive
from hcsearch.cli.tune import tune
from hcsearch.springs.drive.trajectory import time_path
from tests.commands import without_progress

QUICK = ("hex:0234435011:1", "--rate", "4", "--acceleration", "40", "--period", "0.005")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    files = [folder / name for name in ("drive.toml", "drive.csv", "drive.svg")]
    words = ["--output", str(files[0]), "--output", str(files[1]), "--picture", str(files[2])]
    result = CliRunner().invoke(drive, [*QUICK, *words, "--json"], catch_exceptions=False)
    assert result.exit_code == 0
    return json.loads(result.stdout), *files


def test_it_says_what_is_driven_and_how_hard(written):
    printed = written[0]
    assert (printed["verdict"], printed["clearance"]) == ("deploys", "clear")
    assert len(printed["driven"]) == printed["freedoms"] == len(printed["torque_N_m"])
    assert printed["path_play_mm"] <= printed["margin_mm"]
    assert printed["missed_rad"] < 0.002
    assert printed["greatest_rate_rad_s"] == pytest.approx(4.0, rel=0.01)
    assert printed["energy_imbalance"] < 1e-5
    assert 0.0 < printed["least_singular_value"] < 1.0
    assert printed["follows"]
    assert printed["torque_N_m"] == pytest.approx(printed["planned_torque_N_m"], rel=0.05)
    assert printed["motor_torque_N_m"] == max(printed["planned_torque_N_m"])


def test_the_files_hold_the_course_and_what_deploy_takes(written):
    printed, toml, csv, svg = written
    course = pd.read_csv(csv)
    n = printed["hinges"]
    assert list(course)[:2] == ["time_s", "angle_0_rad"]
    assert [name for name in course if name.startswith("torque")] == [f"torque_{k}_N_m" for k in printed["driven"]]
    assert len(list(course)) == 1 + 2 * n + len(printed["driven"])
    assert course["time_s"].iloc[-1] == pytest.approx(printed["seconds"])
    assert "<svg" in svg.read_text(encoding="utf-8")[:1000]
    assert "<!-- fold angle, degrees (thin grey: not driven) -->" in svg.read_text(encoding="utf-8")
    assert svg.stat().st_size < 100_000
    result = CliRunner().invoke(deploy, [str(toml), "--json"], catch_exceptions=False)
    again = json.loads(result.stdout)
    assert result.exit_code == 0
    assert again["flat_time_s"] == pytest.approx(printed["flat_time_s"], abs=1e-4)
    assert again["drive_torque_N_m"] == pytest.approx(max(printed["torque_N_m"]), rel=0.01)
    for command, words, word in (
        (deploy, ["--formulation", "penalty"], "exact closure"),
        (deploy, ["--explain"], "does not apply to a scene with drives"),
        (deploy, ["--held", "free"], "hold a panel"),
        (deploy, ["--flat-pairs", "rigid"], "not one of this design"),
        (tune, [], r"\[drive\]"),
    ):
        with pytest.raises(HcsearchError, match=word):
            CliRunner().invoke(command, [str(toml), *words], catch_exceptions=False)


@pytest.fixture(scope="module")
def plots(tmp_path_factory):
    """The upper and the lower plot of a drive of all ten hinges, which turn in three groups."""
    drawn, save = [], Figure.savefig
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            Figure, "savefig", lambda figure, *words, **options: drawn.append(figure) or save(figure, *words, **options)
        )
        words = [*QUICK, "--firm", "1", "--picture", str(tmp_path_factory.mktemp("plots") / "drive.png")]
        CliRunner().invoke(drive, words, catch_exceptions=False)
    return drawn[0].axes


def named_curves(axes):
    return [line for line in axes.get_lines() if not line.get_label().startswith("_")]


def test_a_driven_hinge_has_one_colour_in_both_plots(plots):
    above, below = ({line.get_label(): line.get_color() for line in named_curves(axes)} for axes in plots)
    colours = {name: colour for names, colour in above.items() for name in names.split(", ")}
    assert len(above) == 3
    assert colours == below
    looks = {(line.get_color(), str(line._dash_pattern), line.get_linewidth()) for line in named_curves(plots[1])}
    assert len(looks) == 10


def test_a_plot_without_thin_grey_curves_explains_none(plots):
    assert plots[0].get_ylabel() == "fold angle, degrees"


def test_planned_torques_come_first_and_size_the_motor():
    result = CliRunner().invoke(drive, [*QUICK], catch_exceptions=False)
    lines = result.stdout.splitlines()
    assert lines[1].startswith("motor torque N m ")
    assert lines[1].endswith("planned: this torque sizes the motor")
    assert lines[2].startswith("control                       follows: greatest torques are within 0.1 %")
    (heads,) = (line for line in lines if line.startswith("hinge "))
    assert heads.split()[1:4] == ["planned", "rms", "simulated"]
    assert "follows" not in {line.split(maxsplit=1)[0] for line in lines if line}


def test_a_folding_without_a_path_has_no_drive():
    result = CliRunner().invoke(drive, ["hex:02334051:0"], catch_exceptions=False)
    assert result.exit_code == 1
    assert result.stdout.startswith("no drive: the folding is twisted")
    assert len(result.stdout.splitlines()) == 1


def test_a_folding_whose_path_is_not_proved_has_no_drive():
    """Panels come too near on the path that is met."""
    result = CliRunner().invoke(drive, ["hex:023335551512:2"], catch_exceptions=False)
    assert result.exit_code == 1
    assert result.stdout.startswith("no drive: undecided: a path with hinged flat pairs was found but not proved: ")
    assert len(result.stdout.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "word"),
    [
        (("--hinges", "0,x"), "write numbers"),
        (("--hinges", "0,1"), "4 at least"),
        (("--hinges", "0,1,2,99"), "no hinge 99"),
        (("--near", "0.1"), "two angles"),
        (("--near", "0.1,0.1"), "out of range"),
        (("--held", "free"), "hold a panel"),
        (("--output", "drive.txt"), "no known ending"),
    ],
)
def test_wrong_input_is_refused(words, word):
    with pytest.raises(HcsearchError, match=word):
        CliRunner().invoke(drive, [*QUICK, *words], catch_exceptions=False)


@pytest.mark.parametrize("option", ["--rate", "--acceleration"])
@pytest.mark.parametrize("value", ["0", "-1", "1e-310", "9e-7", "1.1e6", "1e300", "inf", "nan"])
def test_bounds_that_no_machine_has_are_refused(option, value):
    result = CliRunner().invoke(drive, [*QUICK, option, value])
    assert result.exit_code == 2
    assert f"Invalid value for '{option}'" in result.stderr


@pytest.mark.parametrize("bound", [1e-310, 9e-7, 1.1e6, math.inf, math.nan])
def test_a_time_law_within_such_bounds_is_refused(bound):
    for bounds in ((bound, 1.0), (1.0, bound)):
        with pytest.raises(HcsearchError, match="out of range: give 1e-06 to 1e"):
            time_path(None, *bounds)


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("formulation = 'penalty'", "motions along a path need 'constrained'"),
        ("[drive]\nhinges = [0]", "has a drive: give it to hcsearch deploy"),
    ],
)
def test_a_file_that_says_how_to_drive_is_refused(tmp_path, line, word):
    path = tmp_path / "driven.toml"
    path.write_text(f"design = 'hex:0234435011:1'\n{line}\n", encoding="utf-8")
    with pytest.raises(HcsearchError, match=word):
        CliRunner().invoke(drive, [str(path)], catch_exceptions=False)


def test_a_drive_faster_than_its_controller_does_not_follow():
    result = CliRunner().invoke(drive, [QUICK[0], "--rate", "1e6", "--acceleration", "1e6"], catch_exceptions=False)
    assert result.exit_code == 1
    printed = dict(line.rsplit(maxsplit=1) for line in result.stdout.partition("\n\n")[0].splitlines())
    assert printed["verdict"] in {"collides", "undecided"}
    (control,) = (line for line in result.stdout.splitlines() if line.startswith("control "))
    assert "does not follow: hinge " in control
    assert "give a shorter --period" in control
    assert float(printed["seconds"]) < 0.02  # ten periods


def test_assemblies_and_rates_of_nothing_are_refused_in_one_line():
    for words in (["unit-i"], ["hex:0234435011:1", "--rate", "0"]):
        done = subprocess.run(
            [sys.executable, "-m", "hcsearch", "drive", *words],
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
        assert done.returncode == 2
        assert done.stdout == ""
        assert len(without_progress(done.stderr).splitlines()) == 1
