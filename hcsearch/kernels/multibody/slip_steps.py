"""Steps of a simulation with friction: up to the rest of a sliding joint, and to the slip of a held one."""

from __future__ import annotations

from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.multibody.accelerations import Stepper, accelerate, project_state
from hcsearch.kernels.multibody.integrators import IntegrationMethod
from hcsearch.kernels.multibody.steps import MIN_JUMP_STEP_SHARE, accelerate_at, next_length, take_step
from hcsearch.kernels.multibody.sticking import any_slips, forces_hold

REACHED_REST_RATE = 1e-10
"""Rate (rad/s) at which a joint has come to rest."""
SLIP_STEP_SHARE = 1e-6
"""Share of a step to which the time of a slip is located: forces grow from their bounds, and accelerations from 0."""


@compiled
def land_on_rest(method: IntegrationMethod, stepper: Stepper, guess: float, longest: float, joint: int) -> float:
    """Repeat a step so that it ends where the rate of a sliding joint is 0; return its length."""
    end, last, n = stepper.end, stepper.stages[len(method.b)], len(stepper.hold.held)
    sense = float(stepper.hold.slides[joint])
    low, high, h = 0.0, longest, guess
    for _ in range(12):
        take_step(method, stepper, h)
        rate, change = end[n + joint], last[n + joint]
        if abs(rate) <= REACHED_REST_RATE:
            break
        low, high, h = next_length(h, rate, change, -sense, low, high)
    return h


@compiled
def step_to_slip(
    method: IntegrationMethod, stepper: Stepper, closed: float, grip: float, slow: float, kept: bool, longest: float
) -> float:
    """Repeat a step so that it ends where a held joint slips, if one does; return its length.

    The factor left in `work` is that at the end, for the projection that follows.

    kept : whether a joint seemed to slip at the start and was kept; the step is then accepted. Others as of
    `step_to_release`.
    """
    if longest == 0.0 or not stepper.hold.held.any():
        return longest
    low, high = 0.0, longest
    if not kept and _slips(stepper, closed, grip, slow):
        h = MIN_JUMP_STEP_SHARE * longest  # a joint may slip at the start
        while high - low > SLIP_STEP_SHARE * longest and high > MIN_JUMP_STEP_SHARE * longest:
            accelerate_at(stepper, stepper.start, True)
            take_step(method, stepper, h)
            if _slips(stepper, closed, grip, slow):
                high = h
            else:
                low = h
            h = 0.5 * (low + high)
        accelerate_at(stepper, stepper.start, True)
        take_step(method, stepper, high)
    accelerate_at(stepper, stepper.end, True)
    return high


@compiled
def _slips(stepper: Stepper, closed: float, grip: float, slow: float) -> bool:
    """Return whether a held joint cannot be held at the end of a step, after projection onto closed loops."""
    mechanism, hold, work, n = stepper.mechanism, stepper.hold, stepper.work, len(stepper.hold.held)
    q, v, a = work.trial[0], work.trial[1], work.accelerations
    q[:], v[:] = stepper.end[:n], stepper.end[n : 2 * n]
    project_state(mechanism.tree, hold.held, q, v, closed, work)
    work.time[0] = stepper.end[2 * n + 1]
    accelerate(mechanism, hold, q, v, stepper.scale, True, work, a)
    return not forces_hold(mechanism, hold, a, grip) and any_slips(mechanism, hold, slow, q, v, stepper.scale, work)
