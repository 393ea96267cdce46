"""Models for simulators, read back: the same mechanism as that which was exported."""

import os
import re
import struct

import numpy as np
import pytest

from hcsearch import save
from hcsearch.basics.errors import InputFileError
from hcsearch.motion.kinematics.numerical_rank import generic_rank, rank_at
from hcsearch.search.own_patterns import flat_models
from hcsearch.subjects.resolve import resolve
from tests.commands import run_here

_NAMES = (
    "hex:0234550132:4",
    "square:012233230011:0",
    "triangle:0123434501:1",
    "unit-ii",
    "module-i",
    "element-6r",
)


@pytest.fixture(scope="module", params=[(name, ending) for name in _NAMES for ending in (".urdf", ".xml")], ids=str)
def models(request, tmp_path_factory):
    """An exported linkage, and that of the case of its model."""
    name, ending = request.param
    path = tmp_path_factory.mktemp("models") / f"model{ending}"
    save(name, path, db="none.sqlite")
    return resolve(name, "none.sqlite").linkage, resolve(str(path), "none.sqlite").linkage


def test_a_model_has_the_panels_and_hinges_that_were_exported(models):
    exported, read = models
    assert (read.n_panels, read.n_hinges, len(read.loops)) == (
        exported.n_panels,
        exported.n_hinges,
        len(exported.loops),
    )
    assert read.pattern.thickness == pytest.approx(exported.pattern.thickness, rel=1e-6)
    areas = [
        sorted(sum(_area(linkage.pattern.facets[f]) for f in panel) for panel in linkage.pattern.panels)
        for linkage in models
    ]
    assert np.allclose(*areas, rtol=1e-5)
    faces = [sorted((hinge.face, hinge.closes) for hinge in linkage.pattern.hinges) for linkage in models]
    assert faces[0] == faces[1]


def test_a_model_has_the_mobility_of_what_was_exported(models):
    for state in ("folded", "flat"):
        ranks = [rank_at(linkage, getattr(linkage, state)) for linkage in models]
        assert ranks[0].nullity == ranks[1].nullity is not None
    generic = [generic_rank(linkage).nullity for linkage in models]
    assert generic[0] is None or generic[0] == generic[1]


def _area(facet):
    x, y = np.array(facet).T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("ending", [".urdf", ".xml"])
