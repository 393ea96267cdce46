"""How stiff position control must be: springs that push along a curved closure drive hinges off their course.

Along a closed motion q + t v + t^2 w / 2, J w = -b(v, v) with b the bend of closure, the forces g that closure bears,
g = J^T m, give g w = -m b(v, v). With the slopes K of the springs the motion is statically stable where
v (K - m b) v is positive for all closed rates v; control with the stiffness k of all driven hinges adds k |v_D|^2.
Near the packed state closure bends most, and hardly anything else holds the springs back. Forces of inertia are in g,
their own slopes are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiling import CompiledScene
from hcsearch.springs.deployment.drives import Drives
from hcsearch.springs.drive.choosing import frames_at
from hcsearch.springs.drive.torques import Torques

MAX_CONTROL_YIELD = 0.05
"""What control yields under the greatest torque of the motion, at most (rad)."""
STABILITY_SAFETY_FACTOR = 3.0
"""Stiffness of control over that at which the motion is stable but for inertia."""
STABILITY_STATE_COUNT = 100
"""States along the motion at which stability is looked at."""
DEFAULT_CONTROL_PERIOD = 0.002
"""Of the controller, s."""


@dataclass(frozen=True)
class Stability:
    """What control must be stiffer than (N m/rad) for a statically stable motion, and when that is most (s)."""

    stiffness: float
    time: float


def static_stability(compiled: CompiledScene, torques: Torques) -> Stability:
    """The stiffness of all driven hinges that makes a motion statically stable, without the slopes of gravity."""
    some = np.unique(np.linspace(0, len(torques.times) - 1, STABILITY_STATE_COUNT).astype(int))
    linkage, driven = compiled.linkage, list(torques.driven)
    angles = torques.angles[some]
    frames, values = frames_at(linkage, angles)
    rank = values.shape[1]
    needed = np.zeros(len(some))
    for row, state in enumerate(angles):
        basis = frames[row, :, rank:]
        left = torques.asked[some[row]].copy()
        left[driven] -= torques.torques[some[row]]
        bent = basis.T @ (_slopes(compiled, state)[:, None] * basis) + _bent(linkage, state, left, basis)
        _, sizes, turned = np.linalg.svd(basis[driven])
        held = turned / np.maximum(sizes, 1e-9)[:, None]  # in these directions control has the stiffness 1
        needed[row] = max(0.0, -float(np.linalg.eigvalsh(held @ bent @ held.T)[0]))
    worst = int(needed.argmax())
    return Stability(float(needed[worst]), float(torques.times[some[worst]]))


def position_control(compiled: CompiledScene, torques: Torques, period: float = DEFAULT_CONTROL_PERIOD) -> Drives:
    """Position control for a motion: stiff enough for its torques and its stability, with critical damping.

    The damping is for what each driven hinge moves.
    """
    driven = list(torques.driven)
    most = float(np.abs(torques.torques).max(initial=0.0))
    stiffness = np.full(
        len(driven),
        max(most / MAX_CONTROL_YIELD, STABILITY_SAFETY_FACTOR * static_stability(compiled, torques).stiffness, 1e-9),
    )
    return Drives(
        hinges=torques.driven,
        start=torques.angles[0],
        times=torques.times,
        angles=torques.angles[:, driven],
        torques=torques.torques,
        stiffness=stiffness,
        damping=2.0 * np.sqrt(stiffness * torques.inertias),
        period=period,
    )


def _slopes(compiled: CompiledScene, angles: Reals) -> Reals:
    """Slopes of the springs at fold angles, (n_hinges,), N m/rad."""
    slopes = np.zeros(len(angles))
    for k, angle in enumerate(angles):
        law = compiled.system.drives[compiled.joint_of[k]].law
        branch = law.bent if law.bent is not None and angle > law.snap_up else law.straight
        slopes[k] = (branch.moment(angle + 1e-5) - branch.moment(angle - 1e-5)) / 2e-5
    return slopes


def _bent(linkage: Linkage, angles: Reals, forces: Reals, basis: Reals) -> Reals:
    """-m b in a basis (n_hinges, f) of closed rates, shape (f, f), for forces that closure bears."""
    _, jacobian = linkage.closure(angles)
    borne = np.linalg.lstsq(jacobian.T, forces, rcond=1e-10)[0]
    count = basis.shape[1]
    bent = np.zeros((count, count))
    for i in range(count):
        for j in range(i + 1):
            total, difference = basis[:, i] + basis[:, j], basis[:, i] - basis[:, j]
            both = linkage.bend(jacobian, total) - linkage.bend(jacobian, difference)
            bent[i, j] = bent[j, i] = -0.25 * float(borne @ both)
    return bent
