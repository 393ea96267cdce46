"""A whole motion: steps with error control, events, projection after each step, and the books of energy."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import compiled
from hcsearch.kernels.multibody.cuts import cut_energy
from hcsearch.kernels.multibody.events import UP, first_event, pulling, threshold
from hcsearch.kernels.multibody.explicit import Method, step, write_stage
from hcsearch.kernels.multibody.hinges import energies, moment
from hcsearch.kernels.multibody.implicit import implicit_step
from hcsearch.kernels.multibody.motion import Hold, Mechanism, accelerate, largest_pivot, project
from hcsearch.kernels.multibody.stops import collide, regrip
from hcsearch.kernels.multibody.sweeps import move, place
from hcsearch.kernels.multibody.tree import CENTRE, PLACE, TURN, Work
from hcsearch.kernels.multibody.vectors import at, dot, plus, turned

Reals = NDArray[np.float64]
Whole = NDArray[np.int64]

GOES_ON = -1
TIME_OUT, FLAT, REST, TOO_MANY, NO_STEP, OPEN, WRONG, UNBALANCED, JAMMED = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""How a simulation ends: at its last time, flat, at rest elsewhere, out of steps, with steps too small to go on, with
loops that could not be closed, with numbers that are none, with an energy balance that does not hold, or with stops
that have more and more events in no time."""

HIT, LET_GO, SNAP_UP, SNAP_DOWN = 1, 2, 3, 4
"""What happens at an event: a joint comes to its stop, or leaves it; a law snaps."""

REACHED = 1e-11
"""A joint is at a stop within this (rad)."""
CHATTER, CROWDED = 40, 1e-6
"""Stops count as jammed after so many events, each within this share of the time to simulate after the one before: the
loops drive joints against their stops that can hardly move otherwise, as at a dead point."""
BALANCE = 1e-2
"""Error of the energy balance, as a share of the largest energy, at which a simulation is given up."""
APART = 1e-3
"""Closure residual after projection at which loops count as open."""


class Plan(NamedTuple):
    """What a simulation is asked for.

    end : s. tolerance, floor : relative and absolute. first : first step (s), 0 to find one; longest : longest step.
    restitution : of stops, 0 to 1. slow : speed (rad/s) below which stops do not bounce.
    flat : (n,), coordinates of the flat state, NaN where they do not count. near : distance from them that counts as
        flat; below 0 never.
    rest : what a joint may move by its speed or acceleration in the time left, or in 1 s, to be at rest (rad); below 0
        never. closed : residual after projection.
    """

    end: float
    tolerance: float
    floor: float
    first: float
    longest: float
    restitution: float
    slow: float
    flat: Reals
    near: float
    rest: float
    closed: float


class Record(NamedTuple):
    """What a simulation leaves: up to `steps` states and `events` events.

    times : (steps,). q, v, a : (steps, n). books : (steps, 6), energies: kinetic, stored, of gravity, in stops, lost in
        dampers, lost at events. gaps : (steps,), closure residual before projection. counts : (6,), states, events,
        evaluations, rejected steps, outcome, singular evaluations.
    event_times, event_joints, event_kinds, event_speeds : of each event.
    """

    times: Reals
    q: Reals
    v: Reals
    a: Reals
    books: Reals
    gaps: Reals
    counts: Whole
    event_times: Reals
    event_joints: Whole
    event_kinds: Whole
    event_speeds: Reals


