"""Lower bounds of torque margins at all closed states beside a proved path, between its states too.

The best rates at the middle of an interval, corrected, are closed rates at all its states, and their ratio bounds the
margin from below, also with a spring failed (docs/explanation/flight_margins.md, 5). Intervals of the path are halved
until that bound is near the least margin. Near singular states corrections are not bounded: these parts of a path stay
without a bound, as gaps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, Signs, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.linkage.courses import course_polynomials
from hcsearch.motion.collision.panel_prisms import longest_way
from hcsearch.motion.paths.motions import accumulated_turn
from hcsearch.scenes.laws import Law
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.near_closed_rates import NearClosedRates, StateBoxes
from hcsearch.springs.flight.torque_margin import (
    CLOSED_RATE_TOLERANCE,
    MARGIN_ROUNDING,
    ClosedRates,
    allowed_senses,
    closed_rates,
    kernel_margins,
)

CERTIFIED_SHARE = 0.995
"""A bound is good enough from this share of the least margin at the states tried so far."""
MAX_MARGIN_INTERVALS = 40_000
"""Greatest number of intervals that are tried."""
LEAST_TURN = 4.0
"""Turn of a hinge, over the wander, below which an interval is not halved: near singular states most of the time would
go to parts in which the wander decides."""
DEPENDENT_TURN = 0.01
"""Turn of a hinge (rad) below which an interval is not halved if equations of closure depend on each other at its
middle: while hinges are at stops they do so in all of it, and elsewhere it is small."""
MIN_BOUNDED_SHARE = 0.99
"""Share of the turn of all hinges in which margins must be bounded: else no bound is computed."""

LAW_RANGE_EXCESS = 0.01
"""How far beyond the stops slopes of laws are bounded (rad): paths are proved to pass them by less."""


@dataclass(frozen=True)
class CertifiedMargin:
    """Lower bounds of the torque margins on a motion.

    bound : at all closed states beside the path, but for the gaps; 0 where gaps are too large. failed : the same with
    any one spring failed. gaps : starts and ends, in the time of the path, of parts without a bound; the whole motion
    where they are too large. certified : the share of the turn of all hinges without gaps, at most. least, least_failed
    : the least margins at the states that were tried, at the times weakest and weakest_failed; hinges beyond a stop
    count as at it. intervals : number that were tried.
    """

    bound: float
    failed: float
    gaps: tuple[tuple[float, float], ...]
    certified: float
    least: float
    least_failed: float
    weakest: float
    weakest_failed: float
    intervals: int

    @property
    def is_bounded(self) -> bool:
        """Whether margins are bounded in nearly all of the motion."""
        return self.certified >= MIN_BOUNDED_SHARE


@dataclass(eq=False)
class _Least:
    """The least margins at the states tried so far, with all springs and with one failed, and their times.

    enough : as in `certified_margin`.
    """

    enough: tuple[float, float]
    margins: list[float]
    times: list[float]

    @property
    def asked(self) -> Reals:
        """The bounds from which on an interval is no longer halved, (2,)."""
        return np.minimum(CERTIFIED_SHARE * np.array(self.margins), self.enough)

    def take(self, which: int, margins: Reals, times: Reals) -> None:
        """Take margins (k,) at some times."""
        if len(margins) and margins.min() < self.margins[which]:
            self.margins[which], self.times[which] = float(margins.min()), float(times[margins.argmin()])


@dataclass(frozen=True, eq=False)
class _Intervals(ByValue):
    """Intervals of steps of a path: (k,) their steps, and start and end as shares of these."""

    steps: WholeNumbers
    starts: Reals
    ends: Reals

    def parts(self, counts: WholeNumbers) -> _Intervals:
        """Return equal parts of intervals; counts : (k,), how many of each, 0 where it is left out."""
        own = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(own)) - np.repeat(np.cumsum(counts) - counts, counts)
        starts, lengths = self.starts[own], ((self.ends - self.starts) / np.maximum(counts, 1))[own]
        return _Intervals(self.steps[own], starts + number * lengths, starts + (number + 1) * lengths)


def wander_of(linkage: Linkage, slack: float) -> float:
    """Return the greatest deviation of closed states from the motion of a proof, summed over hinges (rad).

    slack : m, as in `PathProof`.
    """
    return math.log1p(slack / longest_way(linkage))


def steepest_slopes(laws: Sequence[Law]) -> Reals:
    """Return the greatest slopes of laws between the stops, (n_hinges,), N m/rad; HcsearchError if one snaps."""
    if any(law.bent is not None for law in laws):
        raise HcsearchError("margins of springs that snap are known at states only: give laws without a snap")
    return np.array([_steepest(law) for law in laws])


def _steepest(law: Law) -> float:
    """Return the greatest slope of a law's straight branch about the stops; slopes are quadratic in each piece."""
    slopes = [0.0]
    ends = [*law.straight.breaks[1:], math.inf]
    for number, (start, end, (_, b, c, d)) in enumerate(
        zip(law.straight.breaks, ends, law.straight.cubics, strict=True)
    ):
        low = (-LAW_RANGE_EXCESS if number == 0 else max(-LAW_RANGE_EXCESS, start)) - start
        high = min(math.pi + LAW_RANGE_EXCESS, end) - start
        places = [low, high, *([-c / (3.0 * d)] if d else [])]
        slopes += [abs(b + x * (2.0 * c + 3.0 * x * d)) for x in places if low <= x <= high]
    return max(slopes)


