"""Springs of single hinges, changed without compiling the scene anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hcsearch.deployment.compiling import Compiled
from hcsearch.dynamics.laws import linear

Reals = NDArray[np.float64]

SOFTEST, STIFFEST = 0.001, 0.2
"""Bounds of the stiffness of a spring, N m/rad (thesis 4.5.4)."""


def with_springs(compiled: Compiled, stiffnesses: Reals) -> Compiled:
    """The scene with linear springs of some stiffnesses (N m/rad), shape (n_joints,), one for all hinges of a joint.

    Damping stays proportional (thesis 4.4). The scene must have been compiled with its stops kept.
    """
    scene = compiled.scene
    drives = list(compiled.system.drives)
    springs = {}
    for hinge, joint in enumerate(compiled.joint_of.tolist()):
        law = linear(float(stiffnesses[joint]))
        share = float(compiled.shares[joint])
        damping = scene.damping_time * law.mean_stiffness if scene.damping is None else scene.damping
        own = law if share == 1.0 else linear(share * float(stiffnesses[joint]))
        drives[joint] = replace(drives[joint], law=own, damping=share * damping)
        springs[hinge] = law.text
    scene = replace(scene, springs=tuple(springs.items()))
    return replace(compiled, scene=scene, system=compiled.system.driven(tuple(drives)))


def spring_sets(n_joints: int, count: int, seed: int = 0) -> Reals:
    """Stiffnesses (N m/rad) spread evenly over the logarithms between the bounds, shape (count, n_joints)."""
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many deployments to compute

    points = qmc.Sobol(n_joints, seed=seed).random(count)
    found: Reals = SOFTEST * (STIFFEST / SOFTEST) ** points
    return found
