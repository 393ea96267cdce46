"""Simulation of a whole motion: error-controlled steps, events, projection after each step, energy balance."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import dot, rotated, vector_at, vector_sum
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import (
    HELD_BY_FRICTION,
    DiscreteState,
    Mechanism,
    Stepper,
    accelerate,
    closure_energy,
    largest_pivot,
    project_state,
)
from hcsearch.kernels.multibody.endings import (
    CROWDED_TIME_SHARE,
    ENDING_NONE,
    ending_after,
    ending_before,
    update_pace,
)
from hcsearch.kernels.multibody.events import (
    EVENT_REST,
    EVENT_SNAP_UP,
    IntegrationStep,
    first_event,
    first_near,
    greatest_pull,
    smooth_accelerations,
    write_cubic_accelerations,
)
from hcsearch.kernels.multibody.hinges import law_moment, set_factors, write_energies
from hcsearch.kernels.multibody.integrators import IntegrationMethod, write_stage
from hcsearch.kernels.multibody.paused_simulation import (
    PACE_COORDINATES,
    PACE_CROWD_COUNT,
    PACE_CROWD_TIME,
    PACE_EVENT_COUNT,
    PACE_GRIP,
    PACE_IMPLICIT_REJECTIONS,
    PACE_LARGEST_ENERGY,
    PACE_SCALE,
    PACE_START_ENERGY,
    PACE_STEP,
    PACE_STIFF,
    PACE_STOPS_KEPT,
    PACE_TIME,
    Simulation,
    accelerate_simulation,
    current_method,
    new_pace,
)
from hcsearch.kernels.multibody.recording import (
    RECORDED_RELEASE,
    RECORDED_SLIP,
    RECORDED_SNAP_DOWN,
    RECORDED_SNAP_UP,
    RECORDED_STICK,
    SimulationRecord,
    all_turns,
    record_compliant_stops,
    record_event,
    record_hits,
    record_state,
)
from hcsearch.kernels.multibody.slip_steps import land_on_rest, step_to_slip
from hcsearch.kernels.multibody.steps import (
    MIN_JUMP_STEP_SHARE,
    StepPlan,
    first_step,
    land_on_event,
    land_on_flat,
    step_to_release,
    take_step,
)
from hcsearch.kernels.multibody.sticking import (
    any_started,
    forces_hold,
    settle_joints,
)
from hcsearch.kernels.multibody.stiffness import is_to_be_watched, watch_step, watch_stiffness
from hcsearch.kernels.multibody.stops import collide_joints, update_held_joints
from hcsearch.kernels.multibody.sweeps import move_bodies, place_bodies
from hcsearch.kernels.multibody.tree import BODY_CENTRE, WORK_PLACE, WORK_ROTATION, Work
from hcsearch.kernels.multibody.welds import cut_energy, cut_gap


@compiled
def simulate_motion(
    mechanism: Mechanism,
    hold: DiscreteState,
    method: IntegrationMethod,
    stiff_method: IntegrationMethod,
    plan: StepPlan,
    q: Reals,
    v: Reals,
    work: Work,
    record: SimulationRecord,
) -> None:
    """Simulate a motion from a closed state (q, v), which becomes the last state; fill the record."""
    simulation = Simulation(mechanism, hold, method, stiff_method, plan, q, v, work, new_pace(len(q)), record)
    start_simulation(simulation)
    continue_simulation(simulation, len(record.times) + 1)


@compiled
def start_simulation(simulation: Simulation) -> None:
    """Initialise a simulation: resolve impacts in the first state, record it, and choose the first step size."""
    mechanism, hold, plan, work = simulation.mechanism, simulation.hold, simulation.plan, simulation.work
    q, v, pace, record = simulation.q, simulation.v, simulation.pace, simulation.record
    a, energies = np.zeros(len(q)), np.zeros(6)
    record.counts[:] = 0
    record.counts[4], record.counts[5] = ENDING_NONE, -1
    work.time[0] = 0.0
    scale = largest_pivot(mechanism, q, work)
    pace[:PACE_COORDINATES], pace[PACE_COORDINATES:] = 0.0, q
    pace[PACE_SCALE], pace[PACE_GRIP] = scale, _rounding_pull(mechanism, hold, q)
    collide_joints(mechanism, hold, plan.restitution, plan.min_bounce_speed, q, v, scale, plan.closure_tolerance, work)
    if len(hold.slides):
        settle_joints(mechanism, hold, plan.min_bounce_speed, -1, q, v, scale, work, a)
    else:
        update_held_joints(mechanism, hold, plan.min_bounce_speed, q, v, scale, work, a)
    pace[PACE_START_ENERGY] = _write_energies(simulation, energies)
    pace[PACE_LARGEST_ENERGY] = np.abs(energies).max()
    for i in range(len(mechanism.hinges.factors)):  # before laws act, all energies are rounding errors
        _, stored = law_moment(mechanism.hinges, i, hold.branches[i], q[i])
        pace[PACE_LARGEST_ENERGY] = max(pace[PACE_LARGEST_ENERGY], abs(stored))
    if _may_change_method(simulation):
        watch_stiffness(simulation)
    accelerate_simulation(simulation, a)
    pace[PACE_STEP] = first_step(plan, current_method(simulation).order, q, v, a)
    record_state(record, hold, 0.0, q, v, a, energies, 0.0)


@compiled
def continue_simulation(simulation: Simulation, max_states: int) -> None:
    """Continue a simulation until it ends or its record holds a given number of states.

    The motion does not depend on how often it is paused.
    """
    mechanism, hold, plan = simulation.mechanism, simulation.hold, simulation.plan
    q, v, work, pace, record = simulation.q, simulation.v, simulation.work, simulation.pace, simulation.record
    n, method = len(q), current_method(simulation)
    stages = np.zeros((max(len(simulation.method.b), len(simulation.stiff_method.b)) + 1, 2 * n + 2))
    start, end = np.zeros(2 * n + 2), np.zeros(2 * n + 2)
    a = np.zeros(n)
    counts = record.counts
    energies = record.energies[counts[0] - 1].copy()
    scale, rejected = pace[PACE_SCALE], False
    stepper = Stepper(
        mechanism, hold, scale, plan.relative_tolerance, plan.absolute_tolerance, work, stages, start, end, counts
    )
    work.time[0] = pace[PACE_TIME]
    accelerate_simulation(simulation, a)
    _keep_accelerations(simulation, record.a[counts[0] - 1], a)
    start[:n], start[n : 2 * n], start[2 * n], start[2 * n + 1] = q, v, energies[4], pace[PACE_TIME]
    write_stage(mechanism, hold, start, a, work, stages[0])
    coordinates = np.zeros(n + len(mechanism.cuts.bodies))
    all_turns(mechanism, q, v, work, coordinates, coordinates.copy())
    while counts[4] == ENDING_NONE and (counts[0] < max_states or rejected):
        counts[4] = ending_before(simulation, a)
        if counts[4] != ENDING_NONE:
            break
        if is_to_be_watched(simulation) and _may_change_method(simulation):
            watch_stiffness(simulation)
            method = current_method(simulation)
            accelerate_simulation(simulation, a)
        pace[PACE_STEP] = min(pace[PACE_STEP], plan.max_step, plan.end - pace[PACE_TIME])
        error = take_step(method, stepper, pace[PACE_STEP])
        if not error <= 1.0:
            counts[3] += 1
            pace[PACE_IMPLICIT_REJECTIONS] += 1.0 if method.diagonal > 0.0 else 0.0
            pace[PACE_STEP] *= max(0.1, 0.9 * error ** (-1.0 / method.order)) if error < 1e100 else 0.1
            rejected = True
            continue
        if _may_change_method(simulation):
            watch_step(method, stepper, pace)
        length, flat_share, joint, kind = _shorten(simulation, method, stepper, a)
        q[:], v[:], energies[4] = end[:n], end[n : 2 * n], end[2 * n]
        pace[PACE_TIME] += length
        work.time[0] = pace[PACE_TIME]
        residual, _ = project_state(mechanism.tree, hold.held, q, v, plan.closure_tolerance, work)
        if len(mechanism.cuts.bodies):
            residual = cut_gap(mechanism.cuts, work) / mechanism.tree.size
        if kind >= 0:
            _process_event(simulation, joint, kind, residual, stages[len(method.b)], a, energies)
        else:
            _complete_step(simulation, flat_share < 1.0, length / pace[PACE_STEP], stages[len(method.b)], a, energies)
        if mechanism.hinges.stop_stiffness > 0.0:
            record_compliant_stops(mechanism, pace[PACE_TIME], length, q, v, work, coordinates, record)
        record_state(record, hold, pace[PACE_TIME], q, v, a, energies, residual)
        start[:n], start[n : 2 * n], start[2 * n], start[2 * n + 1] = q, v, energies[4], pace[PACE_TIME]
        write_stage(mechanism, hold, start, a, work, stages[0])
        update_pace(pace, q, energies)
        counts[4] = ending_after(mechanism, plan, residual, flat_share < 1.0, pace, energies)
        growth = 5.0 if error == 0.0 else min(5.0, 0.9 * error ** (-1.0 / method.order))
        if kind < 0:
            pace[PACE_STEP] *= max(0.2, min(growth, 1.0) if rejected else growth)
        rejected = False


@compiled
def _may_change_method(simulation: Simulation) -> bool:
    """Return whether a stiff motion would go on with another method."""
    other = simulation.method.diagonal == 0.0 and simulation.stiff_method.diagonal > 0.0
    return other and not simulation.pace[PACE_STIFF] > 0.0


@compiled
def _shorten(
    simulation: Simulation, method: IntegrationMethod, stepper: Stepper, a: Reals
) -> tuple[float, float, int, int]:
    """Shorten a step, where necessary, to its first event, a release, or the flat state.

    Returns the length of the step (s), the share of it at which the system is flat (2 if it is not), and joint and kind
    of the event at its end (-1 without an event).
    """
    plan, pace = simulation.plan, simulation.pace
    n, h = len(a), pace[PACE_STEP]
    keep_stops = pace[PACE_STOPS_KEPT] > 0.0
    pace[PACE_STOPS_KEPT] = 0.0
    start, end, last = stepper.start, stepper.end, stepper.stages[len(method.b)]
    v0, a0, v1, a1 = start[n : 2 * n], a, end[n : 2 * n], last[n : 2 * n]
    overdamped, smooth, both = simulation.mechanism.overdamped, _is_to_be_smooth(simulation), method.diagonal == 0.0
    if overdamped:  # the derivatives of coordinates are not part of the state
        v0, a0, v1, a1 = a, stepper.work.trial[0], last[:n], stepper.work.trial[1]
    elif smooth:
        a0 = simulation.record.a[simulation.record.counts[0] - 1]
    span = IntegrationStep(h, start[:n], v0, a0, end[:n], v1, a1)
    if overdamped:
        write_cubic_accelerations(span)
    elif smooth:
        smooth_accelerations(span, plan.absolute_tolerance, plan.relative_tolerance, both)
    share, joint, kind = first_event(simulation.mechanism, simulation.hold, span)
    length = h
    if kind == EVENT_REST:
        length = land_on_rest(method, stepper, share * h, h, joint)
    elif kind >= 0:
        length = land_on_event(method, stepper, share * h, h, joint, kind)
    if len(simulation.hold.slides):
        slow, event_length = plan.min_bounce_speed, length
        length = step_to_slip(method, stepper, plan.closure_tolerance, pace[PACE_GRIP], slow, keep_stops, length)
        kind = kind if length == event_length else -1
    elif kind < 0:
        length = step_to_release(method, stepper, plan.closure_tolerance, pace[PACE_GRIP], keep_stops, h)
    flat_share = 2.0
    if plan.flat_distance >= 0.0 and length > 0.0:
        # the tables now hold the repeated step
        span = IntegrationStep(length, span.q0, span.v0, span.a0, span.q1, span.v1, span.a1)
        if overdamped:
            write_cubic_accelerations(span)
        flat_share = first_near(span, plan.flat, plan.flat_distance)
    if flat_share < 1.0:
        kind = -1
        length = land_on_flat(method, stepper, plan, flat_share * length, length)
    if smooth and both and 0.0 < length < h:
        span = IntegrationStep(length, span.q0, span.v0, span.a0, span.q1, span.v1, span.a1)
        smooth_accelerations(span, plan.absolute_tolerance, plan.relative_tolerance, both)
    return length, flat_share, joint, kind


@compiled
def _process_event(
    simulation: Simulation, joint: int, kind: int, residual: float, last: Reals, a: Reals, energies: Reals
) -> None:
    """Record and process an event; the state before it is recorded too, as interpolation needs both ends of a step.

    last : the derivative of the state at the end of the step.
    """
    mechanism, hold = simulation.mechanism, simulation.hold
    q, v, pace, record = simulation.q, simulation.v, simulation.pace, simulation.record
    time = pace[PACE_TIME]
    pace[PACE_EVENT_COUNT] += 1.0
    crowded = time - pace[PACE_CROWD_TIME] <= CROWDED_TIME_SHARE * simulation.plan.end
    pace[PACE_CROWD_COUNT] = pace[PACE_CROWD_COUNT] + 1.0 if crowded else 0.0
    pace[PACE_CROWD_TIME] = time
    if kind < 2:
        record_hits(mechanism, hold, time, joint, q, v, record)
    elif kind != EVENT_REST:
        record_event(record, time, joint, RECORDED_SNAP_UP if kind == EVENT_SNAP_UP else RECORDED_SNAP_DOWN, v[joint])
    accelerate_simulation(simulation, a)
    _keep_accelerations(simulation, last[len(a) :], a)
    _write_energies(simulation, energies)
    record_state(record, hold, time, q, v, a, energies, residual)
    _apply_event(simulation, joint, kind, a, energies)
    accelerate_simulation(simulation, a)
    record.counts[2] += 2


@compiled
def _complete_step(simulation: Simulation, flat: bool, share: float, last: Reals, a: Reals, energies: Reals) -> None:
    """Complete a step without an event: free joints whose stops would have to pull, unless the motion has ended.

    share : of the step, before a pull. Unless a joint is freed, the next step ignores pulls where this was short.
    last : the derivative of the state at the end of the step.
    """
    hold, pace = simulation.hold, simulation.pace
    accelerate(simulation.mechanism, hold, simulation.q, simulation.v, pace[PACE_SCALE], True, simulation.work, a)
    simulation.record.counts[2] += 1
    if len(hold.slides):
        _complete_sliding_step(simulation, flat, share < 1.0, a)
    else:
        pulls = greatest_pull(hold, a) > pace[PACE_GRIP]
        if not flat and (pulls or share <= MIN_JUMP_STEP_SHARE):
            if pulls and _release_stops(simulation, a):
                pace[PACE_EVENT_COUNT] += 1.0
            else:
                pace[PACE_STOPS_KEPT] = 1.0
    _keep_accelerations(simulation, last[len(a) :], a)
    _write_energies(simulation, energies)


@compiled
def _is_to_be_smooth(simulation: Simulation) -> bool:
    """Return whether steps are far longer than accelerations at a state last, so that these do not describe them.

    Those of a state multiply the error of its rates by that by which dampers are stiff. Explicit steps are never so
    long; without inertia, or with springs that close the loops, accelerations describe no motion.
    """
    method, mechanism = current_method(simulation), simulation.mechanism
    extrapolated = method.extrapolation_order > 0 and not mechanism.closure_stiffness > 0.0
    return (method.diagonal > 0.0 or extrapolated) and not mechanism.overdamped


@compiled
def _keep_accelerations(simulation: Simulation, known: Reals, a: Reals) -> None:
    """Give free joints known accelerations, of the last stage or the recorded state, where these are to be smooth.

    A joint that is freed begins with none.
    """
    if _is_to_be_smooth(simulation):
        for i in range(len(a)):
            if not simulation.hold.held[i]:
                a[i] = known[i]


@compiled
def _complete_sliding_step(simulation: Simulation, flat: bool, shortened: bool, a: Reals) -> None:
    """The same as `_complete_step`, with friction: also joints that it cannot hold any longer are freed.

    shortened : whether a slip ended the step; where rounding decides, it may be none after projection.
    """
    mechanism, hold, pace, v = simulation.mechanism, simulation.hold, simulation.pace, simulation.v
    slips = not forces_hold(mechanism, hold, a, pace[PACE_GRIP])
    if not flat and (slips or shortened or any_started(mechanism, hold, simulation.plan.min_bounce_speed, v)):
        if _settle(simulation, -1, a):
            pace[PACE_EVENT_COUNT] += 1.0
        else:
            pace[PACE_STOPS_KEPT] = 1.0 if shortened else 0.0
    accelerate_simulation(simulation, a)


@compiled
def _apply_event(simulation: Simulation, joint: int, kind: int, a: Reals, energies: Reals) -> None:
    """Apply an impact or snap, and record the energy lost in it."""
    mechanism, hold, plan, work = simulation.mechanism, simulation.hold, simulation.plan, simulation.work
    q, v, scale = simulation.q, simulation.v, simulation.pace[PACE_SCALE]
    before = _write_energies(simulation, energies)
    if kind < 2:
        collide_joints(
            mechanism, hold, plan.restitution, plan.min_bounce_speed, q, v, scale, plan.closure_tolerance, work
        )
    elif kind != EVENT_REST:
        hold.branches[joint] = 1 - hold.branches[joint]
    if len(hold.slides):
        _settle(simulation, joint if kind == EVENT_REST else -1, a)
    else:
        update_held_joints(mechanism, hold, plan.min_bounce_speed, q, v, scale, work, a)
    project_state(mechanism.tree, hold.held, q, v, plan.closure_tolerance, work)
    energies[5] += before - _write_energies(simulation, energies)


@compiled
def _settle(simulation: Simulation, joint: int, a: Reals) -> bool:
    """Update which joints stick, slide and are held at stops; record it, and return whether it has changed."""
    hold, plan, record, time = simulation.hold, simulation.plan, simulation.record, simulation.pace[PACE_TIME]
    q, v, scale = simulation.q, simulation.v, simulation.pace[PACE_SCALE]
    before = hold.held.copy()
    changed = settle_joints(simulation.mechanism, hold, plan.min_bounce_speed, joint, q, v, scale, simulation.work, a)
    for i in range(len(before)):
        if hold.held[i] == HELD_BY_FRICTION and before[i] != HELD_BY_FRICTION:
            record_event(record, time, i, RECORDED_STICK, 0.0)
        elif before[i] != 0 and hold.held[i] == 0:
            record_event(record, time, i, RECORDED_SLIP if before[i] == HELD_BY_FRICTION else RECORDED_RELEASE, 0.0)
    return changed


@compiled
def _release_stops(simulation: Simulation, a: Reals) -> bool:
    """Free joints whose stops would have to pull, where nothing else holds them; return whether any was freed."""
    hold, q, v, pace = simulation.hold, simulation.q, simulation.v, simulation.pace
    held_before = hold.held.copy()
    update_held_joints(
        simulation.mechanism, hold, simulation.plan.min_bounce_speed, q, v, pace[PACE_SCALE], simulation.work, a
    )
    any_freed = False
    for i in range(len(q)):
        if held_before[i] and not hold.held[i]:
            record_event(simulation.record, pace[PACE_TIME], i, RECORDED_RELEASE, 0.0)
            any_freed = True
    return any_freed


@compiled
def _rounding_pull(mechanism: Mechanism, hold: DiscreteState, q: Reals) -> float:
    """Return the pull (N m) up to which stops hold: the rounding error relative to the initial hinge moments."""
    grip = 1e-300
    for i in range(len(q)):
        value, _ = law_moment(mechanism.hinges, i, hold.branches[i], q[i])
        grip = max(grip, 1e-7 * abs(value))
    return grip


@compiled
def _write_energies(simulation: Simulation, energies: Reals) -> float:
    """Write the energies of the current state into the first four entries; return their sum."""
    mechanism, hold, q, work = simulation.mechanism, simulation.hold, simulation.q, simulation.work
    parts = energies[:4]
    place_bodies(mechanism.tree, q, work)
    move_bodies(mechanism.tree, simulation.v, work)
    set_factors(mechanism.hinges, work.time[0])
    write_energies(mechanism.tree, mechanism.hinges, mechanism.struts, hold.branches, q, work, parts)
    for i in range(len(mechanism.loads)):
        arm = rotated(work.bodies, i, WORK_ROTATION, vector_at(mechanism.tree.bodies, i, BODY_CENTRE))
        parts[2] -= dot(vector_at(mechanism.loads, i, 0), vector_sum(vector_at(work.bodies, i, WORK_PLACE), arm))
    if len(mechanism.cuts.bodies):
        stored, stops, across, _ = cut_energy(mechanism.cuts, hold.cut_branches, work)
        parts[1] += stored
        parts[3] += stops + across
    stored, _ = closure_energy(mechanism, work)
    parts[3] += stored
    total: float = parts[0] + parts[1] + parts[2] + parts[3]
    return total
