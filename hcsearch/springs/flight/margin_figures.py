"""The least torque margins of a travel as figures, each with how it is known.

Along a proved path a figure is a lower bound at all closed states beside it, and along a simulated deployment at those
beside its course between the steps. Gaps have no bound: at singular states, all along a motion of loops that close for
more than their number of equations tells, and where so many hinges are at stops that the others do not close the loops.
There margins of states are taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.motion.kinematics.closing import close_linkage
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.springs.flight.certified_margins import (
    CertifiedMargin,
    certified_margin,
    gap_times,
    steepest_slopes,
    wander_of,
)
from hcsearch.springs.flight.law_torques import law_torques
from hcsearch.springs.flight.path_margins import PathMargins
from hcsearch.springs.flight.torque_margin import allowed_senses, closed_rates, torque_margins, torque_margins_failed
from hcsearch.springs.flight.travel import Travel, states_at

MIN_PROVED_SHARE = 0.99
"""Share of the turn of a path in which margins must be bounded for a figure that counts as proved."""
FigureKind = Literal["proved", "sampled", "simulated"]
"""How a figure is known: for all states beside a proved path; at some states of a path; or along a simulated motion."""


@dataclass(frozen=True)
class MarginFigure:
    """The least torque margin of a travel.

    value : never above the margin at a closed state beside the motion, but for gaps; None where it is not known,
    infinite where nothing resists. least : the least one that was computed at a state, no less than the least of all.
    hinge : of this state the hinge that limits the margin, or whose spring failed; -1 without one. at : its place in
    the travel, 0 packed, 1 flat; time : of the course, where it is between the states of the travel. unbounded : share
    of the turn of all hinges without a bound.
    """

    value: float | None
    least: float
    kind: FigureKind
    hinge: int
    at: float
    time: float | None = None
    unbounded: float = 0.0

    @property
    def is_bounded(self) -> bool:
        """Whether the margin is bounded in nearly all of the motion."""
        return self.unbounded <= 1.0 - MIN_PROVED_SHARE


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
    """Return the figures of a motion by its bounds, and by states in gaps and where those between states are least."""
    weakest = np.array([found.weakest, found.weakest_failed])
    some = course.times[len(course.times) // 2]  # one at least
    times = np.r_[some, weakest[np.isfinite(weakest)], gap_times(course, found.gaps)]
    states = np.array([close_linkage(travel.linkage, state).angles for state in states_at(course, times)])
    rates = closed_rates(np.array([travel.linkage.closure(state)[1] for state in states]))
    program = rates, law_torques(travel.setup.laws, states), friction, allowed_senses(states)
    whole = torque_margins(*program)
    failed = torque_margins_failed(*program, whole)
    turns = accumulated_turn(course.angles)
    shares = np.interp(times, course.times, turns) / turns[-1]
    is_bounded = found.certified >= MIN_PROVED_SHARE
    kind: FigureKind = "simulated" if travel.source == "deployment" else "proved" if is_bounded else "sampled"
    figures = []
    for before, bound, margins, known, hinges in (
        (sampled.whole, found.bound, whole.margins, whole.known, whole.hinges),
        (sampled.failed, found.failed, failed.margins, failed.known, failed.hinges),
    ):
        state = int(margins.argmin())
        least, hinge, at, time = before.least, before.hinge, before.at, None
        if margins[state] < least:
            least, hinge, at = float(margins[state]), int(hinges[state]), float(shares[state])
            time = float(times[state])
        is_known = before.value is not None and bool(known[state])
        value = min(bound, least) if is_bounded else least
        figures.append(MarginFigure(value if is_known else None, least, kind, hinge, at, time, 1.0 - found.certified))
    return MarginFigures(*figures)
