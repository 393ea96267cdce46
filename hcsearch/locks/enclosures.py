"""Locks between the ends: proofs that a linkage never leaves a part of its states, by closed loops and stops alone.

Fold angles from 0 to pi are cut into cubes, and a flood takes in those that a motion from a closed state may reach. If
it ends without the goal, no motion of the linkage comes there, at any margin, though panels may pass through each other
(docs/explanation/locks.md). Where that does not keep the ends apart, panels may: at margins up to one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from hcsearch.equality import ByValue
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.flooding import (
    BOXES,
    ENCLOSED,
    FACES,
    GOING,
    HEAD,
    TAIL,
    Flood,
    new_flood,
    spread,
)
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.kernels.enclosure.refutation import Refutation, new_refutation, refutation_with
from hcsearch.kernels.enclosure.wandering import wander
from hcsearch.linkage import Linkage
from hcsearch.typing import Reals, Whole
from hcsearch.vocabulary import ENDS, End

CUTS = (0.15, 0.4, 0.8, 1.2), (0.075, 0.15, 0.275, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4)
"""Angles from either stop at which cubes meet (rad), of coarse and of fine floods: narrow ones hold hinges that hardly
leave a stop."""
CAPACITY = 200_000
"""Cubes that a flood holds."""
FIRST = 2500
"""Boxes of the first turn of each flood; each turn ends at twice as many."""
EVEN, STEPS = 20_000, 10_000
"""After so many boxes, random walks of so many steps from either end show how many cubes are to be filled, about."""
BEHIND = 6
"""What boxes of floods count for that are not expected to end first, as turns are given."""
SEED = 1
"""Of random walks."""
SLICE = 10_000
"""Boxes in one call of the kernel: an interrupt waits no longer than these take, some tenths of a second."""


@dataclass(frozen=True, eq=False)
class Enclosure(ByValue):
    """What a flood from an end of the motion came to.

    end : the end that no motion leaves for the other one; None where that is not proved. cubes, faces : cubes that hold
    whatever a motion from that end can reach, and faces that were tested for it; of all floods where nothing is
    proved. boxes : of all floods. open : whether more boxes may prove more; not where each flood came to the other end,
    or where there is no loop. lows, highs : (cubes, k), of the cubes where a lock is proved, rad; of the k hinges that
    are in a loop. margin : m, the greatest at which a lock holds that panels have a part in; None where it holds at
    every margin.
    """

    end: End | None
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


def enclose(linkage: Linkage, boxes: int, plates: Plates | None = None) -> Enclosure:
    """Look for a proof that closed loops and stops keep the packed and the flat state of a linkage apart.

    boxes : how many boxes all floods may take together, about. Four take turns, coarse and fine ones from either end,
    and that which is expected to end first has most of them. The first that ends without the other end is the proof,
    which is the same whatever the number of boxes. It holds for panels with any margin, with or without collisions, and
    for the joints of this linkage alone: what is locked with hinged flat pairs is locked with rigid and with merged
    ones, too (docs/explanation/locks.md). Source: ours.
    plates : those of `plates_of`, where panels do not pass through each other; then it holds at their margin and below.
    """
    if not linkage.loops:
        return Enclosure(None, 0, 0, 0, open=False)
    rings, hinges = rings_of(linkage)
    ends = linkage.folded[hinges], linkage.flat[hinges]
    work = new_refutation(rings) if plates is None else refutation_with(rings, plates)
    margin = None if plates is None else plates.margin
    races = [_Race(side, level, ends[side], ends[1 - side]) for side in (0, 1) for level in range(len(CUTS))]
    spent, expected = 0, None
    while going := [race for race in races if race.going]:
        if spent >= boxes:
            return _summary(None, races, spent, open_=True)
        if expected is None and spent >= EVEN:
            expected = [_cubes_expected(rings, end, work) for end in ends]
        race = _next(going, expected)
        before = race.boxes
        state = race.go_on(rings, before + min(max(FIRST, before), boxes - spent), work)
        spent += race.boxes - before
        if state == ENCLOSED:
            lows, highs = race.taken_in
            summary = _summary(ENDS[race.side], [race], spent, open_=False)
            return replace(summary, margin=margin, lows=lows, highs=highs)
    return _summary(None, races, spent, open_=False)


@dataclass(eq=False)
class _Race:
    """A flood from an end (side 0 or 1), coarse or fine (level), which is made as its first turn comes."""

    side: int
    level: int
    start: Reals
    goal: Reals
    flood: Flood | None = None
    going: bool = True

    @property
    def boxes(self) -> int:
        """Boxes that it has taken."""
        return 0 if self.flood is None else int(self.flood.counts[BOXES])

    def go_on(self, rings: Rings, boxes: int, work: Refutation) -> int:
        """Let it go on until it has taken so many boxes in all; what it came to."""
        if self.flood is None:
            self.flood = new_flood(self.start, self.goal, grid_at(self.level), CAPACITY)
        counts, state = self.flood.counts, GOING
        while state == GOING and counts[BOXES] < boxes:
            state = int(spread(rings, self.flood, min(int(counts[BOXES]) + SLICE, boxes), work))
        self.going = state == GOING
        return state

    def boxes_expected(self, cubes: float) -> float:
        """How many boxes it will have taken at its end, if it takes in so many cubes, or those that it has by now."""
        if self.flood is None:
            return math.inf
        counts = self.flood.counts
        return self.boxes * max(cubes, float(counts[TAIL])) / max(float(counts[HEAD]), 0.5)

    @property
    def taken_in(self) -> tuple[Reals, Reals]:
        """Lowest and highest angles of its cubes."""
        assert self.flood is not None
        cubes, grid = self.flood.cubes[: self.flood.counts[TAIL]].astype(np.int64), self.flood.grid
        return grid[cubes], grid[cubes + 1]


def _next(going: list[_Race], expected: list[list[float]] | None) -> _Race:
    """Which flood goes on: that which is expected to end first, but for a share of all boxes that the others have."""
    first = None
    if expected is not None:
        first = min(going, key=lambda race: race.boxes_expected(expected[race.side][race.level]))
    return min(going, key=lambda race: max(race.boxes, FIRST) * (1 if race is first else BEHIND))


def _cubes_expected(rings: Rings, end: Reals, work: Refutation) -> list[float]:
    """How many cubes of either grid hold states that can be reached from an end, about.

    By those that a random walk comes to, to once and to twice. Source: A. Chao, Scand. J. Statist. 11 (1984) 265.
    """
    states, expected = wander(rings, end, STEPS, SEED, work), []
    for level in range(len(CUTS)):
        cubes = np.searchsorted(grid_at(level), states, side="right")
        times = np.unique(cubes, axis=0, return_counts=True)[1]
        once, twice = ((times == k).sum() for k in (1, 2))
        expected.append(len(times) + once * (once - 1) / (2.0 * (twice + 1)))
    return expected


def grid_at(level: int) -> Reals:
    """Where the cubes of a flood meet, from 0 to the double above pi, which is none."""
    cuts = np.array(CUTS[level])
    return np.concatenate([[0.0], cuts, math.pi - cuts[::-1], [np.nextafter(math.pi, 4.0)]])


def _summary(end: End | None, races: list[_Race], boxes: int, *, open_: bool) -> Enclosure:
    counts = [race.flood.counts for race in races if race.flood is not None]
    cubes, faces = (sum(int(own[entry]) for own in counts) for entry in (TAIL, FACES))
    return Enclosure(end, cubes, faces, boxes, open_)


def rings_of(linkage: Linkage) -> tuple[Rings, Whole]:
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
    return Rings(linkage.loop_arrays[0], np.array(hinges, np.int64), *lines, len(own)), own
