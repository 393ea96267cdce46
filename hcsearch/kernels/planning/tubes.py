"""Proofs that closed states lie beside a motion whose loops are nearly closed: a tube around every piece of it.

Steps between states are halved until `pieces` proves each piece; where halving does not help, closed states are
inserted into steps. Closed states of neighbouring pieces are joined where they meet (docs/explanation/motion.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.planning.closed_states import Closing, Group, Loops, close_state, keep_closed, new_closing
from hcsearch.kernels.planning.pieces import MAX_CONTRACTION_FACTOR, PieceTables, new_piece_tables, prove_piece

MAX_PROOF_PIECES = 20000
"""Greatest number of pieces of a proof, which paths along singular states exceed; most proofs take a thousand."""
MIN_PIECE_SHARE = 0.5**12
"""Pieces that are no longer than this share of a step are not halved."""
MAX_CUBIC_OVERSHOOT = 1e-4
"""Greatest overshoot of inserted states beyond stops (rad): cubics overshoot."""
POLISHED_RESIDUAL = 1e-14
"""Closure residual (rad, or gap over size) to which states are closed."""


@compiled
def polishing_residual(loops: Loops) -> float:
    """The residual to which states are closed, raised for long loops, whose rounding errors are greater."""
    return max(POLISHED_RESIDUAL, 2e-15 * len(loops.hinges))


class Track(NamedTuple):
    """A motion as states with cubics between them, and free capacity.

    times : (k,). angles, rates : (k, m). wanders : (k,), of the step before each state: greatest deviation of the fold
    angles of closed states from it, summed over hinges (rad). state_count : (1,).
    """

    times: Reals
    angles: Reals
    rates: Reals
    wanders: Reals
    state_count: WholeNumbers


@compiled
def new_track(k: int, m: int) -> Track:
    """Return a track of no states, with room for k of m hinges."""
    return Track(np.zeros(k), np.zeros((k, m)), np.zeros((k, m)), np.zeros(k), np.zeros(1, np.int64))


@compiled
def prove_tube(
    loops: Loops, group: Group, coarse: Track, ends: Reals, limit: float, halvings: int, fine: Track, stop: Reals
) -> bool:
    """Prove that closed states lie beside a motion; return whether the proof spans it from end to end.

    group : the hinges that turn, and the equations in which the loops close. coarse : closed states and rates that keep
    loops closed. ends : (2, 1 + m), the share of the first step at which the proof begins, and the deviations of the
    fold angles of the state that it is joined to there (rad); the same for the last step. limit : rad, greatest
    deviation of the closed states of a step. halvings : greatest number of times that closed states are inserted into
    an unproved step. fine : written, the states that the proof is about. stop : (2,), written: the time at which the
    proof ends, and the number of pieces that were tried.
    """
    work, tables = new_closing(loops), new_piece_tables(loops, group)
    work.fixed[:] = ~group.moving
    m = coarse.angles.shape[1]
    waiting = new_track(halvings + 1, m)
    course = np.zeros((m, 4))
    _append(coarse, 0, 0.0, fine)
    before, after = ends[0, 1:].copy(), np.zeros(m)
    stop[1] = 0.0
    for k in range(1, coarse.state_count[0]):
        _append(coarse, k, 0.0, waiting)
        while waiting.state_count[0]:
            here, top = fine.state_count[0] - 1, waiting.state_count[0] - 1
            _hermite(fine, here, waiting, top, course)
            last = k == coarse.state_count[0] - 1 and top == 0
            shares = (ends[0, 0] if here == 0 else 0.0, ends[1, 0] if last else 1.0)
            after[:] = 0.0
            if last:
                after[:] = ends[1, 1:]
            wanders_before = before.copy()
            wander = _step(loops, group, course, shares, before, after, limit, tables, stop)
            if wander <= limit and fine.state_count[0] < len(fine.times):
                _append(waiting, top, wander, fine)
                waiting.state_count[0] = top
                continue
            before = wanders_before
            over = top == halvings or stop[1] >= MAX_PROOF_PIECES
            if over or shares != (0.0, 1.0) or not _put_between(loops, course, fine, waiting, work):
                stop[0] = fine.times[here]
                return False
    stop[0] = fine.times[fine.state_count[0] - 1]
    return True


@compiled
def _append(source: Track, k: int, wander: float, target: Track) -> None:
    """Append a state of one motion to another."""
    i = target.state_count[0]
    target.times[i], target.wanders[i] = source.times[k], wander
    target.angles[i], target.rates[i] = source.angles[k], source.rates[k]
    target.state_count[0] = i + 1


@compiled
def _hermite(first: Track, i: int, second: Track, j: int, course: Reals) -> None:
    """Write the Hermite cubics of the fold angles between two states, in the share of the step."""
    h = second.times[j] - first.times[i]
    for k in range(len(course)):
        rise = second.angles[j, k] - first.angles[i, k]
        before, after = h * first.rates[i, k], h * second.rates[j, k]
        course[k, 0], course[k, 1] = first.angles[i, k], before
        course[k, 2], course[k, 3] = 3.0 * rise - 2.0 * before - after, before + after - 2.0 * rise


@compiled
def _put_between(loops: Loops, course: Reals, fine: Track, waiting: Track, work: Closing) -> bool:
    """Push the closed state nearest to the middle of a step onto the waiting states; return whether one is near by."""
    here, top = fine.state_count[0] - 1, waiting.state_count[0] - 1
    h = waiting.times[top] - fine.times[here]
    middle = waiting.angles[top + 1]
    squared_length = 0.0
    for k in range(len(course)):
        a, b, c, d = course[k, 0], course[k, 1], course[k, 2], course[k, 3]
        middle[k] = a + 0.5 * (b + 0.5 * (c + 0.5 * d))
        waiting.rates[top + 1, k] = (b + c + 0.75 * d) / h
        squared_length += (waiting.angles[top, k] - fine.angles[here, k]) ** 2
    before = middle.copy()
    if not close_state(loops, middle, polishing_residual(loops), MAX_CUBIC_OVERSHOOT, 20, work):
        return False
    for k in range(len(course)):
        squared_length -= 16.0 * (middle[k] - before[k]) ** 2
    if squared_length < 0.0:
        return False
    keep_closed(loops, middle, waiting.rates, top + 1, work)
    waiting.times[top + 1] = fine.times[here] + 0.5 * h
    waiting.state_count[0] = top + 2
    return True


@compiled
def _step(
    loops: Loops,
    group: Group,
    course: Reals,
    shares: tuple[float, float],
    before: Reals,
    after: Reals,
    limit: float,
    tables: PieceTables,
    stop: Reals,
) -> float:
    """Return the deviation of closed states beside a step (rad), halved as needed; infinite where none are proved.

    before, after : deviations of the fold angles of the closed states to be joined before and after the step; `before`
    is overwritten with those at the end of the step.
    """
    lows, highs = np.empty(64), np.empty(64)
    lows[0], highs[0] = shares
    top, worst = 0, 0.0
    joined = np.empty(len(before))
    while top >= 0:
        low, high = lows[top], highs[top]
        for h in range(len(joined)):
            joined[h] = max(before[h], after[h] if high == shares[1] else 0.0)
        stop[1] += 1.0
        factor, wander = prove_piece(loops, group, course, (low, high), joined, limit, tables)
        if factor <= MAX_CONTRACTION_FACTOR:
            worst = max(worst, wander)
            before[:] = tables.wander_bounds
            top -= 1
        elif (wander > limit and wander < math.inf) or high - low <= MIN_PIECE_SHARE or stop[1] >= MAX_PROOF_PIECES:
            return math.inf
        else:
            middle = 0.5 * (low + high)
            lows[top], highs[top] = middle, high
            lows[top + 1], highs[top + 1] = low, middle
            top += 1
    return worst
