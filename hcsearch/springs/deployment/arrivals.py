"""Which hinges come to their stops, and in what order: what formulations can be compared by after the first impact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hcsearch.springs.deployment.deploying import Deployment
from hcsearch.springs.deployment.outcomes import FLAT_FOLD_ANGLE

ARRIVAL_TIME_TOLERANCE = 1e-4
"""Hinges that arrive within this of one another (s) arrive together: mirror images do, but for rounding."""


@dataclass(frozen=True)
class Arrival:
    """Hinges that come to their stops together: the first time (s), and the greatest speed (rad/s)."""

    time: float
    stop: Literal["flat", "folded"]
    hinges: tuple[int, ...]
    speed: float


def hinge_arrivals(deployment: Deployment) -> tuple[Arrival, ...]:
    """The arrivals of hinges at stops from which they were away, by more than 0.01 rad, since the hit before.

    Bounces are left out: how many there are, and how small, is a matter of how the stops are modelled.
    """
    arrived: list[Arrival] = []
    for time, stop, hinge, speed in sorted(_hits(deployment)):
        last = next((a for a in arrived[::-1] if a.stop == stop and time - a.time <= ARRIVAL_TIME_TOLERANCE), None)
        if last is None:
            arrived.append(Arrival(time, stop, (hinge,), speed))
        else:
            hinges = tuple(sorted({*last.hinges, hinge}))
            arrived[arrived.index(last)] = Arrival(last.time, stop, hinges, max(last.speed, speed))
    return tuple(arrived)


def _hits(deployment: Deployment) -> list[tuple[float, Literal["flat", "folded"], int, float]]:
    """Time, stop, hinge and speed of each hit that is no bounce."""
    times, angles, hits = deployment.motion.times, deployment.angles, []
    last: dict[int, float] = {}
    for event in deployment.motion.events:
        if event.kind != "hit":
            continue
        for hinge in deployment.compiled.hinges_of(event.joint):
            since = angles[np.searchsorted(times, last.get(hinge, 0.0)) : np.searchsorted(times, event.time), hinge]
            here = float(np.interp(event.time, times, angles[:, hinge]))
            stop: Literal["flat", "folded"] = "flat" if here < 0.5 * math.pi else "folded"
            limit = 0.0 if stop == "flat" else math.pi
            if np.abs(since - limit).max(initial=0.0) > FLAT_FOLD_ANGLE:
                hits.append((event.time, stop, hinge, abs(event.speed)))
            last[hinge] = event.time
    return hits
