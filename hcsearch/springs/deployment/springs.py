"""Springs of single hinges: which get the same, and other ones without compiling the scene anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes.laws import Law, linear_law
from hcsearch.scenes.setup import Setup
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiling import CompiledScene
from hcsearch.springs.dynamics.mirror import mirror_of


def tied_hinges(linkage: Linkage, held: int) -> tuple[tuple[int, ...], ...]:
    """Hinges that get the same spring, so that the deployment can be symmetric (thesis 4.5.4): mirror images.

    By the mirror that maps the held panel onto itself; without one every hinge stands alone. In the order of the first.
    """
    mirror = mirror_of(linkage, held)
    images = range(linkage.n_hinges) if mirror is None else mirror.hinges
    return tuple(sorted({tuple(sorted({hinge, image})) for hinge, image in enumerate(images)}))


def stiffnesses_of(setup: Setup) -> Reals:
    """Return the stiffness of each hinge, N m/rad; HcsearchError where a law is not linear, or has a preload."""
    return np.array([_stiffness(law) for law in setup.laws])


def _stiffness(law: Law) -> float:
    constant, slope, *rest = law.straight.cubics[0]
    if law.bent is not None or len(law.straight.cubics) > 1 or constant or any(rest):
        raise HcsearchError(f"springs that are tuned are linear, without a preload: write linear:0.1, not {law.text}")
    return slope


def with_springs(compiled: CompiledScene, stiffnesses: Reals) -> CompiledScene:
    """The scene with linear springs of some stiffnesses (N m/rad), shape (n_joints,), one for all hinges of a joint.

    Damping stays proportional (thesis 4.4). The scene must have been compiled with its stops kept.
    """
    setup = compiled.setup
    drives = list(compiled.system.drives)
    laws = []
    for joint in compiled.joint_of.tolist():
        law = linear_law(float(stiffnesses[joint]))
        share = float(compiled.shares[joint])
        own = law if share == 1.0 else linear_law(share * float(stiffnesses[joint]))
        drives[joint] = replace(drives[joint], law=own, damping=share * setup.damping_of(law))
        laws.append(law)
    return replace(compiled, setup=replace(setup, laws=tuple(laws)), system=compiled.system.driven(tuple(drives)))
