"""Every value of a scene reaches the models for simulators and the files beside them, or they are refused."""

from dataclasses import fields, replace

import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.export_files import exported_case
from hcsearch.export.formats import EXPORT_FORMATS
from hcsearch.scenes import Scene
from hcsearch.scenes.scene import HINGE_VALUES
from hcsearch.scenes.scene_file import scene_file_text
from hcsearch.subjects.resolve import resolve
from tests.export.exports import MOVING, written

OTHER_VALUES = {
    "name": "solar",
    "panel": (0.06, 0.06, 0.006),
    "density": 600.0,
    "areal_mass": 2.0,
    "flat_pairs": ("hinged",),
    "margin": 2e-4,
    "spring": "linear:0.2+0.05",
    "springs": (("3", "linear:0.3"),),
    "spring_range": (0.002, 0.1),
    "damping_time": 0.02,
    "damping": 0.1,
    "gravity": (0.0, 0.0, -1.62),
    "drag": 1.44,
    "held": "2",
    "base_mass": 3.0,
    "base_inertia": (0.1, 0.2, 0.3),
    "start": 0.99,
    "restitution": 0.3,
    "seconds": 2.5,
    "stop_stiffness": 2e5,
    "stop_damping": 3.0,
    "cut_stiffness": 2e7,
    "cut_damping": 20.0,
    "friction": 0.02,
    "harness": 0.01,
    "latch_stiffness": 80.0,
    "stop_tolerance": 0.001,
    "play": 0.002,
    "hinges": (("3", (("friction", 0.03),)),),
    "releases": (("3", "0.5 s"),),
    "thickness_tolerance": 1e-5,
    "offset_tolerance": 2e-5,
    "equipment": 0.7,
    "root": "1",
    "craft": ((0.0, 0.0, -0.1, 0.1, 0.1, 0.1),),
    "envelope": "3U",
}
"""Another value for each field of a scene."""
REFUSED = {
    *(
        "drag",
        "base_mass",
        "base_inertia",
        "restitution",
        "stop_stiffness",
        "stop_damping",
        "cut_stiffness",
        "cut_damping",
    ),
    *("latch_stiffness", "craft", "releases"),
}
"""What no model of MuJoCo of a held array can hold."""


def test_every_value_of_a_scene_is_tried():
    assert set(OTHER_VALUES) == {field.name for field in fields(Scene)}


def files_in(scene, wanted, tmp_path):
    """All files of an export in a scene that a file holds."""
    path = tmp_path / "file.toml"
    path.write_text(scene_file_text({}, None, scene), encoding="utf-8")
    files = written(exported_case(resolve(MOVING, "none.sqlite", scene=str(path)), EXPORT_FORMATS[wanted]), wanted)
    return files if isinstance(files, str) else {name: text for name, text in files.items() if isinstance(text, str)}


def check_reaches(scene, name, plain, tmp_path):
    """A URDF and its closure file state a value; a model of MuJoCo holds it, or is refused and names it."""
    assert files_in(scene, "urdf", tmp_path) != files_in(plain, "urdf", tmp_path)
    if name in REFUSED:
        with pytest.raises(HcsearchError, match=rf"^models of MuJoCo hold no {name} of this scene: leave it out, or"):
            files_in(scene, "mjcf", tmp_path)
    else:
        assert files_in(scene, "mjcf", tmp_path) != files_in(plain, "mjcf", tmp_path)


@pytest.mark.parametrize("name", OTHER_VALUES)
def test_every_value_of_a_scene_reaches_the_models_or_is_refused(name, tmp_path):
    check_reaches(replace(Scene(), **{name: OTHER_VALUES[name]}), name, Scene(), tmp_path)


@pytest.mark.parametrize("name", HINGE_VALUES)
def test_every_value_of_a_single_hinge_reaches_the_models_or_is_refused(name, tmp_path):
    check_reaches(replace(Scene(), hinges=(("3", ((name, 0.01),)),)), name, Scene(), tmp_path)
    # where all hinges have a value that a single one has not
    most = replace(Scene(), **{name: 0.01})
    if name not in REFUSED:
        check_reaches(replace(most, hinges=(("3", ((name, 0.0),)),)), name, most, tmp_path)


@pytest.mark.parametrize("name", ["base_mass", "base_inertia"])
def test_a_floating_base_reaches_the_models(name, tmp_path):
    floating = replace(Scene(), held="free", base_mass=1.0, base_inertia=(0.01, 0.01, 0.01))
    other = replace(floating, **{name: OTHER_VALUES[name]})
    for wanted in ("mjcf", "urdf"):
        assert files_in(other, wanted, tmp_path) != files_in(floating, wanted, tmp_path)


def test_a_model_that_cannot_hold_several_values_names_them_all(tmp_path):
    scene = replace(Scene(), latch_stiffness=80.0, restitution=0.2)
    with pytest.raises(HcsearchError, match=r"hold no restitution, latch_stiffness of this scene: leave them out"):
        files_in(scene, "mjcf", tmp_path)


@pytest.mark.parametrize("wanted", ["mjcf", "urdf"])
def test_an_option_and_a_scene_file_write_the_same_friction(wanted, tmp_path):
    case = resolve(MOVING, "none.sqlite", scene=Scene(name="file"), values={"friction": 0.02})
    by_option = written(exported_case(case, EXPORT_FORMATS[wanted]), wanted)
    by_file = files_in(replace(Scene(), friction=0.02), wanted, tmp_path)
    if wanted == "mjcf":
        assert by_option == by_file
        assert by_file.count('frictionloss="0.02"') == 8
    else:
        assert {name: by_option[name] for name in by_file} == by_file
        assert by_file[".urdf"].count('friction="0.02"') == 8


def test_friction_and_the_harness_resist_together_in_the_models(tmp_path):
    scene = replace(Scene(), friction=0.25, harness=0.125, hinges=(("3", (("harness", 0.5),)),))
    assert files_in(scene, "mjcf", tmp_path).count('frictionloss="0.375"') == 7
    assert files_in(scene, "mjcf", tmp_path).count('frictionloss="0.75"') == 1
    assert files_in(scene, "urdf", tmp_path)[".urdf"].count('friction="0.75"') == 1
    assert '"harness": 0.5' in files_in(scene, "urdf", tmp_path)[".closure.json"]
