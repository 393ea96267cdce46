"""Proofs that a linkage can follow a path: loops closed, stops kept and panels apart, from packed to flat.

A path is a list of closed states. Cubics through them, with rates that keep the loops closed at first order, come so
near to closed states that a tube around them is proved to hold a closed path (`kernels.planning.tubes`); `ends` joins
it to both singular ends. The deviation of closed states from the cubics is subtracted from the gaps of panels, which
`collision.clearance` bounds at all times. The scope of these proofs: docs/explanation/motion.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.planning.closed_states import Group
from hcsearch.kernels.planning.tubes import Track
from hcsearch.motion.collision.clearance import Clearance, certify_clearance
from hcsearch.motion.collision.distances import deepest_cut
from hcsearch.motion.collision.panel_prisms import MIN_PANEL_MARGIN, kept_apart, longest_way, reaches, scale_of
from hcsearch.motion.locks.lattice import whole_end
from hcsearch.motion.planning.ends import EndClosure
from hcsearch.motion.planning.problems import group_of, group_of_all, loops_of
from hcsearch.motion.planning.stretches import SAME_STATE_DISTANCE, Stretch, Tube, cubics_of, times_of
from hcsearch.shape.linkage import Linkage

CERTIFIED_MARGINS = (MIN_PANEL_MARGIN, 2e-5, 5e-5, 1e-4)
"""Margins at which a path is certified, in ascending order, m, for panels with edges of 50 mm."""
WANDER_MARGIN_SHARE = 0.04
"""Greatest deviation of closed states, as a share of the margin that is tried."""
STRETCH_REST_TIME = 1e-10
"""Time for which a motion rests between stretches; its speed is 1 (rad per unit of time)."""


@dataclass(frozen=True, eq=False)
class PathProof(ByValue):
    """The proved properties of a path.

    motion : the states that the proof is about, with rates; None where closed states are not proved beside all of it.
    closed : whether closed states are proved there. end_distances : rad, distances of the proof from the packed and
    from the flat state, 0 where it joins them. exact : whether both ends are known in whole numbers; else the proof
    holds up to rounding there. slack : m, greatest deviation of panels from their places on the path.
    stop_excess : rad, greatest excess of a hinge beyond its stop. clearance : the clearance at the least margin at
    which panels are certified to keep apart, or at the greatest margin tried. overlap : m, depth by which full-size
    panels cut into each other at the states of the motion; 0 where they only touch.
    """

    motion: Course | None
    closed: bool
    end_distances: tuple[float, float]
    exact: bool
    slack: float
    stop_excess: float
    clearance: Clearance | None
    overlap: float

    @property
    def margin(self) -> float | None:
        """The least margin (m) at which the path is proved; None where it is not."""
        if self.clearance is None or self.clearance.kind != "clear" or not self.closed or any(self.end_distances):
            return None
        return self.clearance.margin


_Enclosed = tuple[tuple[Tube, ...], tuple[float, float], bool]
"""Tubes from one end to the other, empty where that is not proved; `PathProof.end_distances` and `exact`."""
_NOTHING: _Enclosed = ((), (0.0, 0.0), False)


class Prover:
    """Proofs for one linkage."""

    def __init__(self, linkage: Linkage) -> None:
        self.linkage, self.loops = linkage, loops_of(linkage)
        self.apart = kept_apart(linkage)
        self.scale = scale_of(linkage)

    @cached_property
    def _longest_path(self) -> float:
        return longest_way(self.linkage)

    @cached_property
    def _spread(self) -> float:
        """Greatest distance of a panel's corner from the line of one of its hinges (m)."""
        return float(reaches(self.linkage).max(initial=0.0))

    def limit(self, margin: float) -> float:
        """Greatest deviation of closed states from a path, summed over hinges (rad), for panels with a margin (m)."""
        return WANDER_MARGIN_SHARE * margin / self._longest_path

    @cached_property
    def whole(self) -> Stretch:
        """The whole path as one stretch in which all hinges may turn."""
        return self._stretch(self.linkage.folded.astype(float), self.linkage.flat, group_of_all(self.loops))

    def _stretch(self, first: Reals, last: Reals, group: Group) -> Stretch:
        """A stretch between two closed states at which hinges are at stops, or as the folded state has them."""
        return Stretch(
            self.linkage, group, (EndClosure(self.linkage, first, group), EndClosure(self.linkage, last, group))
        )

    def prove(self, states: Reals, margins: Sequence[float]) -> PathProof:
        """Prove a path from the folded to the flat state, shape (k, n_hinges), at the least of some margins (m).

        States are closed to rounding first; the proof is about `PathProof.motion`, which goes through them.
        """
        tubes, end_distances, exact = self.tubes(states, margins)
        if not tubes:
            return self._unproved(end_distances, exact)
        motion, wander, slack = self.motion_in(tubes)
        stop_excess = _beyond(motion) + wander
        clearance = None
        for margin in sorted(margins):
            if stop_excess * self._spread > margin:
                continue  # panels of a hinge would overlap, shrunk by this
            clearance = certify_clearance(
                self.linkage, motion, margin=margin, slack=slack, apart=self.apart, measured=False
            )
            if clearance.kind == "clear":
                break
        overlap = deepest_cut(self.linkage, motion.angles, self.apart)
        return PathProof(motion, True, end_distances, exact, slack, stop_excess, clearance, overlap)

    def motion_in(self, tubes: Sequence[Tube]) -> tuple[Course, float, float]:
        """Return the motion along tubes, and the deviations of closed states (rad) and of panels (m) from it."""
        motion, wander = _end_to_end(tubes)
        # a hinge turns panels that others have moved already
        return motion, wander, math.expm1(wander) * self._longest_path

    def _unproved(self, end_distances: tuple[float, float], exact: bool) -> PathProof:
        """The result for a path beside which closed states are not proved."""
        return PathProof(None, False, end_distances, exact, 0.0, 0.0, None, 0.0)

    def tubes(self, states: Reals, margins: Sequence[float]) -> _Enclosed:
        """Return tubes that hold a closed path, narrow enough for the least stated play or for a margin (m).

        Each stretch between flat-folded states has a tube, in order; `PathProof.end_distances` and `exact` follow.
        """
        if not self.linkage.loops:
            return self._free(states)
        enclosed = _NOTHING
        for stretches in self._cut(states):
            for margin in sorted(
                {CERTIFIED_MARGINS[0] * self.scale, *margins}
            ):  # states that wander less leave more of the gaps
                enclosed = self._along(stretches, self.limit(margin))
                if enclosed[0] and not any(enclosed[1]):
                    return enclosed
        return enclosed

    def _cut(self, states: Reals) -> Iterator[list[tuple[Stretch, Reals]]]:
        """Yield ways of cutting a path into stretches: at its flat-folded states, and not at all.

        A folded state between the stops is an end of the first stretch, too.
        """
        valid = len(states) > 1 and states.shape[1] == self.linkage.n_hinges and bool(np.isfinite(states).all())
        stretches = list(self._stretches(states)) if valid else []
        if stretches:
            yield stretches
        if len(stretches) != 1 or stretches[0][0] is not self.whole:
            yield [(self.whole, states)]

    def _stretches(self, states: Reals) -> Iterator[tuple[Stretch, Reals]]:
        """Yield the stretches of a path between its flat-folded states, with the states of each."""
        stops = np.where(states > 0.5 * math.pi, math.pi, 0.0)
        stops[0] = self.linkage.folded
        flat = np.flatnonzero(np.abs(states - stops).max(axis=1) <= SAME_STATE_DISTANCE)
        if len(flat) < 2 or flat[0] or flat[-1] != len(states) - 1:
            return
        for first, last in pairwise(flat):
            part = states[first : last + 1].copy()
            part[0], part[-1] = stops[first], stops[last]
            moving = np.abs(part - part[0]).max(axis=0) > SAME_STATE_DISTANCE
            end = whole_end(self.linkage, part[0])
            group = self.whole.group
            if end is not None and moving.any():
                group = group_of(self.linkage, self.loops, end, moving, self.linkage.closure(part[0])[1])
            if len(group.rows) == self.linkage.n_rows and len(flat) == 2:
                yield self.whole, part
                continue
            part[:, ~group.moving] = part[0, ~group.moving]
            yield self._stretch(part[0], part[-1], group), part

    def _along(self, stretches: list[tuple[Stretch, Reals]], limit: float) -> _Enclosed:
        """Return tubes about consecutive stretches."""
        exact = all(end.exact for stretch, _ in stretches for end in stretch.ends)
        tubes: list[Tube] = []
        reach = [0.0, 0.0]
        for number, (stretch, part) in enumerate(stretches):
            closed = stretch.closed_states(part)
            if closed is None:
                return (), (0.0, 0.0), exact
            tube = stretch.equal_tube(closed) or stretch.tube_around(closed, limit)
            inner = (tube.reach[0] if number else 0.0, tube.reach[1] if number < len(stretches) - 1 else 0.0)
            if not number:
                reach[0] = tube.reach[0]
            reach[1] = tube.reach[1]
            if tube.track is None or any(inner):
                return (), (reach[0], reach[1]), exact
            tubes.append(tube)
        return tuple(tubes), (reach[0], reach[1]), exact

    def _free(self, states: Reals) -> _Enclosed:
        """The motion of panels in a chain without a loop, whose states are all closed."""
        closed = self.whole.closed_states(states)
        if closed is None:
            return (), (0.0, 0.0), True
        times = times_of(closed)
        count = np.array([len(closed)])
        track = Track(times, closed, self.whole.rates(times, closed), np.zeros(len(closed)), count)
        return (Tube(track, 0.0, (0.0, 0.0)),), (0.0, 0.0), True


