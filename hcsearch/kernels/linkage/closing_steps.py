"""The step that closes the loops of a linkage, by sums in a fixed order: its bits are the same on all processors.

LAPACK and BLAS add up in other orders on other processors. Beside a singular state that leads to another closed state,
and the springs of an array may then open it in another way.
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import divide_row, row_product, subtract_row
from hcsearch.kernels.compiling.compiled import compiled, small


@small
@compiled
def damped_step(jacobian: Reals, residual: Reals, damping: float) -> Reals:
    """Return the x that minimises |J x + r|^2 + |damping x|^2; J : (m, n), r : (m,), damping : above 0.

    Householder reflections of J with the damping below it, by columns; a row of the table is a column, the last is r.
    """
    m, n = jacobian.shape
    table = np.zeros((n + 1, m + n))
    table[:n, :m] = jacobian.T
    table[n, :m] = residual
    lengths = np.empty(n)
    for k in range(n):
        table[k, m + k] = damping
        # the column from row k on, and the entries of the damping that are not zero yet
        column = table[k : k + 1, k:]
        size = m + 1
        length = math.sqrt(row_product(column, 0, column, 0, size))
        lengths[k] = -math.copysign(length, column[0, 0])
        column[0, 0] -= lengths[k]
        divide_row(column, 0, math.sqrt(length * abs(column[0, 0])), size)
        for j in range(k + 1, n + 1):
            rest = table[j : j + 1, k:]
            subtract_row(rest, 0, row_product(column, 0, rest, 0, size), column, 0, size)
    step = np.empty(n)
    for k in range(n - 1, -1, -1):
        total = -table[n, k]
        for j in range(k + 1, n):
            total -= table[j, k] * step[j]
        step[k] = total / lengths[k]
    return step
