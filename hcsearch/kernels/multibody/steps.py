"""Steps of a simulation: choice of the method, first step size, and repetition of steps up to events and releases."""

from __future__ import annotations

import math
from typing import NamedTuple

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import Stepper, accelerate, project_state
from hcsearch.kernels.multibody.events import event_threshold, greatest_pull
from hcsearch.kernels.multibody.extrapolated_steps import extrapolated_step
from hcsearch.kernels.multibody.implicit_steps import implicit_step
from hcsearch.kernels.multibody.integrators import IntegrationMethod, explicit_step, write_stage

REACHED_STOP_ANGLE = 1e-11
"""Distance from a stop (rad) at which a joint has reached it."""
IMMEDIATE_EVENT_SHARE = 1e-9
"""An event within this share of a step counts as at its start."""
PULL_JUMP_SHARE = 1e-4
"""Share of a step within which a pull that remains large counts as a jump, not as growing from zero."""
MAX_FLAT_STEPS = 6
"""Newton steps to the time at which the flat state is reached."""
MAX_SECANT_STEPS = 6
"""Secant steps before bisection takes over: near a jump the secants converge too slowly."""
MIN_JUMP_STEP_SHARE = 1e-4
"""Least share of a step that is taken where the pull jumps, so that the motion progresses."""
ROUNDING_PULL_SHARE = 1e-9
"""A pull within this share of a step is due to rounding at its start; `MIN_JUMP_STEP_SHARE` of the step is taken."""
PARABOLA_TOLERANCE_SHARE = 0.01
"""Share of the tolerance that the error of the final parabola up to an event may have."""


class StepPlan(NamedTuple):
    """Tolerances and end conditions of a simulation.

    end : last time, s. relative_tolerance, absolute_tolerance : of the error of a step.
    first_step_size, max_step : s; the first step is estimated if 0.
    restitution : of stops, 0 to 1. min_bounce_speed : rad/s, below which stops do not bounce.
    flat : (n,), coordinates of the flat state, NaN where they do not count. flat_distance : distance from them (rad)
        that counts as flat; below 0, no state does.
    rest_distance : angle (rad) by which a joint at rest may move, by its speed or acceleration, in the time left or
        1 s, the longer; below 0, no state is at rest. closure_tolerance : closure residual after projection.
    """

    end: float
    relative_tolerance: float
    absolute_tolerance: float
    first_step_size: float
    max_step: float
    restitution: float
    min_bounce_speed: float
    flat: Reals
    flat_distance: float
    rest_distance: float
    closure_tolerance: float


@compiled
def take_step(method: IntegrationMethod, stepper: Stepper, h: float) -> float:
    """Take one step; return its error over the tolerance. The last stage is the derivative at its end."""
    if method.diagonal > 0.0:
        return implicit_step(method, stepper, h)
    if not method.extrapolation_order:
        stepper.counts[2] += len(method.b)
        return explicit_step(method, stepper, h)
    columns, work = method.extrapolation_order, stepper.work
    stepper.counts[2] += columns * (columns + 1) // 2 + 1
    error = extrapolated_step(columns, stepper, h)
    accelerate_at(stepper, stepper.end, False)
    write_stage(stepper.mechanism, stepper.hold, stepper.end, work.accelerations, work, stepper.stages[columns])
    return error


@compiled
def accelerate_at(stepper: Stepper, state: Reals, fresh: bool) -> None:
    """Write the accelerations at a state (q, v, energy lost, time) to `work.accelerations`; see `accelerate`."""
    n, work = len(stepper.hold.held), stepper.work
    q, v = state[:n], state[n : 2 * n]
    work.time[0] = state[2 * n + 1]
    accelerate(stepper.mechanism, stepper.hold, q, v, stepper.scale, fresh, work, work.accelerations)