def certified_margin(
    linkage: Linkage,
    course: Course,
    wander: float,
    torques_at: Callable[[Reals], Reals],
    slopes: Reals,
    friction: Reals,
    enough: tuple[float, float] = (math.inf, math.inf),
) -> CertifiedMargin:
    """Bound the torque margins at all closed states beside a motion from below.

    course : a proved motion, or a simulated one with its loops closed. wander : rad, from `wander_of`. torques_at :
    torques (k, n_hinges) of fold angles (k, n_hinges); slopes : from `steepest_slopes`, in the scale of the torques.
    friction : (n_hinges,), N m. enough : values, with all springs and with one failed, above which no bound is
    improved, as margins known elsewhere are no greater.
    """
    bounding = _Bounding(linkage, course, wander, torques_at, slopes, friction)
    count = len(course.times) - 1
    intervals = _Intervals(np.arange(count), np.zeros(count), np.ones(count))
    least, bound = _Least(enough, [math.inf, math.inf], [math.nan, math.nan]), np.full(2, math.inf)
    tried, unsettled, certified = 0, [np.empty((0, 4))], 1.0
    while len(intervals.steps) and certified >= MIN_BOUNDED_SHARE:
        bounds, counts = bounding.bounds_in(intervals, least)
        tried += len(bounds)
        if tried + counts.sum() > MAX_MARGIN_INTERVALS:
            counts[:] = 0
        low = (bounds < least.asked).any(axis=1)
        bound = np.minimum(bound, bounds[(counts == 0) & ~low].min(axis=0, initial=math.inf))
        kept = (counts == 0) & low
        unsettled.append(np.c_[bounding.ends_of(intervals), bounds][kept])
        certified -= bounding.turn_share(unsettled[-1][unsettled[-1][:, 2:].min(axis=1) <= 0.0])
        intervals = intervals.parts(counts)
    gaps = []
    for part in _joined(np.concatenate(unsettled)):
        own = part[:, 2:].min(axis=0)
        if own.min() > 0.0:  # as near the least margin as intervals of this size allow
            bound = np.minimum(bound, own)
        else:
            gaps.append((float(part[0, 0]), float(part[-1, 1])))
    certified = min(certified, 1.0 - bounding.turn_share(np.array(gaps).reshape(-1, 2)))
    if certified < MIN_BOUNDED_SHARE:
        bound, gaps = np.zeros(2), [(float(course.times[0]), float(course.times[-1]))]
    (margin, margin_failed), (time, time_failed) = least.margins, least.times
    whole, failed = bound.tolist()
    return CertifiedMargin(whole, failed, tuple(gaps), certified, margin, margin_failed, time, time_failed, tried)


