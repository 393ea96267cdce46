"""The trajectory of a drive: a certified path as splines through closed states, and its time law.

The path of a proof consists of cubics whose second derivatives jump. It is resampled, smoothed by a Gaussian window of
a given width, projected onto the nearest closed states within the stops, and interpolated by splines of fifth degree.

The time law starts from the greatest speed that the bounds of rates and, where the path bends, of accelerations allow,
smoothed. Ramps of fifth degree at both ends avoid jumps of the acceleration. Then all times are scaled until both
bounds hold at all samples. The law is not time-optimal: a time-optimal one switches accelerations on and off (Bobrow,
Dubowsky and Gibson 1985).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.kernels.collision.intervals import Course
from hcsearch.kernels.planning.closed_states import close_state, new_closing
from hcsearch.motion.planning.problems import loops_of
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.dynamics.integration_methods import interpolate_motion

DRIVE_END_ANGLES = (0.01, 0.005)
"""Distances from the packed and the flat state at which the driven motion begins and ends (rad): both states are
singular, so that no hinge drives them. The array counts as flat from 0.01 on."""
SMOOTHING_WIDTHS = (0.05, 0.025, 0.0125, 0.006)
"""Standard deviations of the window, in rad of path length, widest first."""
MAX_STOP_OVERSHOOT = 5e-4
"""Greatest overshoot of hinges past their stops on the smoothed path (rad); it grows with the width of the window."""
SPLINE_STATE_SPACING = 0.02
"""Path length, in the norm of all fold angles (rad), between two interpolated states."""
MIN_SPLINE_STATES, MAX_SPLINE_STATES = 200, 4000
"""Bounds of the number of interpolated states."""
STOP_OFFSET_ANGLE, STOP_OFFSET_ROUNDS = 1e-3, 3
"""Approximate distance (rad) kept by a hinge that waits at a stop, as hits of stops on the way make kinks; and the
number of rounds in which states are pushed off the stops and closed in turn."""
MAX_CLOSING_OVERSHOOT = 0.05
"""Greatest overshoot of a hinge past its stop during closing (rad), before it is pushed off again."""
SPLINE_CLOSURE_RESIDUAL = 1e-12
"""Closure residual of the interpolated states (rad, or gap over size)."""


@dataclass(frozen=True)
class SmoothPath:
    """A path from near the packed to near the flat state, as splines parametrised by its length.

    length : rad. end_angles : (2,), greatest distance of a hinge (rad) from the packed state at the start, and from the
    flat state at the end. opening : greatest closure residual midway between interpolated states. width : of the
    window, rad. stop_overshoot : how far hinges would pass their stops, rad.
    """

    spline: Any
    length: float
    end_angles: tuple[float, float]
    opening: float
    width: float
    stop_overshoot: float

    def at(self, places: Reals) -> tuple[Reals, Reals, Reals]:
        """Return fold angles and their first and second derivatives by the length, each (k, n_hinges)."""
        return tuple(np.asarray(self.spline(places, order), float) for order in range(3))  # type: ignore[return-value]


def smooth_path(linkage: Linkage, course: Course, end_angles: tuple[float, float] = DRIVE_END_ANGLES) -> SmoothPath:
    """Smooth the part of a path between its ends by the widest window that keeps hinges within their stops.

    end_angles : approximate distances (rad) of the farthest hinge from the packed state at the start, and from flat at
    the end.
    """
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 - loads slowly

    length, states = _between_ends(linkage, course, end_angles)
    for width in SMOOTHING_WIDTHS:
        closed = _closed(linkage, _smoothed(states, width * (len(states) - 1) / length))
        stop_overshoot = max(-float(closed.min()), float(closed.max()) - np.pi, 0.0)
        if stop_overshoot <= MAX_STOP_OVERSHOOT:
            break
    places = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))]
    spline = make_interp_spline(places, closed, k=5)
    middle = np.asarray(spline(0.5 * (places[1:] + places[:-1])), float)
    opening = max(float(np.abs(linkage.closure(state)[0]).max(initial=0.0)) for state in middle)
    ends = float(np.abs(closed[0] - linkage.folded).max()), float(np.abs(closed[-1]).max())
    return SmoothPath(spline, float(places[-1]), ends, opening, width, stop_overshoot)


def _closed(linkage: Linkage, states: Reals) -> Reals:
    """Project states onto closed ones, away from the stops where possible."""
    loops = loops_of(linkage)
    work = new_closing(loops)
    for _ in range(STOP_OFFSET_ROUNDS):
        states = _off_stops(states)
        for state in states:
            if not close_state(loops, state, SPLINE_CLOSURE_RESIDUAL, MAX_CLOSING_OVERSHOOT, 40, work):
                raise HcsearchError("the smoothed path does not close: give another --near")
    return states


def _off_stops(states: Reals) -> Reals:
    """Push states off the stops by a smooth function: by `STOP_OFFSET_ANGLE` at a stop, hardly far from it."""
    above = 0.5 * (states + np.hypot(states, 2.0 * STOP_OFFSET_ANGLE))
    rest = np.pi - above
    pushed: Reals = np.pi - 0.5 * (rest + np.hypot(rest, 2.0 * STOP_OFFSET_ANGLE))
    return pushed


def _between_ends(linkage: Linkage, course: Course, end_angles: tuple[float, float]) -> tuple[float, Reals]:
    """Return the length of a path between its ends (in its own times), and evenly spaced states along it."""
    times = np.linspace(course.times[0], course.times[-1], 20 * MIN_SPLINE_STATES)
    angles = interpolate_motion(course.times, course.angles, course.rates, None, times)
    departed = np.abs(angles - linkage.folded).max(axis=1) >= end_angles[0]
    away = np.abs(angles).max(axis=1) >= end_angles[1]
    first, last = int(departed.argmax()), len(times) - 1 - int(away[::-1].argmax())
    if not (departed.any() and away.any() and last > first + 10):
        raise HcsearchError(
            f"nothing of the path is further than {max(end_angles):g} rad from its ends: give a smaller --near"
        )
    length = float(times[last] - times[first])
    count = int(np.clip(length / SPLINE_STATE_SPACING, MIN_SPLINE_STATES, MAX_SPLINE_STATES))
    return length, interpolate_motion(
        course.times, course.angles, course.rates, None, np.linspace(times[first], times[last], count + 1)
    )


def _smoothed(states: Reals, width: float) -> Reals:
    """Smooth states by a Gaussian window of a width in steps; both ends keep their positions and slopes."""
    from scipy.ndimage import gaussian_filter1d  # noqa: PLC0415 - loads slowly

    if width < 0.1:
        return states.copy()
    margin = min(len(states) - 1, int(4.0 * width) + 1)
    before = 2.0 * states[0] - states[margin:0:-1]
    after = 2.0 * states[-1] - states[-2 : -margin - 2 : -1]
    smoothed = gaussian_filter1d(np.concatenate([before, states, after]), width, axis=0, mode="nearest")
    return np.asarray(smoothed[margin : margin + len(states)], float)


MAX_HINGE_RATE, MAX_HINGE_ACCELERATION = 1.0, 5.0
"""Default greatest rate (rad/s) and acceleration (rad/s^2) of a hinge."""
MIN_MOTION_LIMIT, MAX_MOTION_LIMIT = 1e-6, 1e6
"""Bounds of both limits."""
TIMING_SAMPLE_COUNT = 2000
"""Number of places at which the limits are checked."""
PACE_WINDOW_SHARE = 0.02
"""Standard deviation of the window that smooths the pace, as a share of the path's length."""
RAMP_TIME_SHARE = 0.25
"""Share of the time for which the motion accelerates; it decelerates for the same share."""