def _end_to_end(tubes: Sequence[Tube]) -> tuple[Course, float]:
    """Concatenate the motions along tubes; return the result and the deviation of closed states from it (rad).

    At a flat-folded state between two of them the linkage rests for a moment, `STRETCH_REST_TIME`, while the cubics
    change their rates; they leave that state by less than this times the rates.
    """
    tracks = [tube.track for tube in tubes if tube.track is not None]
    wander = max(tube.wander for tube in tubes)
    times = [tracks[0].times]
    for before, track in pairwise(tracks):
        wander = max(wander, STRETCH_REST_TIME * float(np.abs(before.rates[-1]).sum() + np.abs(track.rates[0]).sum()))
        times.append(times[-1][-1] + STRETCH_REST_TIME + track.times)
    angles, rates = (np.concatenate([track[k] for track in tracks]) for k in (1, 2))
    return _cubics(np.concatenate(times), angles, rates), wander


def _cubics(times: Reals, angles: Reals, rates: Reals) -> Course:
    """A motion of cubics with the given states and rates."""
    return Course(times.copy(), angles.copy(), rates.copy(), np.zeros_like(angles), True)


def _beyond(motion: Course) -> float:
    """The greatest excess of hinges beyond a stop (rad) at all times of a motion of cubics."""
    start, b, c, d = np.moveaxis(cubics_of(motion.times, motion.angles, motion.rates), -1, 0)
    # extremes lie where b + 2 c s + 3 d s^2 = 0: the roots are q / 3 d and b / q, which loses no digits
    q = -(c + np.copysign(np.sqrt(np.maximum(c * c - 3.0 * b * d, 0.0)), c))
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.nan_to_num(np.stack([q / (3.0 * d), b / q, np.ones_like(q)]), nan=0.0, posinf=0.0, neginf=0.0)
    s = np.clip(places, 0.0, 1.0)
    values = start + s * (b + s * (c + s * d))
    return max(0.0, -float(values.min()), float(values.max()) - math.pi)
