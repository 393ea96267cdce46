"""Stretches of a path between closed states: the proof of each, and the switch states between them.

A path is cut at flat-folded closed states in its middle. In a stretch between two of these often few hinges turn, about
parallel lines or about one, and loops close in a smaller group (`planning.problems`), in which closure may be regular
where it is singular in the group of all motions. Hinges that do not turn stay as they are, exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.kernels.planning.closed_states import (
    PLANNING_CLOSURE_RESIDUAL,
    STOPPED_HINGE_ANGLE,
    Closing,
    Group,
    Loops,
    close_state,
    keep_closed,
    largest_closure_residual,
    new_closing,
)
from hcsearch.kernels.planning.tubes import POLISHED_RESIDUAL, Track, new_track, polishing_residual, prove_tube
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.ends import Departure, EndClosure
from hcsearch.motion.planning.problems import loops_of, turns_equally
from hcsearch.shape.linkage import Linkage

MAX_SWITCH_STEPS = 30
"""Greatest number of Newton steps to a switch state."""
REDUNDANT_CLOSURE_SHARE = 1e-8
"""Singular values of closure up to this share of the greatest count as zeros."""
MAX_SWITCH_DISTANCE_RATIO = 2.0
"""Greatest distance of a switch state from either state, over their distance."""


def switch_between(loops: Loops, first: Reals, second: Reals, work: Closing) -> Reals | None:
    """Return the closed state between two, (m,) each, with all hinges at stops that are at stops in either state.

    Hinges that leave their stops together, some at first order and some at second, do so in such a state: on a straight
    line from a state before it to one after it, some would have to leave too soon. None where both states have the same
    hinges at stops, or where there is no such state near by.
    """
    stopped = _stopped(first), _stopped(second)
    held = stopped[0] | stopped[1]
    if (stopped[0] == stopped[1]).all():
        return None
    switch = second.copy() if (held == stopped[0]).all() else 0.5 * (first + second)
    if (held == stopped[1]).all():
        switch = first.copy()
    ends = np.where(stopped[0], first, second)[held]
    switch[held] = np.where(ends > 0.5 * math.pi, math.pi, 0.0)
    for _ in range(MAX_SWITCH_STEPS):
        if largest_closure_residual(loops, switch, work) < POLISHED_RESIDUAL:
            break
        switch[~held] -= np.linalg.lstsq(work.jacobian[:, ~held], work.residual, rcond=REDUNDANT_CLOSURE_SHARE)[0]
    distances = np.linalg.norm(switch - first), np.linalg.norm(switch - second)
    near = min(distances) > STOPPED_HINGE_ANGLE and max(distances) <= MAX_SWITCH_DISTANCE_RATIO * np.linalg.norm(
        second - first
    )
    within = switch.min() >= 0.0 and switch.max() <= math.pi
    return switch if near and within and largest_closure_residual(loops, switch, work) < POLISHED_RESIDUAL else None


def _stopped(state: Reals) -> Flags:
    """Flags of the hinges that are at a stop."""
    return (state < STOPPED_HINGE_ANGLE) | (state > math.pi - STOPPED_HINGE_ANGLE)


FIRST_STEP_LENGTHS = (1e-2, 5e-3, 2.5e-3, 1e-3, 5e-4)
"""Lengths of the first step (rad), in the order of trial."""
MAX_STRETCH_HALVINGS = 14
"""Greatest number of times that closed states are inserted between two states of a path."""
MAX_STRETCH_STATES = 20000
"""Greatest number of states of a path, including inserted ones."""
SAME_STATE_DISTANCE = 1e-9
"""Distance (rad) below which states count as one."""
MAX_SWITCH_STATES = 6
"""Greatest number of switch states that are inserted into a path."""
STRAIGHT_ANGLE_ROUNDING = 2e-14
"""A few times the rounding error of an angle up to pi on a straight line (rad)."""
MAX_CLOSING_CHANGE = 1e-3
"""Greatest distance (rad) of a state of a path from closed states within the stops."""


@dataclass(frozen=True, eq=False)
class Tube(ByValue):
    """The proof of a stretch.

    track : the motion of cubics beside which closed states lie; None where that is not proved. wander : the greatest
    deviation of closed states from it, rad, summed over hinges. reach : distances of the proof from both ends, rad.
    turns_equally : whether hinges leave a flat-folded state by the same angle throughout, where loops stay closed
    exactly.
    """

    track: Track | None
    wander: float
    reach: tuple[float, float]
    turns_equally: bool = False


class Stretch:
    """A stretch of a path between two closed states at which all hinges are at stops.

    group : the hinges that turn, and the equations in which loops close. ends : the closure equations at both ends.
    """

    def __init__(self, linkage: Linkage, group: Group, ends: tuple[EndClosure, EndClosure]) -> None:
        self.linkage, self.loops, self.group, self.ends = linkage, loops_of(linkage), group, ends
        self.work = new_closing(self.loops)
        self.work.fixed[:] = ~group.moving
        self.polished = float(polishing_residual(self.loops))

    def equal_tube(self, states: Reals) -> Tube | None:
        """Return the tube where hinges leave a flat-folded state by the same angle throughout; None where they do not.

        Loops are closed at every angle, exactly (`problems.turns_equally`): deviations are only rounding of the cubics.
        """
        first, last = states[0], states[-1]
        moving = self.group.moving
        whole = whole_end(self.linkage, first)
        turned = np.abs(states - first)[:, moving]
        all_equal = moving.any() and np.ptp(turned, axis=1).max() <= SAME_STATE_DISTANCE
        all_grow = bool((np.diff(turned, axis=0) > 0.0).all())
        full = np.abs(last - first)[moving].min(initial=math.pi) == math.pi
        if not all_equal or not all_grow or not full or whole is None or not turns_equally(whole, moving):
            return None
        shares = turned[:, :1] / math.pi
        times = shares.ravel() * math.pi * math.sqrt(moving.sum())
        rates = np.broadcast_to((last - first) / times[-1], states.shape).copy()
        count = np.array([len(states)])
        track = Track(times, first + shares * (last - first), rates, np.zeros(len(states)), count)
        return Tube(track, STRAIGHT_ANGLE_ROUNDING * float(moving.sum()), (0.0, 0.0), turns_equally=True)

    def closed_states(self, states: Reals) -> Reals | None:
        """Close states to rounding and drop repeated ones; return None where they do not lead from end to end."""
        ends = np.array([end.angles for end in self.ends])
        if len(states) < 2 or not np.abs(states[[0, -1]] - ends).max() <= SAME_STATE_DISTANCE:
            return None
        polished = [ends[0]]
        for state in states[1:-1]:
            candidate = state.copy()
            closed = close_state(self.loops, candidate, self.polished, 0.0, 20, self.work)
            if not np.abs(candidate - state).max() <= MAX_CLOSING_CHANGE or (
                not closed and largest_closure_residual(self.loops, candidate, self.work) > PLANNING_CLOSURE_RESIDUAL
            ):
                return None
            if closed and np.abs(candidate - polished[-1]).max() > SAME_STATE_DISTANCE:
                polished.append(candidate)
        return np.array([*polished, ends[1]])

    def tube_around(self, states: Reals, limit: float) -> Tube:
        """Prove that closed states deviate from a path through closed states, (k, n_hinges), by no more than a limit.

        limit : rad, summed over hinges. Where that fails in a step in which hinges leave or reach stops, the switch
        state at which they do is inserted.
        """
        m, reach = self.linkage.n_hinges, (0.0, 0.0)
        for _ in range(1 + MAX_SWITCH_STATES):
            coarse, shares, reach = self._joined(states, limit)
            fine = new_track(MAX_STRETCH_STATES, m)
            stop = np.zeros(2)
            if coarse.state_count[0] < 2:
                break
            if prove_tube(self.loops, self.group, coarse, shares, limit, MAX_STRETCH_HALVINGS, fine, stop):
                count = int(fine.state_count[0])
                wander = max(float(fine.wanders[:count].max()), *shares[:, 1:].sum(axis=1).tolist())
                parts = (fine.times, fine.angles, fine.rates, fine.wanders)
                times, angles, rates, wanders = (part[:count].copy() for part in parts)
                track = Track(times, angles, rates, wanders, np.array([count]))
                return Tube(track, wander, reach)
            switched = self._switched(states, coarse, stop[0])
            if switched is None:
                break
            states = switched
        return Tube(None, 0.0, reach)

    def _switched(self, states: Reals, path: Track, time: float) -> Reals | None:
        """Insert a switch state into the step of the path that contains a time; None without one."""
        count = int(path.state_count[0])
        after = int(np.searchsorted(path.times[:count], time, side="right"))
        matches = np.flatnonzero((states == path.angles[after % count]).all(axis=1))
        if after == count or not len(matches) or not matches[0]:
            return None
        switch = switch_between(self.loops, states[matches[0] - 1], states[matches[0]], self.work)
        return None if switch is None else np.insert(states, matches[0], switch, axis=0)

    def _joined(self, states: Reals, limit: float) -> tuple[Track, Reals, tuple[float, float]]:
        """Join a path to both ends and compute its rates.

        Returns the path with rates, shares and deviations of both end steps, and the distances of the proof from both
        ends.
        """
        heads = [
            None if end.regular else self._left(end, line, limit)
            for end, line in zip(self.ends, (states, states[::-1]), strict=True)
        ]
        shares, reach = np.zeros((2, 1 + self.linkage.n_hinges)), [0.0, 0.0]
        shares[1, 0] = 1.0
        lines: list[Reals] = []
        for side, (head, line) in enumerate(zip(heads, (states, states[::-1]), strict=True)):
            if self.ends[side].regular:
                lines.append(line[:1][:0])
                continue
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
        if reach[0]:
            states = states[1:]
        if reach[1]:
            states = states[:-1]
        path = np.concatenate([lines[0], states, lines[1][::-1]])
        times = times_of(path)
        rates = self.rates(times, path)
        for side, end in enumerate(self.ends):
            if end.regular:
                rates[-side] = self._leaving(end, (path[-side] - path[1 - 3 * side]) * (1.0 if side else -1.0))
        for side, head in enumerate(heads):
            if head is not None:
                own = slice(None, 2) if side == 0 else slice(-1, -3, -1)
                times_here = times[own]
                length = abs(times_here[1] - times_here[0])
                sign = -1.0 if side else 1.0
                rates[own] = sign * np.array(head[1]) / length
        count = np.array([len(path)])
        return Track(times, path, rates, np.zeros(len(path)), count), shares, (reach[0], reach[1])

    def _left(
        self, end: EndClosure, states: Reals, limit: float
    ) -> tuple[Reals, tuple[Reals, Reals], float, Departure] | None:
        """Prove that a path leaves an end; return a state near it, slopes at both ends of the step, and the proof."""
        direction = end.direction((states[1] - states[0]) / np.abs(states[1] - states[0]).max())
        if direction is None:
            return None
        for length in FIRST_STEP_LENGTHS:
            state = states[0] + length * direction
            if not close_state(self.loops, state, self.polished, 0.0, 30, self.work):
                continue
            rise, slope = state - states[0], length * direction
            after = self._tangent(state, 2.0 * rise - slope)
            course = np.stack([states[0], slope, 3.0 * rise - 2.0 * slope - after, slope + after - 2.0 * rise], axis=1)
            departure = end.depart(course)
            if departure is not None and self._encloses(states[0], state, slope, after, departure, limit):
                return state, (slope, after), length, departure
        return None

    def _encloses(
        self, end: Reals, state: Reals, slope: Reals, after: Reals, departure: Departure, limit: float
    ) -> bool:
        """Whether closed states lie beside the rest of a first step, too, and near enough."""
        ends = np.zeros((2, 1 + len(end)))
        ends[0, 0], ends[0, 1:], ends[1, 0] = departure.share, departure.wanders, 1.0
        step = Track(np.array([0.0, 1.0]), np.array([end, state]), np.array([slope, after]), np.zeros(2), np.array([2]))
        fine = new_track(3, len(end))
        return bool(prove_tube(self.loops, self.group, step, ends, limit, 0, fine, np.zeros(2)))

    def _tangent(self, state: Reals, rate: Reals) -> Reals:
        """The projection of a rate onto the rates that keep loops closed and hinges at their stops."""
        row = rate[None].copy()
        keep_closed(self.loops, state, row, 0, self.work)
        return row.ravel()

    def _leaving(self, end: EndClosure, direction: Reals) -> Reals:
        """The rate nearest to a direction, at unit speed, at which loops stay closed at a regular end."""
        equations = end.across @ end.jacobian
        rate: Reals = direction - np.linalg.pinv(equations) @ (equations @ direction)
        rate[~self.group.moving] = 0.0
        return rate / max(float(np.linalg.norm(rate)), SAME_STATE_DISTANCE)

    def rates(self, times: Reals, path: Reals) -> Reals:
        """Rates at the states of a path, from the parabola through three of them, projected to keep loops closed."""
        if len(path) < 2:
            return np.zeros_like(path)
        h, slopes = np.diff(times)[:, None], np.diff(path, axis=0) / np.diff(times)[:, None]
        rates = np.concatenate(
            [slopes[:1], (h[1:] * slopes[:-1] + h[:-1] * slopes[1:]) / (h[1:] + h[:-1]), slopes[-1:]]
        )
        return np.array([self._tangent(state, rate) for state, rate in zip(path, rates, strict=True)])


def cubics_of(times: Reals, angles: Reals, rates: Reals) -> Reals:
    """Coefficients of Hermite cubics between states, in the share of each step, (steps, n_hinges, 4)."""
    steps, rise = np.diff(times)[:, None], np.diff(angles, axis=0)
    before, after = steps * rates[:-1], steps * rates[1:]
    return np.stack([angles[:-1], before, 3.0 * rise - 2.0 * before - after, before + after - 2.0 * rise], axis=-1)


def times_of(path: Reals) -> Reals:
    """Times along a path at unit speed."""
    times: Reals = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    return times
