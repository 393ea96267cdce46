"""Vibration of the flat array on its latches: rigid panels, and springs at the hinges.

The rates that close the loops of the flat state to first order include those of all true motions, so that the first
frequency is a lower bound within the model of rigid panels (docs/explanation/flight.md). A preload presses each hinge
on its own stop: the torques at every hinge are in balance, loops carry nothing, and no stiffness comes of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.motion.kinematics.local import local_at
from hcsearch.scenes.laws import Law
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.body_trees import Body
from hcsearch.springs.flight.mass_matrix import mass_matrix

SOFT_SHARE = 1e-10
"""Squares of frequencies below this share of the greatest are those of soft modes; rounding is 1e-14."""


@dataclass(frozen=True, eq=False)
class DeployedModes(ByValue):
    """Modes of the flat array.

    frequencies : (k,), Hz, rising, of the modes that are not soft. shapes : (n_hinges, k), rates of the hinges in each
    mode, scaled to a greatest of 1. soft_modes : number of directions in which nothing is stiff.
    """

    frequencies: Reals
    shapes: Reals
    soft_modes: int

    @property
    def first(self) -> float | None:
        """The first frequency above the soft modes, Hz; None where there is none."""
        return float(self.frequencies[0]) if len(self.frequencies) else None


def hinge_stiffness(laws: Sequence[Law], latch_stiffness: Reals) -> Reals:
    """Return the stiffness of each hinge when flat, (n_hinges,), N m/rad: of its latch, else the slope of its law."""
    slopes = np.array([max(0.0, _slope_when_flat(law)) for law in laws])
    return np.where(latch_stiffness > 0.0, latch_stiffness, slopes)


def _slope_when_flat(law: Law) -> float:
    k = max((k for k, start in enumerate(law.straight.breaks) if start <= 0.0), default=0)
    _, b, c, d = law.straight.cubics[k]
    x = -law.straight.breaks[k]
    return b + x * (2.0 * c + 3.0 * d * x)


def deployed_modes(
    linkage: Linkage, stiffness: Reals, density: float, root: int | None, base: Body | None = None
) -> DeployedModes:
    """Return the modes of a flat array.

    stiffness : (n_hinges,), N m/rad. density, root, base : as of `mass_matrix`. HcsearchError for a negative stiffness.
    """
    if stiffness.shape != (linkage.n_hinges,) or not (stiffness >= 0.0).all():
        raise HcsearchError("the stiffness of each hinge is one number of 0 or more: give one for each")
    basis = local_at(linkage, linkage.flat).null_space()
    if not basis.shape[1]:
        return DeployedModes(np.empty(0), np.empty((linkage.n_hinges, 0)), 0)
    masses = basis.T @ mass_matrix(linkage, linkage.flat, density, root, base) @ basis
    stiffnesses = basis.T @ (stiffness[:, None] * basis)
    squares, vectors = eigh(stiffnesses, masses)
    soft = int(np.count_nonzero(squares <= SOFT_SHARE * max(squares[-1], 0.0))) if squares[-1] > 0.0 else len(squares)
    shapes = basis @ vectors[:, soft:]
    return DeployedModes(
        np.sqrt(squares[soft:]) / (2.0 * math.pi), shapes / np.abs(shapes).max(axis=0, initial=1e-300), soft
    )
