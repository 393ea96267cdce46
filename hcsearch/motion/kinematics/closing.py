"""Closing of loops: the nearest closed state to fold angles that nearly close them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.kernels.linkage.closing_steps import damped_step
from hcsearch.shape.linkage import Linkage

CLOSED_LOOP_RESIDUAL = 1e-12
"""A state is closed when no residual (rad, or gap over the pattern's size) is greater."""
MIN_DAMPING_SHARE = 1e-9
"""Damping of a correction, at least, over the greatest entry of the Jacobian: far above rounding errors, so that
singular values that are zero but for rounding turn hinges by 1e-6 rad or so at most, and below the singular values of
regular states, which may be 1e-8."""


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
    Newton's near closed ones. Redundant loops do no harm. Its bits are the same on all processors, see `damped_step`.
    """
    least = MIN_DAMPING_SHARE * max(float(np.abs(jacobian).max(initial=0.0)), 1.0)
    damping = max(math.hypot(*residual), least)
    step: Reals = damped_step(np.ascontiguousarray(jacobian), residual, damping)
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
