"""Any system without struts by dense matrices in plain NumPy, integrated by SciPy: accelerations of another origin.

Nothing is shared with the compiled recursions. The change of the free accelerations that closes the
loops, least by kinetic energy, comes from singular values: redundant rows do no harm (Udwadia and Kalaba 1992).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.springs.dynamics.body_trees import GROUND
from hcsearch.springs.dynamics.system import System
from hcsearch_bench.peers.states import TURNS, Places, Trajectory, integrated, lines_of, places
from hcsearch_bench.run.work_precision import UnableError

CUT = 1e-6
"""Rows count whose singular value is above this share of the largest: those that closure makes redundant are off by
the gap of the loops only, which is the tolerance."""


@dataclass
class Dense:
    """Accelerations of a system; counts how many."""

    system: System
    evaluations: int = 0

    def __post_init__(self) -> None:
        if self.system.struts:
            raise UnableError("struts")
        self.preloads, self.stiffnesses, self.dampings = lines_of(self.system)
        joints, bodies = self.system.joints, self.system.bodies
        n = len(joints)
        self.above = np.eye(n, dtype=bool)  # whether the second joint carries the first body
        for i, joint in enumerate(joints):
            if joint.parent != GROUND:
                self.above[i] |= self.above[joint.parent]
        self.axes = np.array([joint.axis for joint in joints], float)
        self.turning = np.array([not joint.slides for joint in joints])
        self.arms = np.array([body.centre - joint.point for body, joint in zip(bodies, joints, strict=True)])
        self.masses = np.array([body.mass for body in bodies])
        self.inertias = np.array([body.inertia for body in bodies])

    def accelerations(self, q: Reals, v: Reals) -> Reals:
        """Joint accelerations of one state, (n_joints,)."""
        self.evaluations += 1
        placed = places(self.system, q, v)
        turn, spin = placed.turn[0], placed.spin[0]
        centre = placed.place[0] + (arms := np.einsum("ijk,ik->ij", turn, self.arms))
        drift = placed.speed[0] + np.cross(spin, arms)
        turns, moves, own_turns, own_moves = self._columns(placed, v, centre, drift, self.above)
        inertia = turn @ self.inertias @ turn.transpose(0, 2, 1)
        mass = np.einsum("iaj,iab,ibk->jk", turns, inertia, turns)
        mass += np.einsum("i,iaj,iak->jk", self.masses, moves, moves)
        torque = np.einsum("iab,ib->ia", inertia, own_turns)
        torque += np.cross(spin, np.einsum("iab,ib->ia", inertia, spin))
        force = self.masses[:, None] * (np.array(self.system.gravity) - own_moves)
        forces = np.einsum("iaj,ia->j", moves, force) - np.einsum("iaj,ia->j", turns, torque)
        forces -= self.preloads + self.stiffnesses * q + self.dampings * v
        root = np.linalg.cholesky(mass)
        free = np.linalg.solve(root, forces)  # in coordinates where the inertia is the identity
        if self.system.welds:
            rows, wanted = self._rows(placed, v)
            ways = np.linalg.solve(root, rows.T).T
            change, *_ = np.linalg.lstsq(ways, wanted - ways @ free, rcond=CUT)
            free = free + change
        return np.asarray(np.linalg.solve(root.T, free), np.float64)

    def _columns(
        self, placed: Places, v: Reals, points: Reals, speeds: Reals, above: NDArray[np.bool_]
    ) -> tuple[Reals, Reals, Reals, Reals]:
        """Jacobians (k, 3, n) of turns and of points (k, 3) of k bodies, and accelerations (k, 3) at constant v."""
        axes = np.einsum("nij,nj->ni", placed.turn[0], self.axes)
        swings = np.cross(placed.spin[0], axes)
        arms = points[:, None] - placed.place[0]
        arm_rates = speeds[:, None] - placed.speed[0]
        turning = (above & self.turning)[..., None]
        turns = turning * axes
        moves = np.where(turning, np.cross(axes, arms), above[..., None] * axes)
        turn_rates = turning * swings
        move_rates = np.where(turning, np.cross(swings, arms) + np.cross(axes, arm_rates), above[..., None] * swings)
        return (
            turns.transpose(0, 2, 1),
            moves.transpose(0, 2, 1),
            np.einsum("kna,n->ka", turn_rates, v),
            np.einsum("kna,n->ka", move_rates, v),
        )

    def _rows(self, placed: Places, v: Reals) -> tuple[Reals, Reals]:
        """Rows of the welds, (m, n), and what their accelerations must be, (m,)."""
        rows, wanted = [], []
        for weld in self.system.welds:
            spin = np.zeros(3) if weld.first == GROUND else placed.spin[0, weld.first]
            ways = weld.frame @ placed.turned(weld.first)[0].T
            # the first body carries its frame to where the second's point is, however far along free directions
            place, _ = placed.point(weld.second, weld.point)
            one, two = (self._end(placed, v, body, place) for body in (weld.first, weld.second))
            for kind in weld.kinds:
                way = ways[kind % 3]
                k, size = (0, 1.0) if kind in TURNS else (1, self.system.size)
                swing = np.cross(spin, way) * (1.0 if kind in TURNS else 2.0)
                rows.append(way @ (two[k] - one[k]) / size)
                wanted.append(-(way @ (two[k + 2] - one[k + 2]) + swing @ (two[k] - one[k]) @ v) / size)
        return np.array(rows), np.array(wanted)

    def _end(self, placed: Places, v: Reals, body: int, place: Reals) -> tuple[Reals, Reals, Reals, Reals]:
        """As `_columns`, of that point of one body which is at a place (1, 3)."""
        if body == GROUND:
            above, speed = np.zeros((1, len(v)), bool), np.zeros((1, 3))
        else:
            above = self.above[body, None]
            speed = placed.speed[:, body] + np.cross(placed.spin[:, body], place - placed.place[:, body])
        turns, moves, own_turns, own_moves = self._columns(placed, v, place, speed, above)
        return turns[0], moves[0], own_turns[0], own_moves[0]


def run(
    system: System, q: Reals, v: Reals, times: Reals, *, tolerance: float = 1e-6, method: str = "DOP853"
) -> Trajectory:
    """Follow a system to the times; `method` of SciPy's solve_ivp."""
    return integrated(Dense(system), np.arange(len(q)), q, v, times, tolerance, method)
