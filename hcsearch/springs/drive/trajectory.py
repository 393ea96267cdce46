"""The trajectory of a drive: a certified path as splines through closed states, and its time law.

The path of a proof is made of cubics whose second derivatives jump. It is resampled, smoothed by a Gaussian window of a
given width, moved to the nearest closed states within the stops, and splines of fifth degree are put through these.

First the path goes as fast as the greatest rate and, where it bends, as the root of the greatest acceleration allow,
smoothed; then it begins and ends by steps of fifth degree, without jumps of acceleration; then all times are stretched
until both bounds hold at all samples. It is no time-optimal law: that switches accelerations on and off (Bobrow,
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
"""How near to the packed and to the flat state the driven motion begins and ends (rad): both are singular, and nothing
drives them. Flat counts as flat from 0.01 on."""
SMOOTHING_WIDTHS = (0.05, 0.025, 0.0125, 0.006)
"""Standard deviation of the window, rad of length of a path, widest first."""
MAX_STOP_OVERSHOOT = 5e-4
"""What hinges of the smoothed path may pass their stops by (rad): a wider window rounds off more where they wait."""
SPLINE_STATE_SPACING = 0.02
"""Length of a path, in the norm of all fold angles (rad), between two states that splines go through."""
MIN_SPLINE_STATES, MAX_SPLINE_STATES = 200, 4000
"""States that splines go through."""
STOP_OFFSET_ANGLE, STOP_OFFSET_ROUNDS = 1e-3, 3
"""A hinge that waits at a stop is kept off it by this (rad), about: stops that are met on the way make kinks. Pushing
off and closing take turns so often."""
MAX_CLOSING_OVERSHOOT = 0.05
"""What closing may take a hinge beyond its stop (rad), where it is pushed off again."""
SPLINE_CLOSURE_RESIDUAL = 1e-12
"""Closure residual of these states (rad, or gap over size)."""


@dataclass(frozen=True)
class SmoothPath:
    """A path as splines of its length, from one state near the packed one to one near the flat one.

    length : rad. near : (2,), the widest turn of a hinge (rad) from the packed state at its start, from the flat state
    at its end. opening : closure residual between the states that splines go through. width : of the window, rad.
    beyond : rad, by which hinges would pass their stops.
    """

    spline: Any
    length: float
    near: tuple[float, float]
    opening: float
    width: float
    beyond: float

    def at(self, places: Reals) -> tuple[Reals, Reals, Reals]:
        """Fold angles and their first and second derivatives by the length, each (k, n_hinges)."""
        return tuple(np.asarray(self.spline(places, order), float) for order in range(3))  # type: ignore[return-value]


def smooth_path(linkage: Linkage, course: Course, near: tuple[float, float] = DRIVE_END_ANGLES) -> SmoothPath:
    """The part of a path between its ends, smoothed by the widest window that keeps hinges within their stops.

    near : rad, by which the widest hinge has left the packed state at the start, and is away from flat at the end,
    about.
    """
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 - loads slowly

    length, states = _between_ends(linkage, course, near)
    for width in SMOOTHING_WIDTHS:
        own = _closed(linkage, _smoothed(states, width * (len(states) - 1) / length))
        beyond = max(-float(own.min()), float(own.max()) - np.pi, 0.0)
        if beyond <= MAX_STOP_OVERSHOOT:
            break
    places = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(own, axis=0), axis=1))]
    spline = make_interp_spline(places, own, k=5)
    middle = np.asarray(spline(0.5 * (places[1:] + places[:-1])), float)
    opening = max(float(np.abs(linkage.closure(state)[0]).max(initial=0.0)) for state in middle)
    ends = float(np.abs(own[0] - linkage.folded).max()), float(np.abs(own[-1]).max())
    return SmoothPath(spline, float(places[-1]), ends, opening, width, beyond)


def _closed(linkage: Linkage, states: Reals) -> Reals:
    """The states moved to closed ones, off the stops where that can be."""
    loops = loops_of(linkage)
    work = new_closing(loops)
    for _ in range(STOP_OFFSET_ROUNDS):
        states = _off_stops(states)
        for state in states:
            if not close_state(loops, state, SPLINE_CLOSURE_RESIDUAL, MAX_CLOSING_OVERSHOOT, 40, work):
                raise HcsearchError("the smoothed path does not close: give another --near")
    return states


def _off_stops(states: Reals) -> Reals:
    """States pushed off the stops by a smooth function: by `STOP_OFFSET_ANGLE` at a stop, by nothing far from it."""
    up = 0.5 * (states + np.hypot(states, 2.0 * STOP_OFFSET_ANGLE))
    left = np.pi - up
    pushed: Reals = np.pi - 0.5 * (left + np.hypot(left, 2.0 * STOP_OFFSET_ANGLE))
    return pushed


def _between_ends(linkage: Linkage, course: Course, near: tuple[float, float]) -> tuple[float, Reals]:
    """The length of a path between its ends (in its own times), and states evenly along it."""
    fine = np.linspace(course.times[0], course.times[-1], 20 * MIN_SPLINE_STATES)
    angles = interpolate_motion(course.times, course.angles, course.rates, None, fine)
    left = np.abs(angles - linkage.folded).max(axis=1) >= near[0]
    away = np.abs(angles).max(axis=1) >= near[1]
    first, last = int(left.argmax()), len(fine) - 1 - int(away[::-1].argmax())
    if not (left.any() and away.any() and last > first + 10):
        raise HcsearchError(
            f"nothing of the path is further than {max(near):g} rad from its ends: give a smaller --near"
        )
    length = float(fine[last] - fine[first])
    count = int(np.clip(length / SPLINE_STATE_SPACING, MIN_SPLINE_STATES, MAX_SPLINE_STATES))
    return length, interpolate_motion(
        course.times, course.angles, course.rates, None, np.linspace(fine[first], fine[last], count + 1)
    )


def _smoothed(states: Reals, width: float) -> Reals:
    """States under a Gaussian window of a width in steps; both ends keep their places and slopes."""
    from scipy.ndimage import gaussian_filter1d  # noqa: PLC0415 - loads slowly

    if width < 0.1:
        return states.copy()
    more = min(len(states) - 1, int(4.0 * width) + 1)
    before = 2.0 * states[0] - states[more:0:-1]
    after = 2.0 * states[-1] - states[-2 : -more - 2 : -1]
    wide = gaussian_filter1d(np.concatenate([before, states, after]), width, axis=0, mode="nearest")
    return np.asarray(wide[more : more + len(states)], float)


MAX_HINGE_RATE, MAX_HINGE_ACCELERATION = 1.0, 5.0
"""Greatest rate (rad/s) and acceleration (rad/s^2) of a hinge, unless given."""
MIN_MOTION_LIMIT, MAX_MOTION_LIMIT = 1e-6, 1e6
"""Bounds of both."""
TIMING_SAMPLE_COUNT = 2000
"""Places at which bounds are looked at."""
PACE_WINDOW_SHARE = 0.02
"""Standard deviation of the window that smooths the pace, as a share of the path's length."""
RAMP_TIME_SHARE = 0.25
"""Share of the time in which the motion gathers speed, and as much in which it comes to rest."""


