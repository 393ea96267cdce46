"""Lower bounds of torque margins at all closed states beside a proved path, between its states too.

Around a closed state the screws of hinges turn by no more than the hinges do. So the best rates there, corrected by as
much as loops then open, are closed rates at all states near by, and their ratio bounds the margin from below
(docs/explanation/flight_margins.md, 5). Intervals of the path are halved until that bound is near the least margin.
Near singular states corrections are not bounded: these parts of a path stay without a bound, and are told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.planning.series import centre_screws
from hcsearch.motion.collision.panel_reaches import longest_way
from hcsearch.motion.planning.path_proofs import PathProof
from hcsearch.motion.planning.stretches import cubics_of
from hcsearch.scenes.laws import Law
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.path_margins import MarginKind
from hcsearch.springs.flight.torque_margin import (
    CLOSED_RATE_TOLERANCE,
    MARGIN_ROUNDING,
    allowed_senses,
    closed_rates,
    torque_margins,
)

CERTIFIED_SHARE = 0.9
"""Share of the least margin at the states tried so far at which intervals are no longer halved."""
MAX_INTERVAL_DEPTH, MAX_MARGIN_INTERVALS = 12, 40_000
"""How often an interval between two states is halved, and the greatest number of intervals that are tried."""

LAW_RANGE_EXCESS = 0.01
"""How far beyond the stops slopes of laws are bounded (rad): paths are proved to pass them by less."""


@dataclass(frozen=True)
class CertifiedMargin:
    """A lower bound of the torque margins on a path.

    bound : at all closed states beside the path, but for the gaps; 0 where all of it is a gap. gaps : starts and ends,
    in the time of the path, of parts without a bound. certified : the share of the time of the path without gaps.
    least : the least margin at the states that were tried; hinges beyond a stop count as at it. intervals : number that
    were tried.
    """

    bound: float
    gaps: tuple[tuple[float, float], ...]
    certified: float
    least: float
    intervals: int

    @property
    def kind(self) -> MarginKind:
        """Whether the bound holds on the whole path."""
        return "sampled" if self.gaps else "bound"


@dataclass(frozen=True, eq=False)
class _Intervals(ByValue):
    """Intervals of steps of a path: (k,) their steps, and start and end as shares of these."""

    steps: WholeNumbers
    starts: Reals
    ends: Reals

    def halves(self, kept: WholeNumbers) -> _Intervals:
        """Return both halves of some intervals."""
        steps, starts, ends = self.steps[kept], self.starts[kept], self.ends[kept]
        middles = 0.5 * (starts + ends)
        return _Intervals(np.r_[steps, steps], np.r_[starts, middles], np.r_[middles, ends])


def wander_of(linkage: Linkage, proof: PathProof) -> float:
    """Return the greatest deviation of closed states from the motion of a proof, summed over hinges (rad)."""
    return math.log1p(proof.slack / longest_way(linkage))


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
) -> CertifiedMargin:
    """Bound the torque margins at all closed states beside a proved path from below.

    course : a motion of cubics. wander : rad, of `wander_of`. torques_at : torques (k, n_hinges) of fold angles (k,
    n_hinges); slopes : of `steepest_slopes`, in the scale of the torques. friction : (n_hinges,), N m.
    HcsearchError for a course that is not one of cubics.
    """
    if not course.cubic:
        raise HcsearchError("margins are bounded along cubics: give the motion of a proof of its path")
    cubics = cubics_of(course.times, course.angles, course.rates)
    lengths = np.diff(course.times)
    count = len(cubics)
    intervals = _Intervals(np.arange(count), np.zeros(count), np.ones(count))
    bound = least = math.inf
    tried = 0
    for depth in range(MAX_INTERVAL_DEPTH + 1):
        margins, bounds = _bounds_of(linkage, cubics, intervals, wander, torques_at, slopes, friction)
        tried += len(margins)
        least = min(least, float(margins.min()))
        reached = bounds >= CERTIFIED_SHARE * least
        bound = min(bound, float(bounds[reached].min(initial=math.inf)))
        left = np.flatnonzero(~reached)
        if not len(left) or depth == MAX_INTERVAL_DEPTH or tried + 2 * len(left) > MAX_MARGIN_INTERVALS:
            break
        intervals = intervals.halves(left)
    starts = course.times[intervals.steps[left]] + lengths[intervals.steps[left]] * intervals.starts[left]
    ends = course.times[intervals.steps[left]] + lengths[intervals.steps[left]] * intervals.ends[left]
    gaps = _joined(starts, ends)
    certified = 1.0 - sum(end - start for start, end in gaps) / float(course.times[-1] - course.times[0])
    return CertifiedMargin(bound if math.isfinite(bound) else 0.0, gaps, certified, least, tried)


def _joined(starts: Reals, ends: Reals) -> tuple[tuple[float, float], ...]:
    """Join intervals that meet, in order."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(zip(starts.tolist(), ends.tolist(), strict=True)):
        if joined and start <= joined[-1][1] * (1.0 + MARGIN_ROUNDING):
            joined[-1] = joined[-1][0], end
        else:
            joined.append((start, end))
    return tuple(joined)


