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
    REACHED,
    TAIL,
    Flood,
    new_flood,
    spread,
)
from hcsearch.kernels.enclosure.plates import Plates
from hcsearch.kernels.enclosure.refutation import Refutation, new_refutation, refutation_with
from hcsearch.linkage import Linkage
from hcsearch.typing import Reals, Whole
from hcsearch.vocabulary import ENDS, End

CUTS = (0.15, 0.4, 0.8, 1.2), (0.075, 0.15, 0.275, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4)
"""Angles from either stop at which cubes meet (rad): narrow ones hold hinges that hardly leave a stop. The second are
those of floods that begin again where the first came to the other end."""
FACE = 30_000
"""Boxes by which a face may be proved empty before it counts as crossed."""
CAPACITY = 200_000
"""Cubes that a flood holds."""
FIRST = 2500
"""Boxes of the first turn of each flood; each turn ends at twice as many."""
AHEAD = 3
"""How many times the boxes of the other flood the more promising one may have taken when its turn begins."""
SLICE = 10_000
"""Boxes in one call of the kernel: an interrupt waits no longer than these take, some tenths of a second."""


@dataclass(frozen=True, eq=False)
class Enclosure(ByValue):
    """What a flood from an end of the motion came to.

    end : the end that no motion leaves for the other one; None where that is not proved. cubes, faces : cubes that hold
    whatever a motion from that end can reach, and faces that were tested for it; of both floods where nothing is
    proved. boxes : of all floods, with those that began again. open : whether more boxes may prove more; not where each
    flood came to the other end, or where there is no loop. lows, highs : (cubes, k), of the cubes where a lock is
    proved, rad; of the k hinges that are in a loop. margin : m, the greatest at which a lock holds that panels have a
    part in; None where it holds at every margin.
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

    boxes : how many boxes both floods may take together, about. They take turns, one from each end, the more promising
    one more of them; one that comes to the other end begins again once, with finer cubes. The first that ends without
    the other end is the proof, which is the same whatever the number of boxes. It holds for panels with any
    margin, with or without collisions, and for the joints of this linkage alone: what is locked with hinged flat pairs
    is locked with rigid and with merged ones, too (docs/explanation/locks.md). Source: ours.
    plates : those of `plates_of`, where panels do not pass through each other; then it holds at their margin and below.
    """
    if not linkage.loops:
        return Enclosure(None, 0, 0, 0, open=False)
    rings, hinges = rings_of(linkage)
    ends = linkage.folded[hinges], linkage.flat[hinges]
    work = new_refutation(rings) if plates is None else refutation_with(rings, plates)
    margin = None if plates is None else plates.margin
    floods = [new_flood(start, goal, grid_at(0), CAPACITY) for start, goal in (ends, ends[::-1])]
    going, level, spent = [True, True], [0, 0], 0
    while any(going):
        if spent >= boxes:
            return _summary(None, floods, spent, open_=True)
        side = _next(floods, going)
        flood = floods[side]
        before = _boxes(flood)
        state = _spread(rings, flood, before + min(max(FIRST, before), boxes - spent), work)
        spent += _boxes(flood) - before
        if state == ENCLOSED:
            cubes = flood.cubes[: flood.counts[TAIL]].astype(np.int64)
            lows, highs = flood.grid[cubes], flood.grid[cubes + 1]
            summary = _summary(ENDS[side], [flood], spent, open_=False)
            return replace(summary, margin=margin, lows=lows, highs=highs)
        again = state == REACHED and level[side] + 1 < len(CUTS)
        if again:
            level[side] += 1
            floods[side] = new_flood(ends[side], ends[1 - side], grid_at(level[side]), CAPACITY)
        going[side] = again or state == GOING
    return _summary(None, floods, spent, open_=False)


def _boxes(flood: Flood) -> int:
    return int(flood.counts[BOXES])


def _next(floods: list[Flood], going: list[bool]) -> int:
    """Which flood goes on: the one with the smaller share of cubes that wait, until it has taken thrice the boxes."""
    waiting = [1.0 - flood.counts[HEAD] / flood.counts[TAIL] for flood in floods]
    side = int(waiting[1] < waiting[0])
    if not going[side] or (going[1 - side] and _boxes(floods[side]) > AHEAD * _boxes(floods[1 - side])):
        side = 1 - side
    return side


def grid_at(level: int) -> Reals:
    """Where the cubes of a flood meet, from 0 to the double above pi, which is none."""
    cuts = np.array(CUTS[level])
    return np.concatenate([[0.0], cuts, math.pi - cuts[::-1], [np.nextafter(math.pi, 4.0)]])


def _spread(rings: Rings, flood: Flood, boxes: int, work: Refutation) -> int:
    """Let a flood go on until it has taken so many boxes in all; what it came to."""
    state = GOING
    while state == GOING and flood.counts[BOXES] < boxes:
        state = int(spread(rings, flood, min(int(flood.counts[BOXES]) + SLICE, boxes), FACE, work))
    return state


def _summary(end: End | None, floods: list[Flood], boxes: int, *, open_: bool) -> Enclosure:
    cubes, faces = (sum(int(flood.counts[entry]) for flood in floods) for entry in (TAIL, FACES))
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
