"""Time integration of a system: steps with error control, events at stops and snaps, and the cause of the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Required, TypedDict, Unpack

import numpy as np

from hcsearch.basics.array_values import ByValue, Flags, Reals
from hcsearch.kernels.multibody import endings, recording
from hcsearch.kernels.multibody import simulation as kernel
from hcsearch.kernels.multibody.accelerations import discrete_state_for
from hcsearch.kernels.multibody.events import (
    INTERPOLATED_STATE_RESIDUAL,
    StateSeries,
    largest_opening,
    open_state_share,
    refined_motion,
    step_openings,
)
from hcsearch.kernels.multibody.steps import StepPlan
from hcsearch.kernels.multibody.sweeps import move_bodies, place_bodies
from hcsearch.kernels.multibody.tree import work_for
from hcsearch.kernels.multibody.welds import cut_angles
from hcsearch.springs.dynamics.integration_methods import (
    EXTRAPOLATED_METHOD,
    IMPLICIT_METHOD,
    interpolate_motion,
    method_named,
    methods_text,
)
from hcsearch.springs.dynamics.system import System

SimulationStop = Literal[
    "time", "flat", "rest", "steps", "short", "open", "diverged", "energy", "jammed", "stuck", "singular"
]
"""The end of a simulation: `time` over; `flat`; at `rest` elsewhere; out of `steps`; `short`, no step is short enough;
loops `open`; numbers `diverged`; `energy` balance violated; stops `jammed`, events repeat without progress in time;
`stuck`, friction holds what would move without it; `singular`, rounding limits the steps."""

SIMULATION_STOPS: dict[int, SimulationStop] = {
    endings.ENDING_TIME_OUT: "time",
    endings.ENDING_FLAT: "flat",
    endings.ENDING_REST: "rest",
    endings.ENDING_TOO_MANY_STEPS: "steps",
    endings.ENDING_SMALL_STEP: "short",
    endings.ENDING_OPEN: "open",
    endings.ENDING_INVALID_NUMBER: "diverged",
    endings.ENDING_UNBALANCED: "energy",
    endings.ENDING_JAMMED: "jammed",
    endings.ENDING_STUCK: "stuck",
    endings.ENDING_SINGULAR: "singular",
}
"""Ends of simulations by their codes in the kernel."""
OPENING_BATCH_STEPS = 100
"""Number of steps over which the opening of loops is computed together."""
_KINDS = {
    recording.RECORDED_HIT: "hit",
    recording.RECORDED_RELEASE: "released",
    recording.RECORDED_SNAP_UP: "snap",
    recording.RECORDED_SNAP_DOWN: "snap",
    recording.RECORDED_STICK: "stuck",
    recording.RECORDED_SLIP: "slips",
}


@dataclass(frozen=True)
class Event:
    """An event in a joint: a `hit` of a stop (with its speed, rad/s), a release (`released`), or a `snap`; time in s.

    With friction, it may be `stuck` from then on, or it `slips`.

    joint : its number; cut hinges are numbered after the joints.
    """

    time: float
    joint: int
    kind: str
    speed: float


@dataclass(frozen=True, eq=False)
class Motion(ByValue):
    """States of a motion with its energy balance.

    times : (k,), s. q, v, a : (k, n_joints), coordinates, velocities, accelerations; at an event two
        states, before it and after it.
    cubic : whether accelerations are no use for interpolation between states: the motion is overdamped, and they are 0,
        or stiff springs close its loops.
    kinetic, stored, height, in_stops : (k,), kinetic energy, energy of laws and struts, of gravity, of compliant
        stops, J.
    methods : integrators before and from `stiff_time` (s), which is infinite where the motion is not stiff.
    damped, lost : (k,), energy lost in dampers and to friction, and at events, since the start. gap : greatest closure
        residual before projection, rad or gap over size; of cut hinges, the extension of their springs.
    """

    ending: SimulationStop
    cubic: bool
    times: Reals
    q: Reals
    v: Reals
    a: Reals
    kinetic: Reals
    stored: Reals
    height: Reals
    in_stops: Reals
    damped: Reals
    lost: Reals
    gap: float
    events: tuple[Event, ...]
    steps: int
    rejected: int
    evaluations: int
    methods: tuple[str, str]
    stiff_time: float

    @property
    def method(self) -> str:
        """The integrator, or both of them with the time at which the second one takes over."""
        return methods_text(self.methods, self.stiff_time)

    @property
    def implicit_time(self) -> float:
        """The time from which steps are implicit, s; infinite where none is."""
        return 0.0 if self.methods[0] in {IMPLICIT_METHOD, EXTRAPOLATED_METHOD} else self.stiff_time

    @property
    def drift(self) -> float:
        """Greatest error of the energy balance, J."""
        total = self.kinetic + self.stored + self.height + self.in_stops + self.damped + self.lost
        return float(np.abs(total - total[0]).max())

    @property
    def largest_energy(self) -> float:
        """Greatest magnitude of all terms of the energy balance, J."""
        books = (self.kinetic, self.stored, self.height, self.in_stops, self.damped, self.lost)
        return max(float(np.abs(book).max()) for book in books)

    def at(self, times: Reals) -> Reals:
        """Interpolate the coordinates at times, shape (len(times), n_joints), by quintics over each step.

        The error over a step h is O(h^6), with cubics O(h^4).
        """
        return interpolate_motion(self.times, self.q, self.v, None if self.cubic else self.a, times)


class SimulationOptions(TypedDict, total=False):
    """Options of a simulation; `plan_for` has the defaults.

    end : s. tolerance, floor : relative and absolute error of a step (the floor is the tolerance unless given).
    restitution : of hard stops, 0 to 1; impacts slower than `slow` (rad/s) do not bounce.
    flat : end when all coordinates, or those that are watched, are within this of 0 (rad).
    rest : end when no speed or acceleration would move a joint by more than this (rad) in the time left, or in 1 s.
    closed : residual after the projection that follows each step, where loops are closed exactly.
    first_step, longest_step : s.
    """

    end: Required[float]
    tolerance: float
    floor: float | None
    restitution: float
    slow: float
    flat: float | None
    watched: Flags | None
    rest: float | None
    closed: float
    first_step: float
    longest_step: float


def simulate_system(
    system: System,
    q: Reals,
    v: Reals | None = None,
    *,
    method: str = "dormand-prince",
    stiff_method: str | None = None,
    max_steps: int = 20_000,
    **options: Unpack[SimulationOptions],
) -> Motion:
    """Simulate a system from a closed state, with velocities 0 unless given, up to a time (s).

    stiff_method : the method that takes over where explicit steps are limited by their stability; `method` unless
    given.
    """
    n = system.n_joints
    record = record_for(n, max_steps)
    plan = plan_for(system, **options)
    mechanism = system.mechanism
    coordinates = np.array(q, float)
    discrete_state = discrete_state_for(mechanism, coordinates)
    speeds = np.zeros(n) if v is None else np.array(v, float)
    methods = method, stiff_method or method
    first, second = map(method_named, methods)
    work = work_for(mechanism.tree)
    kernel.simulate_motion(mechanism, discrete_state, first, second, plan, coordinates, speeds, work, record)
    return motion_of_record(record, system, methods)


def plan_for(
    system: System,
    *,
    end: float,
    tolerance: float = 1e-6,
    floor: float | None = None,
    restitution: float = 0.0,
    slow: float = 1e-2,
    flat: float | None = None,
    watched: Flags | None = None,
    rest: float | None = None,
    closed: float = 1e-14,
    first_step: float = 0.0,
    longest_step: float = math.inf,
) -> StepPlan:
    """Return the plan of a simulation for the kernel; see `SimulationOptions`."""
    return StepPlan(
        end=float(end),
        relative_tolerance=float(tolerance),
        absolute_tolerance=float(tolerance if floor is None else floor),
        first_step_size=float(first_step),
        max_step=float(longest_step),
        restitution=float(restitution),
        min_bounce_speed=float(slow),
        flat=np.zeros(system.n_joints) if watched is None else np.where(watched, 0.0, math.nan),
        flat_distance=-1.0 if flat is None else float(flat),
        rest_distance=-1.0 if rest is None else float(rest),
        closure_tolerance=math.inf if system.closure_stiffness else float(closed),
    )


def joined_motion(motions: Sequence[Motion], starts: Sequence[float]) -> Motion:
    """Concatenate successive motions; starts : s, of each. Dissipated energies are accumulated."""

    def concatenated(*names: str) -> dict[str, Any]:
        return {name: np.concatenate([getattr(motion, name) for motion in motions]) for name in names}

    def total(*names: str) -> dict[str, Any]:
        return {name: sum(getattr(motion, name) for motion in motions) for name in names}

    def accumulated(name: str) -> Reals:
        ends = np.cumsum([0.0, *(getattr(motion, name)[-1] for motion in motions)])
        return np.concatenate([getattr(motion, name) + end for motion, end in zip(motions, ends, strict=False)])

    return replace(
        motions[-1],
        times=np.concatenate([motion.times + start for motion, start in zip(motions, starts, strict=True)]),
        **concatenated("q", "v", "a", "kinetic", "stored", "height", "in_stops"),
        damped=accumulated("damped"),
        lost=accumulated("lost"),
        gap=max(motion.gap for motion in motions),
        stiff_time=min(motion.stiff_time + start for motion, start in zip(motions, starts, strict=True)),
        events=tuple(
            replace(event, time=event.time + start)
            for motion, start in zip(motions, starts, strict=True)
            for event in motion.events
        ),
        **total("steps", "rejected", "evaluations"),
    )


def closed_between(system: System, motion: Motion) -> tuple[StateSeries, Reals]:
    """Insert states where loops open by more than `INTERPOLATED_STATE_RESIDUAL`; return states and residuals.

    States are times (k,), coordinates, velocities and accelerations (k, n_joints); residuals of steps, (k - 1,), are as
    in `step_openings`; where springs close the loops, the greatest of `OPENING_BATCH_STEPS` steps. Nothing is inserted
    there, or where hinges are cut.
    """
    tree = system.mechanism.tree
    states, work = closed_states(system, motion), work_for(tree)
    if not system.closure_stiffness:
        return states, step_openings(tree, states, motion.cubic, INTERPOLATED_STATE_RESIDUAL, work)
    gaps = np.zeros(len(states[0]) - 1)
    for k in range(0, len(gaps), OPENING_BATCH_STEPS):
        times, q, v, a = (part[k : k + OPENING_BATCH_STEPS + 1] for part in states)
        gaps[k : k + OPENING_BATCH_STEPS] = largest_opening(tree, (times, q, v, a), True, work)
    return states, gaps


def greatest_opening(system: System, states: StateSeries, cubic: bool) -> float:
    """Return the greatest closure residual at and between states, rad, or gap over size; cubic : as in `Motion`."""
    tree = system.mechanism.tree
    return float(largest_opening(tree, states, cubic, work_for(tree)))


def closed_states(system: System, motion: Motion) -> StateSeries:
    """Return the states of `closed_between`."""
    mechanism = system.mechanism
    states: StateSeries = (motion.times, motion.q, motion.v, motion.a)
    if system.closure_stiffness or not len(mechanism.tree.rows):
        return states
    return refined_motion(
        mechanism, states, INTERPOLATED_STATE_RESIDUAL, motion.implicit_time, work_for(mechanism.tree)
    )


def loose_states(system: System, motion: Motion) -> float:
    """Return the share of states whose loops stay open despite projection; 0 where springs close the loops."""
    mechanism = system.mechanism
    if system.closure_stiffness or not len(mechanism.tree.rows):
        return 0.0
    return float(open_state_share(mechanism.tree, motion.q, work_for(mechanism.tree)))


def cut_states(system: System, q: Reals, v: Reals) -> tuple[Reals, Reals]:
    """Return fold angles and rates of cut hinges, shape (k, n_cuts), at states (k, n_joints)."""
    mechanism = system.mechanism
    work = work_for(mechanism.tree)
    angles, rates = np.empty((len(q), len(system.cuts))), np.empty((len(q), len(system.cuts)))
    for k in range(len(q)):
        place_bodies(mechanism.tree, q[k], work)
        move_bodies(mechanism.tree, v[k], work)
        cut_angles(mechanism.cuts, work, angles[k], rates[k])
    return angles, rates


def record_for(n: int, steps: int) -> recording.SimulationRecord:
    """Allocate a record for a number of steps of n joints."""
    return recording.SimulationRecord(
        times=np.empty(steps + 1),
        q=np.empty((steps + 1, n)),
        v=np.empty((steps + 1, n)),
        a=np.empty((steps + 1, n)),
        energies=np.empty((steps + 1, 6)),
        closure_residuals=np.empty(steps + 1),
        counts=np.zeros(6, np.int64),
        event_times=np.empty(steps + 1),
        event_joints=np.empty(steps + 1, np.int64),
        event_kinds=np.empty(steps + 1, np.int64),
        event_speeds=np.empty(steps + 1),
    )


def motion_of_record(record: recording.SimulationRecord, system: System, methods: tuple[str, str]) -> Motion:
    """Convert a record of the kernel to a motion; methods : integrators of steps that are not stiff and of others."""
    states, events, evaluations, rejected, ending, _ = (int(x) for x in record.counts)
    columns = (record.event_times, record.event_joints, record.event_kinds, record.event_speeds)
    happened = zip(*(column[:events].tolist() for column in columns), strict=True)
    kinetic, stored, height, in_stops, damped, lost = record.energies[:states].T.copy()
    v, a = record.v[:states].copy(), record.a[:states].copy()
    if system.overdamped:  # the kernel then writes velocities in the place of accelerations
        v, a = a, v
    return Motion(
        SIMULATION_STOPS[ending],
        system.overdamped or system.closure_stiffness > 0.0,
        record.times[:states].copy(),
        record.q[:states].copy(),
        v,
        a,
        kinetic,
        stored,
        height,
        in_stops,
        damped,
        lost,
        gap=float(record.closure_residuals[:states].max()),
        events=tuple(Event(time, joint, _KINDS[kind], speed) for time, joint, kind, speed in happened),
        steps=int(np.count_nonzero(np.diff(record.times[:states]))),
        rejected=rejected,
        evaluations=evaluations,
        methods=methods,
        stiff_time=recording.stiff_time(record),
    )
