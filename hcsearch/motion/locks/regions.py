"""Regions of few boxes of fold angles, which enclose all states that an end leads to if no face holds a closed state.

Faces of wide boxes take many boxes of the search, but their number can be estimated beforehand; and unlike a flood of
cubes, such a region does not include another part of the closed states because of a common cube.

Parts are far apart, but a hundred thousand states sample a part of six degrees of freedom so sparsely that the nearest
state may be of another part. So a state belongs to a part if small steps lead from it to a state of that part.
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
from hcsearch.kernels.enclosure.wandering import approach_goal, climb_angles, random_walk
from hcsearch.motion.locks.boxes import (
    MAX_BOX_ANGLE,
    Box,
    BoxCuts,
    BoxFace,
    box_faces,
    boxes_outside,
    excess_over_box,
    region_around,
    states_in,
    whole_box,
)
from hcsearch.motion.locks.floods import BOXES_PER_KERNEL_CALL
from hcsearch.motion.searching import Budget, SteppedSearch

PART_WALK_STEPS, PART_CLIMB_STEPS = 2000, 200
"""Steps of the walk from a state, and of each climb from there."""
MAX_APPROACH_STEPS, APPROACH_ROUNDS = 1000, 3
"""Maximum number of steps towards the nearest state of a part, and number of times that it is chosen anew."""
NEAREST_PART_COUNT = 3
"""Number of parts that are approached: the parts with the nearest states."""
ARRIVED_DISTANCE = 0.05
"""A state is reached from within this distance (rad, root of the sum of squares)."""
APPROACH_START_COUNT = 3
"""Number of starts of an approach: the new state first, then states of the walk from it."""


class StateParts:
    """Parts of the closed states: the first holds the end that is to be enclosed, the second the other end.

    part, other_part : (m, n), states of walks from both ends. seed : of further walks. tables : of the kernels.
    steps : total number of steps of walks, counted like boxes of the search.
    """

    def __init__(self, rings: HingeRings, part: Reals, other_part: Reals, seed: int, tables: Refutation) -> None:
        self.rings, self.seed, self.tables = rings, seed, tables
        self.states = [part, other_part]
        self.steps = 0

    def climb_within(self, states: Reals, box: Box, steps: int) -> Reals:
        """Extend states by climbs from them within a box."""
        climbed: Reals = climb_angles(self.rings, states, *box, steps, self.seed, self.tables)
        self.steps += len(climbed) - len(states)
        return climbed

    def add_state(self, state: Reals, box: Box) -> int:
        """Add a closed state, (n,), and states of a walk and of climbs in a box from it; return the number of its part.

        It is a new part where no approach reaches a known one, from `APPROACH_START_COUNT` starts to
        `NEAREST_PART_COUNT` parts in `APPROACH_ROUNDS` rounds of `MAX_APPROACH_STEPS`.
        """
        walked = random_walk(self.rings, state, PART_WALK_STEPS, self.seed, self.tables)
        self.steps += PART_WALK_STEPS
        inside = states_in(box, walked)
        new_states = [walked, self.climb_within(inside, box, PART_CLIMB_STEPS)[len(inside) :]]
        for start in (state, *walked[:: len(walked) // APPROACH_START_COUNT + 1][1:]):
            number = self._reached_part(start, new_states)
            if number is not None:
                self.states[number] = np.concatenate([self.states[number], *new_states])
                return number
        self.states.append(np.concatenate(new_states))
        return len(self.states) - 1

    def _reached_part(self, state: Reals, new_states: list[Reals]) -> int | None:
        """The part that small steps from a state reach, or None; append the states on the way to `passed`."""
        order = np.argsort([_nearest(part, state)[1] for part in self.states], kind="stable")
        for number in order[:NEAREST_PART_COUNT].tolist():
            position = state
            for attempt in range(APPROACH_ROUNDS):
                goal = self.states[number][_nearest(self.states[number], position)[0]]
                states, steps = approach_goal(
                    self.rings, position, goal, MAX_APPROACH_STEPS, self.seed + attempt, self.tables
                )
                self.steps += steps
                new_states.append(states)
                position = states[-1]
                if float(((position - goal) ** 2).sum()) < ARRIVED_DISTANCE**2:
                    return int(number)
        return None


def _nearest(states: Reals, state: Reals) -> tuple[int, float]:
    """The number of the nearest neighbour of a state, (n,), among others, (m, n), and its squared distance."""
    squares = ((states - state) ** 2).sum(axis=1)
    number = int(squares.argmin())
    return number, float(squares[number])


REGION_CLIMB_STEPS = 300
"""Steps of each climb within a box."""
MAX_REGION_SAMPLES, FACE_NEWTON_STARTS = 20_000, 40
"""Maximum number of states of each part among which the nearest to a face are sought, and number of these at which
Newton's method starts."""
FACE_PROBE_COUNT = 60
"""Number of random branches for the estimate of the boxes that a face takes."""
MAX_FACE_BOXES = 4e6
"""A face that is expected to take more boxes is searched in halves, so that a closed state voids less work."""
MAX_NESTED_MET_STATES, MAX_MET_STATES = 100, 1000
"""Numbers of closed states met on faces at which nested boxes are given up for cuts, and the region altogether."""
MAX_STATES_BEFORE_RECUT = 60
"""Maximum number of closed states met on faces before cuts are laid anew."""
FACE_CLIMB_DISTANCE = 0.7
"""Maximum distance (rad) of climbs from a state on a face along the face's hinge."""


