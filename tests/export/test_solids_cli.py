"""Solid and simulator formats, as the command line writes them."""

from xml.etree import ElementTree as Xml

import pytest

from tests.commands import run_here

NAME = "square:01222300:1"


@pytest.fixture
def written(tmp_path, monkeypatch, capfd):
    """The exit code of an export in a folder of its own, and what it prints."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        done = run_here(("export", *words), capfd)
        return done.returncode, done.stdout + done.stderr

    return run


@pytest.mark.parametrize("file", ["a.glb", "a.stl", "a.3mf", "a.step", "a.stp", "a.xml"])
def test_each_format_is_written_by_its_ending(file, written, tmp_path):
    assert written(NAME, "--output", file) == (0, f"{file}\n")
    assert (tmp_path / file).stat().st_size > 1000


def test_urdf_brings_its_closure_and_meshes_along(written, tmp_path):
    code, output = written(NAME, "--output", "arm.urdf")
    assert code == 0
    assert output.split()[:2] == ["arm.urdf", "arm.closure.json"]
    meshes = {mesh.get("filename") for mesh in Xml.parse(tmp_path / "arm.urdf").iter("mesh")}
    assert meshes == set(output.split()[2:])
    assert all((tmp_path / mesh).exists() for mesh in meshes)


def test_solids_are_written_in_a_state_and_by_panel(written, tmp_path):
    for file, words in {"flat": (), "folded": ("--state", "folded"), "half": ("--state", "0.5")}.items():
        assert written(NAME, "--output", f"{file}.stl", *words)[0] == 0
    contents = {(tmp_path / f"{file}.stl").read_bytes() for file in ("flat", "folded", "half")}
    assert len(contents) == 3
    assert written(NAME, "--output", "one.stl", "--part", "1+2")[0] == 0
    assert (tmp_path / "one.stl").stat().st_size < (tmp_path / "flat.stl").stat().st_size


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--output", "a.stl", "--part", "99"), "there is no panel 99: the panels are 0, 1+2, 3, 4"),
        (
            ("--output", "a.stl", "--state", "0.5", "--motion", "springs", "--seconds", "1e-3"),
            f"the motion of {NAME} does not end flat (simulated",
        ),
        (("--output", "a.xml", "--part", "1"), "mjcf takes no --part"),
        (("--output", "a.stl", "--contact"), "stl takes no --contact"),
        (("--output", "a.stl", "--timestep", "0.1"), "stl takes no --timestep"),
        (("--output", "a.xml", "--scene", "soft.toml"), "MuJoCo's springs are linear"),
    ],
)
def test_what_a_format_cannot_hold_is_refused_in_one_line(words, message, written, tmp_path):
    (tmp_path / "soft.toml").write_text("[scene]\nspring = 'quadratic:0.1,0.02'\n")
    code, output = written(NAME, *words)
    assert code == 2
    assert message in output
    assert len(output.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["soft.toml"]
