"""The least torque margins of a travel as figures, each with how it is known.

Along a proved path a figure is a lower bound at all closed states beside it, and along a simulated deployment at those
beside its course between the steps. Gaps have no bound: at singular states, all along a motion of loops that close for
more than their number of equations tells, and where so many hinges are at stops that the others do not close the loops.
In gaps the margins of single states are taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.springs.flight.certified_margins import (
    CertifiedMargin,
    certified_margin,
    steepest_slopes,
    wander_of,
)
from hcsearch.springs.flight.path_margins import PathMargins
from hcsearch.springs.flight.torque_margin import allowed_senses, closed_rates, torque_margins, torque_margins_failed
from hcsearch.springs.flight.travel import Travel, states_at

GAP_STATES, NEAREST_GAP_SHARE = 12, 0.01
"""Number of states that are tried in gaps at both ends of a motion, in geometric progression, and the nearest one."""
COURSE_STATES, CLOSER_ROUNDS, CLOSER_STATES = 1000, 3, 16
"""Number of states at equal times, tried where they lie in gaps; then, for a motion without bounds, number of rounds,
and of states in each that are tried beside the least one."""
FigureKind = Literal["proved", "sampled", "simulated"]
"""How a figure is known: for all states beside a proved path; at some states of a path; or along a simulated motion."""


@dataclass(frozen=True)
class MarginFigure:
    """The least torque margin of a travel.

    value : never above the margin at a closed state beside the motion, but for gaps; None where it is not known,
    infinite where nothing resists. least : the least one that was computed at a state, no less than the least of all.
    hinge : the hinge that limits the margin at this state, or whose spring failed; -1 without one. at : place of the
    state in the travel, 0 packed, 1 flat; time : its time on the course, if it is between the states of the travel.
    unbounded : share of the turn of all hinges without a bound.
    """

    value: float | None
    least: float
    kind: FigureKind
    hinge: int
    at: float
    time: float | None = None
    unbounded: float = 0.0


class MarginFigures(NamedTuple):
    """The least margins of a travel with all springs, and with the worst one failed."""

    whole: MarginFigure
    failed: MarginFigure


def margin_figures(travel: Travel, friction: Reals, margins: PathMargins) -> MarginFigures:
    """Return the least margins of a travel with a motion; margins : at its states with this friction, (n_hinges,)."""
    state, failed = margins.least_state, margins.least_failed_state
    sampled = MarginFigures(
        _at_states(travel, margins.margins, margins.known, state, int(margins.hinges[state])),
        _at_states(travel, margins.failed, margins.failed_known, failed, int(margins.failed_hinges[failed])),
    )
    if not 0.0 < sampled.whole.least < math.inf:
        return sampled
    laws = travel.setup.laws
    try:
        course, slack = travel.course
        slopes = steepest_slopes(laws)
    except HcsearchError:  # springs snap, or the path is proved no more
        return sampled
    wander = wander_of(travel.linkage, float(np.max(slack, initial=0.0)))
    enough = sampled.whole.least, sampled.failed.least
    springs = (lambda angles: law_torques(laws, angles)), slopes, friction
    found = certified_margin(travel.linkage, course, wander, *springs, enough)
    return _bounded(travel, course, friction, sampled, found)


def _at_states(travel: Travel, margins: Reals, known: Flags, state: int, hinge: int) -> MarginFigure:
    """Return the figure of the least margin at the states of a travel."""
    least = float(margins[state])
    kind: FigureKind = "simulated" if travel.source == "deployment" else "proved" if least == 0.0 else "sampled"
    return MarginFigure(least if known[state] else None, least, kind, hinge, float(travel.shares[state]))


def _bounded(
    travel: Travel, course: Course, friction: Reals, sampled: MarginFigures, found: CertifiedMargin
) -> MarginFigures:
    """Return the figures of a motion by its bounds and states in gaps, or else by states beside the least one."""
    tried = _tried(travel, course, friction, _gap_times(course, found), doubtful=True)
    if not found.is_bounded:
        for _ in range(CLOSER_ROUNDS):
            tried = tried.with_more(_tried(travel, course, friction, tried.times_beside_least(), doubtful=False))
    turns = accumulated_turn(course.angles)
    kind: FigureKind = "simulated" if travel.source == "deployment" else "proved" if found.is_bounded else "sampled"
    figures = []
    for which, (before, bound) in enumerate(zip(sampled, (found.bound, found.failed), strict=True)):
        state = int(tried.margins[which].argmin())
        least, hinge, at, time = before.least, before.hinge, before.at, None
        if tried.margins[which, state] < least:
            least, hinge = float(tried.margins[which, state]), int(tried.hinges[which, state])
            time = float(tried.times[state])
            at = float(np.interp(time, course.times, turns) / turns[-1])
        is_known = before.value is not None and bool(tried.known[which, state])
        value = min(bound, least) if found.is_bounded else least
        figures.append(MarginFigure(value if is_known else None, least, kind, hinge, at, time, 1.0 - found.certified))
    return MarginFigures(*figures)


class _Tried(NamedTuple):
    """Margins at k more states: their times, and with all springs and with one failed, (2, k).

    margins : lower bounds where one is not known, or infinite where it is left out. hinges : as in `PathMargins`.
    """

    times: Reals
    margins: Reals
    known: Flags
    hinges: WholeNumbers

    def with_more(self, more: _Tried) -> _Tried:
        """Return these margins and more."""
        return _Tried(*(np.concatenate(both, axis=-1) for both in zip(self, more, strict=True)))

    def times_beside_least(self) -> Reals:
        """Return times between the least margins and the margins next to them."""
        times = np.unique(self.times)
        least = np.searchsorted(times, self.times[self.margins.argmin(axis=1)])
        before, after = times[np.maximum(least - 1, 0)], times[np.minimum(least + 1, len(times) - 1)]
        beside: Reals = np.linspace(before, after, CLOSER_STATES + 2)[1:-1].ravel()
        return beside


def _gap_times(course: Course, found: CertifiedMargin) -> Reals:
    """Return times at which margins are computed: the weakest so far, and in gaps, more at both ends of the motion.

    Both ends are left out: they are states of the travel, whose margins are known.
    """
    first, last = course.times[0], course.times[-1]
    shares, every = np.geomspace(NEAREST_GAP_SHARE, 1.0, GAP_STATES), np.linspace(first, last, COURSE_STATES + 2)[1:-1]
    times = [np.array([found.weakest, found.weakest_failed, 0.5 * (first + last)])]  # one that is finite at least
    for start, end in found.gaps:
        times += [every[(every > start) & (every < end)], np.linspace(start, end, 3)[1:-1]]
        times += [start + (end - start) * shares] if start == first else []
        times += [end - (end - start) * shares] if end == last else []
    tried = np.concatenate(times)
    inner: Reals = tried[(tried > first) & (tried < last)]
    return inner


def _tried(travel: Travel, course: Course, friction: Reals, times: Reals, *, doubtful: bool) -> _Tried:
    """Return the margins at the closed states next to a course at some times; doubtful : keeps unknown margins."""
    states = np.array([close_linkage(travel.linkage, state).angles for state in states_at(course, times)])
    rates = closed_rates(np.array([travel.linkage.closure(state)[1] for state in states]))
    program = rates, law_torques(travel.setup.laws, states), friction, allowed_senses(states)
    whole = torque_margins(*program)
    failed = torque_margins_failed(*program, whole)
    known = np.array([whole.known, failed.known])
    margins = np.where(known | doubtful, np.array([whole.margins, failed.margins]), np.inf)
    return _Tried(times, margins, known, np.array([whole.hinges, failed.hinges]))
