"""Arrivals of hinges at their stops in a deployment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE
from hcsearch.springs.deployment.simulated_deployment import Deployment

ARRIVAL_TIME_TOLERANCE = 1e-4
"""Greatest time (s) between arrivals that count as one: mirror images arrive together up to rounding."""


@dataclass(frozen=True)
class Arrival:
    """Hinges that arrive at their stops together: the first time (s), and the greatest speed (rad/s)."""

    time: float
    stop: Literal["flat", "folded"]
    hinges: tuple[int, ...]
    speed: float


def hinge_arrivals(deployment: Deployment) -> tuple[Arrival, ...]:
    """Return the arrivals of hinges at stops that they had left by more than 0.01 rad since their last hit.

    Bounces are left out, as their number and size depend on the model of the stops.
    """
    arrived: list[Arrival] = []
    for time, stop, hinge, speed in sorted(_hits(deployment)):
        recent = (a for a in arrived[::-1] if a.stop == stop and time - a.time <= ARRIVAL_TIME_TOLERANCE)
        together = next(recent, None)
        if together is None:
            arrived.append(Arrival(time, stop, (hinge,), speed))
        else:
            hinges = tuple(sorted({*together.hinges, hinge}))
            arrived[arrived.index(together)] = Arrival(together.time, stop, hinges, max(together.speed, speed))
    return tuple(arrived)


def _hits(deployment: Deployment) -> list[tuple[float, Literal["flat", "folded"], int, float]]:
    """Return time, stop, hinge and speed of each hit except bounces."""
    times, angles, hits = deployment.motion.times, deployment.angles, []
    last_hits: dict[int, float] = {}
    for event in deployment.motion.events:
        if event.kind != "hit":
            continue
        for hinge in deployment.compiled.hinges_of(event.joint):
            angles_since = angles[
                np.searchsorted(times, last_hits.get(hinge, 0.0)) : np.searchsorted(times, event.time), hinge
            ]
            angle = float(np.interp(event.time, times, angles[:, hinge]))
            stop: Literal["flat", "folded"] = "flat" if angle < 0.5 * math.pi else "folded"
            limit = 0.0 if stop == "flat" else math.pi
            if np.abs(angles_since - limit).max(initial=0.0) > FLAT_FOLD_ANGLE:
                hits.append((event.time, stop, hinge, abs(event.speed)))
            last_hits[hinge] = event.time
    return hits
