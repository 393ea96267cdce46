"""What a scene leaves out changes nothing: each omission against the full scene."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import SCENES
from hcsearch.scenes.scene_file import scene_named
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.compiled_scene import OMISSIONS, compile_scene
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.deployment.spring_sets import tied_hinges
from hcsearch.springs.dynamics.panels import panel_bodies
from tests.linkages import linkage_named
from tests.naive import rotation

DEFAULT = SCENES["default"]
FLOATING = replace(DEFAULT, held="free", base_mass=0.1, base_inertia=(1e-4, 2e-4, 1e-4))
FULL = frozenset(OMISSIONS)
TOLERANCE = 1e-8


def left_out(deployment):
    return {omission.name for omission in deployment.compiled.omissions}


def angles_at(deployment, times):
    q = deployment.motion.at(times)
    return deployment.compiled.of_hinges(q, np.zeros_like(q))[0]


def difference(one, two):
    """Greatest difference of the angles of all hinges and of the doubled energies, until the first event of either."""
    ends = [motion.times[-1] for motion in (one.motion, two.motion)]
    events = [event.time for motion in (one.motion, two.motion) for event in motion.events]
    times = np.linspace(0.0, 0.999 * min(ends + events), 40)
    angles = np.abs(angles_at(one, times) - angles_at(two, times)).max()
    laws = [np.array([_energy(d, row) for row in angles_at(d, times)]) for d in (one, two)]
    return angles, np.abs(laws[0] - laws[1]).max()


def _energy(deployment, angles):
    return deployment.compiled.factor * sum(
        drive.law.energy(angle)
        for hinge, angle in enumerate(angles)
        if _counts(deployment, hinge)
        for drive in [deployment.compiled.system.drives[deployment.compiled.joint_of[hinge]]]
    )


def _counts(deployment, hinge):
    """Whether a hinge is the first of those that share its joint."""
    joints = deployment.compiled.joint_of.tolist()
    return joints.index(joints[hinge]) == hinge


def motion(name, scene, keep=frozenset(), formulation="constrained", **options):
    return simulate_deployment(
        linkage_named(name), scene, formulation, tolerance=TOLERANCE, keep=frozenset(keep), certified=False, **options
    )


MIRRORED = [
    "thesis-4x4",
    "square:0123:0",
    "square:012230:1",  # all hinges are parallel, the mirror is across them
    "square:01222300:3",
    "square:0112223300:4",
]


@pytest.mark.parametrize("scene", [DEFAULT, FLOATING], ids=["held", "floating"])
@pytest.mark.parametrize("name", MIRRORED)
def test_half_of_a_symmetric_motion_tells_the_other_half(name, scene):
    scene = replace(scene, seconds=0.1)
    half, full = motion(name, scene), motion(name, scene, {"half"})
    assert "half" in left_out(half)
    assert "half" not in left_out(full)
    assert (half.compiled.factor, full.compiled.factor) == (2.0, 1.0)
    joints = [d.compiled.system.n_joints for d in (half, full)]
    assert joints[0] < joints[1] or joints == [1, 1]  # an only hinge is its own image
    angles, energy = difference(half, full)
    assert angles < 2 * TOLERANCE
    assert energy < TOLERANCE
    for book in ("kinetic", "stored", "damped"):
        ends = [d.compiled.factor * getattr(d.motion, book)[0] for d in (half, full)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-12)
    if not (half.motion.events or full.motion.events):
        for book in ("kinetic", "stored", "damped"):
            ends = [d.compiled.factor * getattr(d.motion, book)[-1] for d in (half, full)]
            assert ends[0] == pytest.approx(ends[1], abs=20 * TOLERANCE)


def test_half_of_a_motion_without_inertia():
    scene = replace(DEFAULT, seconds=0.2)
    half, full = (motion("thesis-4x4", scene, keep, "quasistatic") for keep in ((), {"half"}))
    assert (half.compiled.factor, full.compiled.factor) == (2.0, 1.0)
    assert half.angles[-1] == pytest.approx(full.angles[-1], abs=10 * TOLERANCE)
    assert full.angles[-1].min() < 2.0


@pytest.mark.parametrize(
    "changes",
    [
        {"springs": ((1, "linear:0.2"),)},
        {"hinges": ((1, (("damping", 0.02),)),)},
        {"gravity": (0.5, 0.3, 0.0)},
        {"gravity": (0.3, 0.0, -9.81)},
    ],
)
def test_what_breaks_the_symmetry_keeps_both_halves(changes):
    compiled = compile_scene(linkage_named("thesis-4x4"), replace(DEFAULT, **changes))
    normal = [abs(np.array(changes.get("gravity", (1, 0, 0)))[axis]) for axis in (0, 1)]
    assert max(normal) > 0.0
    assert compiled.factor == 1.0
    assert "half" not in {omission.name for omission in compiled.omissions}


def test_equal_dampers_of_mirror_hinges_keep_the_symmetry():
    linkage = linkage_named("square:01222300:3")
    assert (1, 4) in tied_hinges(linkage, linkage.base)  # the pair that opens first
    assert labels_of(linkage).hinges[1:5:3] == ("1", "5")
    dampers = (("1", (("damping", 0.02),)), ("5", (("damping", 0.02),)))
    scene = replace(DEFAULT, seconds=0.1, hinges=dampers)
    half, full = motion("square:01222300:3", scene), motion("square:01222300:3", scene, {"half"})
    assert (half.compiled.factor, full.compiled.factor) == (2.0, 1.0)
    assert max(difference(half, full)) < 2 * TOLERANCE
    plain = motion("square:01222300:3", replace(scene, hinges=()))
    assert half.angles[-1][1] > plain.angles[-1][1] + 1.0
    assert compile_scene(linkage, replace(scene, hinges=dampers[:1])).factor == 1.0


def test_gravity_in_the_mirror_plane_keeps_the_symmetry():
    linkage = linkage_named("thesis-4x4")
    factors = [
        compile_scene(linkage, replace(DEFAULT, gravity=gravity)).factor
        for gravity in ((0.0, 0.0, -9.81), (9.81, 0.0, 0.0), (0.0, 9.81, 0.0))
    ]
    assert factors[0] == 2.0
    assert sorted(factors[1:]) == [1.0, 2.0]


@pytest.mark.parametrize("scene", [DEFAULT, FLOATING], ids=["held", "floating"])
@pytest.mark.parametrize("name", ["hex:023350:1", "hex:0233335000:1"])
def test_panels_on_parallel_hinges_need_no_third_dimension(name, scene):
    scene = replace(scene, seconds=0.2)
    plane, space = motion(name, scene), motion(name, scene, {"third dimension"})
    assert "third dimension" in left_out(plane)
    assert "third dimension" not in left_out(space)
    rows = [d.compiled.system.n_equations for d in (plane, space)]
    assert rows == [3, 6]
    angles, energy = difference(plane, space)
    assert angles < 10 * TOLERANCE
    assert energy < TOLERANCE


def test_hinges_in_two_directions_need_the_third_dimension():
    compiled = compile_scene(linkage_named("hex:0234550132:4"), DEFAULT)
    assert "third dimension" not in {omission.name for omission in compiled.omissions}


@pytest.mark.parametrize(("start", "hinge"), [(0.3, 0), (0.3, 1), (0.2, 1)])
@pytest.mark.parametrize("name", ["hex:0234550132:4", "hex:023350:1"])
def test_stops_that_the_energy_does_not_reach(name, start, hinge):
    crease = labels_of(linkage_named(name)).hinges[hinge]
    scene = replace(DEFAULT, start=start, springs=((crease, "linear:3"),))
    less, full = motion(name, scene), motion(name, scene, {"stops"})
    assert "stops" in left_out(less)
    free = [joint for joint, drive in enumerate(less.compiled.system.drives) if drive.upper == math.inf]
    assert less.compiled.joint_of[hinge] in free
    assert all(drive.upper == math.pi for drive in full.compiled.system.drives)
    assert full.motion.q[:, free].max() < math.pi
    assert less.outcome == full.outcome == "flat"
    assert (less.motion.q == full.motion.q).all()  # a stop that is not hit takes no part in any number


def test_stops_within_reach_stay():
    scene = replace(DEFAULT, start=0.3, springs=((0, "linear:0.001"),))
    compiled = compile_scene(linkage_named("hex:0234550132:4"), scene)
    assert compiled.system.drives[compiled.joint_of[0]].upper == math.pi
    earth = compile_scene(linkage_named("hex:0234550132:4"), replace(scene, gravity=(0.0, 0.0, -9.81)))
    assert all(drive.upper == math.pi for drive in earth.system.drives)


def test_pairs_that_are_left_out_are_hinged_or_mirrored():
    whole = compile_scene(linkage_named("thesis-4x4"), DEFAULT, keep=FULL)
    pattern = whole.linkage.pattern
    assert whole.separated_pairs == {(hinge.first, hinge.second) for hinge in pattern.hinges}
    half = compile_scene(linkage_named("thesis-4x4"), DEFAULT)
    assert half.separated_pairs > whole.separated_pairs


@pytest.mark.parametrize(("name", "across"), [("hex:0234550132:4", 1), ("hex:0223335500:0", 2)])
def test_a_flat_pair_that_reaches_across_the_line_of_a_hinge_is_looked_at(name, across):
    """At a sharp turn the line of the first hinge runs through the other hexagon of the pair."""
    compiled = compile_scene(linkage_named(name), DEFAULT)
    hinged = {(hinge.first, hinge.second) for hinge in compiled.linkage.pattern.hinges}
    left = hinged - compiled.separated_pairs
    assert len(left) == across
    panels = compiled.linkage.pattern.panels
    assert all({len(panels[one]), len(panels[two])} == {1, 2} for one, two in left)


@pytest.mark.parametrize("name", ["element-8r", "hex:0233340501:3"])
def test_a_very_heavy_base_is_as_good_as_held(name):
    heavy = replace(DEFAULT, held="free", base_mass=1e6, base_inertia=(1e6, 1e6, 1e6))
    floating, held = motion(name, heavy), motion(name, DEFAULT)
    assert floating.compiled.system.n_joints == held.compiled.system.n_joints + 6
    assert floating.outcome == held.outcome == "flat"
    assert difference(floating, held)[0] < 1e-6
    assert np.abs(floating.motion.q[:, :6]).max() < 1e-6


def momenta(system, q, v):
    """Momentum and angular momentum about the origin, and the sums of their parts' lengths; by finite differences."""

    def places(q):
        found = []
        for joint, x in zip(system.joints, q, strict=True):
            turn, shift = found[joint.parent] if joint.parent >= 0 else (np.eye(3), np.zeros(3))
            own = np.eye(3) if joint.slides else rotation(x * joint.axis)
            move = x * joint.axis if joint.slides else joint.point - own @ joint.point
            found.append((turn @ own, turn @ move + shift))
        return found

    step = 1e-6
    total = np.zeros(6)
    size = np.zeros(2)
    for body, now, back, on in zip(system.bodies, places(q), places(q - step * v), places(q + step * v), strict=True):
        centre = now[0] @ body.centre + now[1]
        speed = (on[0] @ body.centre + on[1] - back[0] @ body.centre - back[1]) / (2 * step)
        twist = (on[0] - back[0]) / (2 * step) @ now[0].T
        spin = np.array([twist[2, 1], twist[0, 2], twist[1, 0]])
        parts = body.mass * speed, now[0] @ body.inertia @ now[0].T @ spin + np.cross(centre, body.mass * speed)
        total += np.concatenate(parts)
        size += [np.linalg.norm(part) for part in parts]
    return total, size