def _joined(rows: Reals) -> list[Reals]:
    """Return rows, which begin with the ends of an interval, in groups of intervals that meet, in order."""
    rows = rows[np.argsort(rows[:, 0])]
    apart = np.flatnonzero(rows[1:, 0] > rows[:-1, 1] * (1.0 + MARGIN_ROUNDING)) + 1
    return np.split(rows, apart) if len(rows) else []


class _Bounding:
    """Bounds of the margins at all closed states in intervals of a path; arguments as in `certified_margin`."""

    def __init__(
        self,
        linkage: Linkage,
        course: Course,
        wander: float,
        torques_at: Callable[[Reals], Reals],
        slopes: Reals,
        friction: Reals,
    ) -> None:
        self.linkage, self.wander, self.torques_at, self.slopes = linkage, wander, torques_at, slopes
        self.friction, self.times, self.lengths = friction, course.times, np.diff(course.times)
        self.polynomials, self.turns = course_polynomials(*course), accumulated_turn(course.angles)

    def ends_of(self, intervals: _Intervals) -> Reals:
        """Return the times at which intervals start and end, (k, 2)."""
        lengths = self.lengths[intervals.steps]
        ends: Reals = self.times[intervals.steps][:, None] + np.c_[lengths * intervals.starts, lengths * intervals.ends]
        return ends

    def turn_share(self, parts: Reals) -> float:
        """Return the share of the turn of all hinges in parts of the motion, by rows that begin with their ends."""
        return float(np.diff(np.interp(parts[:, :2], self.times, self.turns)).sum() / self.turns[-1])

    def bounds_in(self, intervals: _Intervals, least: _Least) -> tuple[Reals, WholeNumbers]:
        """Return lower bounds of the margins in intervals, (k, 2), and into how many parts each is divided, 0 for none.

        Bounds with one spring failed are improved only where they are less than asked for, in intervals that are not
        divided anyway. least : takes the margins at the middles.
        """
        places = _boxes_of(self.polynomials, intervals, self.wander)
        boxes = _Boxes.of(self, places)
        times, widest = self.ends_of(intervals).mean(axis=1), places.turns.max(axis=1) - self.wander
        margins, rates = boxes.best(np.arange(len(times)), boxes.torques)
        least.take(0, margins, times)
        whole, each = boxes.bounds(np.arange(len(times)), rates)
        divided = (widest > LEAST_TURN * self.wander) & (~boxes.near.dependent | (widest > DEPENDENT_TURN))
        solved = np.zeros(each.shape, bool)
        left = np.flatnonzero(~(divided & (whole < least.asked[0])))
        while len(left):
            worst = np.where(solved[left], np.inf, each[left]).argmin(axis=1)
            low = (each[left, worst] < least.asked[1]) & ~solved[left, worst]
            left, worst = left[low], worst[low]
            failed = boxes.torques[left]
            failed[np.arange(len(left)), worst] = 0.0
            margins, rates = boxes.best(left, failed)
            least.take(1, margins, times[left])
            each[left] = np.maximum(each[left], boxes.bounds(left, rates)[1])
            solved[left, worst] = True
            left = left[~(divided[left] & (each[left, worst] < least.asked[1]))]
        bounds = np.c_[whole, each.min(axis=1)]
        low = (bounds < 0.5 * least.asked).any(axis=1)
        return bounds, np.where(low, 4, 2) * ((bounds < least.asked).any(axis=1) & divided)


