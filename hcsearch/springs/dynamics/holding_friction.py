"""Friction that holds a system at rest: the torques that joints need, within their friction."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.multibody import sticking as kernel
from hcsearch.kernels.multibody.accelerations import discrete_state_for, largest_pivot
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.springs.dynamics.system import System


def holding_friction(system: System, q: Reals) -> Reals:
    """Return the torques of friction in joints at rest at a closed state, (n_joints,), N m.

    The torques that slide, or that hold where joints stick; of redundant joints, those that a slight compliance in
    proportion to their mobility would give. What stops bear is left out. All 0 for a system without friction.
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