@dataclass(frozen=True)
class TimedPath:
    """A path in time.

    seconds : how long it takes. places : spline of the place on the path by time over `seconds`.
    """

    path: SmoothPath
    seconds: float
    places: Any

    def at(self, times: Reals) -> tuple[Reals, Reals, Reals]:
        """Fold angles (rad), rates and accelerations at times (s), each (k, n_hinges); at rest after the end."""
        share = np.clip(times / self.seconds, 0.0, 1.0)
        going = ((times >= 0.0) & (times <= self.seconds))[:, None]
        place, pace, push = (np.asarray(self.places(share, order), float)[:, None] for order in range(3))
        angles, slopes, bends = self.path.at(np.clip(place.ravel(), 0.0, self.path.length))
        pace, push = going * pace / self.seconds, going * push / self.seconds**2
        return angles, slopes * pace, bends * pace**2 + slopes * push


def time_path(
    path: SmoothPath, rate: float = MAX_HINGE_RATE, acceleration: float = MAX_HINGE_ACCELERATION
) -> TimedPath:
    """The time law of a path within a greatest rate (rad/s) and acceleration (rad/s^2) of its hinges."""
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 - loads slowly
    from scipy.ndimage import gaussian_filter1d, maximum_filter1d  # noqa: PLC0415 - loads slowly

    for name, bound in (("rate", rate), ("acceleration", acceleration)):
        if not MIN_MOTION_LIMIT <= bound <= MAX_MOTION_LIMIT:
            raise HcsearchError(
                f"a greatest {name} of {bound:g} is out of range: give {MIN_MOTION_LIMIT:g} to {MAX_MOTION_LIMIT:g}"
            )
    at = np.linspace(0.0, path.length, TIMING_SAMPLE_COUNT)
    _, slopes, bends = path.at(at)
    turning = np.abs(slopes).max(axis=1)
    # from rest to rest no faster: an even pace, where the rate is no bound
    fastest = min(rate, math.sqrt(acceleration * path.length * float(turning.mean())))
    slowness = np.maximum(turning / fastest, np.sqrt(np.abs(bends).max(axis=1) / acceleration))
    width = PACE_WINDOW_SHARE * TIMING_SAMPLE_COUNT
    slowness = gaussian_filter1d(maximum_filter1d(slowness, int(2.0 * width)), width, mode="nearest")
    steps = 0.5 * (slowness[1:] + slowness[:-1]) * path.length / (TIMING_SAMPLE_COUNT - 1)
    clock = np.r_[0.0, np.cumsum(steps)]
    by_clock = make_interp_spline(clock / clock[-1], at, k=5)
    share = np.linspace(0.0, 1.0, TIMING_SAMPLE_COUNT)
    places = make_interp_spline(share, by_clock(_ramped(share)), k=5)
    own = TimedPath(path, 1.0, places)
    _, rates, accelerations = own.at(share)
    seconds = max(float(np.abs(rates).max()) / rate, math.sqrt(float(np.abs(accelerations).max()) / acceleration))
    return TimedPath(path, seconds, places)


def _ramped(share: Reals) -> Reals:
    """From 0 to 1 with an even pace between two ramps, whose pace is a step of fifth degree."""

    def ramp(x: Reals) -> Reals:  # integral of 10 x^3 - 15 x^4 + 6 x^5
        integral: Reals = x**4 * (2.5 + x * (-3.0 + x))
        return integral

    early, late = (
        np.minimum(share, RAMP_TIME_SHARE) / RAMP_TIME_SHARE,
        np.minimum(1.0 - share, RAMP_TIME_SHARE) / RAMP_TIME_SHARE,
    )
    even = np.clip(share, RAMP_TIME_SHARE, 1.0 - RAMP_TIME_SHARE) - RAMP_TIME_SHARE
    ramped: Reals = (RAMP_TIME_SHARE * (ramp(early) + 0.5 - ramp(late)) + even) / (1.0 - RAMP_TIME_SHARE)
    return ramped
