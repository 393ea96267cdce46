"""A few boxes of fold angles around all states to which an end leads, if their faces hold no closed state.

Faces of wide boxes take many boxes of the search, but about how many is known beforehand; and unlike a flood of cubes,
such a region takes in no other part of the closed states for a cube that both have in common.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from functools import partial

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import (
    BOX_CLOSED,
    BOX_EMPTY,
    BOX_UNFINISHED,
    REFUTATION_TESTED_BOXES,
    Refutation,
    continue_refutation,
    estimate_box_count,
    reaches_closed_state,
    start_refutation,
)
from hcsearch.motion.locks.boxes import (
    MAX_BOX_ANGLE,
    Box,
    BoxFace,
    box_faces,
    boxes_outside,
    excess_over_box,
    region_around,
    whole_box,
)
from hcsearch.motion.locks.floods import BOXES_PER_KERNEL_CALL
from hcsearch.motion.locks.partition import BoxCuts, StateParts

REGION_CLIMB_STEPS = 300
"""Steps of each climb within a box."""
MAX_REGION_SAMPLES, FACE_NEWTON_STARTS = 20_000, 40
"""States of each part among which those near a face are looked for, and how many of these Newton's method starts at."""
FACE_PROBE_COUNT = 60
"""Branches by which the number of boxes is estimated that a face takes."""
MAX_FACE_BOXES = 4e6
"""A face that is expected to take more boxes is searched in halves: what a closed state undoes is less."""
MAX_NESTED_MET_STATES, MAX_MET_STATES = 100, 1000
"""Closed states that are met on faces until boxes within boxes are given up for cuts, and at most."""
MAX_STATES_BEFORE_RECUT = 60
"""Closed states that are met on faces before cuts are laid anew, at most."""
FACE_CLIMB_DISTANCE = 0.7
"""How far climbs from a state on a face lead away from that (rad)."""


@dataclass(eq=False)
class _Part:
    """A part of a face that is to be proved, and how many boxes that is expected to take, still."""

    face: BoxFace
    expected: float


