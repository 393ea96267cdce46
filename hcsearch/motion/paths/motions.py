"""Motions as paths of closed states: states, outcome, singular events, and hinges at their stops."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.motion.kinematics.local import LocalState
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
    velocity : unit velocity of the fold angles at the end; of a descent None.
    energies : of a descent, the energy of each state (J for springs in Nm/rad).
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
    """Concatenate two paths, of which the second begins where the first ends. Energies are left out."""
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
