"""The basic problems A01 to A05 of the IFToMM multibody benchmark as systems of joints, bodies and welds.

Source: M. Gonzalez, D. Dopico, U. Lugris and J. Cuadrado, "A benchmarking system for MBS simulation software",
Multibody System Dynamics 16 (2006) 179-190, https://doi.org/10.1007/s11044-006-9020-8; the library of problems of
the IFToMM technical committee for multibody dynamics. What these leave open is said with each problem.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.scenes.laws import linear_law
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, joined_body
from hcsearch.springs.dynamics.system import JointDrive, Strut, System
from hcsearch_bench.iftomm import references

GRAVITY = 9.81
X, Y, Z = np.eye(3)
PLANAR_PIN = (3, 4)


@dataclass(frozen=True)
class Problem:
    """A system and how it starts, at coordinates 0 with speeds v, until a time (s).

    body, point : the point whose way is measured, in the reference state (m). length : that errors are seen against, m.
    reference : where that point is, (k, 3), at times (k,) from 0 on, from equations of its own.
    """

    name: str
    title: str
    system: System
    v: Reals
    end: float
    body: int
    point: Reals
    reference: references.Solution
    length: float = 1.0

    @property
    def q(self) -> Reals:
        """Coordinates at the start."""
        return np.zeros(self.system.n_joints)


def problems() -> list[Problem]:
    """All of them; A02 with 2 and with 40 loops, A04 with rods of both sections."""
    return [pendulum(), four_bars(2), four_bars(40), squeezer(), bricard(0.0), bricard(0.1), governor()]


def rod(start: Reals, end: Reals, mass: float, section: float = 0.0) -> Body:
    """A uniform rod with a square section of a side (m)."""
    way = np.asarray(end, float) - start
    length = float(np.linalg.norm(way))
    axis = way / length
    along, across = mass * section**2 / 6, mass * (length**2 + section**2) / 12
    return Body(mass, (start + end) / 2, across * np.eye(3) + (along - across) * np.outer(axis, axis))


def point_mass(mass: float, point: Reals) -> Body:
    """A body without extent."""
    return Body(mass, point, np.zeros((3, 3)))


def pendulum() -> Problem:
    """A01: 1 kg on a massless bar of 1 m, from rest beside its pivot."""
    mass = np.array([-1.0, 0.0, 0.0])
    system = System(
        (TreeJoint(GROUND, Z, np.zeros(3)),), (point_mass(1.0, mass),), (JointDrive(),), gravity=(0.0, -GRAVITY, 0.0)
    )
    return Problem("A01", "pendulum", system, np.zeros(1), 10.0, 0, mass, references.pendulum)


def four_bars(loops: int) -> Problem:
    """A02: N loops of 2 N + 1 uniform rods of 1 m and 1 kg, upright, at 1 m/s; singular whenever all rods lie flat."""
    joints: list[TreeJoint] = []
    bodies: list[Body] = []
    welds: list[Weld] = []
    speeds: list[float] = []
    for k in range(loops + 1):
        foot, top, next_top = (np.array([x, y, 0.0]) for x, y in ((k, 0), (k, 1), (k + 1, 1)))
        upright = len(joints)
        joints.append(TreeJoint(GROUND, Z, foot))
        bodies.append(rod(foot, top, 1.0))
        speeds.append(-1.0)
        if k:
            welds.append(Weld(upright, upright - 1, top, PLANAR_PIN))
        if k < loops:
            joints.append(TreeJoint(upright, Z, top))
            bodies.append(rod(top, next_top, 1.0))
            speeds.append(1.0)
    drives = tuple(JointDrive() for _ in joints)
    system = System(tuple(joints), tuple(bodies), drives, tuple(welds), gravity=(0.0, -GRAVITY, 0.0))
    title = f"{loops} four-bars"
    return Problem(
        f"A02 N={loops}", title, system, np.array(speeds), 20.0, 0, Y, lambda times: references.four_bars(loops, times)
    )


def squeezer() -> Problem:
    """A03: Andrews' squeezing mechanism, driven by a constant torque; data of the IVP test set."""
    data, start = references.SQUEEZER, dict(zip(references.ANGLES, references.SQUEEZER_START, strict=True))

    def at(x: float, y: float, angle: float, origin: Reals) -> Reals:
        c, s = math.cos(angle), math.sin(angle)
        place: Reals = origin + np.array([c * x - s * y, s * x + c * y, 0.0])
        return place

    def body(number: int, centre: Reals) -> Body:
        return Body(data[f"m{number}"], centre, np.diag([1.0, 1.0, 1.0]) * data[f"i{number}"])

    a, b, c = (np.array([data["x" + name], data["y" + name], 0.0]) for name in "abc")
    beta, gamma, delta, epsilon = (start[name] for name in ("beta", "gamma", "delta", "epsilon"))
    theta, phi, omega = beta + start["theta"], delta + start["phi"], epsilon + start["omega"]
    crank = at(data["rr"], 0.0, beta, np.zeros(3))
    pin = at(-data["d"], 0.0, theta, crank)
    arm, other_arm = at(data["zt"], 0.0, delta, a), at(0.0, -data["u"], epsilon, a)
    joints = (
        TreeJoint(GROUND, Z, np.zeros(3)),
        TreeJoint(0, Z, crank),
        TreeJoint(GROUND, Z, b),
        TreeJoint(GROUND, Z, a),
        TreeJoint(3, Z, arm),
        TreeJoint(GROUND, Z, a),
        TreeJoint(5, Z, other_arm),
    )
    bodies = (
        body(1, at(data["ra"], 0.0, beta, np.zeros(3))),
        body(2, at(-data["da"], 0.0, theta, crank)),
        body(3, at(data["sa"], data["sb"], gamma, b)),  # of the centres of bodies 3, 5 and 7 only the distance counts
        body(5, at(data["ta"], data["tb"], delta, a)),
        body(4, at(0.0, -(data["e"] - data["ea"]), phi, arm)),
        body(7, at(data["ua"], data["ub"], epsilon, a)),
        body(6, at(data["zf"] - data["fa"], 0.0, omega, other_arm)),
    )
    welds = tuple(Weld(1, other, pin, PLANAR_PIN) for other in (2, 4, 6))
    drives = (JointDrive(linear_law(0.0, -data["mom"])), *(JointDrive() for _ in range(6)))
    spring = Strut(GROUND, 2, c, at(data["sd"], -data["sc"], gamma, b), data["c0"], 0.0, data["l0"])
    system = System(joints, bodies, drives, welds, (spring,), size=data["rr"])
    return Problem(
        "A03", "Andrews' squeezer", system, np.zeros(7), 0.05, 0, crank, references.squeezer, length=data["rr"]
    )


