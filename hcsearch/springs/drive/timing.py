"""The time law of a path: hinge rates and accelerations stay within bounds, and both ends are at rest.

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

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import HcsearchError
from hcsearch.springs.drive.smoothing import SmoothPath

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
