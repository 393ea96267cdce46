"""Tightness of a lock: the opening of the loops that a linkage needs to leave a locked state.

A locked state is isolated, but other closed states may be near, behind a gap of micrometres. Let hinges turn by x >= 0
away from their stops. The opening of x is the displacement that the product of transformations around a loop, which
should be the identity, causes: the root mean square over all corners of the panels, placed as in the state. So it is a
length, and does not depend on where a loop is cut, as long as turns are small. For each sum s of x the least opening is
computed, with s growing from 0 until loops are closed again, each time from the x of the previous sum; then back from
there in the same way. The best path changes from the forward to the backward path where that costs least. The result is
a measurement: other paths may be better, panels may collide on this one, and nothing is proved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.linkage.openings import LoopsAtStops, minimise_opening, open_loops, scale_turns
from hcsearch.shape.linkage import Linkage

FIRST_TURN_SUM, TURN_SUM_GROWTH, MAX_TURN_SUM_STEP = 0.01, 1.12, 0.05
"""The first sum of turns (rad), the ratio of consecutive sums, and their greatest difference (rad)."""
LEAVING_START_COUNT = 4
"""Number of starting directions: one of equal turns, the others random."""
SHUT_OPENING_SHARE = 1e-8
"""Loops are closed where their opening is below this share of the pattern's size."""
OPENING_SAMPLE_COUNT = 4
"""Number of intermediate points between two states of a path at which the opening is evaluated."""


@dataclass(frozen=True)
class Tightness:
    """The opening of loops (m) between a locked state and another closed one: measured, not proved.

    opening : the greatest opening on the best path that was found. least : the greatest of the least openings that were
    found for all sums of turns up to the end: other paths need as much, unless the search missed a minimum.
    turn, closed : sums of turns (rad) at that opening, and at the state where loops are closed again; closed is None
        where the search was given up before, as more than the opening would be needed.
    """

    opening: float
    least: float
    turn: float
    closed: float | None

    @property
    def sentence(self) -> str:
        """The measurement in a sentence."""
        if self.closed is None:
            return f"leaving it would open the loops by more than {1e3 * self.opening:.2g} mm (measured)"
        turned = f"{math.degrees(self.closed):.0f} degrees of all hinges"
        return f"leaving it opens the loops by {1e3 * self.opening:.2g} mm, until a turn of {turned} in sum (measured)"


def tightness(linkage: Linkage, angles: Reals, *, max_opening: float | None = None) -> Tightness | None:
    """Measure the opening of the loops that a linkage needs to leave a state where every hinge is at a stop.

    max_opening : opening (m) beyond which no path is followed; None for the panels' thickness.
    None for open chains. Where the state is not isolated at all, the opening is due to rounding. The first panel is
    held: where loops are cut depends on the held panel, and with it the last digits of the opening.
    """
    if not linkage.loops:
        return None
    linkage = linkage if linkage.base == 0 else Linkage(linkage.pattern)
    loops = _Loops(linkage, angles)
    max_opening = linkage.pattern.thickness if max_opening is None else max_opening
    forward = _forward_path(loops, max_opening)
    if not loops.is_closed(forward[-1]):
        return Tightness(max_opening, max_opening, float(forward[-1].sum()), None)
    return _best_path(loops, forward, _backward_path(loops, forward))


class _Loops:
    """The loops of a linkage as functions of turns away from the stops of one state."""

    def __init__(self, linkage: Linkage, angles: Reals) -> None:
        self.n_hinges, self.shut = linkage.n_hinges, SHUT_OPENING_SHARE * linkage.pattern.size
        senses, weights = np.where(angles > 0.5 * math.pi, -1.0, 1.0), _weights(linkage, angles)
        lines, size = (linkage.directions, linkage.points), linkage.pattern.size
        self.at_stops = LoopsAtStops(*lines, *linkage.loop_arrays, size, angles, senses, weights, 0.1 * self.shut)
        self._work = np.empty(linkage.n_rows), np.empty((linkage.n_rows, linkage.n_hinges))

    def opening(self, turns: Reals) -> float:
        """The opening at some turns, m."""
        return math.sqrt(open_loops(self.at_stops, turns, *self._work))

    def least_opening_turns(self, turns: Reals, total: float) -> Reals:
        """The turns of a given sum with the least opening near some turns, which are scaled to this sum."""
        scaled = np.empty_like(turns)
        scale_turns(turns, total, scaled)
        minimise_opening(self.at_stops, scaled, total)
        return scaled

    def greatest_opening(self, start: Reals, end: Reals) -> tuple[float, float]:
        """The greatest opening on the straight line between two states, and the sum of turns at it."""
        between = [start + share * (end - start) for share in np.linspace(0.0, 1.0, OPENING_SAMPLE_COUNT + 2)]
        return max((self.opening(turns), float(turns.sum())) for turns in between)

    def is_closed(self, turns: Reals) -> bool:
        """Whether the loops are closed."""
        return self.opening(turns) < self.shut


