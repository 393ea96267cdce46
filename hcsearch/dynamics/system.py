"""A system of bodies, joints, laws, stops and struts, as the compiled kernels read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hcsearch.dynamics.bodies import Body
from hcsearch.dynamics.laws import FREE, Law, tables_of
from hcsearch.dynamics.trees import GROUND, Joint, Weld, tree_of
from hcsearch.kernels.multibody.hinges import Hinges, Struts
from hcsearch.kernels.multibody.motion import Mechanism

Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Strut:
    """A spring with a damper between points of two bodies (m, in the reference state); the ground is -1.

    stiffness : N/m. damping : Ns/m. rest : length without force, m.
    """

    first: int
    second: int
    first_point: Reals
    second_point: Reals
    stiffness: float
    damping: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True)
class Drive:
    """What acts in one joint: a moment-angle law (N m by rad; a sliding joint: N by m), damping, and stops.

    damping : N m s/rad. lower, upper : rad, infinite where there is no stop.
    """

    law: Law = FREE
    damping: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf


@dataclass(frozen=True)
class System:
    """Bodies that hang on joints, the welds that close their loops, and what acts on them.

    gravity : m/s^2. size : length that gaps of welds are divided by, m.
    stop_stiffness, stop_damping : of compliant stops (N m/rad, N m s/rad); 0 for hard ones.
    """

    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    drives: tuple[Drive, ...]
    welds: tuple[Weld, ...] = ()
    struts: tuple[Strut, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: float = 1.0
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @cached_property
    def mechanism(self) -> Mechanism:
        """The tables that the kernels read."""
        tree = tree_of(self.joints, self.bodies, self.welds, gravity=self.gravity, size=self.size)
        pieces, breaks, cubics, energies = tables_of([drive.law for drive in self.drives])
        hinges = Hinges(
            pieces=pieces,
            breaks=breaks,
            cubics=cubics,
            energies=energies,
            snaps_up=np.array([drive.law.snap_up for drive in self.drives]),
            snaps_down=np.array([drive.law.snap_down for drive in self.drives]),
            damping=np.array([drive.damping for drive in self.drives]),
            lower=np.array([drive.lower for drive in self.drives]),
            upper=np.array([drive.upper for drive in self.drives]),
            stop_stiffness=float(self.stop_stiffness),
            stop_damping=float(self.stop_damping),
        )
        return Mechanism(tree, hinges, self._struts())

    def _struts(self) -> Struts:
        def arm(body: int, point: Reals) -> Reals:
            return point if body == GROUND else point - self.joints[body].point

        points = [
            [*arm(strut.first, strut.first_point), *arm(strut.second, strut.second_point)] for strut in self.struts
        ]
        return Struts(
            bodies=np.array([(strut.first, strut.second) for strut in self.struts], np.int64).reshape(-1, 2),
            points=np.array(points, float).reshape(-1, 6),
            stiffness=np.array([strut.stiffness for strut in self.struts], float),
            damping=np.array([strut.damping for strut in self.struts], float),
            rests=np.array([strut.rest for strut in self.struts], float),
        )
