"""Floods of cubes of fold angles: a superset of the cubes that motions from a state can reach.

[0, pi]^n is cut into cubes. A flood starts with the cube of a state and takes in each neighbour of its cubes, unless
the face between them is proved to hold no closed state. No motion leaves the cubes of a flood
(docs/explanation/locks.md). Taking in a cube needlessly only enlarges the superset.

A few faces take nearly all boxes, and behind most of these is a cube that is taken in by another face. So a face that
is undecided after some boxes waits until all easier faces are tested. The search of a face may go on in a later call,
with the same tables: each flood has its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import HingeRings
from hcsearch.kernels.enclosure.refutation import (
    BOX_CLOSED,
    BOX_EMPTY,
    BOX_OPEN,
    BOX_UNFINISHED,
    REFUTATION_TESTED_BOXES,
    Refutation,
    continue_refutation,
    reaches_closed_state,
    start_refutation,
)

FLOOD_GOING, FLOOD_ENCLOSED, FLOOD_REACHED, FLOOD_FULL = 0, 1, 2, 3
"""Result of a flood: not finished; no motion leaves its cubes, proved; the goal is reached; no more capacity."""
(
    COUNT_HEAD,
    COUNT_TAIL,
    COUNT_TESTED_FACES,
    COUNT_CROSSED_FACES,
    COUNT_DOUBTED_FACES,
    COUNT_BOXES,
    COUNT_NEXT_SIDE,
    COUNT_CURRENT_FACE,
    COUNT_WAITS,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Entries of the counts of a flood."""
FACE_BOX_LIMITS = (300, 3_000, 30_000, 300_000, 3_000_000)
"""Boxes that may be used to prove a face empty, at first and after each wait; after the last limit it counts as
crossed."""


class Flood(NamedTuple):
    """State of a flood.

    cubes : (capacity, n), those taken in. states : (capacity, n), a closed state of each, or one near it. slots : (s,),
    a hash table of cubes, 1 more than their number. goal : (n,), the cube that is not to be reached. grid : (k + 1,),
    bounds of the cubes, from 0 to the double above pi. waiting : (l - 1, capacity), faces that wait for the next of l
    limits: 2 n times their cube, and their side. queues : (l - 1, 2), how many of these were tested, and how many there
    are. counts : (9,), cubes whose faces are all tested or waiting, and cubes taken in; faces tested, faces crossed at
    a closed state, and faces crossed because they are undecided; boxes; the next face of the cube that comes next; the
    face whose search goes on, -1 for none, and how often it has waited.
    """

    cubes: NDArray[np.int8]
    states: Reals
    slots: WholeNumbers
    goal: NDArray[np.int8]
    grid: Reals
    waiting: WholeNumbers
    queues: WholeNumbers
    counts: WholeNumbers


@compiled
def new_flood(start: Reals, goal: Reals, grid: Reals, capacity: int) -> Flood:
    """Return a flood from the cube of a state, (n,), whose goal is the cube of another; grid : bounds of the cubes."""
    n, size = len(start), 4
    while size < 2 * capacity:
        size *= 2
    flood = Flood(
        np.zeros((capacity, n), np.int8),
        np.zeros((capacity, n)),
        np.zeros(size, np.int64),
        np.zeros(n, np.int8),
        grid,
        np.zeros((len(FACE_BOX_LIMITS) - 1, capacity), np.int64),
        np.zeros((len(FACE_BOX_LIMITS) - 1, 2), np.int64),
        np.zeros(9, np.int64),
    )
    for h in range(n):
        flood.goal[h] = np.searchsorted(grid, goal[h], side="right") - 1
        flood.cubes[0, h] = np.searchsorted(grid, start[h], side="right") - 1
        flood.states[0, h] = start[h]
    flood.slots[_slot(flood, flood.cubes[0])] = 1
    flood.counts[COUNT_TAIL], flood.counts[COUNT_CURRENT_FACE] = 1, -1
    return flood


@compiled
def _slot(flood: Flood, cube: NDArray[np.int8]) -> int:
    """The slot of a cube in the hash table, or the empty slot where it would be inserted."""
    key = 1469598103934665603
    for h in range(len(cube)):
        key = (key ^ int(cube[h])) * 1099511628211
    last = len(flood.slots) - 1
    slot = (key ^ (key >> 29)) & last
    while flood.slots[slot]:
        number, same = flood.slots[slot] - 1, True
        for h in range(len(cube)):
            if flood.cubes[number, h] != cube[h]:
                same = False
                break
        if same:
            break
        slot = (slot + 1) & last
    return slot


