"""Springs of single hinges: which get the same, and other ones without compiling the scene anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from hcsearch.deployment.compiling import Compiled, held_panel
from hcsearch.deployment.naming import laws_of
from hcsearch.dynamics.laws import law_named, linear
from hcsearch.dynamics.mirror import mirror_of
from hcsearch.errors import HcsearchError
from hcsearch.linkage import Linkage
from hcsearch.scenes import Scene
from hcsearch.typing import Reals


def range_of(scene: Scene) -> tuple[float, float]:
    """Softest and stiffest spring that is tried or tuned in a settled scene, N m/rad."""
    assert scene.spring_range is not None
    return scene.spring_range


def tied_hinges(linkage: Linkage, scene: Scene) -> tuple[tuple[int, ...], ...]:
    """Hinges that get the same spring, so that the deployment can be symmetric (thesis 4.5.4): mirror images.

    By the mirror that maps the held panel onto itself; without one every hinge stands alone. In the order of the first.
    """
    mirror = mirror_of(linkage, held_panel(linkage, scene))
    images = range(linkage.n_hinges) if mirror is None else mirror.hinges
    return tuple(sorted({tuple(sorted({hinge, image})) for hinge, image in enumerate(images)}))


def scene_springs(scene: Scene, stiffnesses: Sequence[float] | Reals) -> Scene:
    """The scene with a linear spring at every hinge, N m/rad in their order; 0 is none, and with it no damper."""
    laws = (linear(float(stiffness)).text for stiffness in stiffnesses)
    return replace(scene, springs=tuple(enumerate(laws)))


def stiffnesses_of(linkage: Linkage, scene: Scene) -> Reals:
    """Stiffness of each hinge of a scene, N m/rad; HcsearchError where a law is not linear, or has a preload."""
    return np.array([_stiffness(text) for text in laws_of(linkage, scene)])


def _stiffness(text: str) -> float:
    law = law_named(text)
    constant, slope, *rest = law.straight.cubics[0]
    if law.bent is not None or len(law.straight.cubics) > 1 or constant or any(rest):
        raise HcsearchError(f"springs that are tuned are linear, without a preload: write linear:0.1, not {text}")
    return slope


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


@cache
def spring_sets(n_joints: int, count: int, softest: float, stiffest: float) -> Reals:
    """Stiffnesses (N m/rad) spread evenly over the logarithms between two bounds, shape (count, n_joints).

    A scrambled Sobol sequence (scipy.stats.qmc), always the same: one array for all who ask, read-only.
    """
    from scipy.stats import qmc  # noqa: PLC0415 - takes longer to load than many deployments to compute

    points = qmc.Sobol(n_joints, seed=1).random(count)
    stiffness: Reals = softest * (stiffest / softest) ** points
    stiffness.flags.writeable = False
    return stiffness