@compiled
def first_step(plan: StepPlan, order: int, q: Reals, v: Reals, a: Reals) -> float:
    """Estimate the first step from the size of the motion (after Hairer, Norsett and Wanner 1993, section II.4)."""
    if plan.first_step_size > 0.0:
        return plan.first_step_size
    n = len(q)
    size = rate = 0.0
    for i in range(n):
        weight_q = plan.absolute_tolerance + plan.relative_tolerance * abs(q[i])
        weight_v = plan.absolute_tolerance + plan.relative_tolerance * abs(v[i])
        size += (q[i] / weight_q) ** 2 + (v[i] / weight_v) ** 2
        rate += (v[i] / weight_q) ** 2 + (a[i] / weight_v) ** 2
    if rate == 0.0:
        return plan.max_step
    guess = 0.01 * math.sqrt(size / rate) if size > 0.0 else 1e-6
    return min(plan.max_step, max(guess, 1e-9 * plan.end))


@compiled
def land_on_event(
    method: IntegrationMethod, stepper: Stepper, guess: float, longest: float, joint: int, kind: int
) -> float:
    """Repeat a step so that it ends at an event of a joint; return its length, 0 if the joint is there already.

    The last part of the step, over which accelerations hardly change, is a parabola; not without inertia, where
    accelerations are not the derivatives of the velocities.
    """
    mechanism, stages, start, end = stepper.mechanism, stepper.stages, stepper.start, stepper.end
    n = len(stepper.hold.held)
    limit = event_threshold(mechanism, stepper.hold, joint, kind)
    sign = 1.0 if kind % 2 else -1.0
    if guess <= IMMEDIATE_EVENT_SHARE * longest and sign * (start[joint] - limit) >= 0.0:
        for i in range(len(end)):
            end[i] = start[i]
        return 0.0
    last = stages[len(method.b)]
    h = guess
    low, high = 0.0, longest
    for _ in range(12):
        take_step(method, stepper, h)
        miss, speed = end[joint] - limit, last[joint]
        if abs(miss) <= REACHED_STOP_ANGLE:
            break
        if speed != 0.0 and not mechanism.overdamped:
            extension = -miss / speed
            extension = -(miss + 0.5 * extension * extension * last[n + joint]) / speed
            remaining = miss + extension * (speed + 0.5 * extension * last[n + joint])
            reaches_event = abs(extension) <= h and h + extension < longest and abs(remaining) <= REACHED_STOP_ANGLE
            if reaches_event and _parabolic(stepper, h, extension, last):
                for j in range(n):
                    end[j] += extension * (last[j] + 0.5 * extension * last[n + j])
                    end[n + j] += extension * last[n + j]
                end[2 * n] += extension * last[2 * n]
                end[2 * n + 1] += extension
                return float(h + extension)
        low, high, h = next_length(h, miss, speed, sign, low, high)
    return h


@compiled
def land_on_flat(method: IntegrationMethod, stepper: Stepper, plan: StepPlan, guess: float, longest: float) -> float:
    """Repeat a step so that it ends where the flat state is reached; return its length.

    The guess is as exact as quintics are; without inertia, where it comes from cubics, it is improved by Newton steps.
    """
    h, n, end, last = guess, len(stepper.hold.held), stepper.end, stepper.stages[len(method.b)]
    take_step(method, stepper, h)
    for _ in range(MAX_FLAT_STEPS if stepper.mechanism.overdamped else 0):
        furthest, miss, speed = -1, -plan.flat_distance, 0.0
        for i in range(n):
            distance = abs(end[i] - plan.flat[i])  # NaN where the joint does not count
            if distance - plan.flat_distance > miss:
                furthest, miss = i, distance - plan.flat_distance
                speed = last[i] if end[i] > plan.flat[i] else -last[i]
        if furthest < 0 or speed >= 0.0 or abs(miss) <= REACHED_STOP_ANGLE:
            break
        h = min(max(h - miss / speed, 0.5 * h), longest)
        take_step(method, stepper, h)
    return h


@compiled
def next_length(
    h: float, miss: float, speed: float, sign: float, low: float, high: float
) -> tuple[float, float, float]:
    """Narrow the bracket of the length of a step that ends at an event; return it, and the next length by Newton.

    miss, speed : how far the last step, of length h, ended from the event, and how fast that grows. sign : of a miss
    beyond the event. low, high : the bracket, which is halved where Newton's method leaves it.
    """
    if sign * miss > 0.0:
        high = min(high, h)
    else:
        low = max(low, h)
    trial = h - miss / speed if speed != 0.0 else 0.5 * (low + high)
    return low, high, trial if low < trial < high else 0.5 * (low + high)


