"""Singular states between the states of a path: detected, located, and distinguished to second order."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from hcsearch.motion.kinematics.local import LocalState, local_at, same_orientation
from hcsearch.motion.paths.motions import SingularEvent
from hcsearch.motion.paths.quadrics import LOCATED_STATE_RESIDUAL, second_order_forms, solve_quadrics
from hcsearch.motion.paths.stepping import PathStep, Walker

CROSSED_VALUE_SHARE, TOUCHED_VALUE_SHARE = 0.2, 1e-2
"""At a located singular state, singular values below this share of the least at the states around it are zeros: where
orientations differ one is, and rounding alone can hide it; where they agree it has to be shown."""
DIP_VALUE_SHARE = 1e-3
"""A least singular value that turns back is reported where it comes below this share of the greatest."""
MIN_EVENT_STEP = 0.002
"""Steps are looked into down to this length (rad)."""
LOOKAHEAD_STEPS = 1.2
"""A singular value that would come to zero within this many times the step, as it changes now, is looked into."""


def singular_states(walker: Walker, before: PathStep | None, last: PathStep, after: PathStep) -> list[SingularEvent]:
    """The singular states between two states of a path.

    Where orientations differ there is one, or three. Where they agree there may be none or two, so a step on which
    some singular value heads for zero, seen from either end, is looked into by halves.
    """
    if last.local.kept != after.local.kept or not last.local.kept:
        return []
    length = after.length - last.length
    differ = not same_orientation(last.local, after.local)
    heading = bool((last.local.values + LOOKAHEAD_STEPS * length * last.slopes).min() < 0.0)
    coming = bool((after.local.values - LOOKAHEAD_STEPS * length * after.slopes).min() < 0.0)
    if not (differ or heading or coming):
        return []
    middle = walker.advance(before, last, 0.5 * length) if length > MIN_EVENT_STEP else None
    if middle is not None:
        return [
            *singular_states(walker, before, last, middle.step),
            *singular_states(walker, last, middle.step, after),
        ]
    if differ:
        return [_crossing(walker, last, after)]
    event = _turning(walker, last, after) if heading and coming else None
    return [] if event is None else [event]


def _crossing(walker: Walker, last: PathStep, after: PathStep) -> SingularEvent:
    """The singular state between two near states of different orientation, by interpolation.

    Beside it the states themselves are blurred, by rounding over the least singular value; these two are not.
    """
    one, two = last.local.least, after.local.least
    length = after.length - last.length
    # the least singular value goes through zero: beyond, it counts as negative
    value = CubicHermiteSpline([0.0, length], [one, -two], [last.slopes[-1], -after.slopes[-1]])
    at = float(brentq(value, 0.0, length, xtol=1e-15))
    angles = CubicHermiteSpline([0.0, length], [last.angles, after.angles], [last.tangent, after.tangent])(at)
    return _event(walker.local(angles), last.length + at, after.local.kept, CROSSED_VALUE_SHARE * max(one, two))


def _turning(walker: Walker, last: PathStep, after: PathStep) -> SingularEvent | None:
    """The state between two at which the least singular value turns back, if it comes near to zero there."""
    lower = min(last.local.least, after.local.least)

    def least(distance: float) -> float:
        advance = walker.advance(None, last, distance)
        return lower if advance is None else advance.step.local.least

    turn = minimize_scalar(least, bounds=(0.0, after.length - last.length), method="bounded", options={"xatol": 1e-9})
    if turn.fun > min(0.5 * lower, DIP_VALUE_SHARE * float(last.local.rank.singular_values[0])):
        return None
    advance = walker.advance(None, last, float(turn.x))
    if advance is None:
        return None
    zero = TOUCHED_VALUE_SHARE * max(last.local.least, after.local.least)
    return _event(advance.step.local, advance.step.length, after.local.kept, zero)


def _event(local: LocalState, length: float, usual: int, zero: float) -> SingularEvent:
    """A singular state, with the motions that its second-order equations allow.

    usual : number of singular values that count around it; zero : what counts as zero at the state.
    """
    values = local.rank.singular_values
    kept = min(usual, int(np.count_nonzero(values > zero)))
    kind: Literal["bifurcation", "shaky", "dip"] = "dip"
    if kept < usual:
        singular = local_at(local.linkage, local.angles, kept=kept)
        ways, _ = solve_quadrics(second_order_forms(singular, singular.null_space()), solved=LOCATED_STATE_RESIDUAL)
        kind = "bifurcation" if len(ways) > 1 else "shaky"
    least = float(values[kept - 1]) if kept else math.inf
    return SingularEvent(kind, local.angles, length, least, len(local.angles) - kept)
