"""Records of simulations: states, energies and events."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import DiscreteState, Mechanism
from hcsearch.kernels.multibody.events import NEAR_STOP_ANGLE
from hcsearch.kernels.multibody.sweeps import move_bodies, place_bodies
from hcsearch.kernels.multibody.tree import Work
from hcsearch.kernels.multibody.welds import cut_angles

RECORDED_HIT, RECORDED_RELEASE, RECORDED_SNAP_UP, RECORDED_SNAP_DOWN, RECORDED_STICK, RECORDED_SLIP = 1, 2, 3, 4, 5, 6
"""Kinds of recorded events: a joint hits its stop, a joint leaves its stop, a law snaps up, a law snaps down, a joint
begins to be held by friction, a joint begins to slide."""


class SimulationRecord(NamedTuple):
    """The record of a simulation: up to `steps` states and `events` events.

    times : (steps,). q, v, a : (steps, n). energies : (steps, 6): kinetic, stored, of gravity, in stops, lost in
        dampers and to friction, lost at events. closure_residuals : (steps,), before projection. counts : (6,),
        states, events, evaluations, rejected steps, ending, states before steps of the stiff method (-1 if none is).
    event_times, event_joints, event_kinds, event_speeds : of each event; cut hinges are counted after the joints.
    """

    times: Reals
    q: Reals
    v: Reals
    a: Reals
    energies: Reals
    closure_residuals: Reals
    counts: WholeNumbers
    event_times: Reals
    event_joints: WholeNumbers
    event_kinds: WholeNumbers
    event_speeds: Reals


@compiled
def stiff_time(record: SimulationRecord) -> float:
    """Return the time from which steps are those of the stiff method, s; infinite where none is."""
    return math.inf if record.counts[5] < 0 else record.times[max(0, record.counts[5] - 1)]


@compiled
def record_state(
    record: SimulationRecord, hold: DiscreteState, t: float, q: Reals, v: Reals, a: Reals, energies: Reals, gap: float
) -> None:
    """Append a state, if there is room."""
    k = record.counts[0]
    if k < len(record.times):
        record.times[k] = t
        for i in range(len(q)):
            record.q[k, i], record.v[k, i] = q[i], v[i]
            record.a[k, i] = 0.0 if hold.held[i] else a[i]
        for i in range(len(energies)):
            record.energies[k, i] = energies[i]
        record.closure_residuals[k] = gap
        record.counts[0] += 1


@compiled
def record_event(record: SimulationRecord, time: float, joint: int, kind: int, speed: float) -> None:
    """Append an event if there is room; count it in any case."""
    k = record.counts[1]
    if k < len(record.event_times):
        record.event_times[k] = time
        record.event_joints[k] = joint
        record.event_kinds[k] = kind
        record.event_speeds[k] = speed
    record.counts[1] += 1


@compiled
def record_hits(
    mechanism: Mechanism, hold: DiscreteState, time: float, joint: int, q: Reals, v: Reals, record: SimulationRecord
) -> None:
    """Record the hit of a joint on its hard stop, and of all joints that hit theirs at the same time."""
    record_event(record, time, joint, RECORDED_HIT, v[joint])
    hinges = mechanism.hinges
    for i in range(len(q)):
        low = q[i] <= hinges.lower[i] + NEAR_STOP_ANGLE and v[i] < 0.0
        high = q[i] >= hinges.upper[i] - NEAR_STOP_ANGLE and v[i] > 0.0
        if i != joint and not hold.held[i] and (low or high):
            record_event(record, time, i, RECORDED_HIT, v[i])


@compiled
def all_turns(mechanism: Mechanism, q: Reals, v: Reals, work: Work, coordinates: Reals, rates: Reals) -> None:
    """Write coordinates and velocities of all joints, followed by those of the cut hinges, (n + cuts,)."""
    n = len(q)
    coordinates[:n], rates[:n] = q, v
    if len(coordinates) > n:
        place_bodies(mechanism.tree, q, work)
        move_bodies(mechanism.tree, v, work)
        cut_angles(mechanism.cuts, work, coordinates[n:], rates[n:])


@compiled
def record_compliant_stops(
    mechanism: Mechanism, time: float, h: float, q: Reals, v: Reals, work: Work, turns: Reals, record: SimulationRecord
) -> None:
    """Record the compliant stops that were hit or left in the step of length h that ends at `time`.

    turns : (n + cuts,), at the start of the step; overwritten by those at its end.
    """
    n, count = len(q), len(turns)
    turns_now, rates = np.empty(count), np.empty(count)
    all_turns(mechanism, q, v, work, turns_now, rates)
    for i in range(count):
        hinges, k = mechanism.hinges, i
        if i >= n:
            hinges, k = mechanism.cuts.hinges, i - n
        for limit, sign in ((hinges.lower[k], -1.0), (hinges.upper[k], 1.0)):
            before, after = sign * (turns[i] - limit), sign * (turns_now[i] - limit)
            if (before > 0.0) != (after > 0.0):
                moment = time - h * after / (after - before)
                record_event(record, moment, i, RECORDED_HIT if after > 0.0 else RECORDED_RELEASE, rates[i])
    turns[:] = turns_now
