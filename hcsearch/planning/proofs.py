"""Proofs that a path is one of the linkage: loops closed, stops kept and panels apart, from packed to flat.

A path is a list of closed states. Cubics through them, with rates that keep the loops closed at first order, come so
near to closed states that a tube around them is proved to hold a closed path (`kernels.planning.tubes`); `ends` joins
it to both singular ends. How far closed states may be from the cubics is taken off the gaps of panels, which
`collision.clearance` bounds at all times. What these proofs say, and what not: docs/explanation/motion.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hcsearch.collision.clearance import Clearance, certify
from hcsearch.collision.margins import LEAST_PLAY, scale_of
from hcsearch.collision.penetration import deepest_cut
from hcsearch.collision.reaches import longest_way, reaches
from hcsearch.collision.solids import kept_apart
from hcsearch.equality import ByValue
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.planning.closing import CLOSED, close, keep_closed, new_closing, open_by
from hcsearch.kernels.planning.tubes import POLISHED, Track, enclose
from hcsearch.linkage import Linkage
from hcsearch.planning.ends import Departure, End
from hcsearch.planning.problems import loops_of
from hcsearch.planning.switches import switch_between
from hcsearch.typing import Reals

PLAYS = (LEAST_PLAY, 2e-5, 5e-5, 1e-4)
"""Margins at which a path is certified, least first, m, for panels with edges of 50 mm."""
SHARE = 0.04
"""What closed states may be off, as a share of the least of these margins."""
FIRST = (1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4)
"""Lengths of the first step (rad) that are tried, one after the other."""
HALVINGS = 14
"""Closed states are put between two states of a path no more often than this."""
ROOM = 20000
"""States of a path with those that are put between them."""
APART = 1e-9
"""States that differ by less (rad) are one."""
SWITCHES = 6
"""Switch states that are put into a path, at most."""
MOVED = 1e-3
"""A path with a state that is further from closed states within the stops (rad) is none."""


@dataclass(frozen=True, eq=False)
class PathProof(ByValue):
    """What is proved of a path.

    motion : the states that the proof is about, with rates; None where closed states are not proved beside all of it.
    closed : whether they are. reach : how far (rad) the proof stays away from the packed and from the flat state, 0
    where it joins them. exact : whether both ends are known in whole numbers; else the proof holds but for rounding
    there. slack : m, what panels may be elsewhere than the path places them. give : rad, what a hinge may be beyond its
    stop.
    clear : at the least margin at which panels are certified to keep apart, or at the greatest that was tried.
    overlap : m, how deep panels as they are cut into each other at the states of the motion; 0 where they only touch.
    """

    motion: Course | None
    closed: bool
    reach: tuple[float, float]
    exact: bool
    slack: float
    give: float
    clear: Clearance | None
    overlap: float

    @property
    def margin(self) -> float | None:
        """The least margin (m) at which the path is proved, None where it is not."""
        proved = self.clear is not None and self.clear.kind == "clear" and self.closed and not any(self.reach)
        return self.clear.margin if proved and self.clear is not None else None


class Prover:
    """Proofs for one linkage."""

    def __init__(self, linkage: Linkage) -> None:
        self.linkage, self.loops = linkage, loops_of(linkage)
        self.work = new_closing(self.loops)
        self.apart = kept_apart(linkage)
        self.scale = scale_of(linkage)

    @cached_property
    def _way(self) -> float:
        return longest_way(self.linkage)

    @cached_property
    def _spread(self) -> float:
        """What no corner of a panel is further from the line of one of its hinges (m)."""
        return float(reaches(self.linkage).max(initial=0.0))

    @cached_property
    def limit(self) -> float:
        """What closed states may differ from a path by, summed over hinges (rad)."""
        return SHARE * PLAYS[0] * self.scale / self._way

    @cached_property
    def _ends(self) -> tuple[End, End]:
        return End(self.linkage, self.linkage.folded), End(self.linkage, self.linkage.flat)

    def prove(self, states: Reals, margins: Sequence[float]) -> PathProof:
        """Prove a path from the folded to the flat state, shape (k, n_hinges), at the least of some margins (m).

        States are closed to rounding first; the proof is about `PathProof.motion`, which goes through them.
        """
        polished = self._polished(states)
        if polished is None:
            return self._unproved((0.0, 0.0))
        motion, wander, reach = (
            self._enclosed(polished) if self.linkage.loops else (self._free(polished), 0.0, (0.0, 0.0))
        )
        if motion is None:
            return self._unproved(reach)
        slack = math.expm1(wander) * self._way  # a hinge turns what others have moved already
        give = _beyond(motion) + wander
        clear = None
        for margin in sorted(margins):
            if give * self._spread > margin:
                continue  # panels of a hinge would overlap, shrunk by this
            clear = certify(self.linkage, motion, margin=margin, slack=slack, apart=self.apart, measured=False)
            if clear.kind == "clear":
                break
        overlap = deepest_cut(self.linkage, motion.angles, self.apart)
        return PathProof(motion, True, reach, self._exact, slack, give, clear, overlap)

    def _unproved(self, reach: tuple[float, float]) -> PathProof:
        """What is said of a path beside which closed states are not proved."""
        return PathProof(None, False, reach, self._exact, 0.0, 0.0, None, 0.0)

    @property
    def _exact(self) -> bool:
        return not self.linkage.loops or all(end.exact for end in self._ends)

    def _enclosed(self, states: Reals) -> tuple[Course | None, float, tuple[float, float]]:
        """The motion beside which closed states lie, None without; what they wander by (rad), and `PathProof.reach`.

        Where that fails in a step in which hinges leave or reach stops, the state at which they do is put into it.
        """
        m, reach = self.linkage.n_hinges, (0.0, 0.0)
        for _ in range(1 + SWITCHES):
            coarse, shares, reach = self._joined(states)
            fine = Track(
                np.zeros(ROOM), np.zeros((ROOM, m)), np.zeros((ROOM, m)), np.zeros(ROOM), np.zeros(1, np.int64)
            )
            stop = np.zeros(2)
            if coarse.filled[0] < 2:
                break
            if enclose(self.loops, coarse, shares, self.limit, HALVINGS, fine, stop):
                count = int(fine.filled[0])
                wander = max(float(fine.wanders[:count].max()), *shares[:, 1:].sum(axis=1).tolist())
                return _cubics(fine.times[:count], fine.angles[:count], fine.rates[:count]), wander, reach
            switched = self._switched(states, coarse, stop[0])
            if switched is None:
                break
            states = switched
        return None, 0.0, reach

    def _switched(self, states: Reals, path: Track, time: float) -> Reals | None:
        """The states with a switch state put into the step of their path in which a time lies; None without one."""
        count = int(path.filled[0])
        after = int(np.searchsorted(path.times[:count], time, side="right"))
        own = np.flatnonzero((states == path.angles[after % count]).all(axis=1))
        if after == count or not len(own) or not own[0]:
            return None
        switch = switch_between(self.loops, states[own[0] - 1], states[own[0]], self.work)
        return None if switch is None else np.insert(states, own[0], switch, axis=0)

    def _free(self, states: Reals) -> Course:
        """The motion of panels in a chain without a loop, whose states are all closed."""
        times = _times(states)
        return _cubics(times, states, self._rates(times, states))

    def _polished(self, states: Reals) -> Reals | None:
        """States closed to rounding, each once; None where they do not go from packed to flat by closed states."""
        ends = np.array([self.linkage.folded, self.linkage.flat], float)
        if len(states) < 2 or not np.abs(states[[0, -1]] - ends).max() <= APART:
            return None
        polished = [ends[0]]
        for state in states[1:-1]:
            own = state.copy()
            closed = close(self.loops, own, POLISHED, 0.0, 20, self.work)
            if not np.abs(own - state).max() <= MOVED or (not closed and open_by(self.loops, own, self.work) > CLOSED):
                return None
            if closed and np.abs(own - polished[-1]).max() > APART:
                polished.append(own)
        return np.array([*polished, ends[1]])

    def _joined(self, states: Reals) -> tuple[Track, Reals, tuple[float, float]]:
        """The path with rates, begun and ended as the ends can be left; shares and wanders of both end steps."""
        heads = [self._left(end, line) for end, line in zip(self._ends, (states, states[::-1]), strict=True)]
        shares, reach = np.zeros((2, 1 + self.linkage.n_hinges)), [0.0, 0.0]
        shares[1, 0] = 1.0
        lines: list[Reals] = []
        for side, (head, line) in enumerate(zip(heads, (states, states[::-1]), strict=True)):
            if head is None:
                reach[side] = float(np.abs(line[1] - line[0]).max())
                lines.append(line[:1][:0])
                continue
            away, departure = head[2:]
            shares[side, 0] = 1.0 - departure.share if side else departure.share
            shares[side, 1:] = departure.wanders
            lines.append(np.array([line[0], head[0]]))
            far = np.abs(line - line[0]).max(axis=1) > 3.0 * away
            own = np.flatnonzero(far)[0]
            states = states[: len(states) - own] if side else states[own:]
        if heads[0] is None:
            states = states[1:]
        if heads[1] is None:
            states = states[:-1]
        path = np.concatenate([lines[0], states, lines[1][::-1]])
        times = _times(path)
        rates = self._rates(times, path)
        for side, head in enumerate(heads):
            if head is not None:
                own = slice(None, 2) if side == 0 else slice(-1, -3, -1)
                times_here = times[own]
                length = abs(times_here[1] - times_here[0])
                sign = -1.0 if side else 1.0
                rates[own] = sign * np.array(head[1]) / length
        count = np.array([len(path)])
        return Track(times, path, rates, np.zeros(len(path)), count), shares, (reach[0], reach[1])

    def _left(self, end: End, line: Reals) -> tuple[Reals, tuple[Reals, Reals], float, Departure] | None:
        """How a path leaves an end: a state near it, slopes of the step at both its ends, and what is proved of it."""
        direction = end.direction((line[1] - line[0]) / np.abs(line[1] - line[0]).max())
        if direction is None:
            return None
        for away in FIRST:
            state = line[0] + away * direction
            if not close(self.loops, state, POLISHED, 0.0, 30, self.work):
                continue
            rise, slope = state - line[0], away * direction
            after = self._tangent(state, 2.0 * rise - slope)
            course = np.stack([line[0], slope, 3.0 * rise - 2.0 * slope - after, slope + after - 2.0 * rise], axis=1)
            departure = end.depart(course)
            if departure is not None and self._encloses(line[0], state, slope, after, departure):
                return state, (slope, after), away, departure
        return None

    def _encloses(self, end: Reals, state: Reals, slope: Reals, after: Reals, departure: Departure) -> bool:
        """Whether closed states lie beside the rest of a first step, too, and near enough."""
        ends = np.zeros((2, 1 + len(end)))
        ends[0, 0], ends[0, 1:], ends[1, 0] = departure.share, departure.wanders, 1.0
        step = Track(np.array([0.0, 1.0]), np.array([end, state]), np.array([slope, after]), np.zeros(2), np.array([2]))
        fine = Track(np.zeros(3), np.zeros((3, len(end))), np.zeros((3, len(end))), np.zeros(3), np.zeros(1, np.int64))
        return bool(enclose(self.loops, step, ends, self.limit, 0, fine, np.zeros(2)))

    def _tangent(self, state: Reals, rate: Reals) -> Reals:
        """The part of a rate that keeps loops closed and hinges at their stops."""
        row = rate[None].copy()
        keep_closed(self.loops, state, row, 0, self.work)
        return row.ravel()

    def _rates(self, times: Reals, path: Reals) -> Reals:
        """Rates at the states of a path: of the parabola through three of them, less what would open the loops."""
        if len(path) < 2:
            return np.zeros_like(path)
        h, slopes = np.diff(times)[:, None], np.diff(path, axis=0) / np.diff(times)[:, None]
        rates = np.concatenate(
            [slopes[:1], (h[1:] * slopes[:-1] + h[:-1] * slopes[1:]) / (h[1:] + h[:-1]), slopes[-1:]]
        )
        return np.array([self._tangent(state, rate) for state, rate in zip(path, rates, strict=True)])


def _times(path: Reals) -> Reals:
    """Times at which a path is gone along at unit speed."""
    times: Reals = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    return times


def _cubics(times: Reals, angles: Reals, rates: Reals) -> Course:
    """A motion of cubics."""
    return Course(times.copy(), angles.copy(), rates.copy(), np.zeros_like(angles), True)


def _beyond(motion: Course) -> float:
    """What hinges are beyond a stop (rad) at the worst of all times of a motion of cubics."""
    steps = np.diff(motion.times)[:, None]
    start, end = motion.angles[:-1], motion.angles[1:]
    b, after = steps * motion.rates[:-1], steps * motion.rates[1:]
    c, d = 3.0 * (end - start) - 2.0 * b - after, b + after - 2.0 * (end - start)
    # extremes lie where b + 2 c s + 3 d s^2 = 0: the roots are q / 3 d and b / q, which loses no digits
    q = -(c + np.copysign(np.sqrt(np.maximum(c * c - 3.0 * b * d, 0.0)), c))
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.nan_to_num(np.stack([q / (3.0 * d), b / q, np.ones_like(q)]), nan=0.0, posinf=0.0, neginf=0.0)
    s = np.clip(places, 0.0, 1.0)
    values = start + s * (b + s * (c + s * d))
    return max(0.0, -float(values.min()), float(values.max()) - math.pi)
