"""Scenes: sizes of panels, names, files, what is left to the panels, and the laws of scale."""

import math
import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hcsearch.basics.errors import HcsearchError, InputFileError, SceneError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of
from hcsearch.designs.grid import GRIDS
from hcsearch.designs.panel_sizes import default_panel, panel_text, read_panel
from hcsearch.scenes import SCENES, Scene, check_verdicts, joined_name, panel_of, with_panel
from hcsearch.scenes.looks import SceneVariant, first_variant, scene_variants, variant_parts
from hcsearch.scenes.scene import check_scene_name
from hcsearch.scenes.scene_file import read_scene_file, read_scene_text, scene_file_text, scene_in, scene_with
from hcsearch.scenes.setup import scene_of_setup, setup_of_scene
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment

DEFAULT = SCENES["default"]
lengths = st.floats(1e-3, 1e7).map(lambda value: float(f"{value:.10g}"))  # mm


def folding(notation: str, crease: int) -> Folding:
    return folding_of(Circuit.from_notation(notation).canonical(), crease)


@given(lengths, lengths, lengths)
def test_sizes_of_panels_round_trip(length, width, thickness):
    panel = read_panel(f"{length:.10g}x{width:.10g}x{thickness:.10g}")
    assert panel == pytest.approx((1e-3 * length, 1e-3 * width, 1e-3 * thickness))
    assert read_panel(panel_text(panel)) == panel


def test_one_side_is_enough():
    assert read_panel("50x6") == (0.05, 0.05, 0.006)


@pytest.mark.parametrize(
    "text", ["", "50", "50x", "0x6", "50x40x0", "-5x5x5", "nanx5x5", "1e300x5", "50x40x6x2", "5 x 5"]
)
def test_what_is_no_panel_is_refused(text):
    with pytest.raises(SceneError, match="is no panel"):
        read_panel(text)


@pytest.mark.parametrize("grid", ["square", "hex", "triangle"])
def test_width_across_flats_is_that_of_the_cell(grid):
    side, _, thickness = read_panel("across 1000x20", grid)
    corners = [(side * x, side * y) for x, y in GRIDS[grid].corners(tuple([0] * (3 if grid == "triangle" else 2)))]
    widths = []
    for (x, y), (u, v) in zip(corners, corners[1:] + corners[:1], strict=True):
        normal = (y - v, u - x)
        heights = [(p * normal[0] + q * normal[1]) / math.hypot(*normal) for p, q in corners]
        widths.append(max(heights) - min(heights))
    assert widths == pytest.approx([1.0] * len(corners))
    assert thickness == 0.02


def test_rectangles_have_no_width_across_flats():
    with pytest.raises(SceneError, match="--panel 50x40x6"):
        read_panel("across 1000x20", "rectangle")


def test_regular_panels_have_one_side():
    for grid in ("hex", "triangle"):
        with pytest.raises(SceneError, match="--panel SIDExTHICKNESS"):
            panel_of(replace(DEFAULT, panel=(0.05, 0.04, 0.006)), grid)
        assert panel_of(DEFAULT, grid) == (0.05, 0.05, 0.006)
    oblong = replace(DEFAULT, panel=(0.06, 0.04, 0.006))
    assert panel_of(oblong, "rectangle") == panel_of(oblong, "square") == (0.06, 0.04, 0.006)
    check_verdicts(oblong, "rectangle", 12)
    with pytest.raises(SceneError, match="use the grid rectangle"):
        check_verdicts(oblong, "square", 12)


def test_a_scene_with_other_panels_has_another_name():
    for grid in GRIDS:
        assert with_panel(DEFAULT, default_panel(grid), grid) is DEFAULT
        assert with_panel(DEFAULT, (1.0, 1.0, 0.02), grid).name == "1000x1000x20"
        assert with_panel(SCENES["earth"], (1.0, 1.0, 0.02), grid).name == "earth, 1000x1000x20"
    assert joined_name("default") == "default"


