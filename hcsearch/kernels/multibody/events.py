"""Events within integration steps, and closure of loops between recorded states.

Stops and snaps are located on the quintic through both ends of a step. Motions whose loops open too far between states
are refined by closed states in the middle of steps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.courses import (
    COURSE_TERM_COUNT,
    write_course,
    write_course_accelerations,
    write_course_angles,
    write_course_rates,
)
from hcsearch.kernels.multibody.accelerations import (
    HELD_BY_FRICTION,
    DiscreteState,
    Mechanism,
    accelerate,
    largest_pivot,
    project_state,
)
from hcsearch.kernels.multibody.sweeps import place_bodies
from hcsearch.kernels.multibody.tree import BodyTree, Work
from hcsearch.kernels.multibody.welds import weld_errors

NEAR_STOP_ANGLE, PASSED_STOP_ANGLE = 1e-9, 1e-6
"""A joint is at its stop up to the first angle (rad) inside it, and has passed it beyond the second."""

EVENT_LOWER_STOP, EVENT_UPPER_STOP, EVENT_SNAP_DOWN, EVENT_SNAP_UP, EVENT_REST = 0, 1, 2, 3, 4
"""Kinds of events: a joint reaches a stop, or an angle at which its law snaps, where odd ones are passed upwards; or a
joint that slides against friction comes to rest."""
REVERSED_RATE = 1e-6
"""A sliding joint has come to rest where its rate is below 0, in the sense in which it slides, by more (rad/s)."""

MAX_QUINTIC_DISTANCE = 50.0
"""Greatest distance of the quintic through an implicit step from the cubic, in its middle, over the tolerance: smooth
motions are below. A difference of accelerations counts there with h^2 / 64."""


class IntegrationStep(NamedTuple):
    """A step of length h (s): coordinates, velocities and accelerations at its start (0) and end (1), (n,)."""

    h: float
    q0: Reals
    v0: Reals
    a0: Reals
    q1: Reals
    v1: Reals
    a1: Reals


@compiled
def quintic(x: float, h: float, q0: float, v0: float, a0: float, q1: float, v1: float, a1: float) -> float:
    """Evaluate, at a share x of a step, the quintic through positions, velocities and accelerations at both ends."""
    c3 = 10.0 * (q1 - q0) - h * (6.0 * v0 + 4.0 * v1) - 0.5 * h * h * (3.0 * a0 - a1)
    c4 = -15.0 * (q1 - q0) + h * (8.0 * v0 + 7.0 * v1) + 0.5 * h * h * (3.0 * a0 - 2.0 * a1)
    c5 = 6.0 * (q1 - q0) - 3.0 * h * (v0 + v1) - 0.5 * h * h * (a0 - a1)
    return q0 + x * (h * v0 + x * (0.5 * h * h * a0 + x * (c3 + x * (c4 + x * c5))))


@compiled
def _cubic_accelerations(span: IntegrationStep, i: int) -> tuple[float, float]:
    """Return the accelerations at both ends with which the quintic through a step is the cubic through its rates."""
    rise = 6.0 * (span.q1[i] - span.q0[i]) / span.h
    start = (rise - 4.0 * span.v0[i] - 2.0 * span.v1[i]) / span.h
    return start, (2.0 * span.v0[i] + 4.0 * span.v1[i] - rise) / span.h


@compiled
def write_cubic_accelerations(span: IntegrationStep) -> None:
    """Write the accelerations of the cubic through the rates of a step at both of its ends."""
    for i in range(len(span.q0)):
        span.a0[i], span.a1[i] = _cubic_accelerations(span, i)


@compiled
def smooth_accelerations(span: IntegrationStep, absolute: float, relative: float, both: bool) -> None:
    """Write accelerations of the cubic where the quintic would leave it by much: at the start, or at both ends.

    absolute, relative : tolerances of coordinates. A stiff motion leaves its start, or an event, with accelerations
    that last far less long than an implicit step; the quintic would follow them through all of it.
    """
    for i in range(len(span.q0)):
        start, end = _cubic_accelerations(span, i)
        allowed = absolute + relative * max(abs(span.q0[i]), abs(span.q1[i]))
        most = 64.0 * MAX_QUINTIC_DISTANCE * allowed / (span.h * span.h)
        if not abs(span.a0[i] - start) <= most:
            span.a0[i] = start
        if both and not abs(span.a1[i] - end) <= most:
            span.a1[i] = end


@compiled
def _coordinate(span: IntegrationStep, i: int, x: float) -> float:
    """Return the coordinate of a joint at a share x of a step."""
    if x == 1.0:
        return float(span.q1[i])
    return quintic(x, span.h, span.q0[i], span.v0[i], span.a0[i], span.q1[i], span.v1[i], span.a1[i])


@compiled
def event_threshold(mechanism: Mechanism, hold: DiscreteState, i: int, kind: int) -> float:
    """Return the coordinate at which a joint has an event of a given kind; infinite if it has none."""
    hinges = mechanism.hinges
    hard = hinges.stop_stiffness == 0.0 and not hold.held[i]
    if kind == EVENT_LOWER_STOP:
        return hinges.lower[i] if hard else -np.inf
    if kind == EVENT_UPPER_STOP:
        return hinges.upper[i] if hard else np.inf
    if kind == EVENT_SNAP_DOWN:
        return hinges.snaps_down[i] if hold.branches[i] else -np.inf
    return np.inf if hold.branches[i] else hinges.snaps_up[i]


@compiled
def first_event(mechanism: Mechanism, hold: DiscreteState, span: IntegrationStep) -> tuple[float, int, int]:
    """Locate the first event in a step: share of the step, joint and kind; (2, -1, -1) without an event."""
    best, joint, event_kind = 2.0, -1, -1
    for i in range(len(span.q0)):
        for kind in range(4):
            limit = event_threshold(mechanism, hold, i, kind)
            if math.isinf(limit) or hold.held[i] == HELD_BY_FRICTION:
                continue
            share = _passing_share(span, i, kind, 1.0 if kind % 2 else -1.0, limit, PASSED_STOP_ANGLE)
            if share < best:
                best, joint, event_kind = share, i, kind
    for i in range(len(hold.slides)):
        if hold.slides[i]:
            share = _passing_share(span, i, EVENT_REST, -float(hold.slides[i]), 0.0, REVERSED_RATE)
            if share < best:
                best, joint, event_kind = share, i, EVENT_REST
    return best, joint, event_kind


@compiled
def _passing_share(span: IntegrationStep, i: int, kind: int, sign: float, limit: float, passed: float) -> float:
    """Return the share of a step at which a joint passes a limit; 2 if in no quarter it is beyond by `passed`.

    By its coordinate or, for `EVENT_REST`, its rate; sign : 1 where it passes upwards, -1 downwards.
    """
    before = 0.0
    for k in range(1, 5):
        after = 0.25 * k
        if sign * (_followed(span, i, kind, after) - limit) > passed:
            for _ in range(50):
                x = 0.5 * (before + after)
                if sign * (_followed(span, i, kind, x) - limit) > 0.0:
                    after = x
                else:
                    before = x
            return after
        before = after
    return 2.0


@compiled
def _followed(span: IntegrationStep, i: int, kind: int, x: float) -> float:
    """Return the rate of a joint at a share x of a step for `EVENT_REST`, else its coordinate."""
    return _rate(span, i, x) if kind == EVENT_REST else _coordinate(span, i, x)


@compiled
def _rate(span: IntegrationStep, i: int, x: float) -> float:
    """Return the rate of a joint at a share x of a step, by the cubic through rates and accelerations at both ends."""
    rise, s0, s1 = span.v1[i] - span.v0[i], span.h * span.a0[i], span.h * span.a1[i]
    c, d = 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise
    return float(span.v0[i] + x * (s0 + x * (c + x * d)))


@compiled
def first_near(span: IntegrationStep, target: Reals, tolerance: float) -> float:
    """Return the share of a step at which all coordinates first lie within a tolerance of a target; 2 if never.

    Only quarters of the step are sampled.

    target : (n,), NaN where a coordinate does not count.
    """
    before = 0.0
    for k in range(1, 5):
        after = 0.25 * k
        if _within(after, span, target, tolerance):
            for _ in range(40):
                x = 0.5 * (before + after)
                if _within(x, span, target, tolerance):
                    after = x
                else:
                    before = x
            return after
        before = after
    return 2.0


@compiled
def _within(x: float, span: IntegrationStep, target: Reals, tolerance: float) -> bool:
    within = True
    for i in range(len(span.q0)):
        within = within and not abs(_coordinate(span, i, x) - target[i]) > tolerance
    return within


@compiled
def greatest_pull(hold: DiscreteState, forces: Reals) -> float:
    """Return the greatest pull needed at a stop to hold its joint; negative where all stops push.

    Without friction, which could hold the joint against a pull.
    """
    greatest = -np.inf
    for i in range(len(forces)):
        if hold.held[i]:
            greatest = max(greatest, hold.held[i] * forces[i])
    return greatest


StateSeries = tuple[Reals, Reals, Reals, Reals]
"""Times (k,), coordinates, velocities and accelerations (k, n)."""

INTERPOLATED_STATE_RESIDUAL = 1e-6
"""Closure residual (rad, or gap over size) up to which loops count as closed between states."""
RESIDUAL_SAMPLE_SHARES = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)
"""Shares of a step at which closure residuals are sampled between states."""
SMOOTH_STEP_SHARE = 0.1
"""Share of the opening of a quintic below which a cubic takes its place."""
MAX_REFINEMENT_PASSES = 4
"""Greatest number of times that a step is halved."""
HELD_JOINT_TOLERANCE = 1e-9
"""A joint counts as held in a step if it moves by at most this (rad), at most this fast at both ends (rad/s)."""
SIMULATED_STATE_RESIDUAL = 1e-10
"""Closure residual (rad, or gap over size) up to which loops count as closed at states."""


@compiled
def _opening_between(tree: BodyTree, course: Reals, angles: Reals, work: Work) -> float:
    """Return the greatest closure residual at `RESIDUAL_SAMPLE_SHARES` of a step; angles : scratch, (n,)."""
    largest = 0.0
    for share in RESIDUAL_SAMPLE_SHARES:
        write_course_angles(course, share, angles)
        place_bodies(tree, angles, work)
        largest = max(largest, weld_errors(tree, work, work.errors))
    return largest


@compiled
def largest_opening(tree: BodyTree, states: StateSeries, cubic: bool, work: Work) -> float:
    """Return the greatest closure residual (rad, or gap over size) at states and at `RESIDUAL_SAMPLE_SHARES` of steps.

    A polynomial through exact states and rates at both ends deviates most in the middle, or first to one side, then to
    the other.
    """
    times, q, v, a = states
    course, angles = np.empty((q.shape[1], COURSE_TERM_COUNT)), np.empty(q.shape[1])
    largest = 0.0
    for k in range(len(times)):
        place_bodies(tree, q[k], work)
        largest = max(largest, weld_errors(tree, work, work.errors))
        h = times[k + 1] - times[k] if k + 1 < len(times) else 0.0
        if h > 0.0:
            write_course(h, cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
            largest = max(largest, _opening_between(tree, course, angles, work))
    return largest


@compiled
def step_openings(tree: BodyTree, states: StateSeries, cubic: bool, closed: float, work: Work) -> Reals:
    """Return a bound of the closure residual (rad, or gap over size) in each step between k states, (k - 1,).

    It is the greatest of the step itself where that exceeds `closed`; the others have one bound, `closed` at most.
    """
    times, q, v, a = states
    openings = np.zeros(max(0, len(times) - 1))
    for k in range(len(openings)):
        openings[k] = largest_opening(tree, (times[k : k + 2], q[k : k + 2], v[k : k + 2], a[k : k + 2]), cubic, work)
    common = 0.0
    for opening in openings:
        common = max(common, min(opening, closed))
    for k in range(len(openings)):
        openings[k] = max(openings[k], common)
    return openings


@compiled
def open_state_share(tree: BodyTree, q: Reals, work: Work) -> float:
    """Return the share of states q, (k, n), whose loops are open by more than `SIMULATED_STATE_RESIDUAL`.

    Projection closes the chosen rows. The other rows stay closed with them if they depend on them, but not if they only
    seemed to, as on a branch of singular states.
    """
    open_count = 0
    for k in range(len(q)):
        place_bodies(tree, q[k], work)
        if weld_errors(tree, work, work.errors) > SIMULATED_STATE_RESIDUAL:
            open_count += 1
    return open_count / max(1, len(q))


@compiled
def _with_cubic_steps(tree: BodyTree, states: StateSeries, closed: float, work: Work) -> StateSeries:
    """Return a motion with states repeated at both ends of steps that cubics describe better.

    Near singular states accelerations may be unbounded while hardly anything moves, and a quintic through them leaves
    the closed states by far. The repeated states have the accelerations with which the quintic is the cubic through
    angles and rates.
    """
    times, q, v, a = states
    count, n = len(times), q.shape[1]
    course, angles = np.empty((n, COURSE_TERM_COUNT)), np.empty(n)
    cubic = np.zeros(count, np.bool_)
    for k in range(count - 1):
        h = times[k + 1] - times[k]
        if h <= 0.0:
            continue
        write_course(h, False, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
        opening = _opening_between(tree, course, angles, work)
        if opening > closed:
            write_course(h, True, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
            cubic[k] = _opening_between(tree, course, angles, work) < SMOOTH_STEP_SHARE * opening
    rows = count + 2 * cubic.sum()
    if rows == count:
        return states
    states = (np.empty(rows), np.empty((rows, n)), np.empty((rows, n)), np.empty((rows, n)))
    row = 0
    for k in range(count):
        states[0][row], states[1][row], states[2][row], states[3][row] = times[k], q[k], v[k], a[k]
        row += 1
        if cubic[k]:
            h = times[k + 1] - times[k]
            write_course(h, True, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
            for end in range(2):
                states[0][row], states[1][row], states[2][row] = times[k + end], q[k + end], v[k + end]
                write_course_accelerations(course, float(end), h, states[3][row])
                row += 1
    return states


@compiled
def refined_motion(
    mechanism: Mechanism, states: StateSeries, closed: float, smooth_from: float, work: Work
) -> StateSeries:
    """Return a motion with closed states inserted in the middle of steps whose loops open by more than `closed`.

    Steps that cubics describe better are described by these first, and all steps of motions without inertia, whose
    accelerations are 0. The new states are the projections of the polynomials onto closed loops, where Newton's method
    converges; the halves are refined in the same way, up to `MAX_REFINEMENT_PASSES` times.

    smooth_from : time (s) from which steps are implicit, and new states have the accelerations of the polynomials:
        those of the states multiply the errors of rates.
    """
    tree, n = mechanism.tree, states[1].shape[1]
    slides = np.zeros(len(mechanism.hinges.friction), np.int8)
    hold = DiscreteState(np.zeros(n, np.int8), np.zeros(n, np.int8), np.zeros(0, np.int8), slides)
    course, scale = np.empty((n, COURSE_TERM_COUNT)), largest_pivot(mechanism, states[1][0], work)
    cubic = mechanism.overdamped
    if not cubic:
        states = _with_cubic_steps(tree, states, closed, work)
    for _ in range(MAX_REFINEMENT_PASSES):
        times, q, v, a = states
        count = len(times)
        split = np.zeros(count, np.bool_)
        middles = np.empty((3, count, n))
        for k in range(count - 1):
            h = times[k + 1] - times[k]
            if h <= 0.0:
                continue
            write_course(h, cubic, q[k], v[k], a[k], q[k + 1], v[k + 1], a[k + 1], course)
            write_course_angles(course, 0.5, middles[0, k])
            place_bodies(tree, middles[0, k], work)
            residual = weld_errors(tree, work, work.errors)
            if residual > closed:
                write_course_rates(course, 0.5, h, middles[1, k])
                for i in range(n):
                    is_slow = max(abs(v[k, i]), abs(v[k + 1, i])) <= HELD_JOINT_TOLERANCE
                    hold.held[i] = 1 if is_slow and abs(q[k + 1, i] - q[k, i]) <= HELD_JOINT_TOLERANCE else 0
                    if len(slides):
                        slides[i] = 0 if hold.held[i] else np.sign(middles[1, k, i])
                work.time[0] = 0.5 * (times[k] + times[k + 1])
                split[k] = _close(mechanism, hold, scale, middles[0, k], middles[1, k], middles[2, k], work) < residual
                if times[k] >= smooth_from and not cubic:
                    write_course_accelerations(course, 0.5, h, middles[2, k])
        insertions = split.sum()
        if insertions == 0:
            break
        rows = count + insertions
        states = (np.empty(rows), np.empty((rows, n)), np.empty((rows, n)), np.empty((rows, n)))
        row = 0
        for k in range(count):
            states[0][row], states[1][row], states[2][row], states[3][row] = times[k], q[k], v[k], a[k]
            row += 1
            if split[k]:
                states[0][row] = 0.5 * (times[k] + times[k + 1])
                states[1][row], states[2][row], states[3][row] = middles[0, k], middles[1, k], middles[2, k]
                row += 1
    return states


@compiled
def _close(mechanism: Mechanism, hold: DiscreteState, scale: float, q: Reals, v: Reals, a: Reals, work: Work) -> float:
    """Project a state onto closed loops, and write its accelerations; return the remaining closure residual.

    Without inertia the state decides its velocities. Near singular states Newton's method may diverge: the residual is
    then no smaller than before.
    """
    residual = 0.0
    if mechanism.overdamped:
        v[:] = 0.0
    for _ in range(2):
        accelerate(mechanism, hold, q, v, scale, True, work, a)
        residual, _ = project_state(mechanism.tree, hold.held, q, v, 1e-14, work)
    accelerate(mechanism, hold, q, v, scale, True, work, a)
    for i in range(len(hold.held)):
        if hold.held[i]:
            v[i] = a[i] = 0.0
    if mechanism.overdamped:
        v[:] = a
        a[:] = 0.0
    return residual
