"""A whole motion: steps with error control, events, projection after each step, and the books of energy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.algebra.vectors import at, dot, plus, turned
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.multibody.cuts import cut_energy, cut_gap
from hcsearch.kernels.multibody.events import UP, Span, first_event, first_near, greatest_pull
from hcsearch.kernels.multibody.explicit import Method, write_stage
from hcsearch.kernels.multibody.hinges import energies, moment
from hcsearch.kernels.multibody.motion import (
    Hold,
    Mechanism,
    Stepper,
    accelerate,
    closure_energy,
    largest_pivot,
    project,
)
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
"""Of a simulation between two states: time and next step (s), the pivot that others are compared to, the pull above
which a stop may let go (N m), energy at the start and the largest (J), whether stops that seemed to pull were kept, how
many events came one upon the other, and when the last of them, and how many there were since all joints are close to
the coordinates that follow, from `HERE` on."""


class Simulation(NamedTuple):
    """A simulation between two states.

    q, v : (n,), the state that it has come to. pace : (HERE + n,), of `pace_for`.
    """

    mechanism: Mechanism
    hold: Hold
    method: Method
    plan: StepPlan
    q: Reals
    v: Reals
    work: Work
    pace: Reals
    record: Record


@compiled
def simulate(
    mechanism: Mechanism, hold: Hold, method: Method, plan: StepPlan, q: Reals, v: Reals, work: Work, record: Record
) -> None:
    """Follow a motion from a closed state (q, v), which is moved to the last one; fills the record."""
    simulation = Simulation(mechanism, hold, method, plan, q, v, work, pace_for(len(q)), record)
    begin(simulation)
    go_on(simulation, len(record.times) + 1)


@compiled
def pace_for(n: int) -> Reals:
    """Room for the pace of a simulation of n joints."""
    return np.empty(HERE + n)


@compiled
def begin(simulation: Simulation) -> None:
    """Write the first state of a motion, after the impacts in it, and the pace at which it goes on."""
    mechanism, hold, plan, work = simulation.mechanism, simulation.hold, simulation.plan, simulation.work
    q, v, pace, record = simulation.q, simulation.v, simulation.pace, simulation.record
    a, books = np.zeros(len(q)), np.zeros(6)
    record.counts[:] = 0
    record.counts[4] = GOES_ON
    work.clock[0] = 0.0
    scale = largest_pivot(mechanism, q, work)
    pace[:HERE], pace[HERE:] = 0.0, q
    pace[SCALE], pace[GRIP] = scale, _grip(mechanism, hold, q)
    collide(mechanism, hold, plan.restitution, plan.slow, q, v, scale, plan.closed, work)
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    pace[WHOLE] = _balance(simulation, books)
    pace[LARGEST] = np.abs(books).max()
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    pace[STEP] = first_step(plan, simulation.method.order, q, v, a)
    save(record, hold, 0.0, q, v, a, books, 0.0)


@compiled
def go_on(simulation: Simulation, most: int) -> None:
    """Follow a motion from the last state of its record until it ends, or the record holds so many states.

    It is the same motion however often it stops on the way.
    """
    mechanism, hold, method, plan = simulation.mechanism, simulation.hold, simulation.method, simulation.plan
    q, v, work, pace, record = simulation.q, simulation.v, simulation.work, simulation.pace, simulation.record
    n = len(q)
    stages = np.zeros((len(method.b) + 1, 2 * n + 2))
    start, end = np.zeros(2 * n + 2), np.zeros(2 * n + 2)
    a = np.zeros(n)
    counts = record.counts
    books = record.books[counts[0] - 1].copy()
    scale, rejected = pace[SCALE], False
    stepper = Stepper(mechanism, hold, scale, plan.tolerance, plan.floor, work, stages, start, end, counts)
    work.clock[0] = pace[TIME]
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    start[:n], start[n : 2 * n], start[2 * n], start[2 * n + 1] = q, v, books[4], pace[TIME]
    write_stage(mechanism, hold, start, a, work, stages[0])
    turns = np.zeros(n + len(mechanism.cuts.bodies))
    all_turns(mechanism, q, v, work, turns, turns.copy())
    while counts[4] == GOES_ON and (counts[0] < most or rejected):
        counts[4] = _ending_before(simulation, a)
        if counts[4] != GOES_ON:
            break
        pace[STEP] = min(pace[STEP], plan.longest, plan.end - pace[TIME])
        error = take_step(method, stepper, pace[STEP])
        if not error <= 1.0:
            counts[3] += 1
            pace[STEP] *= max(0.1, 0.9 * error ** (-1.0 / method.order)) if error < 1e100 else 0.1
            rejected = True
            continue
        took, came, joint, kind = _shorten(simulation, stepper, a)
        q[:], v[:], books[4] = end[:n], end[n : 2 * n], end[2 * n]
        pace[TIME] += took
        work.clock[0] = pace[TIME]
        gap, _ = project(mechanism.tree, hold.held, q, v, plan.closed, work)
        if len(mechanism.cuts.bodies):
            gap = cut_gap(mechanism.cuts, work) / mechanism.tree.size
        if kind >= 0:
            _meet(simulation, joint, kind, gap, a, books)
        else:
            _arrive(simulation, came < 1.0, took <= LEAST * pace[STEP], a, books)
        if mechanism.hinges.stop_stiffness > 0.0:
            note_stops(mechanism, pace[TIME], took, q, v, work, turns, record)
        save(record, hold, pace[TIME], q, v, a, books, gap)
        start[:n], start[n : 2 * n], start[2 * n], start[2 * n + 1] = q, v, books[4], pace[TIME]
        write_stage(mechanism, hold, start, a, work, stages[0])
        _tally(pace, q, books)
        counts[4] = _ending_after(mechanism, plan, gap, came < 1.0, pace, books)
        grow = 5.0 if error == 0.0 else min(5.0, 0.9 * error ** (-1.0 / method.order))
        if kind < 0:
            pace[STEP] *= max(0.2, min(grow, 1.0) if rejected else grow)
        rejected = False


@lean
def _shorten(simulation: Simulation, stepper: Stepper, a: Reals) -> tuple[float, float, int, int]:
    """Repeat a step, where need be, so that it ends at its first event, at a release, or where the system is flat.

    Returns how long it is (s), at which share of it the system is flat (2 where it is not), and joint and kind of the
    event that it ends in, -1 where it ends in none.
    """
    method, plan, pace = simulation.method, simulation.plan, simulation.pace
    n, h = len(a), pace[STEP]
    firm = pace[FIRM] > 0.0
    pace[FIRM] = 0.0
    start, end, last = stepper.start, stepper.end, stepper.stages[len(method.b)]
    span = Span(h, start[:n], start[n : 2 * n], a, end[:n], end[n : 2 * n], last[n : 2 * n])
    share, joint, kind = first_event(simulation.mechanism, simulation.hold, span)
    if kind >= 0:
        took = land(method, stepper, share * h, h, joint, kind)
    else:
        took = loosen(method, stepper, plan.closed, pace[GRIP], firm, h)
    came = 2.0
    if plan.near >= 0.0 and took > 0.0:
        # the step is another now, in the same tables
        span = Span(took, span.q0, span.v0, a, span.q1, span.v1, span.a1)
        came = first_near(span, plan.flat, plan.near)
    if came < 1.0:
        took, kind = came * took, -1
        take_step(method, stepper, took)
    return took, came, joint, kind


@lean
def _meet(simulation: Simulation, joint: int, kind: int, gap: float, a: Reals, books: Reals) -> None:
    """Note an event and carry it out; saves the state before it, as what is between steps follows from both ends."""
    mechanism, hold, work = simulation.mechanism, simulation.hold, simulation.work
    q, v, pace, record = simulation.q, simulation.v, simulation.pace, simulation.record
    time = pace[TIME]
    pace[EVENTS] += 1.0
    pace[CROWD] = pace[CROWD] + 1.0 if time - pace[CROWD_TIME] <= CROWDED * simulation.plan.end else 0.0
    pace[CROWD_TIME] = time
    if kind < 2:
        note_hits(mechanism, hold, time, joint, q, v, record)
    else:
        note(record, time, joint, SNAP_UP if kind == UP else SNAP_DOWN, v[joint])
    accelerate(mechanism, hold, q, v, pace[SCALE], True, work, a)
    _balance(simulation, books)
    save(record, hold, time, q, v, a, books, gap)
    _happen(simulation, joint, kind, a, books)
    accelerate(mechanism, hold, q, v, pace[SCALE], True, work, a)
    record.counts[2] += 2


@lean
def _arrive(simulation: Simulation, flat: bool, short: bool, a: Reals, books: Reals) -> None:
    """End a step without an event: free joints whose stops would have to pull, unless all is over.

    short : whether a pull has ended it where it began; the next step stands, if it was none.
    """
    hold, pace = simulation.hold, simulation.pace
    accelerate(simulation.mechanism, hold, simulation.q, simulation.v, pace[SCALE], True, simulation.work, a)
    simulation.record.counts[2] += 1
    pulls = greatest_pull(hold, a) > pace[GRIP]
    if not flat and (pulls or short):
        if pulls and _let_go(simulation, a):
            pace[EVENTS] += 1.0
        else:
            pace[FIRM] = 1.0
    _balance(simulation, books)


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
def _ending_before(simulation: Simulation, a: Reals) -> int:
    """How the simulation ends before a step, or that it goes on."""
    hold, plan, pace, record = simulation.hold, simulation.plan, simulation.pace, simulation.record
    q, v, time = simulation.q, simulation.v, pace[TIME]
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
def _happen(simulation: Simulation, joint: int, kind: int, a: Reals, books: Reals) -> None:
    """Carry out an event, and book the energy that it takes."""
    mechanism, hold, plan, work = simulation.mechanism, simulation.hold, simulation.plan, simulation.work
    q, v, scale = simulation.q, simulation.v, simulation.pace[SCALE]
    before = _balance(simulation, books)
    if kind < 2:
        collide(mechanism, hold, plan.restitution, plan.slow, q, v, scale, plan.closed, work)
    else:
        hold.branches[joint] = 1 - hold.branches[joint]
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    project(mechanism.tree, hold.held, q, v, plan.closed, work)
    books[5] += before - _balance(simulation, books)


@compiled
def _let_go(simulation: Simulation, a: Reals) -> bool:
    """Free the joints that their stops would have to pull, where the others do not hold them; whether any is free."""
    hold, q, v, pace = simulation.hold, simulation.q, simulation.v, simulation.pace
    before = hold.held.copy()
    regrip(simulation.mechanism, hold, simulation.plan.slow, q, v, pace[SCALE], simulation.work, a)
    free = False
    for i in range(len(q)):
        if before[i] and not hold.held[i]:
            note(simulation.record, pace[TIME], i, LET_GO, 0.0)
            free = True
    return free


@lean
def _grip(mechanism: Mechanism, hold: Hold, q: Reals) -> float:
    """Pull (N m) up to which stops hold all the same: rounding, beside the moments at the start."""
    grip = 1e-300
    for i in range(len(q)):
        value, _ = moment(mechanism.hinges, i, hold.branches[i], q[i])
        grip = max(grip, 1e-7 * abs(value))
    return grip


@lean
def _balance(simulation: Simulation, books: Reals) -> float:
    """Write the energies of a state into the first four entries; their sum."""
    mechanism, hold, q, work = simulation.mechanism, simulation.hold, simulation.q, simulation.work
    parts = books[:4]
    place(mechanism.tree, q, work)
    move(mechanism.tree, simulation.v, work)
    energies(mechanism.tree, mechanism.hinges, mechanism.struts, hold.branches, q, work, parts)
    for i in range(len(mechanism.loads)):
        arm = turned(work.bodies, i, TURN, at(mechanism.tree.bodies, i, CENTRE))
        parts[2] -= dot(at(mechanism.loads, i, 0), plus(at(work.bodies, i, PLACE), arm))
    if len(mechanism.cuts.bodies):
        stored, stops, across, _ = cut_energy(mechanism.cuts, hold.cut_branches, work)
        parts[1] += stored
        parts[3] += stops + across
    stored, _ = closure_energy(mechanism, work)
    parts[3] += stored
    total: float = parts[0] + parts[1] + parts[2] + parts[3]
    return total
