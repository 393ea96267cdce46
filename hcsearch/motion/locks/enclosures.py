"""Locks between the ends: proofs that a linkage never leaves a part of its states, by closed loops and stops alone.

Fold angles from 0 to pi are cut into cubes, and a flood collects the cubes that a motion from a closed state may reach;
or a region of few boxes is laid around such states. If it holds one end only, and its faces no closed state, no motion
of the linkage leads to the other end, at any margin, even if panels may pass through each other
(docs/explanation/locks.md). Where that does not separate the ends, collisions of panels may, at margins up to one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.vocabulary import MOTION_ENDS, MotionEnd
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.kernels.enclosure.refutation import Refutation, new_refutation, refutation_with
from hcsearch.kernels.enclosure.wandering import climb_angles, random_walk
from hcsearch.motion.locks.boxes import whole_box
from hcsearch.motion.locks.floods import CubeFlood, expected_cube_counts, floods_from
from hcsearch.motion.locks.regions import Region
from hcsearch.motion.searching import Budget, SteppedSearch
from hcsearch.shape.linkage import Linkage

FIRST_TURN_BOXES = 2500
"""Boxes of the first turn of each contender; each later turn doubles their number."""
WALK_SCHEDULE = (
    (10_000, 10_000),
    (50_000, 100_000),
    (250_000, 500_000),
    (250_000, 2_500_000),
    (250_000, 12_500_000),
    (250_000, 62_500_000),
)
"""Pairs (steps, boxes): steps of random walks from either end, and the number of boxes after which these are due; they
are due at once if nothing else is active. Walks estimate the number of cubes to fill, and regions are laid around them;
later walks serve where regions around earlier ones are given up."""
TRAILING_BOX_WEIGHT = 20
"""Weight of the boxes of contenders that are unlikely to end first, which delays their turns."""
UNSETTLED_BOXES, UNSETTLED_BOX_WEIGHT = 300_000, 4
"""Number of boxes after which a contender should have an estimate, and the weight of its boxes without one."""
WALK_CLIMB_STEPS = 1000
"""Steps of each climb from a walk."""
FIRST_WALK_SEED = 1
"""Seed of the first walks."""


@dataclass(frozen=True, eq=False)
class Enclosure(ByValue):
    """Result of floods and regions of few boxes around the ends of the motion.

    end : the end that no motion leaves for the other one; None where that is not proved. cubes, faces : number of
    cubes, or boxes of a region, that enclose all states that a motion from that end can reach, and number of faces
    tested; sums over all contenders where nothing is proved. boxes : number of boxes of all contenders.
    unfinished : whether more boxes may prove more; false where each flood reached the other end and no region is
    active, or without a loop.
    lows, highs : (cubes, k), lowest and highest angles of the cubes of a proved lock, rad, for the k hinges in loops.
    margin : the greatest margin (m) at which a lock by collisions holds; None where it holds at every one.
    """

    end: MotionEnd | None
    cubes: int
    faces: int
    boxes: int
    unfinished: bool
    margin: float | None = None
    lows: Reals = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    highs: Reals = field(default_factory=lambda: np.zeros((0, 0)), repr=False)

    @property
    def proved(self) -> bool:
        """Whether it is proved that no motion leads from one end to the other."""
        return self.end is not None


def enclose_ends(linkage: Linkage, boxes: int, plates: Plates | None = None) -> Enclosure:
    """Search for a proof that closed loops and stops separate the packed and the flat state of a linkage.

    boxes : approximate number of boxes for all contenders together. These take turns: coarse and fine floods from
    either end, and later a region of few boxes around either end; the one that is expected to end first gets most of
    the boxes. The first that ends without reaching the other end is the proof, which is the same whatever the number of
    boxes. It holds for panels with any margin, with or without collisions, and for the joints of this linkage alone: a
    lock with hinged flat pairs is also one with rigid and with merged ones (docs/explanation/locks.md). Source: ours.
    plates : the result of `plates_of`, if panels must not pass through each other; the proof then holds up to its
    margin.
    """
    if not linkage.loops:
        return Enclosure(None, 0, 0, 0, unfinished=False)
    rings, hinges = rings_of(linkage)
    return _Contest(rings, (linkage.folded[hinges], linkage.flat[hinges]), plates).run(Budget(boxes))


_Contender = CubeFlood | Region
"""A candidate enclosure of an end."""


class _Contest(SteppedSearch[Enclosure]):
    """The contenders for an enclosure of one of the ends, and the order of their turns; its efforts are boxes."""

    def __init__(self, rings: HingeRings, ends: tuple[Reals, Reals], plates: Plates | None) -> None:
        self.rings, self.ends, self.plates = rings, ends, plates
        self.walk_tables = self._tables()
        self.floods = floods_from(rings, ends, self._tables)
        self.regions: list[Region] = []
        self._walks_made, self._walk_steps = 0, 0
        self._proof: _Contender | None = None
        self._ends_here = False  # the next walk would take more than the budget

    def _tables(self) -> Refutation:
        return new_refutation(self.rings) if self.plates is None else refutation_with(self.rings, self.plates)

    @property
    def contenders(self) -> list[_Contender]:
        """All floods and regions, including those that were given up."""
        return [*self.floods, *self.regions]

    @property
    def efforts(self) -> int:
        """Number of boxes of all contenders plus steps of walks, which take about as long."""
        return self._walk_steps + sum(contender.efforts for contender in self.contenders)

    @property
    def active(self) -> list[_Contender]:
        """The contenders that have not ended."""
        return [contender for contender in self.contenders if not contender.done]

    @property
    def is_due(self) -> bool:
        """Whether walks are due: after enough boxes, or at once where no contender is active and regions may help."""
        if self._walks_made == len(WALK_SCHEDULE):
            return False
        return self.efforts >= WALK_SCHEDULE[self._walks_made][1] or (self.plates is None and not self.active)

    @property
    def done(self) -> bool:
        """Whether an end is enclosed, or nothing remains that may enclose one."""
        return self._proof is not None or self._ends_here or not (self.is_due or self.active)

    def step(self, budget: Budget) -> None:
        """Make the walks that are due, or advance one contender."""
        if self.is_due:
            self._walk(budget)
        else:
            self._advance(budget)

    @property
    def result(self) -> Enclosure:
        """The proof, or the efforts of all contenders where none has enclosed its end."""
        proof = self._proof
        if proof is None:
            cubes, faces = (sum(getattr(one, name) for one in self.contenders) for name in ("cubes", "faces"))
            return Enclosure(None, cubes, faces, self.efforts, unfinished=self._ends_here or not self.done)
        (lows, highs), margin = proof.bounds, None if self.plates is None else self.plates.margin
        found = MOTION_ENDS[proof.side], proof.cubes, proof.faces, self.efforts
        return Enclosure(*found, False, margin, lows=lows, highs=highs)

    def _walk(self, budget: Budget) -> None:
        """Make and use the walks that are due, where the budget allows them."""
        sides = [side for side in (0, 1) if all(region.done for region in self.regions if region.side == side)]
        steps, seed = WALK_SCHEDULE[self._walks_made][0], FIRST_WALK_SEED + self._walks_made
        if sides and self.efforts + len(self.ends) * steps > budget.efforts:
            self._ends_here = True
            return
        self._walks_made += 1
        if sides:
            walks = [random_walk(self.rings, end, steps, seed, self.walk_tables) for end in self.ends]
            self._walk_steps += len(self.ends) * steps
            expected = [expected_cube_counts(walk) for walk in walks]
            for flood in self.floods:
                flood.cubes_expected = expected[flood.side][flood.level]
            if self.plates is None:  # with panels, regions led to no proof
                self._lay_around(walks, sides, seed)

    def _lay_around(self, walks: list[Reals], sides: list[int], seed: int) -> None:
        """Lay regions around walks from either end."""
        box, tables = whole_box(self.rings.hinge_count), self.walk_tables
        climbed = [climb_angles(self.rings, walk, *box, WALK_CLIMB_STEPS, seed, tables) for walk in walks]
        for side in sides:
            ends = climbed[side], climbed[1 - side]
            self.regions.append(Region(self.rings, side, *ends, seed, self._tables(), self._tables()))

    def _advance(self, budget: Budget) -> None:
        """Advance one contender."""
        active = self.active
        first = min(active, key=lambda contender: contender.boxes_expected)
        chosen = min(active, key=lambda own: max(own.efforts, FIRST_TURN_BOXES) * (1 if own is first else _weight(own)))
        turn = min(max(FIRST_TURN_BOXES, chosen.efforts), int(budget.efforts) - self.efforts)
        if chosen.run(Budget(chosen.efforts + turn)):
            self._proof = chosen


def _weight(contender: _Contender) -> int:
    """Weight of the boxes of a contender that is not expected to end first; 1 early on, before there is an estimate."""
    if math.isfinite(contender.boxes_expected):
        return TRAILING_BOX_WEIGHT
    return 1 if contender.efforts < UNSETTLED_BOXES else UNSETTLED_BOX_WEIGHT


def rings_of(linkage: Linkage) -> tuple[HingeRings, WholeNumbers]:
    """The loops of a linkage for the kernels, and the hinges in loops; loops name a hinge by its place among these.

    Lengths are divided by the pattern's size, and places are relative to the middle of each loop, so that no bound
    depends on its position.
    """
    looped = linkage.looped
    number = {int(hinge): k for k, hinge in enumerate(looped)}
    points, size = linkage.points, linkage.pattern.size
    hinges, directions, places = [], [], []
    for loop in linkage.loops:
        centre = np.mean([points[hinge] for hinge, _ in loop], axis=0)
        for hinge, sign in loop:
            hinges.append(number[hinge])
            directions.append(sign * linkage.directions[hinge])
            places.append((points[hinge] - centre) / size)
    lines = np.array(directions).reshape(-1, 3), np.array(places).reshape(-1, 3)
    return HingeRings(linkage.loop_arrays[0], np.array(hinges, np.int64), *lines, len(looped)), looped