@pytest.mark.parametrize(
    ("values", "remark"),
    [
        ({}, None),
        ({"friction": 0.02}, "the friction of the model is not used: it comes from --friction or --scene"),
        ({"damping": 0.1}, "the damping of the model is not used: it comes from --scene"),
        ({"spring": "linear:0.1+0.02"}, "the springs of the model are not used: they come from --scene"),
        (
            {"gravity": "0,0,-9.81", "held": "free", "springs": {"2": "linear:0.2"}},
            "the springs, damping, gravity and floating base of the model are not used: they come from --gravity, "
            "--held or --scene",
        ),
    ],
    ids=str,
)
def test_what_a_model_states_and_no_command_uses_is_named(values, remark, ending, tmp_path, capfd):
    path = tmp_path / f"a{ending}"
    save("hex:0234550132:4", path, db="none.sqlite", values=values)
    capfd.readouterr()
    resolve(str(path), "none.sqlite")
    design, *remarks = sorted(capfd.readouterr().err.splitlines(), key=lambda line: line.startswith(f"{path}:"))
    assert "is no design of a grid" in design
    assert remarks == ([] if remark is None else [f"{path}: {remark}"])


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        (
            "other.urdf",
            "<robot name='arm'><link name='a'/></robot>",
            "the loops, which URDF cannot hold, in .*other.closure.json",
        ),
        ("other.xml", "<mujoco><worldbody/></mujoco>", "is no model that hcsearch export wrote"),
        ("other.xml", "<html/>", "is no model that hcsearch export wrote"),
        (
            "other.xml",
            "<mujoco><worldbody><body name='a' pos='0 0 0'><geom type='box'/></body></worldbody></mujoco>",
            "mujoco has no keyframe",
        ),
        ("other.mjcf", "<mujoco", "is no model, which is XML"),
        ("other.xml", "<!DOCTYPE mujoco [<!ENTITY a 'aaa'>]><mujoco/>", "it declares a document type"),
    ],
)
def test_models_of_other_programs_are_refused_in_one_line(name, text, message, tmp_path, capfd):
    path = tmp_path / name
    path.write_text(text)
    result = run_here(["check", str(path)], capfd)
    assert (result.returncode, result.stdout, len(result.stderr.splitlines())) == (2, "", 1)
    assert re.search(message, result.stderr)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The files of one URDF model, by name."""
    folder = tmp_path_factory.mktemp("urdf")
    return {path.name: path.read_bytes() for path in save("element-6r", folder / "a.urdf")}


@pytest.fixture
def folder(exported, tmp_path):
    """A folder with a copy of the model."""
    for name, content in exported.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def _as_text(content):
    """A binary STL file as text."""
    lines = ["solid panel"]
    for numbers in struct.iter_unpack("<12f2x", content[84:]):
        corners = (numbers[k : k + 3] for k in (3, 6, 9))
        vertices = [f"vertex {' '.join(map(repr, corner))}" for corner in corners]
        lines += ["facet normal 0 0 1", "outer loop", *vertices, "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid panel", ""]).encode()


def test_meshes_may_be_text_and_may_have_titles_like_text(folder, exported):
    given = resolve(str(folder / "a.urdf")).linkage.pattern
    for path in folder.glob("*.stl"):
        path.write_bytes(_as_text(exported[path.name]))
    (folder / "a.panel_0.stl").write_bytes(b"solid title".ljust(80) + exported["a.panel_0.stl"][80:])
    assert resolve(str(folder / "a.urdf")).linkage.pattern == given


def test_meshes_lie_beside_the_model_whichever_folder_it_names(folder, exported):
    named = exported["a.urdf"].replace(b"a.panel", b"/elsewhere/../meshes/a.panel")
    (folder / "a.urdf").write_bytes(named)
    assert resolve(str(folder / "a.urdf")).linkage.n_panels == 6


_STL, _URDF, _CLOSURES = "a.panel_0.stl", "a.urdf", "a.closure.json"


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        (_STL, lambda content: content[:-7], "a.panel_0.stl is no sound STL file: it has .* bytes where"),
        (_STL, lambda content: _as_text(content)[:-40], r"its text breaks off after \d+ triangles"),
        (_STL, lambda content: content[:100] + b"\xff" * 8 + content[108:], "a coordinate that is no number"),
        (_STL, lambda content: content[:80] + bytes(4), "it has no triangle"),
        (_URDF, lambda text: text.replace(b'rpy="0 0 0"', b'rpy="0 0 1"'), r"has a rotated origin \(rpy\)"),
        (_URDF, lambda text: text.replace(b'type="revolute"', b'type="fixed"', 1), "'hinge_0' is fixed, where"),
        (_URDF, lambda text: re.sub(rb'axis xyz="[^"]*"', b'axis xyz="0 0 1"', text), "not in the plane of the"),
        (_URDF, lambda text: re.sub(rb'axis xyz="[^"]*"', b'axis xyz="1 x 0"', text), "axis of joint 'hinge_0' has"),
        (_CLOSURES, lambda text: text.replace(b"packed_rad", b"packed"), "joint 'hinge_0' has no number packed_rad"),
        (
            _CLOSURES,
            lambda text: re.sub(rb'packed_rad": [^,}]*', b'packed_rad": -1', text),
            "a packed angle that is not",
        ),
        (_CLOSURES, lambda _: b"{}", "a.closure.json is no model that .*: 'joints' is missing"),
    ],
)
def test_damaged_models_are_refused_with_the_damaged_part(file, change, message, folder, exported):
    (folder / file).write_bytes(change(exported[file]))
    with pytest.raises(InputFileError, match=message):
        resolve(str(folder / "a.urdf"))


def test_a_joint_that_lies_on_no_edge_is_refused(tmp_path):
    (path,) = save("element-6r", tmp_path / "a.xml")
    text = re.sub(r'(<joint name="hinge_2"[^>]*axis=")[^"]*"', r'\1 1 0.3 0"', path.read_text())
    path.write_text(text)
    with pytest.raises(InputFileError, match="joint 'hinge_2' lies on no edge that links 'panel_2' and 'panel_3'"):
        resolve(str(path))


def test_a_model_with_too_many_joints_is_refused(folder, monkeypatch):
    monkeypatch.setattr(flat_models, "MAX_MODEL_JOINTS", 5)
    with pytest.raises(InputFileError, match="it has 6 joints, and at most 5 are read"):
        resolve(str(folder / "a.urdf"))


def test_a_mesh_that_is_a_pipe_is_refused(folder):
    (folder / "a.panel_0.stl").unlink()
    os.mkfifo(folder / "a.panel_0.stl")
    with pytest.raises(InputFileError, match=r"cannot read the mesh .*: it is a pipe or a device"):
        resolve(str(folder / "a.urdf"))
