"""Locks between the ends: proofs that a linkage never leaves a part of its states, by closed loops and stops alone.

Fold angles from 0 to pi are cut into cubes, and a flood takes in those that a motion from a closed state may reach; or
a region of few boxes is laid around them. If it holds one end alone, and its faces no closed state, no motion of the
linkage leads to the other one, at any margin, though panels may pass through each other (docs/explanation/locks.md).
Where that does not keep the ends apart, panels may: at margins up to one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.vocabulary import MOTION_ENDS, MotionEnd
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.kernels.enclosure.refutation import Refutation, new_refutation, refutation_with
from hcsearch.kernels.enclosure.wandering import climb_angles, random_walk
from hcsearch.motion.locks.boxes import whole_box
from hcsearch.motion.locks.floods import expected_cube_counts, floods_from
from hcsearch.motion.locks.regions import Region
from hcsearch.shape.linkage import Linkage

FIRST_TURN_BOXES = 2500
"""Boxes of the first turn of each contender; each turn ends at twice as many."""
WALK_SCHEDULE = (
    (10_000, 10_000),
    (50_000, 100_000),
    (250_000, 500_000),
    (250_000, 2_500_000),
    (250_000, 12_500_000),
    (250_000, 62_500_000),
)
"""Steps of random walks from either end, and after how many boxes these are due: at once, if nothing else goes on. They
show how many cubes are to be filled, about, and regions are laid around them; the later ones where those around earlier
ones are given up."""
TRAILING_BOX_WEIGHT = 20
"""What boxes of contenders count for that are expected to end later than the first, as turns are given."""
UNSETTLED_BOXES_AND_WEIGHT = 300_000, 4
"""Boxes after which something should be expected of a contender, and what its boxes count for where nothing is."""
WALK_CLIMB_STEPS = 1000
"""Steps of each climb from a walk."""
FIRST_WALK_SEED = 1
"""Of the first walks."""


@dataclass(frozen=True, eq=False)
class Enclosure(ByValue):
    """What floods and regions of few boxes around the ends of the motion came to.

    end : the end that no motion leaves for the other one; None where that is not proved. cubes, faces : cubes, or boxes
    of a region, that hold whatever a motion from that end can reach, and faces that were tested for it; of all of them
    where nothing is proved. boxes : of the search, of all. open : whether more boxes may prove more; not where each
    flood came to the other end and no region is left, or where there is no loop. lows, highs : (cubes, k), of the cubes
    where a lock is proved, rad; of the k hinges that are in a loop. margin : m, the greatest at which a lock holds that
    panels have a part in; None where it holds at every margin.
    """

    end: MotionEnd | None
    cubes: int
    faces: int
    boxes: int
    open: bool
    margin: float | None = None
    lows: Reals = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    highs: Reals = field(default_factory=lambda: np.zeros((0, 0)), repr=False)

    @property
    def proved(self) -> bool:
        """Whether the linkage is proved never to come from one end to the other."""
        return self.end is not None


class _Contender(Protocol):
    """What may enclose an end: a flood, or a region of few boxes."""

    side: int
    going: bool

    @property
    def boxes(self) -> int: ...
    @property
    def cubes(self) -> int: ...
    @property
    def faces(self) -> int: ...
    @property
    def boxes_expected(self) -> float: ...
    @property
    def taken_in(self) -> tuple[Reals, Reals]: ...
    def go_on(self, boxes: int) -> bool: ...


def enclose_ends(linkage: Linkage, boxes: int, plates: Plates | None = None) -> Enclosure:
    """Look for a proof that closed loops and stops keep the packed and the flat state of a linkage apart.

    boxes : how many boxes all contenders may take together, about. These take turns: coarse and fine floods from either
    end, and later a region of few boxes around either end; that which is expected to end first has most of the boxes.
    The first that ends without the other end is the proof, which is the same whatever the number of boxes. It holds for
    panels with any margin, with or without collisions, and for the joints of this linkage alone: what is locked with
    hinged flat pairs is locked with rigid and with merged ones, too (docs/explanation/locks.md). Source: ours.
    plates : those of `plates_of`, where panels do not pass through each other; then it holds at their margin and below.
    """
    if not linkage.loops:
        return Enclosure(None, 0, 0, 0, open=False)
    rings, hinges = rings_of(linkage)
    contest = _Contest(rings, (linkage.folded[hinges], linkage.flat[hinges]), plates)
    while contest.boxes < boxes:
        if contest.is_due:
            if not contest.walk(boxes):
                break
        elif not contest.going:
            return contest.summary(open_=False)
        elif (proof := contest.next_turn(boxes)) is not None:
            lows, highs = proof.taken_in
            margin = None if plates is None else plates.margin
            return Enclosure(
                MOTION_ENDS[proof.side], proof.cubes, proof.faces, contest.boxes, False, margin, lows=lows, highs=highs
            )
    return contest.summary(open_=True)


class _Contest:
    """What may enclose one of the ends, and whose turn it is."""

    def __init__(self, rings: HingeRings, ends: tuple[Reals, Reals], plates: Plates | None) -> None:
        self.rings, self.ends, self.plates = rings, ends, plates
        self.aside = self._tables()
        self.floods = floods_from(rings, ends, self._tables)
        self.regions: list[Region] = []
        self._walked, self._steps = 0, 0

    def _tables(self) -> Refutation:
        return new_refutation(self.rings) if self.plates is None else refutation_with(self.rings, self.plates)

    @property
    def contenders(self) -> list[_Contender]:
        """All of them, those that were given up, too."""
        return [*self.floods, *self.regions]

    @property
    def boxes(self) -> int:
        """Boxes that all have taken together, and steps of walks, which take about as long."""
        return self._steps + sum(contender.boxes for contender in self.contenders)

    @property
    def going(self) -> list[_Contender]:
        """Those that have not ended."""
        return [contender for contender in self.contenders if contender.going]

    @property
    def is_due(self) -> bool:
        """Whether walks are due: at once if nothing else goes on, where regions may."""
        if self._walked == len(WALK_SCHEDULE):
            return False
        return self.boxes >= WALK_SCHEDULE[self._walked][1] or (self.plates is None and not self.going)

    def walk(self, boxes: int) -> bool:
        """Make the walks that are due, and use them; whether so many boxes of all allow them."""
        sides = [side for side in (0, 1) if not any(region.going for region in self.regions if region.side == side)]
        steps, seed = WALK_SCHEDULE[self._walked][0], FIRST_WALK_SEED + self._walked
        if sides and self.boxes + len(self.ends) * steps > boxes:
            return False
        self._walked += 1
        if sides:
            walks = [random_walk(self.rings, end, steps, seed, self.aside) for end in self.ends]
            self._steps += len(self.ends) * steps
            expected = [expected_cube_counts(walk) for walk in walks]
            for flood in self.floods:
                flood.cubes_expected = expected[flood.side][flood.level]
            if self.plates is None:  # with panels, regions led to no proof
                self._lay_around(walks, sides, seed)
        return True

    def _lay_around(self, walks: list[Reals], sides: list[int], seed: int) -> None:
        """Lay regions around walks from either end."""
        seen = [
            climb_angles(self.rings, walk, *whole_box(self.rings.hinge_count), WALK_CLIMB_STEPS, seed, self.aside)
            for walk in walks
        ]
        self.regions += [
            Region(self.rings, side, seen[side], seen[1 - side], seed, self._tables(), self._tables()) for side in sides
        ]

    def next_turn(self, boxes: int) -> _Contender | None:
        """Let one go on, up to so many boxes of all; it, if it has proved its end to be enclosed."""
        spent, going = self.boxes, self.going
        first = min(going, key=lambda own: own.boxes_expected)
        chosen = min(going, key=lambda own: max(own.boxes, FIRST_TURN_BOXES) * (1 if own is first else _weight(own)))
        ended = chosen.go_on(chosen.boxes + min(max(FIRST_TURN_BOXES, chosen.boxes), boxes - spent))
        return chosen if ended else None

    def summary(self, *, open_: bool) -> Enclosure:
        """What all have come to where none has ended without the other end."""
        cubes, faces = (sum(getattr(own, name) for own in self.contenders) for name in ("cubes", "faces"))
        return Enclosure(None, cubes, faces, self.boxes, open_)


def _weight(own: _Contender) -> int:
    """What boxes of a contender that is not the first are multiplied by; 1 at first, where nothing is expected yet."""
    if math.isfinite(own.boxes_expected):
        return TRAILING_BOX_WEIGHT
    return 1 if own.boxes < UNSETTLED_BOXES_AND_WEIGHT[0] else UNSETTLED_BOXES_AND_WEIGHT[1]


def rings_of(linkage: Linkage) -> tuple[HingeRings, WholeNumbers]:
    """The loops of a linkage as the kernels take them, and the hinges that are in a loop, in whose order those count.

    Lengths are in sizes of the pattern, and places about the middle of each loop, so that no bound hangs on where it
    lies.
    """
    own = linkage.looped
    number = {int(hinge): k for k, hinge in enumerate(own)}
    points, size = linkage.points, linkage.pattern.size
    hinges, directions, places = [], [], []
    for loop in linkage.loops:
        about = np.mean([points[hinge] for hinge, _ in loop], axis=0)
        for hinge, sign in loop:
            hinges.append(number[hinge])
            directions.append(sign * linkage.directions[hinge])
            places.append((points[hinge] - about) / size)
    lines = np.array(directions).reshape(-1, 3), np.array(places).reshape(-1, 3)
    return HingeRings(linkage.loop_arrays[0], np.array(hinges, np.int64), *lines, len(own)), own