@dataclass(frozen=True)
class TimedPath:
    """A path with its time law.

    seconds : duration. places : spline of the place on the path as a function of the time over `seconds`.
    """

    path: SmoothPath
    seconds: float
    places: Any

    def at(self, times: Reals) -> tuple[Reals, Reals, Reals]:
        """Return fold angles (rad), rates and accelerations at times (s), each (k, n_hinges); at rest after the end."""
        share = np.clip(times / self.seconds, 0.0, 1.0)
        going = ((times >= 0.0) & (times <= self.seconds))[:, None]
        place, pace, push = (np.asarray(self.places(share, order), float)[:, None] for order in range(3))
        angles, slopes, bends = self.path.at(np.clip(place.ravel(), 0.0, self.path.length))
        pace, push = going * pace / self.seconds, going * push / self.seconds**2
        return angles, slopes * pace, bends * pace**2 + slopes * push


def time_path(
    path: SmoothPath, rate: float = MAX_HINGE_RATE, acceleration: float = MAX_HINGE_ACCELERATION
) -> TimedPath:
    """Compute the time law of a path within a greatest rate (rad/s) and acceleration (rad/s^2) of its hinges."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 - loads slowly
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d  # noqa: PLC0415 - loads slowly

    for name, bound in (("rate", rate), ("acceleration", acceleration)):
        if not MIN_MOTION_LIMIT <= bound <= MAX_MOTION_LIMIT:
            raise HcsearchError(
                f"a greatest {name} of {bound:g} is out of range: give {MIN_MOTION_LIMIT:g} to {MAX_MOTION_LIMIT:g}"
            )
    samples = np.linspace(0.0, path.length, TIMING_SAMPLE_COUNT)
    _, slopes, bends = path.at(samples)
    turning = np.abs(slopes).max(axis=1)
    # no faster than an even pace from rest to rest, if only the acceleration is bounded
    fastest = min(rate, math.sqrt(acceleration * path.length * float(turning.mean())))
    slowness = np.maximum(turning / fastest, np.sqrt(np.abs(bends).max(axis=1) / acceleration))
    width = PACE_WINDOW_SHARE * TIMING_SAMPLE_COUNT
    slowness = gaussian_filter1d(maximum_filter1d(slowness, int(2.0 * width)), width, mode="nearest")
    steps = 0.5 * (slowness[1:] + slowness[:-1]) * path.length / (TIMING_SAMPLE_COUNT - 1)
    clock = np.r_[0.0, np.cumsum(steps)]
    by_clock = make_interp_spline(clock / clock[-1], samples, k=5)
    share = np.linspace(0.0, 1.0, TIMING_SAMPLE_COUNT)
    places = make_interp_spline(share, by_clock(_ramped(share)), k=5)
    unit_time = TimedPath(path, 1.0, places)
    _, rates, accelerations = unit_time.at(share)
    seconds = max(float(np.abs(rates).max()) / rate, math.sqrt(float(np.abs(accelerations).max()) / acceleration))
    return TimedPath(path, seconds, places)


def _ramped(share: Reals) -> Reals:
    """Map shares of the time to shares of the path: a constant pace between two ramps, smooth steps of fifth degree."""

    def ramp(x: Reals) -> Reals:  # integral of 10 x^3 - 15 x^4 + 6 x^5
        integral: Reals = x**4 * (2.5 + x * (-3.0 + x))
        return integral

    early, late = (
        np.minimum(share, RAMP_TIME_SHARE) / RAMP_TIME_SHARE,
        np.minimum(1.0 - share, RAMP_TIME_SHARE) / RAMP_TIME_SHARE,
    )
    steady = np.clip(share, RAMP_TIME_SHARE, 1.0 - RAMP_TIME_SHARE) - RAMP_TIME_SHARE
    ramped: Reals = (RAMP_TIME_SHARE * (ramp(early) + 0.5 - ramp(late)) + steady) / (1.0 - RAMP_TIME_SHARE)
    return ramped
