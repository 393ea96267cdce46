"""Motions as paths of closed states: states, outcome, hinges at their stops, and singular states on the way.

Singular states are located between the states of a path, and classified to second order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.motion.kinematics.local import LocalState, local_at, same_orientation
from hcsearch.motion.paths.quadrics import LOCATED_STATE_RESIDUAL, second_order_forms, solve_quadrics
from hcsearch.motion.paths.stepping import PathStep, Walker

PathOutcome = Literal[
    "flat",
    "folded",
    "length",
    "stopped",
    "branch",
    "singular",
    "stuck",
    "rigid",
    "undecided",
    "lost closure",
    "out of budget",
]


def accumulated_turn(angles: Reals) -> Reals:
    """Return the accumulated turn of all hinges up to each state, (k,), in rad; angles : (k, n_hinges)."""
    steps = np.abs(np.diff(angles, axis=0)).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])[: len(angles)]


@dataclass(frozen=True, eq=False)
class SingularEvent(ByValue):
    """A singular state on a path.

    kind : `bifurcation` where singular values vanish and the second-order equations allow several continuations,
        `shaky` where they allow only this one, `dip` at a local minimum of the least singular value near zero.
    angles, length : fold angles (rad), and arc length from the start (rad).
    least_singular_value : least singular value that counts as non-zero.
    nullity : number of hinges minus number of non-zero singular values.
    """

    kind: Literal["bifurcation", "shaky", "dip"]
    angles: Reals
    length: float
    least_singular_value: float
    nullity: int


@dataclass(frozen=True, eq=False)
class MotionPath(ByValue):
    """A motion as a list of closed states, and its outcome.

    angles : fold angles (rad), shape (n_states, n_hinges); the first is the start.
    lengths : arc length in the space of fold angles (rad) up to each state.
    residuals : greatest closure residual of each state (rad, or gap over the pattern's size).
    nullities : first-order degrees of freedom at each state (-1 where undecided).
    least_singular_values : least non-zero singular value of the closure Jacobian at each state (infinite in an open
        chain).
    outcome, sentence : how it ended, in a word and in a sentence.
    rejected, evaluations : numbers of rejected steps, and of evaluations of closure and Jacobian.
    stopped_hinges : hinges whose stops ended the motion.
    events : singular states between the ends.
    velocity : unit velocity of the fold angles at the end; None for a descent.
    energies : the energy of each state of a descent (J for springs in Nm/rad).
    """

    angles: Reals
    lengths: Reals
    residuals: Reals
    nullities: WholeNumbers
    least_singular_values: Reals
    outcome: PathOutcome
    sentence: str
    rejected: int
    evaluations: int
    stopped_hinges: tuple[int, ...] = ()
    events: tuple[SingularEvent, ...] = ()
    velocity: Reals | None = None
    energies: Reals | None = None

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.angles) - 1

    @property
    def end(self) -> Reals:
        """Fold angles of the last state."""
        last: Reals = self.angles[-1]
        return last

    @property
    def success(self) -> bool:
        """Whether the motion reached the flat or the folded state, or the given length."""
        return self.outcome in {"flat", "folded", "length"}


@dataclass(frozen=True)
class PathEnding:
    """The reason why a motion ends."""

    outcome: PathOutcome
    sentence: str
    stopped_hinges: tuple[int, ...] = ()


def motion_path_of(
    states: Sequence[LocalState],
    lengths: Sequence[float],
    ending: PathEnding,
    *,
    rejected: int,
    evaluations: int,
    events: Sequence[SingularEvent] = (),
    velocity: Reals | None = None,
    energies: Sequence[float] | None = None,
) -> MotionPath:
    """Assemble a path from its states."""
    return MotionPath(
        np.array([state.angles for state in states]),
        np.array(lengths),
        np.array([state.residual for state in states]),
        np.array([state.nullity for state in states]),
        np.array([state.least_singular_value for state in states]),
        ending.outcome,
        ending.sentence,
        rejected,
        evaluations,
        ending.stopped_hinges,
        tuple(events),
        velocity,
        None if energies is None else np.array(energies),
    )


_OF_STATES = ("angles", "residuals", "nullities", "least_singular_values")


def reversed_path(path: MotionPath, outcome: PathOutcome) -> MotionPath:
    """The path in reverse order; the outcome names its first state. Energies are left out."""
    states: dict[str, Any] = {name: getattr(path, name)[::-1].copy() for name in _OF_STATES}
    return replace(
        path,
        **states,
        lengths=path.lengths[-1] - path.lengths[::-1],
        outcome=outcome,
        sentence=f"{outcome} after {path.steps} steps, found from there",
        events=(),
        velocity=None,
        energies=None,
    )


def joined_paths(first: MotionPath, second: MotionPath) -> MotionPath:
    """Concatenate two paths; the second begins where the first ends. Energies are left out."""
    states: dict[str, Any] = {
        name: np.concatenate([getattr(first, name)[:-1], getattr(second, name)]) for name in _OF_STATES
    }
    return replace(
        second,
        **states,
        lengths=np.concatenate([first.lengths[:-1], first.lengths[-1] + second.lengths]),
        sentence=f"{second.outcome} after {first.steps + second.steps} steps",
        rejected=first.rejected + second.rejected,
        evaluations=first.evaluations + second.evaluations,
        events=(),
        energies=None,
    )


STOP_TOLERANCE = 1e-9
"""A hinge is at its stop when it is nearer than this (rad)."""


def stop_margins(angles: Reals) -> Reals:
    """The distance of each hinge from the nearer of its stops (rad), negative beyond it."""
    distances: Reals = np.minimum(angles, math.pi - angles)
    return distances


def first_stop(walker: Walker, before: PathStep | None, last: PathStep, after: PathStep) -> PathStep | None:
    """Locate the state at which the first hinge reaches its stop, between a state and one beyond stops.

    None where states in between cannot be closed.
    """
    beyond = stop_margins(after.angles) < -STOP_TOLERANCE
    if stop_margins(last.angles)[beyond].min() <= STOP_TOLERANCE:
        return last

    from scipy.optimize import brentq  # noqa: PLC0415 - loads slowly

    def margin(distance: float) -> float:
        if not distance:
            return float(stop_margins(last.angles)[beyond].min())
        advance = walker.advance(before, last, distance)
        return math.nan if advance is None else float(stop_margins(advance.step.angles)[beyond].min())

    try:
        distance_to_stop = brentq(margin, 0.0, after.length - last.length, xtol=1e-14, rtol=1e-14)
    except ValueError:
        return None
    advance = walker.advance(before, last, distance_to_stop)
    return None if advance is None else advance.step


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