@dataclass(eq=False)
class _FacePart:
    """A part of a face that is to be proved, and the estimated number of boxes that this still takes."""

    face: BoxFace
    expected: float


class Region(SteppedSearch[bool]):
    """Boxes around the part of the closed states that holds an end (side 0 packed, 1 flat), and not the other end.

    Its efforts are boxes; its result is whether all faces are proved.

    states, others : states of walks and climbs from the end, (m, n), and from the other end, (k, n).
    seed : of estimates and further walks. search, probe_tables : its own tables, for the search of a face, which may be
    interrupted, and for computations in between.
    Where a closed state is met on a face, the states of a walk from there are added to the part that small steps reach,
    or form a new part. Then boxes are laid anew; proved parts of faces stay proved. Boxes are nested as long as nested
    boxes exclude the other end; new parts are excluded, or included if they cannot be excluded. Afterwards all angles
    are cut into boxes, and all other parts are excluded. A step of a walk, and one trial of Newton's method, count as a
    box of the search, as they take about as long.
    """

    def __init__(
        self,
        rings: HingeRings,
        side: int,
        states: Reals,
        others: Reals,
        seed: int,
        search: Refutation,
        probe_tables: Refutation,
    ) -> None:
        self.rings, self.side, self.seed = rings, side, seed
        self.search, self.probe_tables = search, probe_tables
        self.faces, self._given_up = 0, False
        self._parts = StateParts(rings, states, others, seed, probe_tables)
        self._inside_parts, self._last_part = {0}, 0
        self._cuts: BoxCuts | None = None
        self._region: list[Box] = []
        self._unprobed: list[BoxFace] = []
        self._waiting: list[_FacePart] = []
        self._searched: _FacePart | None = None
        self._proved: dict[tuple[int, float], list[Box]] = defaultdict(list)
        self._expected_by_face: dict[bytes, float] = {}
        self._boxes_taken, self._met_count, self._new_count, self._expected = 0, 0, 0, math.inf

    @property
    def efforts(self) -> int:
        """Number of boxes tested plus steps of walks."""
        return self._boxes_taken + self._parts.steps

    @property
    def cubes(self) -> int:
        """Number of boxes of the region."""
        return len(self._region)

    @property
    def bounds(self) -> tuple[Reals, Reals]:
        """Lowest and highest angles of the boxes, (cubes, n) each."""
        low, high = zip(*self._region, strict=True)
        return np.array(low), np.array(high)

    @property
    def boxes_expected(self) -> float:
        """Estimate of the total number of boxes at the end; infinite until all faces were probed once.

        After boxes were laid anew, the former estimate holds until all faces are probed again.
        """
        if self._unprobed or self._new_count or not self._region:
            return self._expected
        return self.efforts + sum(part.expected for part in self._waiting)

    @property
    def result(self) -> bool:
        """Whether all faces are proved."""
        return not (self._given_up or self._is_stale or self._unprobed or self._waiting)

    @property
    def done(self) -> bool:
        """Whether all faces are proved, or the region is given up."""
        return self._given_up or self.result

    def step(self, budget: Budget) -> None:
        """Lay boxes, probe a face, or go on with the search of a part of one."""
        if self._is_stale:
            self._lay_out()
        elif self._unprobed:
            self._probe(self._unprobed.pop())
        else:
            self._search(self._searched or min(self._waiting, key=lambda part: part.expected), budget)

    @property
    def _is_stale(self) -> bool:
        """Whether boxes must be laid anew.

        Nested boxes are laid anew after each new state; cuts after `MAX_STATES_BEFORE_RECUT` of them, or when all faces
        were probed, as that moves all faces.
        """
        if self._cuts is None:
            return self._new_count > 0 or not self._region
        return self._new_count == MAX_STATES_BEFORE_RECUT or (self._new_count > 0 and not self._unprobed)

    def _lay_out(self) -> None:
        """Lay boxes around the parts that are included; then list the parts of their faces that are not yet proved."""
        self._region = self._new_boxes() or []
        self._new_count = 0
        self._given_up = not self._region or self._met_count >= MAX_MET_STATES
        self._unprobed, self._waiting, self._searched = [], [], None
        for face in box_faces(self._region, MAX_BOX_ANGLE):
            proved = self._proved[face.hinge, face.level]
            for part in boxes_outside([(face.low, face.high)], proved):
                self._enqueue(BoxFace(face.hinge, *part))

    def _new_boxes(self) -> list[Box] | None:
        """Nested boxes, or cuts where there are none, or where too many closed states were met on faces."""
        if self._cuts is None and self._met_count < MAX_NESTED_MET_STATES:
            region = self._nested_boxes()
            if region is None and self._last_part > 1:
                self._inside_parts ^= {self._last_part}
                region = self._nested_boxes()
            if region is not None:
                return region
        self._cuts = self._cuts or BoxCuts()
        part, *other_parts = self._parts.states
        return self._cuts.boxes_around(part, np.concatenate(other_parts))

    def _nested_boxes(self) -> list[Box] | None:
        """Nested boxes around the parts that are included, without the others; None where there are none."""
        states = self._parts.states
        included = [states[number] for number in sorted(self._inside_parts)]
        excluded = [part for number, part in enumerate(states) if number not in self._inside_parts]
        return region_around(
            np.concatenate(included), excluded, partial(self._parts.climb_within, steps=REGION_CLIMB_STEPS)
        )

    def _enqueue(self, face: BoxFace) -> None:
        """Enqueue a face for probing, or for search if its number of boxes is known; halve it if that is too great."""
        expected = self._expected_by_face.get(_key(face))
        if expected is None:
            self._unprobed.append(face)
        elif expected > MAX_FACE_BOXES:
            for half in face.halves():
                self._enqueue(half)
        else:
            self._waiting.append(_FacePart(face, expected))

    def _probe(self, face: BoxFace) -> None:
        """Search for a closed state on a face; without one, enqueue it with an estimate of its boxes."""
        if self._finds_closed_state(face):
            self._take_in(self.probe_tables.state.copy(), face)
            return
        expected, verdict, tested = estimate_box_count(
            self.rings, face.low, face.high, FACE_PROBE_COUNT, self.seed, self.probe_tables
        )
        self._boxes_taken += tested
        if verdict == BOX_CLOSED:
            self._take_in(self.probe_tables.state.copy(), face)
        elif verdict == BOX_EMPTY:
            self._expected_by_face[_key(face)] = expected
            self._enqueue(face)
        else:
            self._given_up = True

    def _finds_closed_state(self, face: BoxFace) -> bool:
        """Whether Newton's method from states near a face finds a closed state on it, kept in `probe_tables.state`."""
        for part in self._parts.states:
            states = part[:: len(part) // MAX_REGION_SAMPLES + 1]
            excess = excess_over_box((face.low, face.high), states).max(axis=1)
            for number in np.argsort(excess, kind="stable")[:FACE_NEWTON_STARTS]:
                self.probe_tables.state[:] = np.clip(states[number], face.low, face.high)
                self._boxes_taken += 1
                if reaches_closed_state(self.rings, face.low, face.high, self.probe_tables.state, self.probe_tables):
                    return True
        return False

    def _search(self, part: _FacePart, budget: Budget) -> None:
        """Continue the search of a part of a face, within a budget of the region."""
        face = part.face
        self._expected = self.boxes_expected
        if part is not self._searched:
            self._searched = part
            self.faces += 1
            if self._cuts is not None:
                self._cuts.freeze()
            start_refutation(self.rings, face.low, face.high, self.search)
        tested_before = int(self.search.counts[REFUTATION_TESTED_BOXES])
        left = int(min(BOXES_PER_KERNEL_CALL, budget.efforts - self.efforts))
        verdict = continue_refutation(self.rings, tested_before + left, self.search)
        tested = int(self.search.counts[REFUTATION_TESTED_BOXES]) - tested_before
        self._boxes_taken += tested
        part.expected = max(part.expected - tested, 0.0)
        if verdict == BOX_CLOSED:
            self._take_in(self.search.state.copy(), face)
        elif verdict == BOX_EMPTY:
            self._waiting.remove(part)
            self._searched = None
            self._proved[face.hinge, face.level].append((face.low, face.high))
        elif verdict != BOX_UNFINISHED:
            self._given_up = True

    def _take_in(self, state: Reals, face: BoxFace) -> None:
        """Add to its part a closed state that is met on a face, and the states that a walk reaches from there."""
        low, high = whole_box(self.rings.hinge_count)
        if self._cuts is not None:  # with so many met states, unlimited climbs take too long
            low[face.hinge] = max(face.level - FACE_CLIMB_DISTANCE, 0.0)
            high[face.hinge] = min(face.level + FACE_CLIMB_DISTANCE, MAX_BOX_ANGLE)
        self._last_part = self._parts.add_state(state, (low, high))
        self._met_count += 1
        self._new_count += 1


def _key(face: BoxFace) -> bytes:
    """A key that identifies a face."""
    return face.low.tobytes() + face.high.tobytes()
