"""`hcsearch init`: scene files to start from."""

import re
import tomllib
from dataclasses import fields, replace

import pytest

from hcsearch import HcsearchError, Scene, init_scene
from hcsearch.basics.errors import HcsearchWarning, OutputError, SceneError
from hcsearch.designs.grid import GRIDS
from hcsearch.scenes.scene import SCENE_VALUES
from hcsearch.scenes.scene_file import scene_template
from hcsearch.subjects.stored_scenes import read_scene
from tests.commands import run_here


def test_the_file_is_the_scene_default_under_its_own_name(tmp_path):
    path = init_scene(tmp_path / "solar.toml")
    assert read_scene(str(path), None) == replace(Scene(), name="solar")


def test_every_value_of_a_scene_is_in_the_file_once():
    assert list(SCENE_VALUES) == [field.name for field in fields(Scene)]
    text = scene_template()
    for key in SCENE_VALUES:
        if key not in ("springs", "hinges", "releases"):
            written = f"{key}_mm" if key in ("panel", "margin") else key
            assert len(re.findall(rf"^(# )?{written} = ", text, re.MULTILINE)) == 1, key
            assert re.search(rf"^(# )?{written} = .*  # \w", text, re.MULTILINE), key
        else:
            assert f"# [{key}]" in text


def test_values_that_are_not_set_are_examples_that_can_be_set(tmp_path):
    path = tmp_path / "solar.toml"
    path.write_text(re.sub(r"^# (?=\w+ = |\[)", "", scene_template(), flags=re.MULTILINE))
    scene = read_scene(str(path), None)
    changed = {field.name for field in fields(Scene) if getattr(scene, field.name) != getattr(Scene(), field.name)}
    assert changed == {
        *("name", "panel", "margin", "areal_mass", "spring_range", "damping", "seconds", "springs", "hinges"),
        "releases",
    }


@pytest.mark.parametrize("grid", [None, *GRIDS])
def test_panels_are_those_that_are_given(tmp_path, grid):
    size = "300x200x12" if grid in (None, "rectangle") else "300x12"
    scene = read_scene(str(init_scene(tmp_path / "a.toml", panel=size, grid=grid)), None, grid)
    assert scene.panel == pytest.approx((0.3, 0.2 if size.count("x") == 2 else 0.3, 0.012))


def test_the_grid_gives_the_size_that_is_shown():
    assert '# panel_mm = "50x40x6"' in scene_template(grid="rectangle")
    assert '# panel_mm = "50x50x6"' in scene_template(grid="kite")


def test_a_width_across_flats_needs_the_grid(tmp_path):
    path = init_scene(tmp_path / "a.toml", panel="across 1000x20", grid="hex")
    assert tomllib.loads(path.read_text())["panel_mm"].endswith("x20")
    with pytest.raises(HcsearchError, match="--grid"):
        init_scene(tmp_path / "b.toml", panel="across 1000x20")


@pytest.mark.parametrize(
    ("name", "options", "error", "message"),
    [
        ("there.toml", {}, OutputError, "exists: name another file"),
        ("earth.toml", {}, SceneError, "a scene of the program"),
        ("a,b.toml", {}, SceneError, "no name of a scene"),
        ("solar.txt", {}, OutputError, "write .toml"),
        ("no/folder/a.toml", {}, OutputError, "there is no folder"),
        ("a.toml", {"panel": "300"}, SceneError, "is no panel"),
        ("a.toml", {"panel": "300x200x12", "grid": "hex"}, SceneError, "one side"),
        ("a.toml", {"grid": "hexx"}, HcsearchError, "hexx"),
    ],
)
def test_what_is_refused_writes_nothing(tmp_path, name, options, error, message):
    (tmp_path / "there.toml").write_text("mine")
    with pytest.raises(error, match=message):
        init_scene(tmp_path / name, **options)
    assert [file.name for file in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text() == "mine"


def test_a_doubtful_size_is_told(tmp_path):
    with pytest.warns(HcsearchWarning, match="did you mean 300x12"):
        init_scene(tmp_path / "a.toml", panel="12x300")


def test_the_command_prints_the_path(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    done = run_here(("init", "solar.toml", "--panel", "300x12", "--grid", "square"), capfd)
    assert (done.returncode, done.stdout, done.stderr) == (0, "solar.toml\n", "")
    again = run_here(("init", "solar.toml"), capfd)
    assert (again.returncode, again.stderr.count("\n")) == (2, 1)
    assert read_scene("solar.toml", None).panel == (0.3, 0.3, 0.012)