@compiled
def spread_flood(rings: HingeRings, flood: Flood, boxes: int, work: Refutation) -> int:
    """Continue a flood until it has used so many boxes in all; return GOING, ENCLOSED, REACHED or FULL."""
    counts, n = flood.counts, len(flood.goal)
    cube, state = np.zeros(n, np.int8), np.zeros(n)
    low, high = np.zeros(n), np.zeros(n)
    while counts[COUNT_BOXES] < boxes:
        if max(counts[COUNT_TAIL], flood.queues[:, 1].max()) >= len(flood.cubes):
            return FLOOD_FULL
        begins = counts[COUNT_CURRENT_FACE] < 0
        if begins:
            counts[COUNT_CURRENT_FACE], counts[COUNT_WAITS] = _next_face(flood)
        face, waited = counts[COUNT_CURRENT_FACE], counts[COUNT_WAITS]
        if face < 0:
            return FLOOD_ENCLOSED
        number, h, step = face // (2 * n), face % (2 * n) // 2, 2 * (face % 2) - 1
        for k in range(n):
            cube[k] = flood.cubes[number, k]
            low[k], high[k] = flood.grid[cube[k]], flood.grid[cube[k] + 1]
        cube[h] += step
        slot = _slot(flood, cube)
        if not 0 <= cube[h] < len(flood.grid) - 1 or flood.slots[slot]:
            counts[COUNT_CURRENT_FACE] = -1
            continue
        low[h] = high[h] = high[h] if step > 0 else low[h]
        verdict = _tested(rings, flood, low, high, begins, boxes, state, work)
        if verdict == BOX_UNFINISHED:
            return FLOOD_GOING
        counts[COUNT_CURRENT_FACE] = -1
        if verdict == BOX_OPEN and waited + 1 < len(FACE_BOX_LIMITS):
            flood.waiting[waited, flood.queues[waited, 1]] = face
            flood.queues[waited, 1] += 1
        elif verdict != BOX_EMPTY:
            counts[COUNT_CROSSED_FACES if verdict == BOX_CLOSED else COUNT_DOUBTED_FACES] += 1
            _take_in(flood, slot, cube, state)
            if (cube == flood.goal).all():
                return FLOOD_REACHED
    return FLOOD_GOING


@compiled
def _next_face(flood: Flood) -> tuple[int, int]:
    """The next face to test, 2 n times its cube plus its side, and how often it has waited; -1 for none."""
    counts, queues, sides = flood.counts, flood.queues, 2 * len(flood.goal)
    if counts[COUNT_HEAD] < counts[COUNT_TAIL]:
        face = counts[COUNT_HEAD] * sides + counts[COUNT_NEXT_SIDE]
        counts[COUNT_NEXT_SIDE] += 1
        if counts[COUNT_NEXT_SIDE] == sides:
            counts[COUNT_HEAD] += 1
            counts[COUNT_NEXT_SIDE] = 0
        return face, 0
    for k in range(len(queues)):
        if queues[k, 0] < queues[k, 1]:
            queues[k, 0] += 1
            return flood.waiting[k, queues[k, 0] - 1], k + 1
    return -1, 0


@compiled
def _tested(
    rings: HingeRings, flood: Flood, low: Reals, high: Reals, begins: bool, boxes: int, state: Reals, work: Refutation
) -> int:
    """Return EMPTY, CLOSED or OPEN for a face of a cube, or UNFINISHED where the flood has used up its boxes before.

    A state of a face that is not empty is written: a closed one, if met. Newton's method begins at the state of the
    face nearest to the one by which the flood came to the cube.
    """
    counts, limit = flood.counts, FACE_BOX_LIMITS[flood.counts[COUNT_WAITS]]
    if begins:
        if counts[COUNT_WAITS] == 0:
            counts[COUNT_TESTED_FACES] += 1
        counts[COUNT_BOXES] += 1
        _write_nearest(flood, low, high, state)
        if reaches_closed_state(rings, low, high, state, work):
            return BOX_CLOSED
        start_refutation(rings, low, high, work)
    before = work.counts[REFUTATION_TESTED_BOXES]
    verdict = continue_refutation(rings, min(limit, before + max(boxes - counts[COUNT_BOXES], 0)), work)
    counts[COUNT_BOXES] += work.counts[REFUTATION_TESTED_BOXES] - before
    if verdict == BOX_CLOSED:
        for h in range(len(low)):
            state[h] = work.state[h]
    else:
        _write_nearest(flood, low, high, state)
    return BOX_OPEN if verdict == BOX_UNFINISHED and work.counts[REFUTATION_TESTED_BOXES] >= limit else verdict


@compiled
def _write_nearest(flood: Flood, low: Reals, high: Reals, state: Reals) -> None:
    """Write the state of the current face that is nearest to the one by which the flood came to its cube."""
    number = flood.counts[COUNT_CURRENT_FACE] // (2 * len(low))
    for h in range(len(low)):
        state[h] = min(max(flood.states[number, h], low[h]), high[h])


@compiled
def _take_in(flood: Flood, slot: int, cube: NDArray[np.int8], state: Reals) -> None:
    """Take in a cube, with a state of the face by which it was reached."""
    number = flood.counts[COUNT_TAIL]
    for h in range(len(cube)):
        flood.cubes[number, h] = cube[h]
        flood.states[number, h] = state[h]
    flood.slots[slot] = number + 1
    flood.counts[COUNT_TAIL] = number + 1
