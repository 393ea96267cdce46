"""What the tuning of springs minimises: the thesis's objective, extended so that it orders all outcomes."""

from __future__ import annotations

import math

from hcsearch.deployment.checking import Check

SPEED = 1.0
"""Approach speed that is worth as much as all of the way from folded to flat, m/s: p of eq. 4.26 is its inverse."""
AMPLE = 2e-3
"""A gap that is as good as any larger one, m: q of eq. 4.26 is its inverse."""


def objective(check: Check) -> float:
    """The less, the better; below 0 for what comes flat and clear.

    The thesis minimises f = p v_a - q d_p (eq. 4.26): the approach speed at the first collision, less the smallest gap
    where there is none. That says nothing of deployments that stop short of flat, and equals 0 for collisions at any
    time that are slow enough. So here f is a sum:

    - flat and clear: -q d_p, from 0 to -1, as gaps above `AMPLE` count as that;
    - else, if not clear: 1 + p v_a + the mean fold angle over pi that is left when panels come together, so that late
      and slow collisions are better than early and fast ones; what cannot be told apart (`undecided`) counts the same;
    - and if not flat: 2 + the mean fold angle over pi that is left at the end; 1 more where the simulation gave up.
    """
    if check.deploys:
        return -min(AMPLE if check.gap is None else check.gap, AMPLE) / AMPLE
    value = 0.0
    if check.clear is not True:
        value += 1.0 + check.speed / SPEED + check.remaining
    if check.outcome != "flat":
        value += 2.0 + check.end_remaining + (check.outcome in {"diverged", "out of steps"})
    # a simulation that overflowed tells nothing
    return value if math.isfinite(value) else 10.0
