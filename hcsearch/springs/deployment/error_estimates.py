"""Estimates of the errors of a deployment, from simulations of it at tighter tolerances."""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.springs.deployment.simulated_deployment import Deployment

EVEN_TIMES = 500
"""Number of evenly spaced times at which motions are compared."""
MAX_COMPARED_STEPS = 1_000
"""Greatest number of steps inside which motions are compared."""
_INSIDE = np.array([0.25, 0.5, 0.75])
"""Shares of a step at which motions are compared inside it."""
PARTING_ANGLE = 0.01
"""Two motions part where a fold angle differs by more than this (rad): the greatest angle of a flat array."""


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

    States between those of a motion are interpolated by its own polynomials, with closed loops.
    """
    distances: Reals = np.abs(one.angles_at(times) - other.angles_at(times)).max(axis=1, initial=0.0)
    return distances


def parting_time(times: Reals, distances: Reals) -> float | None:
    """Return the first time (s) at which two motions differ by more than `PARTING_ANGLE`; None if they never do."""
    parted = np.flatnonzero(~(distances <= PARTING_ANGLE))
    return float(times[parted[0]]) if len(parted) else None
