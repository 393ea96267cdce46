"""Exported scenes in MuJoCo and Pinocchio, beside our own motions and poses. Needs the extra `bench`."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.export.mjcf import mjcf_of
from hcsearch.export.urdf import urdf_of
from hcsearch.motion.collision.panel_prisms import margin_of, prisms_of
from hcsearch.scenes import SCENES
from hcsearch.shape.labels import labels_of
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.springs.deployment.simulated_deployment import simulate_deployment
from hcsearch.springs.dynamics.panels import panel_bodies
from tests.export.cases import NAMES, case

pytestmark = pytest.mark.extra

DEFAULT = SCENES["default"]
BOUNDS = {"hex:0234550132:4": 1e-3, "thesis-4x4": 5e-6, "unit-ii": 1.5e-2, "hex:023224350400:4": 1e-4}
"""What a fold angle of MuJoCo may be off by before the first impact, rad: twice what was measured."""


def model_of(text):
    import mujoco

    mujoco.set_mju_user_warning(lambda _: None)  # it would write a file
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    return mujoco, model, data


def addresses(model, labels):
    return np.array([model.joint(f"hinge_{name}").qposadr[0] for name in labels.hinges])


def greatest_error(of, scene, until=None, **options):
    """Of any fold angle in MuJoCo, before the first impact or a time; and by how much our own turn until then (rad)."""
    linkage, labels = of
    own = simulate_deployment(linkage, scene, tolerance=1e-9, certified=False)
    motion = own.motion
    end = until or (motion.events[0].time if motion.events else motion.times[-1])
    mujoco, model, data = model_of(mjcf_of(linkage, labels, scene, **options))
    at = addresses(model, labels)
    times, angles = [0.0], [data.qpos[at].copy()]
    while data.time + model.opt.timestep < end:
        mujoco.mj_step(model, data)
        times.append(data.time)
        angles.append(data.qpos[at].copy())
    assert not any(warning.number for warning in data.warning)
    q = motion.at(np.array(times))
    expected = own.compiled.of_hinges(q, np.zeros_like(q))[0]
    return np.abs(np.array(angles) - expected).max(), np.abs(expected[-1] - expected[0]).max()


@pytest.mark.parametrize("name", BOUNDS)
def test_mujoco_moves_as_we_do_before_the_first_impact(name):
    error, turned = greatest_error(case(name), DEFAULT)
    assert error < BOUNDS[name]
    assert error < 0.2 * turned


@pytest.mark.parametrize(
    ("name", "until", "bound"), [("hex:0234550132:4", 0.14, 4e-3), ("hex:023224350400:4", 0.3, 2e-3)]
)
def test_mujoco_moves_as_we_do_after_impacts_as_its_stops_hardly_throw_hinges_back(name, until, bound):
    error, turned = greatest_error(case(name), DEFAULT, until)
    assert error < bound
    assert turned > 2.0


SCENES_OF = {
    "gravity": {"gravity": (0.0, -9.81, 0.0)},
    "preloads": {"spring": "linear:0.05+0.1", "springs": ((3, "linear:0+0.2"),), "damping": 0.004},
    "floating": {"held": "free", "base_mass": 0.02, "base_inertia": (1e-5, 2e-5, 3e-5)},
    "another panel held": {"held": 5},
}


@pytest.mark.parametrize("scene", SCENES_OF)
def test_mujoco_moves_as_we_do_in_other_scenes(scene):
    error, turned = greatest_error(case("thesis-4x4"), replace(DEFAULT, **SCENES_OF[scene]), timestep=2e-5)
    assert error < 4e-4
    assert turned > 0.1


def test_mujoco_moves_light_panels_as_we_do():
    linkage = Folding.from_notation("hex:023224350400:4").linkage((0.005, 0.005, 0.0006))
    error, turned = greatest_error((linkage, labels_of(linkage)), DEFAULT, timestep=5e-6)
    assert error < 1e-2
    assert turned > 0.1


RESISTED = [
    ("hex:0234550132:4", {}, "flat"),
    ("hex:0234550132:4", {"friction": 0.02}, "stuck"),
    ("hex:0234550132:4", {"friction": 0.015, "harness": 0.005}, "stuck"),
    ("hex:0234550132:4", {"friction": 0.02, "spring": "linear:0.1+0.05"}, "flat"),
    ("hex:0234550132:4", {"hinges": (("3", (("friction", 0.3),)),)}, "stuck"),
    ("hex:0233340501:3", {"friction": 0.05}, "stuck"),
    ("hex:023344400120:0", {"friction": 0.02}, "stuck"),  # after 20 impacts
    ("square:0122323001:3", {"friction": 0.02}, "stuck"),
    ("square:0122323001:3", {"friction": 0.02, "spring": "linear:0.1+0.05"}, "flat"),
    ("kite:23203030:3", {"friction": 0.1, "spring": "linear:0.1+0.05"}, "stuck"),
    ("kite:23203030:3", {"friction": 0.02, "spring": "linear:0.1+0.05"}, "flat"),
    ("rhombus:23121320:1", {"friction": 0.02}, "stuck"),
]


@pytest.mark.parametrize(("name", "values", "outcome"), RESISTED)
def test_mujoco_and_deploy_agree_on_what_friction_holds(name, values, outcome):
    linkage = Folding.from_notation(name).linkage((0.05, 0.05, 0.006))
    labels, scene = labels_of(linkage), replace(DEFAULT, **values)
    own = simulate_deployment(linkage, scene, certified=False)
    assert own.outcome == outcome
    mujoco, model, data = model_of(mjcf_of(linkage, labels, scene))
    at, flat, end = addresses(model, labels), False, own.motion.times[-1] + 0.1
    while data.time < end and not flat:
        mujoco.mj_step(model, data, nstep=50)
        flat = np.abs(data.qpos[at]).max() < FLAT_FOLD_ANGLE
    assert flat == (outcome == "flat")
    if outcome == "stuck":
        assert np.abs(data.qvel).max() < 1e-3
        assert data.qpos[at] == pytest.approx(own.angles[-1], abs=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_mujoco_has_our_masses_and_places_panels_as_the_linkage_does(name):
    linkage, labels = case(name)
    mujoco, model, data = model_of(mjcf_of(linkage, labels, DEFAULT))
    masses = [body.mass for body in panel_bodies(linkage, DEFAULT.density)]
    assert model.body_mass.sum() == pytest.approx(sum(masses))
    angles, prisms = data.qpos[addresses(model, labels)], prisms_of(linkage, margin_of(linkage))
    poses = linkage.poses(angles)
    for panel, label in enumerate(labels.panels):
        body = model.body(f"panel_{label}").id
        turn = data.xmat[body].reshape(3, 3)
        assert turn == pytest.approx(poses[panel, :, :3], abs=1e-8)
        for geom in np.flatnonzero(model.geom_bodyid == body):
            mesh = model.geom_dataid[geom]
            own = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
            corners = own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            facet = facet_of(mujoco, model, geom)
            expected = prisms.vertices[facet, : prisms.counts[facet, 0]] @ poses[panel, :, :3].T + poses[panel, :, 3]
            apart = np.linalg.norm(corners[:, None] - expected, axis=2)
            assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-6
    mujoco.mj_resetDataKeyframe(model, data, model.key("flat").id)
    assert np.abs(data.qpos).max() == 0.0


def facet_of(mujoco, model, geom):
    mesh = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_MESH, model.geom_dataid[geom])
    return int(mesh.rpartition("_facet")[2])


def test_panels_that_may_collide_in_mujoco_touch_nothing_at_the_start():
    linkage, labels = case("thesis-4x4")
    mujoco, model, data = model_of(mjcf_of(linkage, labels, DEFAULT, contact=True))
    assert data.ncon == 0
    mujoco.mj_step(model, data, nstep=500)
    assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize("name", NAMES)
def test_pinocchio_reads_urdf_with_our_masses_joints_and_poses(name):
    import pinocchio

    linkage, labels = case(name)
    files = urdf_of(linkage, labels, DEFAULT, name, "array")
    closure = json.loads(files[".closure.json"])
    model = pinocchio.buildModelFromXML(files[".urdf"])
    assert model.nq == model.nv == linkage.n_hinges
    bodies = panel_bodies(linkage, DEFAULT.density)
    assert sum(inertia.mass for inertia in model.inertias) == pytest.approx(sum(body.mass for body in bodies))
    start = {joint: facts["start_rad"] for joint, facts in closure["joints"].items()}
    q = np.zeros(model.nq)
    for joint, angle in start.items():
        q[model.joints[model.getJointId(joint)].idx_q] = angle
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    poses = linkage.poses(np.array([start[f"hinge_{name}"] for name in labels.hinges]))
    for panel, label in enumerate(labels.panels):
        frame = data.oMf[model.getFrameId(f"panel_{label}")]
        assert frame.rotation == pytest.approx(poses[panel, :, :3], abs=1e-8)
    for pair in closure["closures"]:
        ends = [
            data.oMf[model.getFrameId(pair[end]["link"])].act(np.array(pair[end]["xyz_m"]))
            for end in ("first", "second")
        ]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert all(bound == pytest.approx(np.pi) for bound in model.upperPositionLimit)
