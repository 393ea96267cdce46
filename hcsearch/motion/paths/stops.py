"""Where hinges come to their stops: fold angles 0 and pi."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from hcsearch.basics.arrays import Reals
from hcsearch.motion.paths.predictors import Step
from hcsearch.motion.paths.walking import Walker

SLACK = 1e-9
"""A hinge is at its stop when it is nearer than this (rad)."""


def margins(angles: Reals) -> Reals:
    """How far each hinge is from the nearer of its stops (rad), negative beyond."""
    distances: Reals = np.minimum(angles, math.pi - angles)
    return distances


def first_stop(walker: Walker, before: Step | None, last: Step, after: Step) -> Step | None:
    """The state at which the first hinge reaches its stop, between a state and one that lies beyond stops.

    None where states between cannot be closed.
    """
    beyond = margins(after.angles) < -SLACK
    if margins(last.angles)[beyond].min() <= SLACK:
        return last

    def margin(distance: float) -> float:
        if not distance:
            return float(margins(last.angles)[beyond].min())
        advance = walker.advance(before, last, distance)
        return math.nan if advance is None else float(margins(advance.step.angles)[beyond].min())

    try:
        at = brentq(margin, 0.0, after.length - last.length, xtol=1e-14, rtol=1e-14)
    except ValueError:
        return None
    advance = walker.advance(before, last, at)
    return None if advance is None else advance.step