@pytest.mark.parametrize("name", ["solar", "solar-2", "a b", "Solar.v2"])
def test_names_of_scenes(name):
    assert check_scene_name(name) == name


@pytest.mark.parametrize("name", ["", "a, b", "1000x1000x20", "a'b", "\x1b[31m", "a" * 100, "a:b", " a"])
def test_names_that_a_command_line_could_not_hold_are_refused(name):
    with pytest.raises(SceneError, match="is no name of a scene"):
        check_scene_name(name)


numbers = st.floats(1e-6, 1e6)
scenes = st.builds(
    Scene,
    name=st.sampled_from(["default", "solar", "hinged, spread 3"]),
    panel=st.none() | st.just((0.05, 0.04, 0.006)) | st.just(read_panel("across 1000x20", "hex")),
    density=numbers,
    areal_mass=st.none() | numbers,
    flat_pairs=st.sampled_from(["rigid", "hinged", "merged", "either", ("hinged", "merged")]),
    margin=st.none() | st.sampled_from([1e-4, 0.0, 2.5e-5]),
    spring=st.sampled_from(["linear:0.1", "free", "table:0@0,1@3"]),
    springs=st.sampled_from([(), (("0", "linear:0.2"), ("7", "free"))]),
    spring_range=st.none() | st.just((0.001, 0.2)),
    damping_time=numbers,
    damping=st.none() | numbers,
    gravity=st.tuples(*(st.floats(-1e6, 1e6) for _ in range(3))),
    drag=numbers,
    held=st.sampled_from(["bottom", "free", "0", "3"]),
    base_mass=numbers,
    base_inertia=st.tuples(numbers, numbers, numbers),
    start=st.floats(0.5, 1.0),
    restitution=st.floats(0.0, 1.0),
    seconds=st.none() | numbers,
    friction=st.floats(0.0, 1.0),
    harness=st.floats(0.0, 1.0),
    latch_stiffness=numbers,
    stop_tolerance=st.floats(0.0, 0.1),
    play=st.floats(0.0, 0.1),
    hinges=st.sampled_from([(), (("0", (("friction", 0.02),)), ("7", (("play", 0.001), ("damping", 0.02))))]),
    releases=st.sampled_from([(), (("0", "0.5 s"), ("7", "hinge 3+4 at 0.2 rad"))]),
    thickness_tolerance=st.floats(0.0, 1e-3),
    offset_tolerance=st.floats(0.0, 1e-3),
    equipment=numbers,
    root=st.sampled_from(["held", "free", "2"]),
    craft=st.sampled_from([(), ((0.0, -0.1, -0.2, 0.1, 0.2, 0.15),)]),
    envelope=st.sampled_from(["", "3U", "100x100x340"]),
)


