"""What the tuning of springs minimises: the thesis's objective, extended so that it orders all outcomes."""

from __future__ import annotations

import math
from typing import NamedTuple

from hcsearch.springs.deployment.outcomes import DeploymentCheck

APPROACH_SPEED_SCALE = 5.0
"""Approach speed that is worth as much as all of the way from folded to flat, m/s: p of eq. 4.26 is its inverse."""
AMPLE_GAP = 2e-3
"""A gap that is as good as any larger one, m: q of eq. 4.26 is its inverse."""


class SceneScales(NamedTuple):
    """Lengths and times of a scene over those of `default`, for which `APPROACH_SPEED_SCALE` and `AMPLE_GAP` hold."""

    length: float = 1.0
    time: float = 1.0


DEFAULT_SCENE_SCALES = SceneScales()


def tuning_objective(check: DeploymentCheck, slack: float = 0.0, scales: SceneScales = DEFAULT_SCENE_SCALES) -> float:
    """The less, the better; least for what becomes flat and clear.

    slack : what panels may be elsewhere as the loops give way, m.

    The thesis minimises f = p v_a - q d_p (eq. 4.26): the approach speed at the first collision, less the smallest gap
    where there is none. That says nothing of deployments that stop short of flat, and equals 0 for collisions at any
    time that are slow enough. So here:

    - flat and clear: -q (d_p - slack), not less than -1, as gaps above `AMPLE_GAP` count as that, and less than 1: what
      is certain of the gap, which impacts that open the loops lessen;
    - else 1 + the mean fold angle over pi that is left when panels come together (or may do so), or where it
      is clear at the end, so that what gets further is better; what comes after a collision counts for nothing. To that
      p v_a, and 1 where the simulation gave up.
    """
    ample, speed = AMPLE_GAP * scales.length, APPROACH_SPEED_SCALE * scales.length / scales.time
    if check.deploys:
        gap = ample if check.gap is None else min(check.gap, ample)
        return min((slack - gap) / ample, 0.999)
    value = 1.0 + check.remaining + (0.0 if check.clear else check.speed / speed)
    value += check.outcome in {"diverged", "out of steps"}
    # a simulation that overflowed shows nothing
    return value if math.isfinite(value) else 10.0
