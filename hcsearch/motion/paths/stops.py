"""Where hinges come to their stops: fold angles 0 and pi."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from hcsearch.basics.arrays import Reals
from hcsearch.motion.paths.predictors import PathStep
from hcsearch.motion.paths.walking import Walker

STOP_TOLERANCE = 1e-9
"""A hinge is at its stop when it is nearer than this (rad)."""


def stop_margins(angles: Reals) -> Reals:
    """How far each hinge is from the nearer of its stops (rad), negative beyond."""
    distances: Reals = np.minimum(angles, math.pi - angles)
    return distances


def first_stop(walker: Walker, before: PathStep | None, last: PathStep, after: PathStep) -> PathStep | None:
    """The state at which the first hinge reaches its stop, between a state and one that lies beyond stops.

    None where states between cannot be closed.
    """
    beyond = stop_margins(after.angles) < -STOP_TOLERANCE
    if stop_margins(last.angles)[beyond].min() <= STOP_TOLERANCE:
        return last

    def margin(distance: float) -> float:
        if not distance:
            return float(stop_margins(last.angles)[beyond].min())
        advance = walker.advance(before, last, distance)
        return math.nan if advance is None else float(stop_margins(advance.step.angles)[beyond].min())

    try:
        at = brentq(margin, 0.0, after.length - last.length, xtol=1e-14, rtol=1e-14)
    except ValueError:
        return None
    advance = walker.advance(before, last, at)
    return None if advance is None else advance.step
