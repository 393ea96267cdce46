"""One box of fold angles around all states to which a walk from an end leads, if its faces hold no closed state.

Its faces take many boxes, but about how many is known beforehand; and unlike a flood of cubes, it takes in no other
part of the closed states for a cube that both have in common.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.enclosure.estimates import estimate
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.refutation import CLOSED, EMPTY, TESTED, UNFINISHED, Refutation, begin, go_on, meets
from hcsearch.kernels.enclosure.wandering import wander
from hcsearch.locks.floods import SLICE
from hcsearch.typing import Reals

BESIDE = 0.1
"""How far faces are from the states of a walk (rad)."""
NEAR = 0.05
"""A walk that comes so near to a stop (rad) counts as reaching it."""
MORE = 5_000
"""Steps of the walk from a closed state that is met on a face."""
STARTS = 100
"""States of the walk from which Newton's method looks for a closed state on a face."""
PROBES = 200
"""Branches by which the number of boxes is estimated that a face takes."""
TOP = float(np.nextafter(math.pi, 4.0))

LEAST = 0.002
"""A face is not moved inward where less than this is between the states on either side of it (rad)."""
MOST = 300
"""Closed states that are met on faces, at most."""

Face = tuple[int, int]
"""A hinge, and the side of its angles: 0 low, 1 high."""


@dataclass(eq=False)
class _Part:
    """A part of a face that is to be proved, and how many boxes that is expected to take, still."""

    face: Face
    low: Reals
    high: Reals
    expected: float


