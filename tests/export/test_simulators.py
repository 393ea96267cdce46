"""Scenes as trees of links whose loops are cut, and the formats of simulators, read in plain Python."""

import json
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree as Xml

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError, HcsearchWarning
from hcsearch.designs.folding import Folding
from hcsearch.export.cut_trees import cut_tree, linear_law_of
from hcsearch.export.mjcf import mjcf_of
from hcsearch.export.settings import ExportSettings
from hcsearch.export.urdf import urdf_of
from hcsearch.scenes import SCENES
from hcsearch.scenes.laws import law_named
from hcsearch.shape.labels import labels_of
from hcsearch.springs.dynamics.panels import panel_bodies
from tests.export.cases import NAMES, case, merged
from tests.export.exports import exported, written

DEFAULT, EARTH, SATELLITE = SCENES["default"], SCENES["earth"], SCENES["satellite"]


@pytest.mark.parametrize("name", NAMES)
def test_every_hinge_is_a_joint_and_each_loop_is_closed_between_parts_of_one_panel(name):
    linkage, labels = case(name)
    tree = cut_tree(linkage, labels, DEFAULT)
    joined = [link.joint for link in tree.links[1:]]
    assert sorted(own.hinge for own in joined) == list(range(linkage.n_hinges))
    assert len({own.name for own in joined}) == linkage.n_hinges
    assert len({link.name for link in tree.links}) == len(tree.links) == linkage.n_hinges + 1
    assert len(tree.closures) == len(linkage.loops)
    for closure in tree.closures:
        first, second = tree.links[closure.first], tree.links[closure.second]
        assert first.panel == second.panel
        assert first.has_shape
        assert not second.has_shape
    assert sorted(link.panel for link in tree.links if link.has_shape) == list(range(linkage.n_panels))
    for link in tree.links[1:]:
        ends = linkage.pattern.hinges[link.joint.hinge]
        assert {ends.first, ends.second} == {link.panel, tree.links[link.joint.parent].panel}


@pytest.mark.parametrize("scene", [DEFAULT, SATELLITE], ids=lambda scene: scene.name)
def test_parts_of_panels_have_their_mass_together(scene):
    linkage, labels = case("unit-ii")
    tree = cut_tree(linkage, labels, scene)
    bodies = panel_bodies(linkage, scene.density)
    own = np.zeros(linkage.n_panels)
    for link in tree.links:
        own[link.panel] += link.body.mass
    assert own[1:] == pytest.approx([body.mass for body in bodies[1:]])
    assert own[0] == pytest.approx(bodies[0].mass + scene.base_mass)
    assert tree.has_free_base == (scene.held == "free")


def test_mjcf_has_the_springs_dampers_and_stops_of_the_scene():
    linkage, labels = case("hex:0234550132:4")
    scene = replace(EARTH, spring="linear:0.2+0.05", springs=((2, "free"), (3, "2*linear:0.1"), (5, "linear:0+0.01")))
    root = Xml.fromstring(mjcf_of(linkage, labels, scene, "a <name>", timestep=1e-3))
    assert root.get("model") == "a <name>"
    assert root.find("option").get("gravity") == "0.0 0.0 -9.81"
    assert root.find("option").get("timestep") == "0.001"
    assert root.find("default/joint").get("range") == f"0.0 {np.pi!r}"
    joints = {joint.get("name"): joint.attrib for joint in root.iter("joint") if "name" in joint.attrib}
    assert set(joints) == {f"hinge_{name}" for name in labels.hinges}
    plain, free, firm, moment = (joints[f"hinge_{labels.hinges[k]}"] for k in (0, 2, 3, 4))
    assert (plain["stiffness"], float(plain["springref"])) == ("0.2", pytest.approx(-0.25))
    assert float(plain["damping"]) == pytest.approx(0.043 * 0.2)
    assert (free["stiffness"], free["damping"]) == ("0.0", "0.0")
    assert firm["stiffness"] == "0.2"
    assert moment["stiffness"] == "0.0"
    (actuator,) = root.find("actuator")
    assert (actuator.get("joint"), actuator.get("biasprm")) == (moment["name"], "-0.01 0.0 0.0")


def test_mjcf_lets_panels_collide_where_they_should_but_never_at_a_hinge():
    linkage, labels = case("unit-ii")
    root = Xml.fromstring(mjcf_of(linkage, labels, DEFAULT, contact=True))
    assert root.find("default/geom").get("contype") == "1"
    excluded = {(pair.get("body1"), pair.get("body2")) for pair in root.iter("exclude")}
    expected = {(f"panel_{hinge.first}", f"panel_{hinge.second}") for hinge in linkage.pattern.hinges}
    assert excluded == expected
    assert Xml.fromstring(mjcf_of(linkage, labels, DEFAULT)).find("default/geom").get("contype") == "0"


def option_of(panel, **changes):
    linkage = Folding.from_notation("hex:0234550132:4").linkage(panel)
    text = mjcf_of(linkage, labels_of(linkage), replace(DEFAULT, **changes))
    return Xml.fromstring(text).find("option").attrib


def test_steps_of_mjcf_follow_the_natural_time_of_the_panels():
    small, large = option_of((0.05, 0.05, 0.006), seconds=9.0), option_of((1.0, 1.0, 0.02))
    assert (float(small["timestep"]), small["integrator"]) == (pytest.approx(2e-5), "RK4")
    assert float(large["timestep"]) > 100 * float(small["timestep"])