def bricard(section: float) -> Problem:
    """A04: five uniform rods of 1 m and 1 kg and the ground in one loop of six hinges; closed by 5 rows of rank 4.

    Whether the official rods are thin or have a section of 0.1 m by 0.1 m is not known.
    """
    corners = [np.array(point, float) for point in references.BRICARD_CORNERS]
    joints = tuple(TreeJoint(k - 1, np.eye(3)[axis], corners[k]) for k, axis in enumerate(references.BRICARD_AXES[:5]))
    bodies = tuple(rod(corners[k], corners[k + 1], 1.0, section) for k in range(5))
    weld = Weld(GROUND, 4, corners[5], (0, 1, 3, 4, 5), np.array([Y, Z, X]))
    system = System(joints, bodies, tuple(JointDrive() for _ in joints), (weld,), gravity=(0.0, -GRAVITY, 0.0))
    return Problem(
        "A04 square" if section else "A04 thin",
        "Bricard's mechanism",
        system,
        np.zeros(5),
        10.0,
        1,
        corners[2],
        lambda times: references.bricard(section, times),
    )


def governor() -> Problem:
    """A05: flyball governor, its slider on stiff springs with dampers; from 2 pi rad/s.

    The speed is the one that gives the published curve; where the rods start, the springs have no force.
    """
    data = references.GOVERNOR
    section, reach = data.section, np.array([math.cos(data.alpha), 0.0, -math.sin(data.alpha)])
    shaft = TreeJoint(GROUND, Z, np.zeros(3))
    height = data.slide * Z
    cube = data.density * data.cube**3
    joints, struts = [shaft, TreeJoint(0, Z, height, slides=True)], []
    bodies = [
        rod(np.zeros(3), Z, data.rod, section),
        Body(cube, height, cube * data.cube**2 / 6 * np.eye(3)),
    ]
    for side in (1.0, -1.0):
        mirror = np.array([side, 1.0, 1.0])
        pivot = Z + side * data.pivot * X
        end = pivot + mirror * reach
        joints.append(TreeJoint(0, Y, pivot))
        bodies.append(joined_body([rod(pivot, end, data.rod, section), point_mass(data.ball, end)]))
        middle, hold = (pivot + end) / 2, height + side * data.cube / 2 * X
        struts.append(Strut(len(joints) - 1, 1, middle, hold, data.stiffness, data.damping, data.rest))
    system = System(
        tuple(joints),
        tuple(bodies),
        tuple(JointDrive() for _ in joints),
        struts=tuple(struts),
        gravity=(0.0, 0.0, -GRAVITY),
    )
    return Problem(
        "A05",
        "flyball governor",
        system,
        np.array([data.spin, 0.0, 0.0, 0.0]),
        10.0,
        1,
        height,
        references.governor,
    )