@compiled
def _parabolic(stepper: Stepper, h: float, extension: float, last: Reals) -> bool:
    """Return whether a step can be extended by a parabola with an error well below the tolerance.

    extension : its length (s), over which accelerations are assumed to change as fast as in the step h.
    """
    first, end = stepper.stages[0], stepper.end
    n = len(end) // 2 - 1
    for j in range(n, 2 * n):
        allowed = PARABOLA_TOLERANCE_SHARE * (stepper.absolute_tolerance + stepper.relative_tolerance * abs(end[j]))
        if abs(last[j] - first[j]) * extension * extension > 2.0 * h * allowed:
            return False
    return True


@compiled
def step_to_release(
    method: IntegrationMethod, stepper: Stepper, closed: float, grip: float, keep_stops: bool, longest: float
) -> float:
    """Repeat a step so that it ends where a stop begins to pull, if one pulls at its end but not at its start.

    Returns the length of the step. A step across a release would have an error of the order of its length squared,
    whatever the tolerance. The factor left in `work` is that at the end, for the projection that follows. If the pull
    jumps, the motion goes on in small steps: in singular states rounding decides how forces are shared between stops
    and loops.

    keep_stops : whether a stop seemed to pull at the start and was kept; the step is then accepted, as the same
        pull would end every step after it.
    """
    any_held = False
    for i in range(len(stepper.hold.held)):
        any_held = any_held or stepper.hold.held[i] != 0
    if not any_held:
        return longest
    end_pull = _pull(stepper, closed, stepper.end)
    if not end_pull > grip:
        return longest
    start_pull = _pull(stepper, closed, stepper.start)
    low, high, h, side, first_pull = 0.0, longest, longest, 0, end_pull
    low_value, high_value = start_pull - 2.0 * grip, end_pull - 2.0 * grip
    for k in range(40):
        if keep_stops or start_pull > grip or end_pull <= 3.0 * grip or high - low <= 1e-12 * longest:
            break
        if high - low <= PULL_JUMP_SHARE * longest and end_pull > 1e3 * PULL_JUMP_SHARE * first_pull:
            high = max(high, MIN_JUMP_STEP_SHARE * longest)
            break
        # by the secant; the end that stays counts less and less (Anderson and Bjorck 1973)
        share = min(max(-low_value / (high_value - low_value), 0.01), 0.99) if k < MAX_SECANT_STEPS else 0.5
        h = low + (high - low) * share
        accelerate_at(stepper, stepper.start, True)
        take_step(method, stepper, h)
        pull = _pull(stepper, closed, stepper.end)
        value = pull - 2.0 * grip
        if pull > grip:
            factor = 1.0 - value / high_value
            low_value *= (factor if factor > 0.0 else 0.5) if side > 0 else 1.0
            high, end_pull, high_value, side = h, pull, max(value, 0.0), 1
        else:
            factor = 1.0 - value / low_value
            high_value *= (factor if factor > 0.0 else 0.5) if side < 0 else 1.0
            low, start_pull, low_value, side = h, pull, value, -1
    if high <= ROUNDING_PULL_SHARE * longest:
        high = MIN_JUMP_STEP_SHARE * longest
    if h < high:
        accelerate_at(stepper, stepper.start, True)
        take_step(method, stepper, high)
    elif high == longest:  # the step was not repeated, and the factor is that at the start
        accelerate_at(stepper, stepper.end, True)
    return high


@compiled
def _pull(stepper: Stepper, closed: float, state: Reals) -> float:
    """Return the greatest pull needed at a stop (N m) in a projected state (q, v, energy lost, time).

    closed : closure residual after projection.
    """
    mechanism, hold, work = stepper.mechanism, stepper.hold, stepper.work
    n = len(hold.held)
    q, v = work.trial[0], work.trial[1]
    for i in range(n):
        q[i], v[i] = state[i], state[n + i]
    project_state(mechanism.tree, hold.held, q, v, closed, work)
    work.time[0] = state[2 * n + 1]
    accelerate(mechanism, hold, q, v, stepper.scale, True, work, work.accelerations)
    return greatest_pull(hold, work.accelerations)