@given(scenes)
def test_files_of_scenes_round_trip(scene):
    assert (
        scene_in(read_scene_text(scene_file_text({"design": "hex:023350:1"}, "constrained", scene), "a text")) == scene
    )


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"damping": True}, "damping cannot be True"),
        ({"gravity": "9.81"}, "gravity cannot be '9.81': give x,y,z"),
        ({"gravity": ["9.81"]}, "give x,y,z in m/s"),
        ({"springs": {"0": "linear:1", "00": "linear:2"}}, "springs names hinge 0 twice"),
        ({"spring_range": "0.2,0.1"}, "the softest and the stiffest"),
        ({"spring_range": "0.2,1e300"}, r"spring_range cannot be '0.2,1e300': give numbers from 0 to 1e\+12"),
        ({"base_inertia": (0.0, -1.0, 0.0)}, r"give numbers from 0 to 1e\+12"),
        ({"stop_stiffness": 1e300}, r"stop_stiffness cannot be 1e\+300: give a number from 0 to 1e\+12"),
        ({"base_mass": -1}, r"base_mass cannot be -1: give a number from 0 to 1e\+12"),
        ({"held": "top"}, "bottom, free, or the number"),
        ({"flat_pairs": "loose"}, "'rigid', 'hinged', 'merged' or 'either'"),
        ({"flat_pairs": []}, "or a list of ways in the order of trial"),
        ({"flat_pairs": ["hinged", "hinged"]}, "or a list of ways in the order of trial"),
        ({"density": 0.0}, r"density cannot be 0.0: give a number from 1e-09 to 1e\+12"),
        ({"areal_mass": float("nan")}, r"areal_mass cannot be nan: give a number from 1e-09 to 1e\+12"),
        ({"colour": "red"}, "a scene has no 'colour'"),
        ({"friction": -0.01}, r"friction cannot be -0.01: give a number from 0 to 1e\+12"),
        ({"play": 0.2}, "play cannot be 0.2: give a number from 0 to 0.1"),
        ({"hinges": {"0": {"density": 1.0}}}, "hinge 0 has no 'density': it has damping, friction, harness"),
        ({"hinges": {"0": {"play": 0.2}}}, "play cannot be 0.2"),
        ({"hinges": {"0": {"damping": -1.0}}}, r"damping cannot be -1.0: give a number from 0 to 1e\+12"),
        ({"hinges": {"0": {}, "00": {}}}, "hinges names hinge 0 twice"),
        ({"hinges": 3}, "the values of each hinge"),
        ({"releases": 3}, "a release for each hinge"),
        ({"releases": {"0": 0.5}}, "write { 3 = '0.5 s' }"),
        ({"releases": {"0": "soon"}}, "cannot read the release 'soon': write a time, such as '0.5 s'"),
        ({"releases": {"0": "hinge 3 at 0 rad"}}, "with an angle above 0, up to 3.14"),
        ({"releases": {"0": "1 s", "00": "2 s"}}, "releases names hinge 0 twice"),
        ({"root": "top"}, "give held, free, or the number of a panel"),
        ({"craft": [[0, 0, 0, 1, 1]]}, "a list of boxes"),
        ({"craft": [[0, 0, 0, 1, 1, -1]]}, "give numbers from 0"),
        ({"envelope": 3}, "write '3U', or three lengths in mm"),
        ({"seconds": "9" * 100_000}, r"seconds cannot be '9{56}\.\.\."),
    ],
)
def test_values_that_no_scene_has_are_refused(values, message):
    with pytest.raises(SceneError, match=message):
        scene_with(DEFAULT, values)


def test_hinges_have_the_values_of_the_scene_or_their_own():
    linkage = folding("hex:0234550132", 4).linkage(default_panel("hex"))
    own = (("0", (("friction", 0.02), ("play", 0.001))), ("7", (("harness", 0.005), ("latch_stiffness", 50.0))))
    scene = replace(DEFAULT, friction=0.01, stop_tolerance=1e-3, hinges=own, held="3", root="2")
    setup = setup_of_scene(scene, linkage)
    labels = labels_of(linkage)
    place = {name: labels.hinge(name) for name in ("0", "7")}
    for k in range(linkage.n_hinges):
        friction = 0.02 if k == place["0"] else 0.01
        harness = 0.005 if k == place["7"] else 0.0
        assert setup.resistance[k] == friction + harness
        assert setup.latch_stiffness[k] == (50.0 if k == place["7"] else 0.0)
        assert setup.play[k] == (0.001 if k == place["0"] else 0.0)
    assert setup.root == labels.panel("2") != setup.held == labels.panel("3")
    assert setup_of_scene(replace(scene, root="held"), linkage).root == setup.held
    assert setup_of_scene(replace(scene, root="free"), linkage).root is None
    with pytest.raises(HcsearchError, match="there is no hinge 99"):
        setup_of_scene(replace(scene, hinges=(("99", ()),)), linkage)


