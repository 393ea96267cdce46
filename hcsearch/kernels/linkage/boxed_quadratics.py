"""Convex quadratics within bounds: the problem of forces that are bounded, as those of friction and stops are.

Minimise x G x / 2 + c x subject to lower <= x <= upper, with G positive definite: bounded-variable least squares in
terms of the Gram matrix (Stark and Parker 1995). The solution is unique.
"""

from __future__ import annotations

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import factor_symmetric, scalar_product, solve_factored
from hcsearch.kernels.compiling.compiled import compiled

MAX_ROUNDS_PER_VARIABLE = 20
"""Changes of the set of free variables, per variable, after which the search ends with what it has."""
SLOPE_TOLERANCE = 1e-12
"""A variable leaves its bound where the slope, relative to the greatest coefficient of c, exceeds this."""


@compiled
def minimise_in_box(gram: Reals, linear: Reals, lower: Reals, upper: Reals, x: Reals) -> bool:
    """Write the minimiser of a quadratic within bounds; return whether it was found.

    All variables begin free at 0. Steps go to the minimum over the free ones, or to the first bound in the way, at
    which a variable is then held; at a minimum the variable whose slope pulls most strongly off its bound is freed.

    gram : (n, n), positive definite. linear : (n,). lower <= 0 <= upper : (n,), may be infinite. x : (n,), written.
    """
    n = len(linear)
    is_free = np.ones(n, np.bool_)
    tolerance = SLOPE_TOLERANCE * np.abs(linear).max() if n else 0.0
    x[:] = 0.0
    for _ in range(MAX_ROUNDS_PER_VARIABLE * max(1, n)):
        free = np.flatnonzero(is_free)
        matrix, change = np.empty((len(free), len(free))), np.empty(len(free))
        for k in range(len(free)):
            change[k] = -linear[free[k]] - scalar_product(gram[free[k]], x)
            for j in range(len(free)):
                matrix[k, j] = gram[free[k], free[j]]
        if not factor_symmetric(matrix, 0.0):
            return False
        solve_factored(matrix, change)
        step, first = 1.0, -1
        for k in range(len(free)):
            i = free[k]
            bound = upper[i] if change[k] > 0.0 else lower[i]
            if change[k] != 0.0 and abs(bound - x[i]) < step * abs(change[k]):
                step, first = abs(bound - x[i]) / abs(change[k]), i
        for k in range(len(free)):
            x[free[k]] += step * change[k]
        if first >= 0:
            x[first] = lower[first] if abs(x[first] - lower[first]) < abs(x[first] - upper[first]) else upper[first]
            is_free[first] = False
            continue
        worst, greatest = -1, tolerance
        for i in range(n):
            if not is_free[i]:
                slope = linear[i] + scalar_product(gram[i], x)
                pull = slope if x[i] == upper[i] else -slope
                if pull > greatest:
                    worst, greatest = i, pull
        if worst < 0:
            return True
        is_free[worst] = True
    return False