def test_light_panels_are_damped_implicitly_as_runge_kutta_steps_would_be_unstable():
    assert option_of((0.005, 0.005, 0.0006))["integrator"] == "implicitfast"
    assert option_of((0.005, 0.005, 0.0006), damping=0.0)["integrator"] == "RK4"


def test_laws_that_are_no_lines_are_refused_with_a_linear_one():
    linkage, labels = case("thesis-4x4")
    scene = replace(DEFAULT, springs=((3, "quadratic:0.1,0.02"),))
    with pytest.raises(
        HcsearchError, match=r"hinge_3 has the law quadratic:0.1,0.02, .* give it one, such as linear:0.163"
    ):
        mjcf_of(linkage, labels, scene)
    with pytest.raises(HcsearchError, match=r"hinge_3 has the law tape:0.2@0.05,0.03@0.01"):
        mjcf_of(linkage, labels, replace(DEFAULT, springs=((3, "tape:0.2@0.05,0.03@0.01"),)))


@pytest.mark.parametrize("text", ["linear:0.1", "linear:0.1+0.02", "3*linear:0.1-0.5", "free", "table:0.1@-1,0.3@1"])
def test_lines_of_laws_give_their_moments(text):
    law = law_named(text)
    stiffness, moment = linear_law_of(law, "hinge_0")
    for angle in (-0.5, 0.0, 0.7):
        assert moment + stiffness * angle == pytest.approx(law.straight.moment(angle))


@pytest.mark.parametrize("name", NAMES)
def test_urdf_is_a_tree_and_its_closure_file_names_frames_that_coincide_where_loops_are_closed(name):
    linkage, labels = case(name)
    files = urdf_of(linkage, labels, DEFAULT, name, "array")
    root, closure = Xml.fromstring(files[".urdf"]), json.loads(files[".closure.json"])
    frames = {closure["base"]: np.eye(4)}
    for joint in root.iter("joint"):
        frames[joint.find("child").get("link")] = frames[joint.find("parent").get("link")] @ turned(
            joint, closure["joints"][joint.get("name")]["start_rad"]
        )
    assert len(frames) == len(root.findall("link")) == linkage.n_hinges + 1
    assert len(closure["closures"]) == len(linkage.loops)
    for pair in closure["closures"]:
        ends = [frames[pair[end]["link"]] for end in ("first", "second")]
        points = [frames[pair[end]["link"]] @ [*pair[end]["xyz_m"], 1.0] for end in ("first", "second")]
        assert points[0] == pytest.approx(points[1], abs=1e-9)
        assert ends[0][:3, :3] == pytest.approx(ends[1][:3, :3], abs=1e-9)
    meshes = {f"array{ending}" for ending in files if ending.endswith(".stl")}
    assert {mesh.get("filename") for mesh in root.iter("mesh")} == meshes
    assert len(meshes) == linkage.n_panels


def turned(joint, angle):
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    axis = np.array(joint.find("axis").get("xyz").split(), float)
    pose[:3, :3] = Rotation.from_rotvec(angle * axis).as_matrix()
    pose[:3, 3] = np.array(joint.find("origin").get("xyz").split(), float)
    return pose


def test_open_chains_need_no_closure():
    tree = cut_tree(*merged(), DEFAULT)
    assert tree.closures == ()
    assert all(link.has_shape for link in tree.links)


def test_subjects_with_drives_are_refused_as_models_of_mujoco():
    case = SimpleNamespace(drives=object())
    with pytest.raises(HcsearchError, match=r"leave out the table \[drive\]"):
        written(SimpleNamespace(case=case), "mjcf")


@pytest.mark.parametrize(("panel", "most"), [("50x0.2", "0.1"), ("50x0.19", "0.095"), ("500x2", "1")])
def test_panels_no_thicker_than_two_margins_are_refused_by_mjcf_as_by_deploy(panel, most, tmp_path):
    file = tmp_path / "thin.toml"
    file.write_text(f'panel_mm = "{panel}"\nmargin_mm = 1.0\n', encoding="utf-8")
    thin = exported("hex:0234550132:4", "mjcf", scene=str(file))
    for contact in (False, True):
        message = (
            rf"^a margin of \S+ mm .*: give more than 0 and less than {most} mm as margin_mm .*, or thicker panels$"
        )
        with pytest.raises(HcsearchError, match=message):
            written(thin, "mjcf", ExportSettings(contact=contact))


def test_meshes_of_thin_panels_are_not_inside_out():
    root = Xml.fromstring(written(exported("hex:0234550132:4", "mjcf", panel="50x0.21"), "mjcf"))
    for mesh in root.iter("mesh"):
        bottom, top = np.array(mesh.get("vertex").split(), float).reshape(2, -1, 3)
        assert (top - bottom)[:, 2] == pytest.approx(0.6 * 0.21e-3)  # a fifth of it goes off each face


def test_panels_too_small_for_mujoco_are_refused():
    with pytest.warns(HcsearchWarning, match="did you mean 500x60"):
        small = exported("hex:0234550132:4", "mjcf", panel="0.5x0.06")
    with pytest.raises(HcsearchError, match=r"panel_4\+5 has a moment of inertia of .* give larger panels"):
        written(small, "mjcf")
    with pytest.warns(HcsearchWarning, match="a side of less than 5 mm"):
        fast = exported("square:0122333011:1", "mjcf", panel="2x0.24")
    with pytest.raises(HcsearchError, match=r"alone at .* rad/s\^2, and MuJoCo stops above 1e\+10: give larger panels"):
        written(fast, "mjcf")