def test_two_names_of_one_hinge_have_one_value():
    merged = Folding.from_notation("square:012233300121:5")
    linkage = merged.linkage(default_panel("square"), flat_pairs="merged")
    joint = next(name for name in labels_of(linkage).hinges if "+" in name)
    first, second = joint.split("+")[:2]
    scene = replace(DEFAULT, hinges=((first, (("friction", 0.02),)), (second, (("friction", 0.03),))))
    with pytest.raises(HcsearchError, match=f"hinge {re.escape(joint)} is given two values of friction"):
        setup_of_scene(scene, linkage)
    same = replace(DEFAULT, hinges=((first, (("friction", 0.02),)), (second, (("friction", 0.02),))))
    assert sorted(setup_of_scene(same, linkage).resistance)[-1] == 0.02


def test_the_congruent_linkage_has_the_same_friction_at_the_same_hinges():
    scene = replace(DEFAULT, hinges=(("1", (("friction", 0.02),)), ("3", (("friction", 0.03),))))
    linkage = Folding.from_notation("hex:0223344000:4").linkage(default_panel("hex"))
    assert linkage.twin is not None
    setup = setup_of_scene(scene, linkage)
    congruent = setup.of_congruent(linkage)
    for hinge, image in enumerate(linkage.twin.hinges):
        assert congruent.resistance[image] == setup.resistance[hinge]


DAMPERS = st.dictionaries(st.sampled_from([str(hinge) for hinge in range(10)]), st.sampled_from([0.0, 0.004, 0.02]))
LINKAGES = [
    Folding.from_notation(notation).linkage(default_panel("hex"))
    for notation in ("hex:0234550132:4", "hex:0223344000:4")
]


def with_dampers(scene, dampers):
    return replace(scene, hinges=tuple((hinge, (("damping", damping),)) for hinge, damping in dampers.items()))


@given(DAMPERS, st.sampled_from([0.02, 0.0]), st.none() | st.just(0.007), st.sampled_from(LINKAGES))
def test_a_hinge_has_its_own_damping_or_that_of_the_scene(dampers, time, damping, linkage):
    labels = labels_of(linkage)
    dampers = {hinge: value for hinge, value in dampers.items() if hinge in labels.hinges}
    scene = replace(DEFAULT, damping_time=time, damping=damping, springs=((labels.hinges[2], "linear:0.3"),))
    setup = setup_of_scene(with_dampers(scene, dampers), linkage)
    for hinge, name in enumerate(labels.hinges):
        stiffness = 0.3 if hinge == 2 else 0.1
        plain = time * stiffness if damping is None else damping
        assert setup.dampings[hinge] == pytest.approx(dampers.get(name, plain), rel=1e-14)
    drives = compile_scene(linkage, setup, keep=frozenset({"half"})).system.drives
    assert sorted(drive.damping for drive in drives) == sorted(setup.dampings)


@given(DAMPERS, DAMPERS, st.none() | st.just(0.007), st.sampled_from(LINKAGES))
def test_dampers_of_setups_are_written_back(dampers, others, damping, linkage):
    labels = labels_of(linkage)
    dampers, others = ({hinge: c for hinge, c in one.items() if hinge in labels.hinges} for one in (dampers, others))
    scene = with_dampers(replace(DEFAULT, damping=damping), dampers)
    setup = setup_of_scene(with_dampers(scene, others), linkage)
    written = scene_of_setup(setup, scene, labels)
    assert setup_of_scene(written, linkage).dampings == setup.dampings
    assert scene_in(read_scene_text(scene_file_text({}, None, written), "a text")) == written


def test_values_of_a_hinge_that_are_not_given_stay():
    scene = replace(DEFAULT, hinges=(("0", (("friction", 0.02), ("damping", 0.01))), ("7", (("play", 0.001),))))
    changed = scene_with(scene, {"hinges": {"0": {"damping": 0.03}, "3": {"damping": 0.0}}})
    assert dict(dict(changed.hinges)["0"]) == {"friction": 0.02, "damping": 0.03}
    assert dict(dict(changed.hinges)["3"]) == {"damping": 0.0}
    assert dict(changed.hinges)["7"] == (("play", 0.001),)


