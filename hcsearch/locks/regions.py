"""A few boxes of fold angles around all states to which an end leads, if their faces hold no closed state.

Faces of wide boxes take many boxes of the search, but about how many is known beforehand; and unlike a flood of cubes,
such a region takes in no other part of the closed states for a cube that both have in common.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from functools import partial
from itertools import compress

import numpy as np

from hcsearch.kernels.enclosure.estimates import estimate
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.refutation import CLOSED, EMPTY, TESTED, UNFINISHED, Refutation, begin, go_on, meets
from hcsearch.kernels.enclosure.wandering import climb, wander
from hcsearch.locks.boxes import TOP, Box, Face, beyond, faces_of, outside, whole
from hcsearch.locks.floods import SLICE
from hcsearch.locks.layouts import region_around
from hcsearch.typing import Reals

MORE, FEWER = 2000, 200
"""Steps of the walk from a closed state that is met on a face, and of each climb from it."""
WITHIN = 300
"""Steps of each climb within a box."""
SAME = 0.25
"""Walks that come so near to each other (rad) are taken for walks in one part of the closed states."""
SAMPLE = 60
"""States of a walk by which that is seen."""
SEEN, STARTS = 20_000, 40
"""States of each part among which those near a face are looked for, and how many of these Newton's method starts at."""
PROBES = 60
"""Branches by which the number of boxes is estimated that a face takes."""
PIECE = 4e6
"""A face that is expected to take more boxes is searched in halves: what a closed state undoes is less."""
MOST = 100
"""Closed states that are met on faces, at most."""


@dataclass(eq=False)
class _Part:
    """A part of a face that is to be proved, and how many boxes that is expected to take, still."""

    face: Face
    expected: float