def test_a_light_base_keeps_the_momentum_of_the_whole():
    found = motion("hex:0234550132:4", FLOATING)
    assert found.outcome == "flat"
    assert len([e for e in found.motion.events if e.kind == "hit"]) > 0  # impacts keep it too
    for k in np.linspace(0, len(found.motion.times) - 1, 12).astype(int):
        total, size = momenta(found.compiled.system, found.motion.q[k], found.motion.v[k])
        assert np.linalg.norm(total[:3]) <= 2e-6 * size[0] + 1e-12
        assert np.linalg.norm(total[3:]) <= 2e-6 * size[1] + 1e-12
    assert size[0] > 1e-3


def test_the_base_is_the_panel_and_what_it_carries():
    compiled = compile_scene(linkage_named("hex:0234550132:4"), FLOATING)
    panel = panel_bodies(compiled.linkage, FLOATING.density)[compiled.linkage.base]
    base = compiled.system.bodies[5]
    assert base.mass == pytest.approx(panel.mass + 0.1)
    assert base.centre == pytest.approx(panel.centre)
    assert np.diag(base.inertia) == pytest.approx(np.diag(panel.inertia) + np.array([1e-4, 2e-4, 1e-4]))
    assert not compiled.hinged[:6].any()
    assert compiled.hinged[6:].all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"held": "10"}, r"there is no panel 10: the panels are 0\+9, 1 to 3, 4\+5, 6 to 8"),
        ({"held": -1}, "held cannot be -1: give bottom, free, or the number of a panel"),
        ({"springs": (("10", "free"),)}, "there is no hinge 10: the hinges are 0 to 3, 5 to 8"),
        ({"springs": ((-1, "free"),)}, "springs cannot be .*: write { 3 = 'linear:0.2' }, a law for each hinge"),
        ({"start": 0.0}, "give a share above 0, up to 1"),
        ({"start": 1.001}, "start cannot be 1.001: give a number from 0 to 1"),
        ({"start": math.nan}, "start cannot be nan: give a number from 0 to 1"),
        ({"spring": "linear"}, "cannot read the law 'linear': write free, linear:0.1"),
    ],
)
def test_scenes_that_cannot_be_are_refused(changes, message):
    with pytest.raises(HcsearchError, match=message):
        compile_scene(linkage_named("hex:0234550132:4"), replace(DEFAULT, **changes))


def test_names_that_are_not_left_out_are_refused():
    with pytest.raises(HcsearchError, match="a simulation has no omission 'weight': choose from half, third dimension"):
        compile_scene(linkage_named("hex:0234550132:4"), DEFAULT, keep=frozenset({"weight"}))
    with pytest.raises(HcsearchError, match="there is no scene 'moon': choose one of default, earth"):
        scene_named("moon")


def test_a_start_that_does_not_close_is_refused_far_from_the_folded_state():
    with pytest.raises(HcsearchError, match=r"no closed state lies near 0\.5 .*: start nearer to 1"):
        compile_scene(linkage_named("hex:0234451512:0"), replace(DEFAULT, start=0.5))
    locked = linkage_named("hex:0234535012:4")
    compiled = compile_scene(locked, DEFAULT)
    assert (compiled.of_hinges(compiled.start[None], compiled.start[None])[0][0] == locked.folded).all()
