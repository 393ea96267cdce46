"""Floods of cubes of fold angles: which cubes motions from a state can reach, at most.

[0, pi]^n is cut into cubes. A flood takes in the cube of a state, and then each neighbour of a cube that was taken in,
unless the face between them is proved to hold no closed state. No motion leaves what a flood has taken in
(docs/explanation/locks.md). A cube that is taken in without need only enlarges that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.refutation import CLOSED, EMPTY, Refutation, meets, refute
from hcsearch.typing import Reals, Whole

GOING, ENCLOSED, REACHED, FULL = 0, 1, 2, 3
"""A flood goes on; has proved what it has taken in to be left by no motion; came to the goal; has no more room."""
HEAD, TAIL, FACES, MET, DOUBTED, BOXES, SIDE = 0, 1, 2, 3, 4, 5, 6
"""Entries of the counts of a flood."""


class Flood(NamedTuple):
    """A flood.

    cubes : (capacity, n), those taken in. states : (capacity, n), a closed state of each, or one near it.
    slots : (s,), a hash table of cubes, 1 more than their number. goal : (n,), the cube that is not to be reached.
    grid : (k + 1,), where cubes meet, from 0 to the double above pi. counts : (7,), cubes whose faces were all tested
    and cubes taken in; faces that were tested, of these crossed at a closed state, and crossed as nothing is known of
    them; boxes; the next face of the cube that comes next.
    """

    cubes: NDArray[np.int8]
    states: Reals
    slots: Whole
    goal: NDArray[np.int8]
    grid: Reals
    counts: Whole


@compiled
def new_flood(start: Reals, goal: Reals, grid: Reals, capacity: int) -> Flood:
    """A flood from the cube of a state, (n,), that should not reach that of a goal. grid : where cubes meet."""
    n, size = len(start), 4
    while size < 2 * capacity:
        size *= 2
    flood = Flood(
        np.zeros((capacity, n), np.int8),
        np.zeros((capacity, n)),
        np.zeros(size, np.int64),
        np.zeros(n, np.int8),
        grid,
        np.zeros(7, np.int64),
    )
    for h in range(n):
        flood.goal[h] = np.searchsorted(grid, goal[h], side="right") - 1
        flood.cubes[0, h] = np.searchsorted(grid, start[h], side="right") - 1
        flood.states[0, h] = start[h]
    flood.slots[_slot(flood, flood.cubes[0])] = 1
    flood.counts[TAIL] = 1
    return flood


@lean
def _slot(flood: Flood, cube: NDArray[np.int8]) -> int:
    """The slot of a cube in the hash table, or the empty one where it would go."""
    key = 1469598103934665603
    for h in range(len(cube)):
        key = (key ^ int(cube[h])) * 1099511628211
    last = len(flood.slots) - 1
    slot = (key ^ (key >> 29)) & last
    while flood.slots[slot]:
        own, same = flood.slots[slot] - 1, True
        for h in range(len(cube)):
            if flood.cubes[own, h] != cube[h]:
                same = False
                break
        if same:
            break
        slot = (slot + 1) & last
    return slot


@compiled
def spread(rings: Rings, flood: Flood, boxes: int, face: int, work: Refutation) -> int:
    """Let a flood go on until it has taken so many boxes in all; GOING, ENCLOSED, REACHED or FULL.

    face : boxes that a face is given at most; a face that takes more is crossed.
    """
    counts, n = flood.counts, len(flood.goal)
    cube, state = np.zeros(n, np.int8), np.zeros(n)
    low, high = np.zeros(n), np.zeros(n)
    while counts[HEAD] < counts[TAIL]:
        if counts[TAIL] + 2 * n > len(flood.cubes):
            return FULL
        own = counts[HEAD]
        for h in range(n):
            cube[h] = flood.cubes[own, h]
            low[h], high[h] = flood.grid[cube[h]], flood.grid[cube[h] + 1]
        while counts[SIDE] < 2 * n:
            if counts[BOXES] >= boxes:
                return GOING
            h, step = counts[SIDE] // 2, 2 * (counts[SIDE] % 2) - 1
            counts[SIDE] += 1
            if not 0 <= cube[h] + step < len(flood.grid) - 1:
                continue
            cube[h] += step
            slot = _slot(flood, cube)
            if flood.slots[slot] == 0:
                below, above = low[h], high[h]
                low[h] = high[h] = above if step > 0 else below
                if _crossed(rings, flood, own, low, high, face, state, work):
                    _take_in(flood, slot, cube, state)
                    reached = True
                    for k in range(n):
                        reached = reached and cube[k] == flood.goal[k]
                    if reached:
                        return REACHED
                low[h], high[h] = below, above
            cube[h] -= step
        counts[HEAD] += 1
        counts[SIDE] = 0
    return ENCLOSED


@lean
def _crossed(
    rings: Rings, flood: Flood, own: int, low: Reals, high: Reals, face: int, state: Reals, work: Refutation
) -> bool:
    """Whether a face of a cube is not proved empty; a state of it, closed where one is met, is written.

    Newton's method begins at the nearest state of the face to that by which the flood came to the cube.
    """
    n, counts = len(low), flood.counts
    counts[FACES] += 1
    for h in range(n):
        state[h] = min(max(flood.states[own, h], low[h]), high[h])
    if meets(rings, low, high, state, work):
        counts[MET] += 1
        counts[BOXES] += 1
        return True
    verdict, boxes = refute(rings, low, high, face, work)
    counts[BOXES] += boxes + 1
    if verdict == EMPTY:
        return False
    if verdict == CLOSED:
        counts[MET] += 1
        for h in range(n):
            state[h] = work.state[h]
    else:
        counts[DOUBTED] += 1
    return True


@lean
def _take_in(flood: Flood, slot: int, cube: NDArray[np.int8], state: Reals) -> None:
    """Take in a cube, with a state of the face by which it was reached."""
    own = flood.counts[TAIL]
    for h in range(len(cube)):
        flood.cubes[own, h] = cube[h]
        flood.states[own, h] = state[h]
    flood.slots[slot] = own + 1
    flood.counts[TAIL] = own + 1
