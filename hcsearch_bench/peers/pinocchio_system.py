"""Any system in Pinocchio: its constrained dynamics with a proximal term, integrated by SciPy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.body_trees import GROUND
from hcsearch_bench.peers.states import Trajectory, common_points, depth_first, installed, integrated, lines_of

if TYPE_CHECKING:
    from hcsearch.springs.dynamics.system import System


PROXIMAL, ITERATIONS = 1e-6, 10
"""Proximal term as a share of the inverse of the mean mass, and steps that take its error away.

Without it redundant rows make the accelerations wrong as soon as rounding opens the loops."""
BAUMGARTE = 30.0
"""1/s: gaps die out with this rate, by which Pinocchio does not project."""


class _Forces:
    """Accelerations of a system in Pinocchio."""

    def __init__(self, pin: Any, system: System) -> None:
        self.pin, self.system = pin, system
        self.constants, self.stiffnesses, self.dampings = lines_of(system)
        self.model = model = pin.Model()
        model.gravity.linear = np.array(system.gravity)
        self.numbers = numbers = [0] * system.n_joints
        for i in depth_first(system):  # in another order its recursions are silently wrong
            joint, body = system.joints[i], system.bodies[i]
            kind = pin.JointModelPrismaticUnaligned if joint.slides else pin.JointModelRevoluteUnaligned
            parent, placed = self._place(joint.parent, joint.point)
            numbers[i] = model.addJoint(parent, kind(np.array(joint.axis, float)), placed, f"joint{i}")
            inertia = pin.Inertia(body.mass, body.centre - joint.point, np.array(body.inertia, float))
            model.appendBodyToJoint(numbers[i], inertia, pin.SE3.Identity())
        self.order = np.array([model.joints[number].idx_v for number in numbers])
        self.data = model.createData()
        self.constraints = pin.StdVec_RigidConstraintModel()
        for weld in system.welds:
            for point in common_points(system, weld):
                constraint = pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D,
                    model,
                    *self._place(weld.first, point),
                    *self._place(weld.second, point),
                    pin.ReferenceFrame.LOCAL,
                )
                _damp(constraint)
                self.constraints.append(constraint)
        self.contacts = pin.StdVec_RigidConstraintData()
        for constraint in self.constraints:
            self.contacts.append(constraint.createData())
        _prepare(pin, model, self.data, self.constraints, self.contacts)
        mass = float(np.mean([body.mass for body in system.bodies]))
        self.settings = pin.ProximalSettings(1e-14, PROXIMAL / mass, ITERATIONS)
        self.evaluations = 0

    def _place(self, body: int, point: Reals) -> tuple[int, Any]:
        number = 0 if body == GROUND else self.numbers[body]
        origin = np.zeros(3) if body == GROUND else self.system.joints[body].point
        return number, self.pin.SE3(np.eye(3), point - origin)

    def accelerations(self, q: Reals, v: Reals) -> Reals:
        """Of coordinates and velocities in the order of Pinocchio."""
        self.evaluations += 1
        torques = np.empty(len(q))
        own = self.order
        torques[own] = -(self.constants + self.stiffnesses * q[own] + self.dampings * v[own])
        if self.system.struts:
            torques += self._struts(q, v)
        if len(self.constraints):
            rates: Reals = self.pin.constraintDynamics(
                self.model, self.data, q, v, torques, self.constraints, self.contacts, self.settings
            )
        else:
            rates = self.pin.aba(self.model, self.data, q, v, torques)
        return np.array(rates)

    def _struts(self, q: Reals, v: Reals) -> Reals:
        pin, torques = self.pin, np.zeros(len(q))
        pin.computeJointJacobians(self.model, self.data, q)
        for strut in self.system.struts:
            way, slope = np.zeros(3), np.zeros((3, len(q)))
            for sign, body, point in ((-1, strut.first, strut.first_point), (1, strut.second, strut.second_point)):
                if body == GROUND:
                    way += sign * np.asarray(point)
                    continue
                number, own = self._place(body, point)
                placed = self.data.oMi[number]
                here = placed.act(own.translation)
                jacobian = pin.getJointJacobian(self.model, self.data, number, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
                way += sign * here
                slope += sign * (jacobian[:3] - pin.skew(here - placed.translation) @ jacobian[3:])
            length = float(np.linalg.norm(way))
            by_joint = way @ slope / length
            torques -= (strut.stiffness * (length - strut.rest) + strut.damping * (by_joint @ v)) * by_joint
        return torques


def _prepare(pin: Any, model: Any, data: Any, constraints: Any, contacts: Any) -> None:
    try:
        pin.initConstraintDynamics(model, data, constraints, contacts)
    except TypeError:  # Pinocchio 3
        pin.initConstraintDynamics(model, data, constraints)


def _damp(constraint: Any) -> None:
    """Let gaps die out, critically damped."""
    kp, kd = BAUMGARTE**2, 2 * BAUMGARTE
    if hasattr(constraint, "corrector"):  # Pinocchio 3
        constraint.corrector.Kp[:], constraint.corrector.Kd[:] = kp, kd
    else:
        parameters = constraint.m_baumgarte_parameters
        parameters.Kp, parameters.Kd = kp, kd


def run(
    system: System, q: Reals, v: Reals, times: Reals, *, tolerance: float = 1e-6, method: str = "DOP853"
) -> Trajectory:
    """Follow a system to the times; `method` of SciPy's solve_ivp."""
    forces = _Forces(installed("pinocchio"), system)
    return integrated(forces, forces.order, q, v, times, tolerance, method)