class SingleBox:
    """A box around the part of the closed states that holds an end (side 0 packed, 1 flat).

    states : (m, n), to which a walk from the end leads, the end first. others : (k, n), the same of the other end.
    seed : of estimates and further walks. search : tables of its own; aside : tables that others may use in between.
    Where a closed state is met on a face, the box is widened around what a walk from there leads to: of the other
    faces, what is proved stays so, and the strips that come to them are to be proved. If it would then hold one of the
    others, a face is moved inward instead, as the state is one of theirs.
    """

    cubes = 1

    def __init__(
        self, rings: Rings, side: int, states: Reals, others: Reals, seed: int, search: Refutation, aside: Refutation
    ) -> None:
        self.rings, self.side, self.states, self.others, self.seed = rings, side, states, others, seed
        self.search, self.aside = search, aside
        self.boxes, self.faces, self.going = 0, 0, True
        self.bounds = np.array([states[0], states[0]])
        self._parts: list[_Part] = []
        self._settled: set[Face] = set()
        self._searched: _Part | None = None
        self._sorted = 0
        self._settle(states)

    @property
    def taken_in(self) -> tuple[Reals, Reals]:
        """Lowest and highest angles of the box, (1, n) each."""
        return self.bounds[:1], self.bounds[1:]

    @property
    def boxes_expected(self) -> float:
        """How many boxes it will have taken at its end, about."""
        return self.boxes + sum(part.expected for part in self._parts)

    def go_on(self, boxes: int) -> bool:
        """Search its faces until it has taken so many boxes in all; whether all of them are proved."""
        while self.going and self._parts and self.boxes < boxes:
            part = self._parts[-1]
            if part is not self._searched:
                self._searched = part
                begin(self.rings, part.low, part.high, self.search)
            before = int(self.search.counts[TESTED])
            verdict = go_on(self.rings, before + min(SLICE, boxes - self.boxes), self.search)
            taken = int(self.search.counts[TESTED]) - before
            self.boxes += taken
            part.expected = max(part.expected - taken, 0.0)
            if verdict == CLOSED:
                self._searched = None  # the box that holds the state is no longer in the list of the search
                self._settle(self._walk_from(self.search.state.copy()))
            elif verdict == EMPTY:
                self._parts.remove(part)
            elif verdict != UNFINISHED:
                self.going = False
        return self.going and not self._parts

    def _settle(self, states: Reals) -> None:
        """Take in states, and all that Newton's method comes to on faces; then list what is to be proved of these."""
        waiting = [states]
        while waiting and self.going:
            self._sort_in(waiting.pop())
            for face in self._unsettled():
                state = self._met(face)
                if state is not None:
                    waiting.append(self._walk_from(state))
                    break
                self._add(face, *self._box_of(face))
                self._settled.add(face)
        self._parts.sort(key=lambda part: -part.expected)

    def _walk_from(self, state: Reals) -> Reals:
        """What a walk from a closed state that is met on a face leads to."""
        walked: Reals = wander(self.rings, state, MORE, self.seed, self.aside)
        return walked

    def _sort_in(self, states: Reals) -> None:
        """Take in states, or leave them out with the others, if the box would then hold one of these."""
        self._sorted += 1
        least, most = states.min(axis=0), states.max(axis=0)
        low = np.where(least < NEAR, 0.0, np.maximum(least - BESIDE, 0.0))
        high = np.where(most > math.pi - NEAR, TOP, np.minimum(most + BESIDE, TOP))
        wider = np.minimum(self.bounds[0], low), np.maximum(self.bounds[1], high)
        if self._sorted > 1 and self._held(wider).any():
            self.others = np.concatenate([self.others, states])
        else:
            self.states = np.concatenate([self.states, states])
            for hinge in range(len(least)):
                for side in (0, 1):
                    if wider[side][hinge] != self.bounds[side, hinge]:
                        self._move((hinge, side), float(wider[side][hinge]))
        self._leave_out()

    def _held(self, bounds: tuple[Reals, Reals] | Reals) -> NDArray[np.bool_]:
        """Which of the others lie between bounds."""
        within: NDArray[np.bool_] = np.all((bounds[0] <= self.others) & (self.others <= bounds[1]), axis=1)
        return within

    def _leave_out(self) -> None:
        """Move faces inward until the box holds none of the others; give up where it holds all around one."""
        low, high = self.states.min(axis=0), self.states.max(axis=0)
        while self.going and (held := self._held(self.bounds)).any():
            other = self.others[held.argmax()]
            gaps = np.array([low - other, other - high])
            side, hinge = np.unravel_index(gaps.argmax(), gaps.shape)
            self.going = bool(gaps[side, hinge] > LEAST and self._sorted <= MOST)
            face = int(hinge), int(side)
            self.bounds[side, hinge] = 0.5 * (other[hinge] + (low, high)[side][hinge])
            self._forget(face)
            self._clip()

    def _clip(self) -> None:
        """Leave out of what is to be proved what is no longer of the box."""
        for part in self._parts:
            part.low, part.high = np.maximum(part.low, self.bounds[0]), np.minimum(part.high, self.bounds[1])
        self._parts = [part for part in self._parts if (part.low <= part.high).all()]

    def _forget(self, face: Face) -> None:
        """What was proved of a face is of no use where it has moved."""
        self._settled.discard(face)
        self._parts = [part for part in self._parts if part.face != face]

    def _move(self, face: Face, level: float) -> None:
        """Move a face outward: it is to be proved anew, and of each other one the strip that comes to it."""
        hinge, side = face
        before, self.bounds[side, hinge] = float(self.bounds[side, hinge]), level
        self._forget(face)
        for other in sorted(self._settled):
            if other[0] != hinge:
                low, high = self._box_of(other)
                low[hinge], high[hinge] = min(level, before), max(level, before)
                self._add(other, low, high)

    def _unsettled(self) -> list[Face]:
        """Faces that are no stops and not yet listed."""
        faces = [(hinge, side) for hinge in range(self.bounds.shape[1]) for side in (0, 1)]
        return [face for face in faces if 0.0 < self.bounds[face[::-1]] < TOP and face not in self._settled]

    def _box_of(self, face: Face) -> tuple[Reals, Reals]:
        """The lowest and highest angles of a face."""
        low, high = self.bounds.copy()
        low[face[0]] = high[face[0]] = self.bounds[face[::-1]]
        return low, high

    def _met(self, face: Face) -> Reals | None:
        """A closed state on a face, by Newton's method from states of the walks near it; None where it meets none."""
        low, high = self._box_of(face)
        away = np.abs(self.states[:, face[0]] - low[face[0]])
        for number in np.argsort(away, kind="stable")[:STARTS]:
            state: Reals = np.clip(self.states[number], low, high)
            if meets(self.rings, low, high, state, self.aside):
                return state
        return None

    def _add(self, face: Face, low: Reals, high: Reals) -> None:
        """Add a part of a face to what is to be proved."""
        expected, verdict = estimate(self.rings, low, high, PROBES, self.seed, self.aside)
        self.faces += 1
        self._parts.append(_Part(face, low, high, expected if verdict == EMPTY else math.inf))