def _weights(linkage: Linkage, angles: Reals) -> Reals:
    """Weights of the closure residuals, (n_loops, 6, 6), with which their norms are openings in metres."""
    corners = np.concatenate([solid.reshape(-1, 3) for solid in linkage.solids(angles)])
    poses = linkage.poses(angles)
    weights = []
    for (hinge, sign), *_ in linkage.loops:
        joint = linkage.pattern.hinges[hinge]
        pose = poses[joint.first if sign == 1 else joint.second]  # the panel in whose frame the residual is
        x, y, z = ((corners - pose[:, 3]) @ pose[:, :3]).T
        zero, unit = np.zeros(len(corners)), np.full(len(corners), linkage.pattern.size)
        rows = [[zero, z, -y, unit, zero, zero], [-z, zero, x, zero, unit, zero], [y, -x, zero, zero, zero, unit]]
        moved = np.array(rows).transpose(2, 0, 1).reshape(-1, 6) / math.sqrt(len(corners))
        weights.append(np.linalg.qr(moved)[1])
    return np.array(weights)


def _first_turns(loops: _Loops) -> Reals:
    """Turns of the first sum with the least opening over all starts."""
    n = loops.n_hinges
    rng = np.random.default_rng(0)
    starts = [np.full(n, 1.0 / n), *rng.dirichlet(np.ones(n), size=LEAVING_START_COUNT - 1)]
    return min(
        (loops.least_opening_turns(FIRST_TURN_SUM * start, FIRST_TURN_SUM) for start in starts), key=loops.opening
    )


def _forward_path(loops: _Loops, max_opening: float) -> list[Reals]:
    """Turns of least opening with growing sums, until the loops are closed again or their opening exceeds a maximum."""
    states = [_first_turns(loops)]
    total, greatest = FIRST_TURN_SUM, math.pi * loops.n_hinges
    while total < greatest and not loops.is_closed(states[-1]) and loops.opening(states[-1]) <= max_opening:
        total = min(total + min((TURN_SUM_GROWTH - 1.0) * total, MAX_TURN_SUM_STEP), greatest)
        states.append(loops.least_opening_turns(states[-1], total))
    return states


def _backward_path(loops: _Loops, forward: list[Reals]) -> list[Reals]:
    """Turns of least opening with the sums of the forward path, in its order, computed from its end."""
    states = [forward[-1]]
    for turns in forward[-2::-1]:
        total = float(turns.sum())
        states.append(loops.least_opening_turns(states[-1], total))
    return states[::-1]


def _best_path(loops: _Loops, forward: list[Reals], backward: list[Reals]) -> Tightness:
    """The best path: along the forward path, over to the backward path where that costs least, and along it."""
    forward_openings, backward_openings = (
        [loops.greatest_opening(*pair) for pair in pairwise(path)] for path in (forward, backward)
    )
    crossing_openings = [loops.greatest_opening(*pair) for pair in zip(forward, backward, strict=True)]
    up_to = list(accumulate(forward_openings, max, initial=(0.0, 0.0)))
    from_there = list(accumulate(reversed(backward_openings), max, initial=(0.0, 0.0)))[::-1]
    opening, turn = min(map(max, up_to, crossing_openings, from_there))
    least = max(min(pair) for pair in zip(map(loops.opening, forward), map(loops.opening, backward), strict=True))
    return Tightness(opening, min(least, opening), turn, float(forward[-1].sum()))
