"""Closed states in boxes of fold angles, by Newton's method of least squares within the bounds of the box."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.algebra.cholesky import factor_symmetric, solve_factored
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.expansion import Expansion, HingeRings, write_first_order

MAX_NEWTON_STEPS = 20
"""Steps, at most: most closed states are reached in seven."""
NEWTON_RESIDUAL = 1e-7
"""Root of the sum of squares of the equations at a closed state."""
STALL_STEP_COUNT, STALL_RESIDUAL_SHARE = 5, 0.5
"""Where so many steps leave more than this share of the residual, there will be no closed state."""


class Newton(NamedTuple):
    """Tables of normal equations, (n, n) each: of all angles, and of those that are not held at an edge of the box.

    right, step, edge : (n,), the right side, the step, and that to the edge. held : (n,).
    """

    normal: Reals
    free: Reals
    right: Reals
    step: Reals
    edge: Reals
    held: NDArray[np.bool_]


@compiled
def new_newton(rings: HingeRings) -> Newton:
    """Empty tables."""
    n = rings.folds
    tables, lists = (np.zeros((n, n)), np.zeros((n, n))), (np.zeros(n), np.zeros(n), np.zeros(n))
    return Newton(tables[0], tables[1], lists[0], lists[1], lists[2], np.zeros(n, np.bool_))


@lean
def close_within_box(rings: HingeRings, low: Reals, high: Reals, state: Reals, own: Expansion, work: Newton) -> float:
    """Move a state to a closed one within a box, (n,) each; what is left of the equations there."""
    residual, before = math.inf, math.inf
    for step in range(MAX_NEWTON_STEPS):
        write_first_order(rings, state, own)
        total = 0.0
        for i in range(len(own.values)):
            total += own.values[i] * own.values[i]
        residual = math.sqrt(total)
        if residual < NEWTON_RESIDUAL:
            break
        if step % STALL_STEP_COUNT == 0:
            if residual > STALL_RESIDUAL_SHARE * before:
                break
            before = residual
        _write_normal(1e-3 * residual + 1e-12, own, work)
        if not _write_step(low, high, state, work):
            break
        moved = 0.0
        for h in range(len(state)):
            state[h] = min(max(state[h] + work.step[h], low[h]), high[h])
            moved = max(moved, abs(work.step[h]))
        if moved < 1e-10:
            break
    return residual


@lean
def _write_normal(damping: float, own: Expansion, work: Newton) -> None:
    """Write the normal equations of a step."""
    r, n = own.slopes.shape
    for h in range(n):
        work.right[h] = 0.0
        for k in range(n):
            work.normal[h, k] = 0.0
    for i in range(r):
        for h in range(n):
            slope = own.slopes[i, h]
            if slope != 0.0:
                work.right[h] -= slope * own.values[i]
                for k in range(n):
                    work.normal[h, k] += slope * own.slopes[i, k]
    for h in range(n):
        work.normal[h, h] += damping


@lean
def _write_step(low: Reals, high: Reals, state: Reals, work: Newton) -> bool:
    """Write a step that ends within the bounds: angles that would leave these end there, and the others without them.

    Whether there is one.
    """
    n, held, edge, free, step = len(state), work.held, work.edge, work.free, work.step
    for h in range(n):
        held[h] = False
    within = False
    while not within:
        for h in range(n):
            step[h] = edge[h] if held[h] else work.right[h]
            for k in range(n):
                if held[h] or held[k]:
                    free[h, k] = 1.0 if h == k else 0.0
                    if held[k] and not held[h]:
                        step[h] -= work.normal[h, k] * edge[k]
                else:
                    free[h, k] = work.normal[h, k]
        if not factor_symmetric(free, 0.0):
            return False
        solve_factored(free, step)
        within = True
        for h in range(n):
            if not held[h] and not low[h] <= state[h] + step[h] <= high[h]:
                edge[h] = (low[h] if step[h] < 0.0 else high[h]) - state[h]
                held[h], within = True, False
    return True