def _bounds_of(
    linkage: Linkage,
    cubics: Reals,
    intervals: _Intervals,
    wander: float,
    torques_at: Callable[[Reals], Reals],
    slopes: Reals,
    friction: Reals,
) -> tuple[Reals, Reals]:
    """Return the margins at the middles of intervals, and lower bounds of those at all closed states in them, (k,)."""
    middles, turns = _boxes_of(cubics, intervals)
    turns = turns + wander
    near_flat, near_packed = middles <= turns, middles >= math.pi - turns
    senses = near_packed.astype(np.int8) - near_flat.astype(np.int8)  # what stops allow in all of the interval
    jacobians = np.array([linkage.closure(state)[1] for state in middles])
    torques = torques_at(middles)
    closed = closed_rates(jacobians)
    margins = torque_margins(closed, torques, friction, allowed_senses(middles)).bounds
    rates = torque_margins(closed, torques, friction, senses).rates
    off = _corrections(linkage, jacobians, turns, rates, senses == 0)
    changes = slopes * turns
    sizes = np.linalg.norm(torques, axis=1) + np.linalg.norm(changes, axis=1)
    power = (torques * rates).sum(axis=1) - (changes * np.abs(rates)).sum(axis=1) - off * sizes
    losses = (friction * np.abs(rates)).sum(axis=1) + off * np.linalg.norm(friction)
    usable = np.isfinite(off) & (power > 0.0) & (losses > 0.0) & ~(near_flat & near_packed).any(axis=1)
    bounds = np.where(usable, power, 0.0) / np.where(usable, losses, 1.0)
    return margins, bounds * (1.0 - CLOSED_RATE_TOLERANCE)


def _boxes_of(cubics: Reals, intervals: _Intervals) -> tuple[Reals, Reals]:
    """Return fold angles at the middles of intervals and the greatest distances from them in these, (k, n_hinges)."""
    m = 0.5 * (intervals.starts + intervals.ends)[:, None]
    h = 0.5 * (intervals.ends - intervals.starts)[:, None]
    a, b, c, d = np.moveaxis(cubics[intervals.steps], -1, 0)
    middles = a + m * (b + m * (c + m * d))
    turns = h * np.abs(b + m * (2.0 * c + 3.0 * m * d)) + h * h * np.abs(c + 3.0 * m * d) + h**3 * np.abs(d)
    return middles, turns


def _corrections(linkage: Linkage, jacobians: Reals, turns: Reals, rates: Reals, free: Flags) -> Reals:
    """Return how far rates of each middle are from closed ones at all states of its interval at most, (k,).

    turns : (k, n_hinges), of each hinge from the middle. free : hinges whose rates may be corrected. Infinite where the
    equations of closure may depend on each other.
    """
    if not linkage.loops:
        return np.zeros(len(rates))
    screws = jacobians.copy()
    moments, opened, grown = np.zeros(rates.shape), np.zeros(len(rates)), np.zeros(len(rates))
    for number, loop in enumerate(linkage.loops):
        hinges, rows = np.array([hinge for hinge, _ in loop]), slice(6 * number, 6 * number + 6)
        for k in range(len(screws)):
            centre_screws(screws[k], 6 * number, hinges, np.empty(3), moments[k])
        own = moments[:, hinges]
        gains = 0.5 * (own + np.sqrt(own * own + 4.0))  # of the bracket with a screw
        change = np.expm1((gains * turns[:, hinges]).sum(axis=1))
        sizes = np.linalg.norm(screws[:, rows][:, :, hinges], axis=1)
        opened += (change * (sizes * np.abs(rates[:, hinges])).sum(axis=1)) ** 2
        grown += (change * np.linalg.norm(sizes * free[:, hinges], axis=1)) ** 2
    least = np.linalg.svd(screws * free[:, None, :], compute_uv=False)[:, linkage.n_rows - 1 : linkage.n_rows]
    firm = (least[:, 0] if least.shape[1] else np.zeros(len(rates))) - np.sqrt(grown)
    return np.where(firm > 0.0, np.sqrt(opened) / np.where(firm > 0.0, firm, 1.0), np.inf)
