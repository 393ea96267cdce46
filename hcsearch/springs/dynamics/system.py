"""Systems of bodies, joints, laws, stops and struts, and their tables for the kernels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.multibody.accelerations import Mechanism
from hcsearch.kernels.multibody.drag import Drag
from hcsearch.kernels.multibody.hinges import Hinges, Struts, Targets, no_targets
from hcsearch.kernels.multibody.tree import BODY_INERTIA, BODY_MASS
from hcsearch.kernels.multibody.welds import CutHinges
from hcsearch.scenes.laws import FREE_LAW, Law, tables_of_laws
from hcsearch.springs.dynamics.body_trees import GROUND, Body, TreeJoint, Weld, tree_of


@dataclass(frozen=True, eq=False)
class Strut(ByValue):
    """A spring with a damper between points of two bodies (m, in the reference state); the ground is -1.

    stiffness : N/m. damping : Ns/m. rest : free length, m.
    """

    first: int
    second: int
    first_point: Reals
    second_point: Reals
    stiffness: float
    damping: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class JointDrive:
    """Law, damping, stops and friction of one joint; the law gives N m for rad, or N for m in a sliding joint.

    damping : N m s/rad. lower, upper : rad, infinite where there is no stop. friction : the greatest torque of Coulomb
    friction, sliding or at rest, N m.
    """

    law: Law = FREE_LAW
    damping: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    friction: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.friction < math.inf:
            raise HcsearchError(f"a joint cannot have a friction of {self.friction:g}: give 0 N m or more")


@dataclass(frozen=True, eq=False)
class CutHinge(ByValue):
    """A hinge that is cut open and held together by stiff springs at both ends of its line (thesis 4.2.2).

    first, second : bodies, the first may be the ground. ends : both ends of the line, m; axis : direction about which
        the second turns by the fold angle relative to the first; in the reference state. drive : its law, damping and
        stops.
    """

    first: int
    second: int
    ends: tuple[Reals, Reals]
    axis: Reals
    drive: JointDrive


@dataclass(frozen=True, eq=False)
class FacetDrag(ByValue):
    """A facet of a body on which air acts.

    normal : unit vector; points : (p, 3), of a quadrature, m; both in the reference state. weights : (p,), half of the
    density of the air times the drag coefficient, times shares of the area, kg/m.
    """

    body: int
    normal: Reals
    points: Reals
    weights: Reals


@dataclass(frozen=True, eq=False)
class System(ByValue):
    """A tree of bodies and joints, the welds that close its loops, and the forces on it.

    gravity : m/s^2. size : length by which gaps of welds are divided, m.
    stop_stiffness, stop_damping : of compliant stops (N m/rad, N m s/rad); 0 for hard ones.
    cuts : hinges held together by springs; cut_stiffness, cut_damping : of each spring (N/m, Ns/m).
    closure_stiffness, closure_damping : of springs that close the loops across the welds (N/m, Ns/m; turns are held as
        by springs at the distance `size`); 0 for exact closure.
    overdamped : whether inertia is neglected, so that dampers alone resist: every joint needs one.
    targets : of drives; None without drives. drags : facets on which air acts.
    """

    joints: tuple[TreeJoint, ...]
    bodies: tuple[Body, ...]
    drives: tuple[JointDrive, ...]
    welds: tuple[Weld, ...] = ()
    struts: tuple[Strut, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: float = 1.0
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0
    cuts: tuple[CutHinge, ...] = ()
    cut_stiffness: float = 0.0
    cut_damping: float = 0.0
    closure_stiffness: float = 0.0
    closure_damping: float = 0.0
    overdamped: bool = False
    targets: Targets | None = None
    drags: tuple[FacetDrag, ...] = ()

    def __post_init__(self) -> None:
        springy = self.stop_stiffness or self.closure_stiffness or self.cuts
        if (springy or self.overdamped) and any(drive.friction for drive in self.drives):
            raise HcsearchError(
                "friction holds joints at rest only where loops and stops are rigid and bodies have inertia: take the "
                "constrained formulation, or a scene without friction and harness"
            )
        if self.overdamped and self.drags:
            raise HcsearchError(
                "quasistatic motion has no drag, which grows as the square of speeds: take the constrained "
                "formulation, or a scene without drag"
            )

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def n_equations(self) -> int:
        """Number of closure equations."""
        return sum(len(weld.kinds) for weld in self.welds)

    @cached_property
    def mechanism(self) -> Mechanism:
        """The system as tables for the kernels."""
        tree = tree_of(self.joints, self.bodies, self.welds, gravity=self.gravity, size=self.size)
        loads = np.zeros((0, 3))
        if self.overdamped:
            loads = np.outer(tree.bodies[:, BODY_MASS], tree.gravity)
            tree.bodies[:, BODY_INERTIA:] = 0.0
            tree.gravity[:] = 0.0
        hinges = self._hinges(self.drives)
        area = self.size**2
        closure = (self.closure_stiffness * area, self.closure_damping * area)
        targets = no_targets() if self.targets is None else self.targets
        forces = self._struts(), self._cuts(), loads, *closure
        return Mechanism(tree, hinges, *forces, self.overdamped, targets, self._drag())

    def driven(self, drives: tuple[JointDrive, ...]) -> System:
        """Return the system with other laws, dampers and stops in the joints; the tables of the tree are reused."""
        system = replace(self, drives=drives)
        system.__dict__["mechanism"] = self.mechanism._replace(hinges=self._hinges(drives))
        return system

    def under_control(self, targets: Targets) -> System:
        """Return the system with drives that follow targets; the other tables are reused."""
        system = replace(self, targets=targets)
        system.__dict__["mechanism"] = self.mechanism._replace(targets=targets)
        return system

    def _hinges(self, drives: Sequence[JointDrive]) -> Hinges:
        pieces, breaks, cubics, energies = tables_of_laws([drive.law for drive in drives])
        friction = np.array([drive.friction for drive in drives])
        ramped = any(drive.law.full > 0.0 for drive in drives)
        return Hinges(
            pieces=pieces,
            breaks=breaks,
            cubics=cubics,
            energies=energies,
            snaps_up=np.array([drive.law.snap_up for drive in drives]),
            snaps_down=np.array([drive.law.snap_down for drive in drives]),
            damping=np.array([drive.damping for drive in drives]),
            lower=np.array([drive.lower for drive in drives]),
            upper=np.array([drive.upper for drive in drives]),
            stop_stiffness=float(self.stop_stiffness),
            stop_damping=float(self.stop_damping),
            friction=friction if friction.any() else np.zeros(0),
            ramps=np.array([_ramp(drive.law) for drive in drives]) if ramped else np.zeros((0, 3)),
            factors=np.zeros(len(drives) if ramped else 0),
        )

    def _arm(self, body: int, point: Reals) -> Reals:
        return point if body == GROUND else point - self.joints[body].point

    def _cuts(self) -> CutHinges:
        ends = [(body, *cut.ends) for cut in self.cuts for body in (cut.first, cut.second)]
        points = [[*self._arm(body, start), *self._arm(body, end)] for body, start, end in ends]
        frames = []
        for cut in self.cuts:
            across = np.cross(cut.axis, np.eye(3)[np.abs(cut.axis).argmin()])
            across /= np.linalg.norm(across)
            frames.append([*cut.axis, *across, *np.cross(cut.axis, across)])
        return CutHinges(
            bodies=np.array([(cut.first, cut.second) for cut in self.cuts], np.int64).reshape(-1, 2),
            points=np.array(points, float).reshape(-1, 12),
            frames=np.array(frames, float).reshape(-1, 9),
            hinges=self._hinges([cut.drive for cut in self.cuts]),
            stiffness=float(self.cut_stiffness),
            damping=float(self.cut_damping),
        )

    def _drag(self) -> Drag:
        ends = np.cumsum([0, *(len(facet.points) for facet in self.drags)])
        arms = [np.column_stack([facet.points - self.joints[facet.body].point, facet.weights]) for facet in self.drags]
        return Drag(
            bodies=np.array([facet.body for facet in self.drags], np.int64),
            pieces=np.column_stack([ends[:-1], ends[1:]]).astype(np.int64),
            normals=np.array([facet.normal for facet in self.drags], float).reshape(-1, 3),
            points=np.concatenate([np.zeros((0, 4)), *arms]),
        )

    def _struts(self) -> Struts:
        ends = [((s.first, s.first_point), (s.second, s.second_point)) for s in self.struts]
        points = [[*self._arm(*one), *self._arm(*other)] for one, other in ends]
        return Struts(
            bodies=np.array([(strut.first, strut.second) for strut in self.struts], np.int64).reshape(-1, 2),
            points=np.array(points, float).reshape(-1, 6),
            stiffness=np.array([strut.stiffness for strut in self.struts], float),
            damping=np.array([strut.damping for strut in self.struts], float),
            rests=np.array([strut.rest for strut in self.struts], float),
        )


def _ramp(law: Law) -> tuple[float, float, float]:
    """Return when a law begins to act and acts in full, s, and its rate, 1/s, where it rises from the time 0 on."""
    rises = law.begin <= 0.0 < law.full
    return law.begin, law.full, 1.0 / (law.full - law.begin) if rises else 0.0
