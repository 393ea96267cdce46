"""Switch states: closed states at which a path changes which of its hinges are at a stop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.planning.closing import STOPPED_HINGE_ANGLE, Closing, Loops, largest_closure_residual
from hcsearch.kernels.planning.tubes import POLISHED_RESIDUAL

MAX_SWITCH_STEPS = 30
"""Newton steps to a switch state."""
REDUNDANT_CLOSURE_SHARE = 1e-8
"""Singular directions of closure up to this share of the greatest count as none."""
MAX_SWITCH_DISTANCE_RATIO = 2.0
"""A switch state is no further from either state than this many times what these are apart."""


def switch_between(loops: Loops, one: Reals, two: Reals, work: Closing) -> Reals | None:
    """The closed state between two, (m,) each, with all hinges at their stops that are there in either state.

    Hinges that leave their stops together, some at first order and some at second, do so in such a state: on a straight
    way from a state before it to one after it, some would have to leave too soon. None where both states have the same
    hinges at stops, or where there is no such state near by.
    """
    stopped = _stopped(one), _stopped(two)
    held = stopped[0] | stopped[1]
    if (stopped[0] == stopped[1]).all():
        return None
    switch = (
        two.copy() if (held == stopped[0]).all() else one.copy() if (held == stopped[1]).all() else 0.5 * (one + two)
    )
    ends = np.where(stopped[0], one, two)[held]
    switch[held] = np.where(ends > 0.5 * math.pi, math.pi, 0.0)
    for _ in range(MAX_SWITCH_STEPS):
        if largest_closure_residual(loops, switch, work) < POLISHED_RESIDUAL:
            break
        switch[~held] -= np.linalg.lstsq(work.jacobian[:, ~held], work.residual, rcond=REDUNDANT_CLOSURE_SHARE)[0]
    away = np.linalg.norm(switch - one), np.linalg.norm(switch - two)
    near = min(away) > STOPPED_HINGE_ANGLE and max(away) <= MAX_SWITCH_DISTANCE_RATIO * np.linalg.norm(two - one)
    within = switch.min() >= 0.0 and switch.max() <= math.pi
    return switch if near and within and largest_closure_residual(loops, switch, work) < POLISHED_RESIDUAL else None


def _stopped(state: Reals) -> NDArray[np.bool_]:
    """Which hinges are at a stop."""
    return (state < STOPPED_HINGE_ANGLE) | (state > math.pi - STOPPED_HINGE_ANGLE)
