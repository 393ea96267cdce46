"""What commands say where nothing comes of what was asked for, and short forms that they understand."""

import json
import re
from pathlib import Path

import pytest

from hcsearch.basics.errors import SizeError
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import search_all
from tests import forking

MOVING = "hex:0234550132:4"


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    """The designs of eight hexagons, none of them judged."""
    folder = tmp_path_factory.mktemp("eight")
    words = ("enumerate", "--grid", "hex", "--n", "8", "--until", "twist", "--db", "d.sqlite")
    assert forking.run(words, cwd=folder).returncode == 0
    return str(folder / "d.sqlite")


ODD = "makes no two equal stacks"
OPPOSITE = "no two opposite creases can stay flat while all others fold"


@pytest.mark.parametrize(
    ("words", "code", "line"),
    [
        (("enumerate", "--grid", "hex", "--n", "11", "--until", "twist"), 0, f"an odd number of panels, 11, {ODD}"),
        (("enumerate", "--grid", "hex", "--n", "11", "--keep", "untwisted", "--dry-run"), 0, f"panels, 11, {ODD}"),
        (("enumerate", "--grid", "hex", "--array", "h3", "--until", "twist", "--dry-run"), 0, f"panels, 19, {ODD}"),
        (("enumerate", "--grid", "triangle", "--n", "6", "--until", "twist", "--dry-run"), 0, OPPOSITE),
        (("count", "--grid", "hex", "--n", "11", "--keep", "untwisted"), 0, f"panels, 11, {ODD}"),
        (("count", "--grid", "hex", "--array", "3-4-4", "--keep", "two-stack"), 0, f"panels, 11, {ODD}"),
        (("check", "hex:024"), 1, f"panels, 3, {ODD}"),
        (("check", "hex:024", "--json"), 1, f"panels, 3, {ODD}"),
        (("check", "triangle:012345"), 1, OPPOSITE),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_why_nothing_folds_is_said_in_one_line_beside_the_numbers(run, words, code, line):
    done = run(*words)
    assert done.returncode == code
    assert done.stderr.startswith("nothing folds: ")
    assert done.stderr.endswith(f"{line}\n")
    assert done.stderr.count("\n") == 1
    assert "0" in done.stdout
    assert "nothing folds" not in done.stdout


@pytest.mark.parametrize(
    "words",
    [
        ("enumerate", "--grid", "hex", "--n", "6", "--until", "twist", "--dry-run"),
        ("enumerate", "--grid", "hex", "--n", "11", "--until", "circuits", "--dry-run"),
        ("count", "--grid", "hex", "--n", "11"),
        ("count", "--grid", "hex", "--n", "8", "--keep", "untwisted"),
    ],
    ids=" ".join,
)
def test_nothing_is_said_where_something_folds_or_nobody_asked(run, words):
    done = run(*words)
    assert (done.returncode, done.stderr) == (0, "")


def test_where_there_is_no_circuit_that_is_said(run):
    for spec in (("--array", "3x3"), ("--n", "7")):
        done = run("enumerate", "--grid", "square", *spec, "--until", "twist", "--dry-run")
        assert done.stderr == "no circuits: no closed walk from panel to panel goes through each of them once\n"


def test_a_design_of_an_odd_number_says_so_too(run):
    assert run("show", "hex:024").stdout.endswith(f"\nno two-stack folding: an odd number of panels, 3, {ODD}\n")
    assert run("show", "triangle:012345").stdout.endswith(f"\nno two-stack folding: {OPPOSITE}\n")
    for words in (("show", "hex:024:1"), ("deploy", "hex:024"), ("export", "hex:024", "--output", "a.glb")):
        done = run(*words)
        assert done.returncode == 2
        assert f", as an odd number of panels, 3, {ODD}: choose " in done.stderr


@pytest.mark.parametrize(("grid", "keep"), [*((grid, "all") for grid in GRIDS), ("hex", "untwisted")])
def test_the_size_that_a_refusal_names_works_and_the_next_does_not(run, grid, keep):
    done = run("enumerate", "--grid", grid, "--n", "1000", "--keep", keep, "--dry-run")
    assert (done.returncode, done.stdout) == (2, "")
    most = int(re.search(r"use --n (\d+) or less", done.stderr)[1])
    assert search_all(GRIDS[grid], most, keep).prefixes
    with pytest.raises(SizeError, match=rf"use --n {most} or less"):  # odd numbers have few circuits that fold: none
        _ = search_all(GRIDS[grid], most + 2, keep).prefixes


@pytest.mark.parametrize("crease", [0, 2, 5, 7, 10, 99])
def test_the_crease_that_was_given_is_named_and_not_its_opposite(run, crease):
    for words in (("show",), ("drive",), ("check",), ("export", "--output", "a.fold")):
        done = run(words[0], f"hex:0234550132:{crease}", *words[1:])
        assert done.returncode == 2
        assert f"no two-stack folding at crease {crease}: its creases are 3, 4" in done.stderr


def test_either_flat_crease_names_a_folding(run):
    assert run("show", "hex:0234550132:9").stdout == run("show", "hex:0234550132:4").stdout


def test_one_of_joined_panels_names_both(run):
    facts = []
    for held in ("4+5", "4", "5"):
        words = ("deploy", MOVING, "--seconds", "0.01", "--held", held, "--output", f"{held}.csv")
        assert run(*words).returncode == 1
        facts.append(Path(f"{held}.csv").read_bytes())
    assert facts[0] == facts[1] == facts[2]
    assert run("export", MOVING, "--output", "whole.stl", "--part", "4+5").returncode == 0
    for part in ("4", "5"):
        assert run("export", MOVING, "--output", "part.stl", "--part", part).returncode == 0
        assert Path("part.stl").read_bytes()[80:] == Path("whole.stl").read_bytes()[80:]  # after its title
    assert "the panels are 0+9, 1 to 3, 4+5, 6 to 8" in run("deploy", MOVING, "--held", "77").stderr
    assert (
        "the panels are 0+9, 1 to 3, 4+5, 6 to 8" in run("export", MOVING, "--output", "a.stl", "--part", "77").stderr
    )


@pytest.mark.parametrize("command", ["query", "rank"])
def test_conditions_need_no_quotes(run, database, command):
    more = ("--db", database, "--format", "json")
    apart, quoted = run(command, "n=8", "untwisted", *more), run(command, "n=8 untwisted", *more)
    assert apart.returncode == 0
    assert apart.stdout == quoted.stdout
    assert len(json.loads(apart.stdout)) == 1
    either = run(command, "(symmetry>1", "or", "untwisted)", *more)
    assert either.stdout == run(command, "(symmetry>1 or untwisted)", *more).stdout


@pytest.mark.parametrize(
    ("query", "line"),
    [
        ("n>8", "the greatest n here is 8"),
        ("n < 8", "the least n here is 8"),
        ("n=10", "n is 8 here"),
        ("symmetry=7", "symmetry is from 1 to 4 here"),
        ("min_twist>=5 untwisted", "the greatest min_twist here is 0"),
        ("min_twist>=5 grid=hex", "the greatest min_twist here is 1"),
        ("deploy_time<1", "deploy_time is not known here"),
        ("fits=10x10x34", "the size of folded arrays is not known here"),
        ("grid=square", "grid is hex here"),
        ("n=10 min_twist=1", "n is 8 here"),
        ("n>9 symmetry>100", "the greatest n here is 8 and the greatest symmetry here is 4"),  # no row has either
    ],
)
def test_an_empty_table_names_the_ranges_of_what_is_compared(run, database, query, line):
    done = run("query", query, "--db", database, "--format", "csv", "-c", "id")
    assert (done.returncode, done.stdout, done.stderr) == (0, "id\n", f"no design: {line}\n")
    assert run("query", query, "--db", database, "--output", "none.csv", "--format", "csv").stderr == done.stderr
    assert Path("none.csv").read_text(encoding="utf-8").count("\n") == 1


@pytest.mark.parametrize(
    "words", [("n=8", "--limit", "0"), ("not grid=hex",), ("--sql", "SELECT id FROM designs WHERE n > 9")]
)
def test_other_empty_tables_say_nothing(run, database, words):
    assert run("query", *words, "--db", database).stderr == ""


def test_a_report_needs_no_quotes_either(run, database):
    for name, words in (("a", ("n=8", "untwisted")), ("b", ("n=8 untwisted",))):
        assert run("report", *words, "--db", database, "--output", f"{name}.html").stdout == f"{name}.html\n"
        assert '"count":1,' in Path(f"{name}.html").read_text(encoding="utf-8")


def test_show_takes_the_size_of_panels(run):
    thin, thick = (run("show", "hex:0234550132:3", "--panel", size) for size in ("50x6", "50x20"))
    assert thin.returncode == thick.returncode == 0
    assert thin.stdout == run("show", "hex:0234550132:3").stdout
    assert "leaving it opens the loops by 1.7 mm" in thin.stdout
    assert "leaving it opens the loops by 1.7 mm" not in thick.stdout


def test_sql_asks_for_a_scene_that_is_there(run, database):
    words = ("query", "--sql", "SELECT count(*) FROM designs", "--db", database)
    assert run(*words, "--format", "csv").stdout.split() == ["count(*)", "16"]
    done = run(*words, "--scene", "earth")
    assert (done.returncode, done.stdout) == (2, "")
    assert "no verdicts of the scene 'earth'" in done.stderr


def test_what_is_no_design_may_be_meant_as_an_assembly(run):
    for words in (("show", "fig-9.9"), ("show", "fig-9.9", "--html")):
        assert "there is no assembly 'fig-9.9': see hcsearch assembly list, or name DESIGN" in run(*words).stderr
