"""From fold angles that nearly close the loops to the nearest ones that do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.shape.linkage import Linkage

CLOSED_LOOP_RESIDUAL = 1e-12
"""A state is closed when no residual (rad, or gap over the pattern's size) is greater."""


@dataclass(frozen=True, eq=False)
class ClosingResult(ByValue):
    """Outcome of closing: fold angles, greatest residual that is left, steps taken, and whether that is closed."""

    angles: Reals
    residual: float
    steps: int
    success: bool


def correction(jacobian: Reals, residual: Reals) -> Reals:
    """Shortest change of the fold angles that takes a residual away, to first order.

    Damped by the residual itself (Levenberg and Marquardt), so that it stays short at singular states and is Newton's
    where they are near; redundant loops do no harm.
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
    """Close the loops, moving the fold angles as little as needed (Gauss-Newton)."""
    angles = np.array(angles, float)
    residual, jacobian = linkage.closure(angles)
    for step in range(max_steps + 1):
        worst = float(np.abs(residual).max(initial=0.0))
        if worst <= tolerance or step == max_steps:
            break
        angles += correction(jacobian, residual)
        residual, jacobian = linkage.closure(angles)
    return ClosingResult(angles, worst, step, worst <= tolerance)