class Region:
    """Boxes around the part of the closed states that holds an end (side 0 packed, 1 flat), and not the other end.

    states : (m, n), to which walks and climbs from the end lead. others : (k, n), the same of the other end.
    seed : of estimates and further walks. search, aside : tables of its own, for the search of a face, which is
    interrupted, and for what comes in between.
    Where a closed state is met on a face, what a walk from there leads to is added to the part to which small steps
    lead, or is a part by itself. Then boxes are laid anew; of their faces, what is proved stays so. They are boxes
    within boxes as long as some of these leave out the other end; parts by themselves are left out, or taken in if they
    cannot be left out. Afterwards all angles are cut into boxes, and all other parts are left out. A step of a walk,
    and one try of Newton's method, count as a box of the search, as they take about as long.
    """

    def __init__(
        self,
        rings: HingeRings,
        side: int,
        states: Reals,
        others: Reals,
        seed: int,
        search: Refutation,
        aside: Refutation,
    ) -> None:
        self.rings, self.side, self.seed = rings, side, seed
        self.search, self.aside = search, aside
        self.faces, self.going = 0, True
        self._parts = StateParts(rings, states, others, seed, aside)
        self._inside, self._last = {0}, 0
        self._cuts: BoxCuts | None = None
        self._region: list[Box] = []
        self._unprobed: list[BoxFace] = []
        self._waiting: list[_Part] = []
        self._searched: _Part | None = None
        self._proved: dict[tuple[int, float], list[Box]] = defaultdict(list)
        self._known: dict[bytes, float] = {}
        self._taken, self._met, self._new, self._expected = 0, 0, 0, math.inf

    @property
    def boxes(self) -> int:
        """Boxes of the search, and steps of walks."""
        return self._taken + self._parts.steps

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
        if self._unprobed or self._new or not self._region:
            return self._expected
        return self.boxes + sum(part.expected for part in self._waiting)

    def go_on(self, boxes: int) -> bool:
        """Search its faces until it has taken so many boxes in all; whether all of them are proved."""
        while self.going and self.boxes < boxes:
            if self._is_stale:
                self._lay_out()
            elif self._unprobed:
                self._probe(self._unprobed.pop())
            elif self._waiting:
                self._search(self._searched or min(self._waiting, key=lambda part: part.expected), boxes)
            else:
                return True
        return False

    @property
    def _is_stale(self) -> bool:
        """Whether boxes are to be laid anew.

        Boxes within boxes are after each state that is met; cuts after AT_ONCE of them, or when all faces were probed,
        as that moves all faces.
        """
        if self._cuts is None:
            return self._new > 0 or not self._region
        return self._new == MAX_STATES_BEFORE_RECUT or (self._new > 0 and not self._unprobed)

    def _lay_out(self) -> None:
        """Lay boxes around the parts that are taken in; then list what is to be proved of their faces."""
        self._region = self._boxes() or []
        self._new = 0
        self.going = bool(self._region) and self._met < MAX_MET_STATES
        self._unprobed, self._waiting, self._searched = [], [], None
        for face in box_faces(self._region, MAX_BOX_ANGLE):
            proved = self._proved[face.hinge, face.level]
            for part in boxes_outside([(face.low, face.high)], proved):
                self._list(BoxFace(face.hinge, *part))

    def _boxes(self) -> list[Box] | None:
        """Boxes within boxes, or by cuts where there are none, or closed states were met on too many of their faces."""
        if self._cuts is None and self._met < MAX_NESTED_MET_STATES:
            region = self._boxes_within_boxes()
            if region is None and self._last > 1:
                self._inside ^= {self._last}
                region = self._boxes_within_boxes()
            if region is not None:
                return region
        self._cuts = self._cuts or BoxCuts()
        own, *others = self._parts.states
        return self._cuts.lay(own, np.concatenate(others))

    def _boxes_within_boxes(self) -> list[Box] | None:
        """Boxes within boxes around the parts that are taken in, without the others; None where there are none."""
        states = self._parts.states
        own = [states[number] for number in sorted(self._inside)]
        others = [part for number, part in enumerate(states) if number not in self._inside]
        return region_around(np.concatenate(own), others, partial(self._parts.climbed, steps=REGION_CLIMB_STEPS))

    def _list(self, face: BoxFace) -> None:
        """List a face as one to be probed, or to be searched if it was probed before; or its halves, as by then."""
        expected = self._known.get(_key(face))
        if expected is None:
            self._unprobed.append(face)
        elif expected > MAX_FACE_BOXES:
            for half in face.halves():
                self._list(half)
        else:
            self._waiting.append(_Part(face, expected))

    def _probe(self, face: BoxFace) -> None:
        """Look for a closed state on a face; without one, list it with the boxes that it is to take."""
        if self._meets_at(face):
            self._take_in(self.aside.state.copy(), face)
            return
        expected, verdict, tested = estimate_box_count(
            self.rings, face.low, face.high, FACE_PROBE_COUNT, self.seed, self.aside
        )
        self._taken += tested
        if verdict == BOX_CLOSED:
            self._take_in(self.aside.state.copy(), face)
        elif verdict == BOX_EMPTY:
            self._known[_key(face)] = expected
            self._list(face)
        else:
            self.going = False

    def _meets_at(self, face: BoxFace) -> bool:
        """Whether Newton's method comes to a closed state on a face, `aside.state`, from states near it."""
        for part in self._parts.states:
            states = part[:: len(part) // MAX_REGION_SAMPLES + 1]
            away = excess_over_box((face.low, face.high), states).max(axis=1)
            for number in np.argsort(away, kind="stable")[:FACE_NEWTON_STARTS]:
                self.aside.state[:] = np.clip(states[number], face.low, face.high)
                self._taken += 1
                if reaches_closed_state(self.rings, face.low, face.high, self.aside.state, self.aside):
                    return True
        return False

    def _search(self, part: _Part, boxes: int) -> None:
        """Search a part of a face on, until it has taken so many boxes in all."""
        face = part.face
        self._expected = self.boxes_expected
        if part is not self._searched:
            self._searched = part
            self.faces += 1
            if self._cuts is not None:
                self._cuts.keep()
            start_refutation(self.rings, face.low, face.high, self.search)
        before = int(self.search.counts[REFUTATION_TESTED_BOXES])
        verdict = continue_refutation(self.rings, before + min(BOXES_PER_KERNEL_CALL, boxes - self.boxes), self.search)
        taken = int(self.search.counts[REFUTATION_TESTED_BOXES]) - before
        self._taken += taken
        part.expected = max(part.expected - taken, 0.0)
        if verdict == BOX_CLOSED:
            self._take_in(self.search.state.copy(), face)
        elif verdict == BOX_EMPTY:
            self._waiting.remove(part)
            self._searched = None
            self._proved[face.hinge, face.level].append((face.low, face.high))
        elif verdict != BOX_UNFINISHED:
            self.going = False

    def _take_in(self, state: Reals, face: BoxFace) -> None:
        """Add a closed state that is met on a face, and what a walk from there leads to, to its part."""
        low, high = whole_box(self.rings.hinge_count)
        if self._cuts is not None:  # so many are met that climbs as far as they lead take too long
            low[face.hinge] = max(face.level - FACE_CLIMB_DISTANCE, 0.0)
            high[face.hinge] = min(face.level + FACE_CLIMB_DISTANCE, MAX_BOX_ANGLE)
        self._last = self._parts.add(state, (low, high))
        self._met += 1
        self._new += 1


def _key(face: BoxFace) -> bytes:
    """What tells a face from others."""
    return face.low.tobytes() + face.high.tobytes()