@compiled
def simulate(
    mechanism: Mechanism, hold: Hold, method: Method, plan: Plan, q: Reals, v: Reals, work: Work, record: Record
) -> None:
    """Follow a motion from a closed state (q, v), which is moved to the last one; fills the record."""
    n = len(q)
    stages = np.zeros((len(method.b) + 1, 2 * n + 1))
    start, end = np.zeros(2 * n + 1), np.zeros(2 * n + 1)
    a = np.zeros(n)
    books = np.zeros(6)
    counts = record.counts
    counts[:] = 0
    scale = largest_pivot(mechanism, q, work)
    grip = _grip(mechanism, hold, q)
    collide(mechanism, hold, plan.restitution, plan.slow, q, v, scale, plan.closed, work)
    regrip(mechanism, hold, plan.slow, q, v, scale, work, a)
    whole = _balance(mechanism, hold, q, v, work, books)
    largest = np.abs(books).max()
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    _save(record, hold, 0.0, q, v, a, books, 0.0)
    start[:n], start[n : 2 * n], start[2 * n] = q, v, books[4]
    write_stage(mechanism, hold, start, a, work, stages[0])
    time, h = 0.0, _first_step(plan, method.order, q, v, a)
    rejected, crowd, crowd_time = False, 0, 0.0
    counts[4] = GOES_ON
    while counts[4] == GOES_ON:
        counts[4] = _ending(plan, hold, time, h, q, v, a, record)
        if counts[4] != GOES_ON:
            break
        h = min(h, plan.longest, plan.end - time)
        error = _step(mechanism, hold, method, plan, h, scale, work, stages, start, end, counts)
        if not error <= 1.0:
            counts[3] += 1
            h *= max(0.1, 0.9 * error ** (-1.0 / method.order)) if error < 1e100 else 0.1
            rejected = True
            continue
        last = stages[len(method.b)]
        share, joint, kind = first_event(
            mechanism, hold, h, start[:n], start[n : 2 * n], a, end[:n], end[n : 2 * n], last[n : 2 * n]
        )
        took = h
        if share <= 1.0:
            took = _land(
                mechanism, hold, method, plan, share * h, h, joint, kind, scale, work, stages, start, end, counts
            )
        else:
            took = _loosen(mechanism, hold, method, plan, grip, h, scale, work, stages, start, end, counts)
        q[:], v[:], books[4] = end[:n], end[n : 2 * n], end[2 * n]
        time += took
        gap, _ = project(mechanism.tree, hold.held, q, v, plan.closed, work)
        if share <= 1.0:
            crowd = crowd + 1 if time - crowd_time <= CROWDED * plan.end else 0
            crowd_time = time
            _note(record, time, joint, HIT if kind < 2 else (SNAP_UP if kind == UP else SNAP_DOWN), v[joint])
            # a state before the event and one after it: what is between steps follows from both their ends
            accelerate(mechanism, hold, q, v, scale, True, work, a)
            counts[2] += 1
            _balance(mechanism, hold, q, v, work, books)
            _save(record, hold, time, q, v, a, books, gap)
            _happen(mechanism, hold, plan, joint, kind, q, v, scale, work, a, books)
        else:
            accelerate(mechanism, hold, q, v, scale, True, work, a)
            counts[2] += 1
            if pulling(hold, grip, a):
                _let_go(mechanism, hold, plan, time, q, v, scale, work, a, record)
            _balance(mechanism, hold, q, v, work, books)
        accelerate(mechanism, hold, q, v, scale, True, work, a)
        _save(record, hold, time, q, v, a, books, gap)
        start[:n], start[n : 2 * n], start[2 * n] = q, v, books[4]
        write_stage(mechanism, hold, start, a, work, stages[0])
        largest = max(largest, np.abs(books).max())
        if not gap <= APART:
            counts[4] = OPEN if gap > APART else WRONG
        elif not abs(books.sum() - whole) <= BALANCE * largest:
            counts[4] = UNBALANCED
        elif crowd > CHATTER:
            counts[4] = JAMMED
        grow = 5.0 if error == 0.0 else min(5.0, 0.9 * error ** (-1.0 / method.order))
        if share > 1.0:
            h *= max(0.2, min(grow, 1.0) if rejected else grow)
        rejected = False