class Region:
    """Boxes around the part of the closed states that holds an end (side 0 packed, 1 flat), and around no other part.

    states : (m, n), to which walks and climbs from the end lead. others : (k, n), the same of the other end.
    seed : of estimates and further walks. search : tables of its own; aside : tables that others may use in between.
    Where a closed state is met on a face, what a walk from there leads to is added to the part that it comes near, or
    is a part by itself, which is left out, or taken in if it cannot be left out. Then boxes are laid anew; of their
    faces, what is proved stays so. A step of a walk, and one try of Newton's method, count
    as a box of the search, as they take about as long.
    """

    def __init__(
        self, rings: Rings, side: int, states: Reals, others: Reals, seed: int, search: Refutation, aside: Refutation
    ) -> None:
        self.rings, self.side, self.seed = rings, side, seed
        self.search, self.aside = search, aside
        self.boxes, self.faces, self.going = 0, 0, True
        self._parts, self._inside = [states, others], [True, False]
        self._region: list[Box] = []
        self._unprobed: list[Face] = []
        self._waiting: list[_Part] = []
        self._searched: _Part | None = None
        self._proved: dict[tuple[int, float], list[Box]] = defaultdict(list)
        self._known: dict[bytes, float] = {}
        self._met, self._expected = 0, math.inf

    @property
    def cubes(self) -> int:
        """Of how many boxes it consists."""
        return len(self._region)

    @property
    def taken_in(self) -> tuple[Reals, Reals]:
        """Lowest and highest angles of its boxes, (cubes, n) each."""
        low, high = zip(*self._region, strict=True)
        return np.array(low), np.array(high)

    @property
    def boxes_expected(self) -> float:
        """How many boxes it will have taken at its end, about; infinite until all faces were probed once.

        Where boxes were laid anew, those that were expected before, until all faces are probed again.
        """
        if self._unprobed or not self._region:
            return self._expected
        return self.boxes + sum(part.expected for part in self._waiting)

    def go_on(self, boxes: int) -> bool:
        """Search its faces until it has taken so many boxes in all; whether all of them are proved."""
        while self.going and self.boxes < boxes:
            if not self._region:
                self._lay_out()
                self.going = bool(self._region)
            elif self._unprobed:
                self._probe(self._unprobed.pop())
            elif self._waiting:
                self._search(self._searched or min(self._waiting, key=lambda part: part.expected), boxes)
            else:
                return True
        return False

    def _lay_out(self) -> None:
        """Lay boxes around the parts that are taken in; then list what is to be proved of their faces."""
        self._expected = self.boxes_expected
        own = list(compress(self._parts, self._inside))
        others = list(compress(self._parts, (not inside for inside in self._inside)))
        reach = partial(self._climbed, steps=WITHIN)
        self._region = region_around(np.concatenate(own), others, reach) or []
        self._unprobed, self._waiting, self._searched = [], [], None
        for face in faces_of(self._region, TOP):
            proved = self._proved[face.hinge, face.level]
            for part in outside([(face.low, face.high)], proved):
                self._list(Face(face.hinge, *part))

    def _list(self, face: Face) -> None:
        """List a face as one to be probed, or to be searched if it was probed before."""
        expected = self._known.get(_key(face))
        if expected is None:
            self._unprobed.append(face)
        else:
            self._waiting.append(_Part(face, expected))

    def _climbed(self, states: Reals, box: Box, steps: int) -> Reals:
        """States, and those to which climbs from them lead, within a box."""
        climbed: Reals = climb(self.rings, states, *box, steps, self.seed, self.aside)
        self.boxes += len(climbed) - len(states)
        return climbed

    def _probe(self, face: Face) -> None:
        """Look for a closed state on a face; without one, list it, or its halves, with the boxes it is to take."""
        if self._meets_at(face):
            self._take_in(self.aside.state.copy())
            return
        expected, verdict, tested = estimate(self.rings, face.low, face.high, PROBES, self.seed, self.aside)
        self.boxes += tested
        if verdict == CLOSED:
            self._take_in(self.aside.state.copy())
        elif verdict == EMPTY and expected > PIECE:
            self._unprobed += face.halves()
        else:
            self.going = verdict == EMPTY
            self._known[_key(face)] = expected
            self._waiting.append(_Part(face, expected))

    def _meets_at(self, face: Face) -> bool:
        """Whether Newton's method comes to a closed state on a face, `aside.state`, from states near it."""
        for part in self._parts:
            states = part[:: len(part) // SEEN + 1]
            away = beyond((face.low, face.high), states).max(axis=1)
            for number in np.argsort(away, kind="stable")[:STARTS]:
                self.aside.state[:] = np.clip(states[number], face.low, face.high)
                self.boxes += 1
                if meets(self.rings, face.low, face.high, self.aside.state, self.aside):
                    return True
        return False

    def _search(self, part: _Part, boxes: int) -> None:
        """Search a part of a face on, until it has taken so many boxes in all."""
        face = part.face
        if part is not self._searched:
            self._searched = part
            self.faces += 1
            begin(self.rings, face.low, face.high, self.search)
        before = int(self.search.counts[TESTED])
        verdict = go_on(self.rings, before + min(SLICE, boxes - self.boxes), self.search)
        taken = int(self.search.counts[TESTED]) - before
        self.boxes += taken
        part.expected = max(part.expected - taken, 0.0)
        if verdict == CLOSED:
            self._take_in(self.search.state.copy())
        elif verdict == EMPTY:
            self._waiting.remove(part)
            self._searched = None
            self._proved[face.hinge, face.level].append((face.low, face.high))
        elif verdict != UNFINISHED:
            self.going = False

    def _take_in(self, state: Reals) -> None:
        """Add what a walk from a closed state leads to to the part that it comes near, and lay boxes anew."""
        self._met += 1
        walked = wander(self.rings, state, MORE, self.seed, self.aside)
        self.boxes += MORE
        walked = self._climbed(walked, whole(self.rings.folds), FEWER)
        distances = [_distance(walked, part) for part in self._parts]
        number = int(np.argmin(distances))
        if distances[number] > SAME:
            number = len(self._parts)
            self._parts.append(walked)
            self._inside.append(False)
        else:
            self._parts[number] = np.concatenate([self._parts[number], walked])
        self._lay_out()
        if not self._region and number > 1:
            self._inside[number] = not self._inside[number]
            self._lay_out()
        self.going = bool(self._region) and self._met < MOST


def _distance(walked: Reals, part: Reals) -> float:
    """How near a walk comes to a part, as far as some of its states show (rad)."""
    some = np.concatenate([walked[:1], walked[:: len(walked) // SAMPLE + 1]])
    return min(float(np.abs(part - state).max(axis=1).min()) for state in some)


def _key(face: Face) -> bytes:
    """What tells a face from others."""
    return face.low.tobytes() + face.high.tobytes()
