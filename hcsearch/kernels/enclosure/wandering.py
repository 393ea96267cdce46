"""Random walks through closed states, by which floods of two ends are compared before they are made."""

from __future__ import annotations

import numpy as np

from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import Rings
from hcsearch.kernels.enclosure.refutation import Refutation, meets
from hcsearch.typing import Reals

STRIDE = 0.15
"""The longest step, of the angle that turns most (rad)."""
TURN = 20
"""A walk begins anew at any of its states after so many steps."""
BEND = 0.3
"""How much each step bends off the one before, for its length."""


@compiled
def wander(rings: Rings, start: Reals, steps: int, seed: int, work: Refutation) -> Reals:
    """Closed states, (m, n), that a random walk of so many steps from a closed state, (n,), passes.

    Panels are clear at them, where they do not pass through each other. A step that comes to none is not taken.
    """
    np.random.seed(seed)
    n, count = len(start), 1
    low, high = np.zeros(n), np.full(n, np.pi)
    states = np.zeros((steps + 1, n))
    states[0] = start
    here, way, state = start.copy(), np.random.standard_normal(n), start.copy()
    for step in range(steps):
        if step % TURN == 0:
            here[:] = states[np.random.randint(count)]
            way[:] = np.random.standard_normal(n)
        length = STRIDE * np.random.random() / np.abs(way).max()
        state[:] = np.minimum(np.maximum(here + length * way, low), high)
        closed = meets(rings, low, high, state, work)
        moved = np.abs(state - here).max()
        # a state further away may be one of another part
        if not closed or moved < 1e-6 or moved > 1.5 * STRIDE:
            way[:] = np.random.standard_normal(n)
            continue
        way[:] = state - here + BEND * moved * np.random.standard_normal(n)
        here[:] = state
        states[count] = state
        count += 1
    return states[:count]