@compiled
def _step(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    h: float,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """One step by the method; its error. The last stage holds the derivative at its end."""
    if not method.columns:
        counts[2] += len(method.b)
        return step(mechanism, hold, method, plan.tolerance, plan.floor, h, scale, work, stages, start, end)
    n, columns = len(hold.held), method.columns
    counts[2] += columns * (columns + 1) // 2 + 1
    error = implicit_step(mechanism, hold, columns, plan.tolerance, plan.floor, h, scale, work, stages[1:], start, end)
    a = np.empty(n)
    accelerate(mechanism, hold, end[:n], end[n : 2 * n], scale, False, work, a)
    write_stage(mechanism, hold, end, a, work, stages[columns])
    return error


@compiled
def _ending(plan: Plan, hold: Hold, time: float, h: float, q: Reals, v: Reals, a: Reals, record: Record) -> int:
    """How the simulation ends here, or that it goes on."""
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
    elif h < 1e-15 * max(time, 1e-3 * plan.end):
        ending = NO_STEP
    return ending


@compiled
def _happen(
    mechanism: Mechanism,
    hold: Hold,
    plan: Plan,
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
    plan: Plan,
    time: float,
    q: Reals,
    v: Reals,
    scale: float,
    work: Work,
    a: Reals,
    record: Record,
) -> None:
    """Free the joints that their stops would have to pull, where the others do not hold them."""
    before = hold.held.copy()
    if regrip(mechanism, hold, plan.slow, q, v, scale, work, a):
        for i in range(len(q)):
            if before[i] and not hold.held[i]:
                _note(record, time, i, LET_GO, 0.0)


@compiled
def _grip(mechanism: Mechanism, hold: Hold, q: Reals) -> float:
    """Pull (N m) that a stop may show before it is looked at: rounding, beside the moments at the start."""
    grip = 1e-300
    for i in range(len(q)):
        value, _ = moment(mechanism.hinges, i, hold.branches[i], q[i])
        grip = max(grip, 1e-7 * abs(value))
    return grip


@compiled
def _balance(mechanism: Mechanism, hold: Hold, q: Reals, v: Reals, work: Work, books: Reals) -> float:
    """Write the energies of a state into the first four entries; their sum."""
    found = np.empty(4)
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
    total = 0.0
    for k in range(4):
        books[k] = found[k]
        total += found[k]
    return total


@compiled
def _first_step(plan: Plan, order: int, q: Reals, v: Reals, a: Reals) -> float:
    """A first step from the size of the motion (Hairer, Norsett and Wanner 1993, section II.4, in part)."""
    if plan.first > 0.0:
        return plan.first
    n = len(q)
    size = rate = 0.0
    for i in range(n):
        weight_q, weight_v = plan.floor + plan.tolerance * abs(q[i]), plan.floor + plan.tolerance * abs(v[i])
        size += (q[i] / weight_q) ** 2 + (v[i] / weight_v) ** 2
        rate += (v[i] / weight_q) ** 2 + (a[i] / weight_v) ** 2
    if rate == 0.0:
        return plan.longest
    guess = 0.01 * math.sqrt(size / rate) if size > 0.0 else 1e-6
    return min(plan.longest, max(guess, 1e-9 * plan.end))


@compiled
def _land(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    guess: float,
    longest: float,
    joint: int,
    kind: int,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """Repeat the step so that it ends where the joint has its event; its length."""
    n = len(hold.held)
    limit = threshold(mechanism, hold, joint, kind)
    h = guess
    low, high = 0.0, longest
    for _ in range(12):
        _step(mechanism, hold, method, plan, h, scale, work, stages, start, end, counts)
        past = (end[joint] - limit) * (1.0 if kind % 2 else -1.0)
        if abs(past) <= REACHED:
            break
        if past > 0.0:
            high = min(high, h)
        else:
            low = max(low, h)
        speed = end[n + joint]
        trial = h - (end[joint] - limit) / speed if speed != 0.0 else 0.5 * (low + high)
        h = trial if low < trial < high else 0.5 * (low + high)
    return h


@compiled
def _loosen(
    mechanism: Mechanism,
    hold: Hold,
    method: Method,
    plan: Plan,
    grip: float,
    longest: float,
    scale: float,
    work: Work,
    stages: Reals,
    start: Reals,
    end: Reals,
    counts: Whole,
) -> float:
    """Repeat the step so that it ends where a stop begins to pull, if one does at its end only; its length.

    A step across a release would have an error of its own length squared, whatever the tolerance. The factor that is
    left is one at the end, for the projection that follows.
    """
    n = len(hold.held)
    if not np.abs(hold.held).max():
        return longest
    above = _pull(mechanism, hold, plan, scale, work, end)
    if not above > grip:
        return longest
    below = _pull(mechanism, hold, plan, scale, work, start)
    low, high, h = 0.0, longest, longest
    for k in range(40):
        if below > grip or above <= 3.0 * grip or high - low <= 1e-12 * longest:
            break
        # by the secant, a third of the times by halves, so that one end does not stay
        share = 0.5 if k % 3 == 2 else (2.0 * grip - below) / (above - below)
        h = low + (high - low) * min(max(share, 0.01), 0.99)
        accelerate(mechanism, hold, start[:n], start[n : 2 * n], scale, True, work, np.empty(n))
        _step(mechanism, hold, method, plan, h, scale, work, stages, start, end, counts)
        pull = _pull(mechanism, hold, plan, scale, work, end)
        if pull > grip:
            high, above = h, pull
        else:
            low, below = h, pull
    accelerate(mechanism, hold, start[:n], start[n : 2 * n], scale, True, work, np.empty(n))
    _step(mechanism, hold, method, plan, high, scale, work, stages, start, end, counts)
    return high


@compiled
def _pull(mechanism: Mechanism, hold: Hold, plan: Plan, scale: float, work: Work, state: Reals) -> float:
    """By how much a stop would have to pull at most at a state (q, v, energy lost), N m."""
    n = len(hold.held)
    q, v, forces = state[:n].copy(), state[n : 2 * n].copy(), np.empty(n)
    project(mechanism.tree, hold.held, q, v, plan.closed, work)
    accelerate(mechanism, hold, q, v, scale, True, work, forces)
    most = 0.0
    for i in range(n):
        most = max(most, hold.held[i] * forces[i])
    return most


@compiled
def _save(record: Record, hold: Hold, time: float, q: Reals, v: Reals, a: Reals, books: Reals, gap: float) -> None:
    k = record.counts[0]
    if k < len(record.times):
        record.times[k] = time
        record.q[k] = q
        record.v[k] = v
        for i in range(len(q)):
            record.a[k, i] = 0.0 if hold.held[i] else a[i]
        record.books[k] = books
        record.gaps[k] = gap
        record.counts[0] += 1


@compiled
def _note(record: Record, time: float, joint: int, kind: int, speed: float) -> None:
    k = record.counts[1]
    if k < len(record.event_times):
        record.event_times[k] = time
        record.event_joints[k] = joint
        record.event_kinds[k] = kind
        record.event_speeds[k] = speed
    record.counts[1] += 1
