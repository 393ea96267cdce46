"""Which scene the commands that read a database show, where it has verdicts of the user's own panels alone."""

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch

SEARCH = ("enumerate", "--grid", "hex", "--n", 8, "--keep", "untwisted")
READING = (
    ("query", "untwisted", "-c", "id,status,deploy_time", "--format", "csv"),
    ("query", "--sql", "SELECT id, status, deploy_time FROM designs", "--format", "csv"),
    ("rank", "untwisted", "--format", "csv"),
    ("show", 1),
)
reading = pytest.mark.parametrize("words", READING, ids=lambda words: " ".join(map(str, words[:2])))


def call(*words):
    """Standard output and standard error."""
    result = CliRunner().invoke(hcsearch, [*map(str, words)], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout, result.stderr


def refusal(*words):
    return str(CliRunner().invoke(hcsearch, [*map(str, words)]).exception)


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """A database with verdicts of one scene, for panels of one's own."""
    file = tmp_path_factory.mktemp("own") / "one.sqlite"
    call(*SEARCH, "--panel", "1000x20", "--db", file)
    return file


@pytest.fixture(scope="module")
def two(one):
    """A database with verdicts for two sizes."""
    file = Path(shutil.copy(one, one.with_name("two.sqlite")))
    call(*SEARCH, "--panel", "500x20", "--db", file)
    return file


@reading
def test_the_only_scene_of_a_database_is_taken_and_named(one, words):
    shown, said = call(*words, "--db", one)
    assert said == f"in the scene 1000x1000x20, the only one that {one} has verdicts of\n"
    assert "48.13" in shown
    assert call(*words, "--db", one, "--panel", "1000x20") == (shown, "")
    refused = refusal(*words, "--db", one, "--scene", "default")
    assert "no verdicts of the scene 'default'" in refused
    assert "its scenes are: 1000x1000x20; name one of these with --scene" in refused


@reading
def test_one_of_several_scenes_has_to_be_named(two, words):
    assert "its scenes are: 1000x1000x20, 500x500x20; name one of these with --scene" in refusal(*words, "--db", two)
    shown, said = call(*words, "--db", two, "--scene", "1000x20")
    assert ("48.13" in shown, said) == (words[0] != "show", "") or "deploy time     48.13 s" in shown
    assert "48.13" not in call(*words, "--db", two, "--panel", "500x20")[0]


@reading
def test_widths_across_are_of_the_grid_that_is_read(one, words):
    shown = call(*words, "--db", one, "--panel", "1000x20")[0]
    assert call(*words, "--db", one, "--across", f"{1000 * 3**0.5:.10g}x20") == (shown, "")
    for width, side in (("1000x20", "577.3502692x577.3502692x20"), ("50x6", "28.86751346x28.86751346x6")):
        assert f"no verdicts of the scene '{side}'" in refusal(*words, "--db", one, "--across", width)
    # the height of a triangle that has the default size
    assert "no verdicts of the scene '25x25x6'" in refusal(*words, "--db", one, "--across", f"{25 * 3**0.5:.10g}x6")


def test_widths_across_of_several_grids_need_one(one):
    file = Path(shutil.copy(one, one.with_name("grids.sqlite")))
    call("enumerate", "--grid", "square", "--n", 8, "--keep", "untwisted", "--panel", "1000x20", "--db", file)
    asked = ("--across", "1000x20", "--db", file)
    assert "name the grid, as in grid=hex, or one with --scene" in refusal("query", "untwisted", *asked)
    assert call("query", "grid=square untwisted", *asked)[1] == ""
    assert "no verdicts of the scene '577.3502692x" in refusal("query", "grid=hex untwisted", *asked)


def test_reports_are_of_the_only_scene(one, two, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "in the scene 1000x1000x20, the only one" in call("report", "n=8", "--db", one, "--output", "r.html")[1]
    assert "48.13 s" in Path("r.html").read_text(encoding="utf-8")
    assert "name one of these with --scene" in refusal("report", "n=8", "--db", two, "--output", "none.html")
    assert not Path("none.html").exists()


def test_views_that_name_scenes_show_all_of_them(two):
    shown, said = call("query", "--sql", "SELECT DISTINCT base FROM deployments ORDER BY 1", "--db", two)
    assert (shown.split()[-2:], said) == (["1000x1000x20", "500x500x20"], "")


def test_an_export_of_what_was_not_judged_says_so(two, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = call("export", 1, "--output", "a.fold", "--db", two)[1]
    assert said == f"scene default, without verdicts in {two}: its scenes are 1000x1000x20, 500x500x20\n"
    for options, scene in ((("--panel", "60x6"), "60x60x6"), (("--scene", "earth"), "earth")):
        said = call("export", 1, *options, "--output", "a.fold", "--db", two)[1]
        assert said == f"scene {scene}, without verdicts in {two}: its scenes are 1000x1000x20, 500x500x20\n"
    said = call("export", 1, "--panel", "500x20", "--output", "a.fold", "--db", two)[1]
    assert "without verdicts" not in said


def test_what_no_stage_has_judged_has_no_status(tmp_path):
    file = tmp_path / "designs.sqlite"
    call("enumerate", "--grid", "hex", "--n", 8, "--until", "mobility", "--db", file)
    listed, said = call("query", "two_stack", "-c", "circuit,status,deployable", "--format", "csv", "--db", file)
    assert (listed.splitlines()[1:], said) == (["hex:02334051,twisted,0", "hex:02234400,,"], "")
    assert "status          not judged" in call("show", 14, "--db", file)[0]
