"""A whole motion: steps with error control, events, projection after each step, and the books of energy."""

from __future__ import annotations

import numpy as np

from hcsearch.kernels.algebra.vectors import at, dot, plus, turned
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.multibody.cuts import cut_energy, cut_gap
from hcsearch.kernels.multibody.events import UP, first_event, first_near, greatest_pull
from hcsearch.kernels.multibody.explicit import Method, write_stage
from hcsearch.kernels.multibody.hinges import energies, moment
from hcsearch.kernels.multibody.motion import Hold, Mechanism, accelerate, closure_energy, largest_pivot, project
from hcsearch.kernels.multibody.recording import (
    LET_GO,
    SNAP_DOWN,
    SNAP_UP,
    Record,
    all_turns,
    note,
    note_hits,
    note_stops,
    save,
)
from hcsearch.kernels.multibody.steps import LEAST, StepPlan, first_step, land, loosen, take_step
from hcsearch.kernels.multibody.stops import collide, regrip
from hcsearch.kernels.multibody.sweeps import move, place
from hcsearch.kernels.multibody.tree import CENTRE, PLACE, TURN, Work
from hcsearch.typing import Reals, Whole

GOES_ON = -1
TIME_OUT, FLAT, REST, TOO_MANY, NO_STEP, OPEN, WRONG, UNBALANCED, JAMMED = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""How a simulation ends: at its last time, flat, at rest elsewhere, out of steps, with steps too small to go on, with
loops that could not be closed, with numbers that are none, with an energy balance that does not hold, or with stops
that have event after event and hardly move."""

CHATTER, CROWDED = 40, 1e-6
"""Stops count as jammed after so many events, each within this share of the time to simulate after the one before: the
loops drive joints against their stops that can hardly move otherwise, as at a dead point."""
RATTLE, CLOSE = 100, 1e-3
"""They are jammed, too, after so many events and releases between which no step ends with a joint further away than
this (rad); where stops bounce with a restitution e, after 1 / (1 - e) times as many, as a step may span a bounce. Of 14
squares, motions that come flat have at most 34."""
BALANCE = 1e-2
"""Error of the energy balance, as a share of the largest energy, at which a simulation is given up."""
APART = 1e-3
"""Closure residual after projection at which loops count as open."""

TIME, STEP, SCALE, GRIP, WHOLE, LARGEST, FIRM, CROWD, CROWD_TIME, EVENTS, HERE = range(11)
"""Of a simulation between two states: time and next step (s), the pivot that others are compared to, the pull at which
stops are looked at (N m), energy at the start and the largest (J), whether stops that seemed to pull were kept, how
many events came one upon the other, and when the last of them, and how many there were since all joints are close to
the coordinates that follow, from `HERE` on."""


@compiled
def simulate(
    mechanism: Mechanism, hold: Hold, method: Method, plan: StepPlan, q: Reals, v: Reals, work: Work, record: Record
) -> None:
    """Follow a motion from a closed state (q, v), which is moved to the last one; fills the record."""
    pace = pace_for(len(q))
    begin(mechanism, hold, method, plan, q, v, work, pace, record)
    go_on(mechanism, hold, method, plan, len(record.times) + 1, q, v, work, pace, record)


@compiled
def pace_for(n: int) -> Reals:
    """Room for the pace of a simulation of n joints."""
    return np.empty(HERE + n)


@compiled
def begin(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: StepPlan,
    q: Reals,
    v: Reals,
    work: Work,
    pace: Reals,
    record: Record,
) -> None:
    """Write the first state of a motion, after the impacts in it, and the pace at which it goes on."""
    a, books = np.zeros(len(q)), np.zeros(6)
    record.counts[:] = 0
    record.counts[4] = GOES_ON
    scale = largest_pivot(mechanism, q, work)
    pace[:HERE], pace[HERE:] = 0.0, q
    pace[SCALE], pace[GRIP] = scale, _grip(mechanism, hold, q)
    collide(mechanism, hold, plan.restitution, plan.slow, q, v, scale, plan.closed, work)
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    pace[WHOLE] = _balance(mechanism, hold, q, v, work, books)
    pace[LARGEST] = np.abs(books).max()
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    pace[STEP] = first_step(plan, method.order, q, v, a)
    save(record, hold, 0.0, q, v, a, books, 0.0)


@compiled
def go_on(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: StepPlan,
    most: int,
    q: Reals,
    v: Reals,
    work: Work,
    pace: Reals,
    record: Record,
) -> None:
    """Follow a motion from the last state of its record until it ends, or the record holds so many states.

    It is the same motion however often it stops on the way.
    """
    n = len(q)
    stages = np.zeros((len(method.b) + 1, 2 * n + 1))
    start, end = np.zeros(2 * n + 1), np.zeros(2 * n + 1)
    a = np.zeros(n)
    counts = record.counts
    books = record.books[counts[0] - 1].copy()
    scale, rejected = pace[SCALE], False
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    start[:n], start[n : 2 * n], start[2 * n] = q, v, books[4]
    write_stage(mechanism, hold, start, a, work, stages[0])
    turns = np.zeros(n + len(mechanism.cuts.bodies))
    all_turns(mechanism, q, v, work, turns, turns.copy())
    while counts[4] == GOES_ON and (counts[0] < most or rejected):
        counts[4] = _ending_before(plan, hold, pace, q, v, a, record)
        if counts[4] != GOES_ON:
            break
        pace[STEP] = min(pace[STEP], plan.longest, plan.end - pace[TIME])
        error = take_step(mechanism, hold, method, plan, pace[STEP], scale, work, stages, start, end, counts)
        if not error <= 1.0:
            counts[3] += 1
            pace[STEP] *= max(0.1, 0.9 * error ** (-1.0 / method.order)) if error < 1e100 else 0.1
            rejected = True
            continue
        took, came, joint, kind = _shorten(mechanism, hold, method, plan, a, work, stages, start, end, pace, counts)
        q[:], v[:], books[4] = end[:n], end[n : 2 * n], end[2 * n]
        pace[TIME] += took
        gap, _ = project(mechanism.tree, hold.held, q, v, plan.closed, work)
        if len(mechanism.cuts.bodies):
            gap = cut_gap(mechanism.cuts, work) / mechanism.tree.size
        if kind >= 0:
            _meet(mechanism, hold, plan, joint, kind, gap, q, v, work, pace, a, books, record)
        else:
            _arrive(mechanism, hold, plan, came < 1.0, took <= LEAST * pace[STEP], q, v, work, pace, a, books, record)
        if mechanism.hinges.stop_stiffness > 0.0:
            note_stops(mechanism, pace[TIME], took, q, v, work, turns, record)
        save(record, hold, pace[TIME], q, v, a, books, gap)
        start[:n], start[n : 2 * n], start[2 * n] = q, v, books[4]
        write_stage(mechanism, hold, start, a, work, stages[0])
        _tally(pace, q, books)
        counts[4] = _ending_after(mechanism, plan, gap, came < 1.0, pace, books)
        grow = 5.0 if error == 0.0 else min(5.0, 0.9 * error ** (-1.0 / method.order))
        if kind < 0:
            pace[STEP] *= max(0.2, min(grow, 1.0) if rejected else grow)
        rejected = False


@lean
def _shorten(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: StepPlan,
    a: Reals,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    pace: Reals,
    counts: Whole,
) -> tuple[float, float, int, int]:
    """Repeat a step, where need be, so that it ends at its first event, at a release, or where the system is flat.

    Returns how long it is (s), at which share of it the system is flat (2 where it is not), and joint and kind of the
    event that it ends in, -1 where it ends in none.
    """
    n, h, scale = len(a), pace[STEP], pace[SCALE]
    firm = pace[FIRM] > 0.0
    pace[FIRM] = 0.0
    last = stages[len(method.b)]
    share, joint, kind = first_event(
        mechanism, hold, h, start[:n], start[n : 2 * n], a, end[:n], end[n : 2 * n], last[n : 2 * n]
    )
    if kind >= 0:
        guess = share * h
        took = land(mechanism, hold, method, plan, guess, h, joint, kind, scale, work, stages, start, end, counts)
    else:
        grip = pace[GRIP]
        took = loosen(mechanism, hold, method, plan, grip, firm, h, scale, work, stages, start, end, counts)
    came = 2.0
    if plan.near >= 0.0 and took > 0.0:
        came = first_near(
            took, start[:n], start[n : 2 * n], a, end[:n], end[n : 2 * n], last[n : 2 * n], plan.flat, plan.near
        )
    if came < 1.0:
        took, kind = came * took, -1
        take_step(mechanism, hold, method, plan, took, scale, work, stages, start, end, counts)
    return took, came, joint, kind


@lean
def _meet(
    mechanism: Mechanism,
    hold: Hold,
    plan: StepPlan,
    joint: int,
    kind: int,
    gap: float,
    q: Reals,
    v: Reals,
    work: Work,
    pace: Reals,
    a: Reals,
    books: Reals,
    record: Record,
) -> None:
    """Note an event and carry it out; saves the state before it, as what is between steps follows from both ends."""
    time = pace[TIME]
    pace[EVENTS] += 1.0
    pace[CROWD] = pace[CROWD] + 1.0 if time - pace[CROWD_TIME] <= CROWDED * plan.end else 0.0
    pace[CROWD_TIME] = time
    if kind < 2:
        note_hits(mechanism, hold, time, joint, q, v, record)
    else:
        note(record, time, joint, SNAP_UP if kind == UP else SNAP_DOWN, v[joint])
    accelerate(mechanism, hold, q, v, pace[SCALE], True, work, a)
    _balance(mechanism, hold, q, v, work, books)
    save(record, hold, time, q, v, a, books, gap)
    _happen(mechanism, hold, plan, joint, kind, q, v, pace[SCALE], work, a, books)
    accelerate(mechanism, hold, q, v, pace[SCALE], True, work, a)
    record.counts[2] += 2


@lean
def _arrive(
    mechanism: Mechanism,
    hold: Hold,
    plan: StepPlan,
    flat: bool,
    short: bool,
    q: Reals,
    v: Reals,
    work: Work,
    pace: Reals,
    a: Reals,
    books: Reals,
    record: Record,
) -> None:
    """End a step without an event: free joints whose stops would have to pull, unless all is over.

    short : whether a pull has ended it where it began; the next step stands, if it was none.
    """
    accelerate(mechanism, hold, q, v, pace[SCALE], True, work, a)
    record.counts[2] += 1
    pulls = greatest_pull(hold, a) > pace[GRIP]
    if not flat and (pulls or short):
        if pulls and _let_go(mechanism, hold, plan, pace[TIME], q, v, pace[SCALE], work, a, record):
            pace[EVENTS] += 1.0
        else:
            pace[FIRM] = 1.0
    _balance(mechanism, hold, q, v, work, books)


@lean
def _tally(pace: Reals, q: Reals, books: Reals) -> None:
    """Note the largest energy, and count events anew, from here, where a joint has gone further than `CLOSE`."""
    away = False
    for i in range(len(q)):
        away = away or abs(q[i] - pace[HERE + i]) > CLOSE
    if away:
        pace[EVENTS] = 0.0
        for i in range(len(q)):
            pace[HERE + i] = q[i]
    for i in range(len(books)):
        pace[LARGEST] = max(pace[LARGEST], abs(books[i]))


@lean
def _ending_after(mechanism: Mechanism, plan: StepPlan, gap: float, flat: bool, pace: Reals, books: Reals) -> int:
    """How the simulation ends after a step, or that it goes on."""
    apart = APART if mechanism.closure_stiffness == 0.0 else np.inf
    ending = GOES_ON
    if not gap <= apart:
        ending = OPEN if gap > apart else WRONG
    elif not abs(books.sum() - pace[WHOLE]) <= BALANCE * pace[LARGEST]:
        ending = UNBALANCED
    elif pace[CROWD] > CHATTER or pace[EVENTS] * (1.0 - plan.restitution) > RATTLE:
        ending = JAMMED
    elif flat:
        ending = FLAT
    return ending


@lean
def _ending_before(plan: StepPlan, hold: Hold, pace: Reals, q: Reals, v: Reals, a: Reals, record: Record) -> int:
    """How the simulation ends before a step, or that it goes on."""
    time = pace[TIME]
    near = plan.near >= 0.0
    for i in range(len(q)):
        near = near and not abs(q[i] - plan.flat[i]) > plan.near
    still = plan.rest >= 0.0
    left = max(1.0, plan.end - time)  # a slow motion that has long to go is none at rest
    for i in range(len(q)):
        still = still and (hold.held[i] != 0 or (abs(v[i]) * left <= plan.rest and abs(a[i]) * left**2 <= plan.rest))
    ending = GOES_ON
    if near:
        ending = FLAT
    elif time >= plan.end * (1.0 - 1e-14):
        ending = TIME_OUT
    elif still:
        ending = REST
    elif record.counts[0] >= len(record.times):
        ending = TOO_MANY
    elif pace[STEP] < 1e-15 * max(time, 1e-3 * plan.end):
        ending = NO_STEP
    return ending


@lean
def _happen(
    mechanism: Mechanism,
    hold: Hold,
    plan: StepPlan,
    joint: int,
    kind: int,
    q: Reals,
    v: Reals,
    scale: float,
    work: Work,
    a: Reals,
    books: Reals,
) -> None:
    """Carry out an event, and book the energy that it takes."""
    before = _balance(mechanism, hold, q, v, work, books)
    if kind < 2:
        collide(mechanism, hold, plan.restitution, plan.slow, q, v, scale, plan.closed, work)
    else:
        hold.branches[joint] = 1 - hold.branches[joint]
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    project(mechanism.tree, hold.held, q, v, plan.closed, work)
    books[5] += before - _balance(mechanism, hold, q, v, work, books)


@compiled
def _let_go(
    mechanism: Mechanism,
    hold: Hold,
    plan: StepPlan,
    time: float,
    q: Reals,
    v: Reals,
    scale: float,
    work: Work,
    a: Reals,
    record: Record,
) -> bool:
    """Free the joints that their stops would have to pull, where the others do not hold them; whether any is free."""
    before = hold.held.copy()
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    free = False
    for i in range(len(q)):
        if before[i] and not hold.held[i]:
            note(record, time, i, LET_GO, 0.0)
            free = True
    return free


@lean
def _grip(mechanism: Mechanism, hold: Hold, q: Reals) -> float:
    """Pull (N m) that a stop may show before it is looked at: rounding, beside the moments at the start."""
    grip = 1e-300
    for i in range(len(q)):
        value, _ = moment(mechanism.hinges, i, hold.branches[i], q[i])
        grip = max(grip, 1e-7 * abs(value))
    return grip


@lean
def _balance(mechanism: Mechanism, hold: Hold, q: Reals, v: Reals, work: Work, books: Reals) -> float:
    """Write the energies of a state into the first four entries; their sum."""
    found = books[:4]
    place(mechanism.tree, q, work)
    move(mechanism.tree, v, work)
    energies(mechanism.tree, mechanism.hinges, mechanism.struts, hold.branches, q, work, found)
    for i in range(len(mechanism.loads)):
        arm = turned(work.bodies, i, TURN, at(mechanism.tree.bodies, i, CENTRE))
        found[2] -= dot(at(mechanism.loads, i, 0), plus(at(work.bodies, i, PLACE), arm))
    if len(mechanism.cuts.bodies):
        stored, stops, across, _ = cut_energy(mechanism.cuts, hold.cut_branches, work)
        found[1] += stored
        found[3] += stops + across
    stored, _ = closure_energy(mechanism, work)
    found[3] += stored
    total: float = found[0] + found[1] + found[2] + found[3]
    return total