def test_the_congruent_linkage_has_the_same_dampers_at_the_same_hinges():
    linkage = LINKAGES[1]
    setup = setup_of_scene(with_dampers(DEFAULT, {"1": 0.02, "3": 0.0}), linkage)
    congruent = setup.of_congruent(linkage)
    for hinge, image in enumerate(linkage.twin.hinges):
        assert congruent.dampings[image] == setup.dampings[hinge]


def test_a_longer_time_is_simulated_with_stronger_dampers():
    linkage = LINKAGES[0]
    damped = setup_of_scene(with_dampers(DEFAULT, {"1": 0.043}), linkage)
    assert damped.seconds == pytest.approx(setup_of_scene(replace(DEFAULT, damping=0.043), linkage).seconds)
    assert setup_of_scene(with_dampers(DEFAULT, {"1": 0.001}), linkage).seconds == 1.0


def test_equipment_adds_to_the_density():
    assert Scene(equipment=2.5).density_of(0.01) == pytest.approx(547.0 + 250.0)
    assert Scene(areal_mass=1.0, equipment=2.5).density_of(0.01) == pytest.approx(350.0)


def test_values_of_single_hinges_are_of_one_design():
    with pytest.raises(SceneError, match="has values of single hinges, which are those of one design"):
        check_verdicts(replace(DEFAULT, hinges=(("0", (("friction", 0.01),)),)), "hex", 10)
    with pytest.raises(SceneError, match="root may be 'held', or 0 to 9"):
        check_verdicts(replace(DEFAULT, root="10"), "hex", 10)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("panel_mm = '1e300x1e300x1e300'", "is no panel"),
        ("a = " + 2000 * "[", "nested too deep|is no TOML"),
        ("colour = 1", "unknown key"),
        ("margin_mm = true", "margin_mm cannot be True"),
        ("margin_mm = 1e300", r"margin_mm cannot be 1e\+300: give a number from 0 to 1e\+12"),
        ("[scene]\ndamping = 1e300", r"damping cannot be 1e\+300: give a number from 0 to 1e\+12"),
        ("scene = 3", r"write a table \[scene\]"),
        ("\xff", "is no text file"),
    ],
)
def test_files_that_hold_no_scene_are_one_line(tmp_path, text, message):
    path = tmp_path / "scene.toml"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(HcsearchError, match=message) as refused:
        scene_in(read_scene_file(str(path)))
    assert len(str(refused.value)) < 400


def test_devices_and_huge_files_are_refused(tmp_path):
    with pytest.raises(InputFileError, match="is a pipe or a device"):
        read_scene_file("/dev/zero")
    path = tmp_path / "huge.toml"
    path.write_bytes(b"#" * 5_000_000)
    with pytest.raises(InputFileError, match="larger than 4 MiB"):
        read_scene_file(str(path))


def test_ways_and_looks_follow_the_scene():
    assert DEFAULT.flat_pairs == ("rigid", "hinged", "merged")
    assert replace(DEFAULT, flat_pairs="merged").flat_pairs == ("merged",)
    assert replace(DEFAULT, flat_pairs="hinged").flat_pairs == ("hinged",)
    for scene in (DEFAULT, SCENES["earth"], replace(DEFAULT, flat_pairs="hinged", name="solar")):
        looks = scene_variants(scene)
        assert looks[0] == first_variant(scene)
        names = [look.name(scene) for look in looks]
        assert len(set(names)) == len(names)
        assert all(look.pairs in scene.flat_pairs for look in looks)
        for look, name in zip(looks[1:], names[1:], strict=True):
            parts = name.split(", ")
            pairs, springs = variant_parts(parts)
            assert (pairs or first_variant(scene).pairs, springs) == (look.pairs, look.springs)
            assert (parts or ["default"]) == [scene.name]
    assert SceneVariant("hinged", "spread 3").name(DEFAULT) == "hinged, spread 3"
    assert SceneVariant("rigid", "mountains first").name(DEFAULT) == "mountains first"


