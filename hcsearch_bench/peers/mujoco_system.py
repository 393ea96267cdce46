"""Any system in MuJoCo: joints of a tree, struts as tendons, welds as soft equality constraints."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as Xml

import numpy as np
from scipy.linalg import eigh, null_space

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.body_trees import GROUND
from hcsearch_bench.peers.states import Trajectory, common_points, depth_first, installed, lines_of
from hcsearch_bench.run.work_precision import UnableError

if TYPE_CHECKING:
    from hcsearch.springs.dynamics.system import System


LEAST = 1e-12
"""MuJoCo wants every body to have inertia about every axis: where there is none, this share of mass by size squared."""
ITERATIONS = 3
"""Of its solver; with equality constraints alone one is enough but for rounding."""
FRICTION_ITERATIONS = 50
"""The same with friction, which bounds forces."""
SINGULAR_SHARE = 1e-9
"""Singular values of constraints below this share of the greatest count as zero."""
IMPEDANCE = 0.9999
"""The stiffest constraints that MuJoCo has; they settle within two steps."""


def run(system: System, q: Reals, v: Reals, times: Reals, *, step: float = 1e-3, integrator: str = "RK4") -> Trajectory:
    """Follow a system in steps of about `step` (s), which must fit into equal spaces between the times.

    integrator : RK4, Euler, implicit or implicitfast.
    """
    mujoco = installed("mujoco")
    each = max(1, round((times[1] - times[0]) / step))
    constants, _, _ = lines_of(system)
    model = mujoco.MjModel.from_xml_string(text_of(system, (times[1] - times[0]) / each, integrator))
    data = mujoco.MjData(model)
    order = depth_first(system)  # hinges and slides only: positions and velocities have the same addresses
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = q[order], v[order], -constants[order]
    qs, vs = np.empty((len(times), len(q))), np.empty((len(times), len(q)))
    qs[0], vs[0] = q, v
    mujoco.set_mju_user_warning(_silent)  # it would write a file
    begin = time.perf_counter()
    for k in range(1, len(times)):
        mujoco.mj_step(model, data, nstep=each)
        qs[k, order], vs[k, order] = data.qpos, data.qvel
    seconds = time.perf_counter() - begin
    if _warned(mujoco, data) or not np.isfinite(qs).all():
        raise UnableError("the motion diverged")
    return Trajectory(times, qs, vs, seconds, (len(times) - 1) * each * (4 if integrator == "RK4" else 1))


def frequencies(system: System, q: Reals) -> Reals:
    """Frequencies of small vibrations about a state, Hz, rising.

    Its constraints are soft, so that its mass matrix is projected here onto the kernel of its constraint Jacobian.
    """
    mujoco = installed("mujoco")
    model = mujoco.MjModel.from_xml_string(text_of(system, 1e-4))
    data = mujoco.MjData(model)
    data.qpos[:] = q[depth_first(system)]
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    rows = np.asarray(data.efc_J).reshape(-1, model.nv)
    basis = null_space(rows, rcond=SINGULAR_SHARE) if len(rows) else np.eye(model.nv)
    eigenvalues = eigh(basis.T @ np.diag(model.jnt_stiffness) @ basis, basis.T @ mass @ basis, eigvals_only=True)
    found: Reals = np.sqrt(np.maximum(eigenvalues, 0.0)) / (2.0 * np.pi)
    return found


def _silent(_: str) -> None:
    pass


def _warned(mujoco: Any, data: Any) -> bool:
    """Whether MuJoCo met numbers that are not finite and reset the state, which only its data show."""
    kinds = mujoco.mjtWarning
    wrong = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
    return any(data.warning[int(kind)].number for kind in wrong)


def text_of(system: System, step: float, integrator: str = "RK4") -> str:
    """The system in MJCF; all frames of bodies are the world's in the reference state, so points are as given."""
    _, stiffnesses, dampings = lines_of(system)
    root = Xml.Element("mujoco")
    Xml.SubElement(root, "compiler", angle="radian")
    option = Xml.SubElement(
        root,
        "option",
        timestep=_text(step),
        integrator=integrator,
        gravity=_text(system.gravity),
        tolerance="0",
        iterations=str(FRICTION_ITERATIONS if any(drive.friction for drive in system.drives) else ITERATIONS),
    )
    Xml.SubElement(option, "flag", contact="disable")
    elements = {GROUND: Xml.SubElement(root, "worldbody")}
    for i, (joint, body) in enumerate(zip(system.joints, system.bodies, strict=True)):
        element = elements[i] = Xml.SubElement(elements[joint.parent], "body", name=f"body{i}")
        least = max(LEAST * body.mass * system.size**2, 1e-14)
        inertia = body.inertia + (least if np.linalg.eigvalsh(body.inertia)[0] < least else 0.0) * np.eye(3)
        parts = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2])
        Xml.SubElement(element, "inertial", pos=_text(body.centre), mass=_text(body.mass), fullinertia=_text(parts))
        friction = (
            {}
            if not system.drives[i].friction
            else {
                "frictionloss": _text(system.drives[i].friction),
                "solreffriction": _text((2 * step, 1.0)),
                "solimpfriction": _text((IMPEDANCE, IMPEDANCE, system.size)),
            }
        )
        Xml.SubElement(
            element,
            "joint",
            friction,
            type="slide" if joint.slides else "hinge",
            axis=_text(joint.axis),
            pos=_text(joint.point),
            stiffness=_text(stiffnesses[i]),
            damping=_text(dampings[i]),
        )
    tendons = Xml.SubElement(root, "tendon")
    for k, strut in enumerate(system.struts):
        spatial = Xml.SubElement(
            tendons,
            "spatial",
            stiffness=_text(strut.stiffness),
            damping=_text(strut.damping),
            springlength=_text(strut.rest),
        )
        for end, on, point in ((0, strut.first, strut.first_point), (1, strut.second, strut.second_point)):
            Xml.SubElement(elements[on], "site", name=f"site{k}{end}", pos=_text(point))
            Xml.SubElement(spatial, "site", site=f"site{k}{end}")
    equality = Xml.SubElement(root, "equality")
    for weld in system.welds:
        ends = {"body1": f"body{weld.second}"} | ({} if weld.first == GROUND else {"body2": f"body{weld.first}"})
        soft = {"solref": _text((2 * step, 1.0)), "solimp": _text((IMPEDANCE, IMPEDANCE, system.size))}
        for point in common_points(system, weld):
            Xml.SubElement(equality, "connect", ends | soft, anchor=_text(point))
    return Xml.tostring(root, encoding="unicode")


def _text(values: Any) -> str:
    return " ".join(repr(float(x)) for x in np.atleast_1d(values))
