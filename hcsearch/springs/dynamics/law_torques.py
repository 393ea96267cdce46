"""Torques of springs along a path, from their laws, and of friction that holds a system at rest.

Tape springs snap on the way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.multibody import sticking as kernel
from hcsearch.kernels.multibody.accelerations import discrete_state_for, largest_pivot
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.scenes.laws import Law, LawBranch
from hcsearch.springs.dynamics.system import System


def law_torques(laws: Sequence[Law], angles: Reals) -> Reals:
    """Return the torques with which springs open hinges at states of a path, (k, n_hinges), N m.

    laws : of the hinges. angles : fold angles, (k, n_hinges), rad, in the order of the motion: a law that snaps stays
    on a branch until it leaves it.
    """
    torques = np.empty(angles.shape)
    for hinge, law in enumerate(laws):
        own = angles[:, hinge]
        torques[:, hinge] = branch_moments(law.straight, own)
        if law.bent is not None:
            bent = _is_bent(law, own)
            torques[bent, hinge] = branch_moments(law.bent, own[bent])
    return torques


def branch_moments(branch: LawBranch, angles: Reals) -> Reals:
    """Return the moments of a branch at fold angles, (k,), N m, as `LawBranch.moment` does at each."""
    pieces = np.maximum(np.searchsorted(branch.breaks, angles, side="right") - 1, 0)
    x = angles - np.array(branch.breaks)[pieces]
    a, b, c, d = np.array(branch.cubics)[pieces].T
    moments: Reals = a + x * (b + x * (c + x * d))
    return moments


def _is_bent(law: Law, angles: Reals) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return at which states of a path a law is on its bent branch, (k,)."""
    bent, flags = False, np.zeros(len(angles), bool)
    for k, angle in enumerate(angles):
        bent = angle >= law.snap_down if bent else angle > law.snap_up
        flags[k] = bent
    return flags


def holding_friction(system: System, q: Reals) -> Reals:
    """Return the torques of friction in joints at rest at a closed state, (n_joints,), N m.

    Joints that slide have their greatest torque, and joints that stick the one that holds them; redundant joints have
    what a slight compliance in proportion to their mobility would give. Torques of stops are left out. All 0 for a
    system without friction.
    """
    mechanism, n = system.mechanism, system.n_joints
    friction = mechanism.hinges.friction
    if not len(friction):
        return np.zeros(n)
    work, coordinates = work_for(mechanism.tree), np.array(q, float)
    resting = kernel.RestingJoints(np.empty(n, np.int8), np.empty(n, np.int8), np.empty(n))
    hold, scale = discrete_state_for(mechanism, coordinates), largest_pivot(mechanism, coordinates, work)
    kernel.decide_resting_joints(mechanism, hold, 0.0, coordinates, np.zeros(n), scale, work, resting)
    torques: Reals = np.clip(resting.forces, -friction, friction)
    pushed = (resting.held * resting.forces < 0.0) & (np.abs(resting.held) == 1)
    return np.where(pushed, 0.0, torques)
