"""Estimates of the errors of a deployment, from simulations of it at tighter tolerances, also as data and in a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.motion.collision.panel_prisms import TOUCHING_DISTANCE, resolution_of, scale_of
from hcsearch.springs.deployment.play import Play, least_gap_of
from hcsearch.springs.deployment.simulated_deployment import Deployment, hinge_arrivals
from hcsearch.springs.dynamics.law_torques import law_torques
from hcsearch.system.terminal import short_number

EVEN_TIMES = 500
"""Number of evenly spaced times at which motions are compared."""
MAX_COMPARED_STEPS = 1_000
"""Greatest number of steps inside which motions are compared."""
_INSIDE = np.array([0.25, 0.5, 0.75])
"""Shares of a step at which motions are compared inside it."""
PARTING_ANGLE = 0.01
"""Two motions part where a fold angle differs by more than this (rad): the greatest angle of a flat array."""
SMOOTH_FACTOR, EVENT_FACTOR, SENSITIVE_FACTOR = 4.0, 12.0, 150.0
"""An estimate of an error is so many times the greatest distance from the same deployment at tighter tolerances. Where
these converge, errors fall with the tolerance and are about that distance; more is allowed with impacts or sticking,
and most where the motion is sensitive. On scenes drawn at random errors were at most 1.1, 10 and 123 times the
distance (docs/explanation/accuracy.md)."""
SLOW_SHARE, SLOW_DISTANCE = 0.3, 10.0
"""A motion is sensitive where the two at the tighter tolerances are further apart than this share of the distance, and
this is more than so many tolerances; at a tenth of a tolerance, a share of 0.1 is expected."""
RELATIVE_ROUNDING = 1e-11
"""Relative error that rounding, and the location of events, may leave in any number."""
ANGLE_ROUNDING = 1e-10
"""The same for a fold angle, as an absolute error, rad."""


def comparison_times(steps: Reals, until: float) -> Reals:
    """Return the times (s) at which a motion with steps at given times is compared: evenly spaced, and inside steps."""
    nodes = np.unique(steps[steps <= until])
    chosen = np.unique(np.linspace(0, max(0, len(nodes) - 2), min(len(nodes), MAX_COMPARED_STEPS)).astype(int))
    inside = np.empty(0)
    if len(nodes) > 1:
        begin, end = nodes[chosen, None], nodes[chosen + 1, None]
        inside = (begin + (end - begin) * _INSIDE).ravel()
    times: Reals = np.unique(np.concatenate([np.linspace(0.0, until, EVEN_TIMES), inside]))
    return times


def angle_distances(one: Deployment, other: Deployment, times: Reals) -> Reals:
    """Return the greatest distance of a fold angle between two deployments at each time, shape (len(times),), rad.

    Between its states a motion is interpolated by its own polynomials, with closed loops.
    """
    return _distances(one.angles_at(times), other.angles_at(times))


def parting_time(times: Reals, distances: Reals) -> float | None:
    """Return the first time (s) at which two motions differ by more than `PARTING_ANGLE`; None if they never do."""
    parted = np.flatnonzero(~(distances <= PARTING_ANGLE))
    return float(times[parted[0]]) if len(parted) else None


@dataclass(frozen=True)
class ErrorBar:
    """A number that a user reads, and the estimate of its error, in the same unit."""

    value: float
    error: float


@dataclass(frozen=True)
class ErrorEstimates:
    """Estimates of the errors of a deployment; none is a bound.

    angle : of all fold angles at any time until `reproducible_until`, or the end, rad. flat_time : s; None unless all
    simulations are flat. clearance : the smallest gap to which panels return, m. latch_rate : the greatest speed at
    which hinges arrive at their flat stops, rad/s; torque : the greatest of spring and damper at a hinge, N m; both
    until motions that part differ by a tenth of `PARTING_ANGLE`. These three are None where a simulation has no such
    number.
    sensitive : whether errors do not fall as tolerances do, so that the estimates are wider.
    reproducible_until : s, from which on a fold angle differs by more than `PARTING_ANGLE` between simulations; None
    if none ever does.
    """

    angle: float
    flat_time: ErrorBar | None
    clearance: ErrorBar | None
    latch_rate: ErrorBar | None
    torque: ErrorBar | None
    sensitive: bool
    reproducible_until: float | None

    def error_of_time(self, time: float | None) -> float | None:
        """Estimate the error of a rounded flat time (s), rounding included.

        None without one, and where the error is as large as the time, so that nothing is known of it.
        """
        if time is None or self.flat_time is None:
            return None
        error = self.flat_time.error + abs(time - self.flat_time.value)
        return error if error < time else None


def error_estimate(values: Sequence[float], factor: float = SMOOTH_FACTOR, resolution: float = 0.0) -> float:
    """Estimate the error of the first of several values of one number, the others at tighter tolerances.

    factor : multiplies the greatest distance. resolution : of the values, by which each may be off.
    """
    first, *others = values
    distance = max(0.0, max(abs(first - other) for other in others) - resolution)
    return factor * distance + resolution + RELATIVE_ROUNDING * abs(first)


class Clearances(NamedTuple):
    """The smallest gap of each of several deployments, m, None where it is not known, and its resolution, m."""

    gaps: Sequence[float | None]
    resolution: float


def clearances_of(deployments: Sequence[Deployment], play: Play | None = None) -> Clearances:
    """Return the gaps to which panels return, or, where panels as built overlap by a play, the least gaps."""
    linkage = deployments[0].compiled.linkage
    if play is None or play.least_gap is None or play.least_gap >= 0.0:
        gaps = [None if one.clearance is None else one.clearance.gap for one in deployments]
        return Clearances(gaps, resolution_of(linkage))
    others = [least_gap_of(one.compiled, one.motion) for one in deployments[1:]]
    return Clearances([play.least_gap, *others], TOUCHING_DISTANCE * scale_of(linkage))


def estimate_errors(
    deployments: Sequence[Deployment], tolerance: float, clearances: Clearances | None = None, *, figures: bool = True
) -> ErrorEstimates | None:
    """Estimate the errors of a deployment, the first one, from others at tighter tolerances, the tightest last.

    tolerance : of the first. clearances : of all, if their errors are wanted. figures : whether the errors of the latch
    rate and the torque are wanted. None where there are no others, one has no states to compare, or the first diverges.
    """
    first, others = deployments[0], deployments[1:]
    states = all(len(one.motion.times) > 1 and np.isfinite(one.motion.q).all() for one in deployments)
    if not others or not states or first.outcome == "diverged":
        return None
    times = comparison_times(first.motion.times, min(float(one.motion.times[-1]) for one in deployments))
    angles = [one.angles_at(times) for one in deployments]
    distances = np.max([_distances(angles[0], other) for other in angles[1:]], axis=0)
    parting = parting_time(times, distances)
    end = float(times[-1]) if parting is None else _agreeing_end(times, distances)
    here = slice(None) if parting is None else times < parting
    greatest = float(distances[here].max(initial=0.0))
    tighter = float(_distances(angles[-1], angles[-2])[here].max(initial=0.0)) if len(others) > 1 else 0.0
    slow = tighter > SLOW_SHARE * greatest and greatest > SLOW_DISTANCE * tolerance
    sensitive = slow or parting is not None
    factor = SENSITIVE_FACTOR if sensitive else EVENT_FACTOR if first.motion.events else SMOOTH_FACTOR
    return ErrorEstimates(
        angle=min(factor * greatest + ANGLE_ROUNDING, math.pi),
        flat_time=_bar([one.flat_time for one in deployments], factor),
        clearance=None if clearances is None else _bar(clearances.gaps, factor, clearances.resolution),
        latch_rate=_bar([greatest_latch_rate(one, end) for one in deployments], factor) if figures else None,
        torque=_bar([greatest_torque(one, end) for one in deployments], factor) if figures else None,
        sensitive=sensitive,
        reproducible_until=parting,
    )


def _agreeing_end(times: Reals, distances: Reals) -> float:
    """Return the time (s) until which motions that part agree to a tenth of `PARTING_ANGLE`."""
    return float(times[np.flatnonzero(~(distances <= 0.1 * PARTING_ANGLE))[0]])


def _distances(angles: Reals, others: Reals) -> Reals:
    """Return the greatest distance of a fold angle at each time, rad."""
    distances: Reals = np.abs(angles - others).max(axis=1, initial=0.0)
    return distances


def _bar(values: Sequence[float | None], factor: float, resolution: float = 0.0) -> ErrorBar | None:
    """Return the first value with the estimate of its error; None unless all simulations have the number."""
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        return None
    return ErrorBar(float(known[0]), float(error_estimate(known, factor, resolution)))


def greatest_torque(deployment: Deployment, until: float) -> float | None:
    """Return the greatest torque of the spring and the damper of a hinge at the states until a time (s), N m.

    None without hinges. At the start it is the torque of the wound springs; dampers add to it where hinges are fast.
    """
    compiled, here = deployment.compiled, deployment.motion.times <= until
    angles, rates = deployment.angles[here], deployment.rates[here]
    torques = law_torques(compiled.setup.laws, angles) + np.array(compiled.setup.dampings) * rates
    return float(np.abs(torques).max()) if torques.size else None


def greatest_latch_rate(deployment: Deployment, until: float) -> float | None:
    """Return the greatest speed at which hinges arrive at their flat stops before a time (s), rad/s; None without any.

    Bounces are no arrivals. Without inertia stops take no speed, so that it is None, too.
    """
    if deployment.compiled.system.overdamped:
        return None
    arrivals = [arrival for arrival in hinge_arrivals(deployment) if arrival.stop == "flat" and arrival.time < until]
    return max((arrival.speed for arrival in arrivals), default=None)


ERROR_KIND = "estimate"
"""What the errors of a deployment are: estimates from simulations at tighter tolerances, and no bounds."""


def error_facts(errors: ErrorEstimates) -> dict[str, Any]:
    """Return estimates of errors as plain data; keys name their units."""
    return {
        "kind": ERROR_KIND,
        "angles_rad": errors.angle,
        "flat_time_s": _facts(errors.flat_time),
        "min_clearance_mm": _facts(errors.clearance, 1e3),
        "latch_rate_rad_s": _facts(errors.latch_rate),
        "torque_N_m": _facts(errors.torque),
        "sensitive": errors.sensitive,
        "reproducible_until_s": errors.reproducible_until,
    }


def _facts(bar: ErrorBar | None, scale: float = 1.0) -> dict[str, float] | None:
    return None if bar is None else {"value": scale * bar.value, "error": scale * bar.error}


def errors_sentence(facts: dict[str, Any]) -> str:
    """Return the errors of `error_facts` in one line."""
    units = {"flat_time_s": "s", "min_clearance_mm": "mm", "latch_rate_rad_s": "rad/s", "torque_N_m": "N m"}
    words = {
        "flat_time_s": "flat time",
        "min_clearance_mm": "clearance",
        "latch_rate_rad_s": "latch rate",
        "torque_N_m": "torque",
    }
    known = [name for name in units if facts[name] is not None]
    parts = [f"{words[name]} {with_error(**facts[name])} {units[name]}" for name in known]
    parts.append(f"fold angles +- {facts['angles_rad']:.0e} rad")
    text = f"{', '.join(parts)} ({ERROR_KIND}s)"
    until = facts["reproducible_until_s"]
    if until is not None:
        text += (
            f"; not reproducible from {short_number(until)} s on, where tolerances differ by {PARTING_ANGLE:g} rad: "
            "verdict and ending stand as said above, and angles and arrivals before"
        )
    return text


def with_error(value: float, error: float) -> str:
    """Return a number in the digits that its error leaves, with the error in one digit, such as `0.141 +- 2e-06`."""
    if not error > 0.0 or not math.isfinite(error):
        return f"{short_number(value, 6)} +- {error:.0e}"
    decimals = max(0, -math.floor(math.log10(error)))
    return f"{value:.{min(decimals, 9)}f} +- {error:.0e}"