@dataclass(frozen=True, eq=False)
class _Boxes(ByValue):
    """Boxes of fold angles around k states, in which closed states are compared.

    senses, allowed : what stops allow at the middle, and in all of the box. torques, changes : torques at the middle,
    and by how much others in the box differ from them at most. usable : (k,), where no hinge is near both stops.
    """

    of_path: _Bounding
    closed: ClosedRates
    near: NearClosedRates
    senses: Signs
    allowed: Signs
    torques: Reals
    changes: Reals
    usable: Flags

    @staticmethod
    def of(path: _Bounding, places: StateBoxes) -> _Boxes:
        """Return the boxes of intervals of a motion."""
        middles, turns = places.middles, places.turns
        near_flat, near_packed = middles <= turns, middles >= math.pi - turns
        closed = closed_rates(np.array([path.linkage.closure(state)[1] for state in middles]))
        allowed = near_packed.astype(np.int8) - near_flat.astype(np.int8)
        usable = ~np.any(near_flat & near_packed, axis=1)
        senses = allowed_senses(middles)
        near = NearClosedRates.of(path.linkage, closed.jacobians, places, allowed == 0, senses == 0)
        torques, changes = path.torques_at(middles), path.slopes * turns
        return _Boxes(path, closed, near, senses, allowed, torques, changes, usable)

    def best(self, boxes: WholeNumbers, torques: Reals) -> tuple[Reals, Reals]:
        """Return upper bounds of the margins at the middles of some boxes, and the best rates in all of each."""
        closed, friction = self.closed.take(boxes), self.of_path.friction
        found = kernel_margins(closed, torques, friction, self.senses[boxes])
        rates, differ = found.rates.copy(), np.flatnonzero((self.senses[boxes] != self.allowed[boxes]).any(axis=1))
        own = kernel_margins(closed.take(differ), torques[differ], friction, self.allowed[boxes[differ]])
        rates[differ] = own.rates
        return found.bounds, rates

    def bounds(self, boxes: WholeNumbers, rates: Reals) -> tuple[Reals, Reals]:
        """Return the bounds that rates give in some boxes, (k,), and with each spring failed, (k, n_hinges)."""
        friction, torques, turned = self.of_path.friction, self.torques[boxes], self.changes[boxes]
        changes, off = self.near.changes(boxes, rates)
        usable = self.usable[boxes] & np.isfinite(off)
        off = np.where(usable, off, 0.0)[:, None]
        sizes = np.linalg.norm(torques, axis=1) + np.linalg.norm(turned, axis=1)
        lost = turned * (np.abs(rates) + np.abs(changes))
        least = np.full((len(boxes), torques.shape[1] + 1), np.inf)
        # power is linear and losses are convex along the drift: their ratio is least at one of its ends
        for corrected in (rates - changes, rates + changes):
            powers = torques * corrected - lost
            losses = (friction * np.abs(corrected)).sum(axis=1, keepdims=True) + off * np.linalg.norm(friction)
            power = powers.sum(axis=1, keepdims=True) - off * sizes[:, None]
            kept = usable[:, None] * (1.0 - CLOSED_RATE_TOLERANCE) / np.where(losses > 0.0, losses, np.inf)
            least = np.minimum(least, np.maximum(np.c_[power, power - powers], 0.0) * kept)
        return least[:, 0], least[:, 1:]


def _boxes_of(polynomials: Reals, intervals: _Intervals, wander: float) -> StateBoxes:
    """Return boxes, about their middles, of the states in intervals and of the states within a wander of them."""
    m = 0.5 * (intervals.starts + intervals.ends)[:, None]
    h = 0.5 * (intervals.ends - intervals.starts)[:, None]
    about = polynomials[intervals.steps]
    count = about.shape[2]
    for done in range(count - 1):  # in powers of the distance from the middle, by Horner's rule again and again
        for power in range(count - 2, done - 1, -1):
            about[:, :, power] += m * about[:, :, power + 1]
    rests = np.zeros(about.shape[:2])
    for power in range(count - 1, 1, -1):
        rests = h * (rests + np.abs(about[:, :, power]))
    return StateBoxes(about[:, :, 0], h * about[:, :, 1], h * rests + wander)
