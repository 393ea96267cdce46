"""Singular states between the states of a path: detection, location, and classification to second order."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from hcsearch.motion.kinematics.local import LocalState, local_at, same_orientation
from hcsearch.motion.paths.motions import SingularEvent
from hcsearch.motion.paths.quadrics import LOCATED_STATE_RESIDUAL, second_order_forms, solve_quadrics
from hcsearch.motion.paths.stepping import PathStep, Walker

CROSSED_VALUE_SHARE, TOUCHED_VALUE_SHARE = 0.2, 1e-2
"""At a located singular state, singular values below this share of the least at the states around it are zeros. The
first share holds where orientations differ, so that a zero exists and only rounding can hide it; the second where they
agree, and a zero has to be shown."""
DIP_VALUE_SHARE = 1e-3
"""A local minimum of the least singular value is reported where it is below this share of the greatest value."""
MIN_EVENT_STEP = 0.002
"""Steps are halved down to this length (rad) in search of singular states."""
LOOKAHEAD_STEPS = 1.2
"""A step is halved if a singular value, extrapolated linearly, vanishes within this many times the step."""


def singular_states(walker: Walker, before: PathStep | None, last: PathStep, after: PathStep) -> list[SingularEvent]:
    """Find the singular states between two states of a path.

    Where orientations differ their number is odd. Where they agree there may be none or two, so a step on which some
    singular value tends to zero from either end is searched by bisection.
    """
    if last.local.kept_rank != after.local.kept_rank or not last.local.kept_rank:
        return []
    length = after.length - last.length
    differ = not same_orientation(last.local, after.local)
    falls_ahead = bool((last.local.values + LOOKAHEAD_STEPS * length * last.slopes).min() < 0.0)
    falls_behind = bool((after.local.values - LOOKAHEAD_STEPS * length * after.slopes).min() < 0.0)
    if not (differ or falls_ahead or falls_behind):
        return []
    middle = walker.advance(before, last, 0.5 * length) if length > MIN_EVENT_STEP else None
    if middle is not None:
        return [*singular_states(walker, before, last, middle.step), *singular_states(walker, last, middle.step, after)]
    if differ:
        return [_crossing(walker, last, after)]
    event = _turning(walker, last, after) if falls_ahead and falls_behind else None
    return [] if event is None else [event]


def _crossing(walker: Walker, last: PathStep, after: PathStep) -> SingularEvent:
    """Locate the singular state between two near states of different orientation, by interpolation.

    Closed states near the singular one are inaccurate, by rounding over the least singular value; these two are not.
    """
    from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415 - loads slowly
    from scipy.optimize import brentq  # noqa: PLC0415 - as above

    least_before, least_after = last.local.least_singular_value, after.local.least_singular_value
    length = after.length - last.length
    # the least singular value goes through zero: beyond, it counts as negative
    value = CubicHermiteSpline([0.0, length], [least_before, -least_after], [last.slopes[-1], -after.slopes[-1]])
    distance = float(brentq(value, 0.0, length, xtol=1e-15))
    angles = CubicHermiteSpline([0.0, length], [last.angles, after.angles], [last.tangent, after.tangent])(distance)
    zero = CROSSED_VALUE_SHARE * max(least_before, least_after)
    return _event(walker.state_at(angles), last.length + distance, after.local.kept_rank, zero)


def _turning(walker: Walker, last: PathStep, after: PathStep) -> SingularEvent | None:
    """Locate the local minimum of the least singular value between two states; None if it is not near zero."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 - loads slowly

    least_at_ends = min(last.local.least_singular_value, after.local.least_singular_value)

    def least(distance: float) -> float:
        advance = walker.advance(None, last, distance)
        return least_at_ends if advance is None else advance.step.local.least_singular_value

    minimum = minimize_scalar(
        least, bounds=(0.0, after.length - last.length), method="bounded", options={"xatol": 1e-9}
    )
    if minimum.fun > min(0.5 * least_at_ends, DIP_VALUE_SHARE * float(last.local.rank.singular_values[0])):
        return None
    advance = walker.advance(None, last, float(minimum.x))
    if advance is None:
        return None
    zero = TOUCHED_VALUE_SHARE * max(last.local.least_singular_value, after.local.least_singular_value)
    return _event(advance.step.local, advance.step.length, after.local.kept_rank, zero)


def _event(local: LocalState, length: float, generic_rank: int, zero_below: float) -> SingularEvent:
    """Classify a singular state by the motions that its second-order equations allow.

    generic_rank : number of non-zero singular values around it. zero_below : values up to this count as zero at it.
    """
    values = local.rank.singular_values
    kept_rank = min(generic_rank, int(np.count_nonzero(values > zero_below)))
    kind: Literal["bifurcation", "shaky", "dip"] = "dip"
    if kept_rank < generic_rank:
        singular = local_at(local.linkage, local.angles, kept_rank=kept_rank)
        solutions, _ = solve_quadrics(
            second_order_forms(singular, singular.null_space()), solved=LOCATED_STATE_RESIDUAL
        )
        kind = "bifurcation" if len(solutions) > 1 else "shaky"
    least_value = float(values[kept_rank - 1]) if kept_rank else math.inf
    return SingularEvent(kind, local.angles, length, least_value, len(local.angles) - kept_rank)
