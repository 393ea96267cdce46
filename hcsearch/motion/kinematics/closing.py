"""Closing of loops: the nearest closed state to fold angles that nearly close them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage

CLOSED_LOOP_RESIDUAL = 1e-12
"""A state is closed when no residual (rad, or gap over the pattern's size) is greater."""


@dataclass(frozen=True, eq=False)
class ClosingResult(ByValue):
    """Result of `close_linkage`: fold angles, their greatest residual, number of steps, and whether they are closed."""

    angles: Reals
    residual: float
    steps: int
    closed: bool


def correction(jacobian: Reals, residual: Reals) -> Reals:
    """The shortest change of the fold angles that cancels a residual to first order.

    The step is damped by the residual itself (Levenberg and Marquardt): it stays short at singular states and tends to
    Newton's near closed ones. Redundant loops do no harm.
    """
    u, s, vt = np.linalg.svd(jacobian, full_matrices=False)
    damping = float(residual @ residual)
    weight = s / (s * s + damping + np.finfo(float).tiny)
    weight[s < 1e-13 * max(s[0], 1.0)] = 0.0
    step: Reals = -(vt.T @ (weight * (u.T @ residual)))
    return step


def close_linkage(
    linkage: Linkage, angles: Reals, *, tolerance: float = CLOSED_LOOP_RESIDUAL, max_steps: int = 30
) -> ClosingResult:
    """Close the loops with a small change of the fold angles (Gauss-Newton)."""
    angles = np.array(angles, float)
    residual, jacobian = linkage.closure(angles)
    for step in range(max_steps + 1):
        worst = float(np.abs(residual).max(initial=0.0))
        if worst <= tolerance or step == max_steps:
            break
        angles += correction(jacobian, residual)
        residual, jacobian = linkage.closure(angles)
    return ClosingResult(angles, worst, step, worst <= tolerance)
