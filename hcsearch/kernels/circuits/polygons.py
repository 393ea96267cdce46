"""Self-avoiding polygons of n steps, one per congruence class, by a resumable depth-first walk.

A polygon is represented by its cyclic word of turns, as codes, walked counterclockwise. The walk visits only words that
can still become the least of their rotations (prenecklaces, tracked with one integer per step as by Fredricksen,
Kessler and Maiorana) and can still return home around the visited places; a complete word is accepted if it is also not
greater than any rotation of its mirror image, whose turns are met backwards.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Integers16, WholeNumbers
from hcsearch.kernels.circuits.step_tables import StepTables, turn_moves
from hcsearch.kernels.compiling.compiled import compiled


@compiled
def mirror_rank(letters: NDArray[np.int8], n: int, reversed_codes: WholeNumbers) -> int:
    """Compare a word (a least rotation) with the least rotation of its mirror image: -1 less, 0 equal, 1 greater."""
    equal = False
    for start in range(n):
        position = start
        for k in range(n):
            difference = letters[k] - reversed_codes[letters[position]]
            if difference != 0:
                break
            position -= 1
            if position < 0:
                position = n - 1
        else:
            equal = True
            continue
        if difference > 0:
            return 1
    return 0 if equal else -1


@compiled
def _can_reach_home(
    start: int,
    step: int,
    step_count: int,
    steps: StepTables,
    moves: WholeNumbers,
    distance: Integers16,
    visited: NDArray[np.uint8],
    stamps: WholeNumbers,
    stamp: int,
    queue: WholeNumbers,
    queue_steps: WholeNumbers,
) -> bool:
    """Return whether home (distance 0) is within some steps of a place over unvisited places (breadth-first).

    start, step : the place, and the step by which it was entered; the queues hold further ones.
    """
    first, last, steps_taken = 0, 1, 0
    queue[0], queue_steps[0] = start, step
    stamps[start] = stamp
    while first < last and steps_taken < step_count:
        steps_taken += 1
        for index in range(first, last):
            for to in steps.following[queue_steps[index]]:
                next_place = queue[index] + moves[to]
                if distance[next_place] == 0:
                    return True
                near = distance[next_place] <= step_count - steps_taken
                if near and visited[next_place] == 0 and stamps[next_place] != stamp:
                    stamps[next_place] = stamp
                    queue[last], queue_steps[last] = next_place, to
                    last += 1
            first += 1
    return False


@compiled
def walk_polygons(
    steps: StepTables,
    moves: WholeNumbers,
    distance: Integers16,
    n: int,
    depth: int,
    trap: int,
    letters: NDArray[np.int8],
    heading: WholeNumbers,
    place: WholeNumbers,
    period: WholeNumbers,
    visited: NDArray[np.uint8],
    state: WholeNumbers,
    words: NDArray[np.int8],
    symmetry: Integers16,
) -> int:
    """Resume a walk until it ends or `words` is full; return the number of words written.

    letters[k] is the code of the turn before step k (k >= 1); letters[0] is unused and the closing turn is letters[n].
    With `trap` or more steps left the walk checks for a way home, which is cheaper than exploring a walk that has
    enclosed itself. The words of a unit share letters[1:depth + 1]; `state` holds (step, first, done).
    `enumeration.polygon_search` owns the arrays and initialises them for a prefix.
    """
    stamps = np.zeros(len(distance), np.int64)
    queue, queue_steps = np.empty(len(distance), np.int64), np.empty(len(distance), np.int64)
    stamp = 0
    n_turns = steps.following.shape[1]
    offsets = turn_moves(steps, moves)
    capacity = len(words)
    written = 0
    k = state[0]
    is_first_visit = state[1]
    while written < capacity:
        # choose the next letter of step k: on a first visit from the prenecklace bound on, else after the last letter
        before = np.uint64(heading[k - 1])
        base = steps.first_codes[before]
        turn = 0
        if is_first_visit == 1:
            if k > 1:
                turn = max(0, letters[k - period[k - 1]] - base)
        else:
            if k < n - 1:
                visited[place[k + 1]] = 0
            turn = letters[k] - base + 1
        advanced = False
        steps_left = n - 1 - k
        next_place = place[k]
        while turn < n_turns:
            next_place = place[k] + offsets[before, np.uint64(turn)]
            if distance[next_place] <= steps_left and (visited[next_place] == 0 or steps_left == 0):
                advanced = True
                if steps_left >= trap:
                    visited[next_place] = 1
                    stamp += 1
                    d = steps.following[before, np.uint64(turn)]
                    advanced = _can_reach_home(
                        next_place, d, steps_left, steps, moves, distance, visited, stamps, stamp, queue, queue_steps
                    )
                    visited[next_place] = 0
                if advanced:
                    break
            turn += 1
        if not advanced:
            k -= 1
            is_first_visit = 0
            if k <= depth:
                state[2] = 1
                break
            continue
        letter = base + turn
        d = steps.following[before, np.uint64(turn)]
        letters[k] = letter
        heading[k] = d
        p = period[k - 1]
        if k == 1 or letter != letters[k - p]:
            p = k
        period[k] = p
        if steps_left > 0:
            place[k + 1] = next_place
            visited[next_place] = 1
            k += 1
            is_first_visit = 1
            continue
        # back home: check the closing turn, the orientation, the necklace, the mirror image
        place[k + 1] = next_place
        is_first_visit = 0
        closing = steps.codes[d, heading[0]]
        if closing < 0 or closing < letters[n - p]:
            continue
        if closing > letters[n - p]:
            p = n
        if n % p != 0:
            continue
        letters[n] = closing
        total = np.int64(0)
        for i in range(1, n + 1):
            total += steps.code_turns[letters[i]]
        if total != steps.directions:
            continue
        rank = mirror_rank(letters[1 : n + 1], n, steps.reversed)
        if rank > 0:
            continue
        for i in range(n):
            words[written, i] = heading[i]
        symmetry[written] = (n // p) * (2 if rank == 0 else 1)
        written += 1
    state[0] = k
    state[1] = is_first_visit
    return written