def test_scenes_without_verdicts_on_all_designs_are_refused():
    for changed, message in (
        ({"held": "free"}, "holds no panel"),
        ({"held": "12"}, "panel 12 is not in all foldings of 12 panels"),
        ({"springs": (("0", "free"),)}, "springs of single hinges"),
        ({"panel": (0.05, 0.04, 0.006)}, "--panel SIDExTHICKNESS"),
    ):
        with pytest.raises(SceneError, match=message):
            check_verdicts(replace(DEFAULT, **changed), "hex", 12)
    check_verdicts(replace(DEFAULT, held=5), "hex", 12)


def test_the_default_scene_is_what_it_always_was():
    for notation, crease in (("hex:0234550132", 4), ("square:01222300", 3)):
        scene = setup_of_scene(DEFAULT, folding(notation, crease).linkage())
        assert (scene.seconds, scene.margin, scene.density) == (1.0, 1e-4, 547.0)
        assert scene.spring_range == (0.001, 0.2)


def test_what_is_left_open_grows_with_the_panels():
    one = folding("square:01222300", 3)
    large = setup_of_scene(replace(DEFAULT, areal_mass=20.0), one.linkage((1.0, 1.0, 0.02)))
    assert large.density == pytest.approx(1000.0)
    assert large.margin == pytest.approx(2e-3)
    assert large.seconds == pytest.approx(math.sqrt(20.0 / (547.0 * 0.05**4 * 0.006)), rel=5e-3)
    assert large.spring_range == (0.001, 0.2)  # without weight springs set the time alone
    lifted = setup_of_scene(replace(SCENES["earth"], areal_mass=20.0), one.linkage((1.0, 1.0, 0.02)))
    weight = 20.0 / (547.0 * 0.05**3 * 0.006)
    assert lifted.spring_range == pytest.approx((0.001 * weight, 0.2 * weight), rel=5e-3)
    given_by_hand = replace(DEFAULT, seconds=0.5, margin=1e-5, spring_range=(1.0, 2.0))
    kept = setup_of_scene(given_by_hand, one.linkage((1.0, 1.0, 0.02)))
    assert (kept.seconds, kept.margin, kept.spring_range) == (0.5, 1e-5, (1.0, 2.0))


@pytest.mark.parametrize(("notation", "crease"), [("hex:0234550132", 4), ("hex:02234400", 1)])
@pytest.mark.parametrize(("size", "slowness"), [(20.0, 1.0), (0.1, 1.0), (20.0, 50.0), (3.0, 0.2)])
def test_similar_scenes_have_the_same_verdict(notation, crease, size, slowness):
    """Panels `size` times as large, springs such that times grow by `slowness`: angles are those of the small ones."""
    one = folding(notation, crease)
    small = simulate_deployment(one.linkage(), replace(DEFAULT, seconds=1.0))
    stiffness = 0.1 * size**5 / slowness**2
    scene = replace(
        DEFAULT,
        spring=f"linear:{stiffness!r}",
        damping_time=slowness * DEFAULT.damping_time,
        seconds=slowness,
    )
    large = simulate_deployment(one.linkage((0.05 * size, 0.05 * size, 0.006 * size)), scene)
    assert large.verdict == small.verdict
    assert large.outcome == small.outcome
    assert large.clearance.kind == small.clearance.kind
    if small.clearance.kind == "collides":
        assert large.clearance.panels == small.clearance.panels
        assert large.clearance.time == pytest.approx(slowness * small.clearance.time, rel=1e-3)
    else:
        # gaps are known to the resolution, 0.05 mm of panels of 50 mm
        assert large.clearance.gap == pytest.approx(size * small.clearance.gap, abs=5e-5 * size)
    assert large.motion.times[-1] == pytest.approx(slowness * small.motion.times[-1], rel=1e-3)
