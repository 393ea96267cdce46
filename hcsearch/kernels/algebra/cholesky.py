"""Cholesky factors of small symmetric matrices, and systems that they solve."""

from __future__ import annotations

import math

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.compiling.compiled import lean


@lean
def factor_symmetric(matrix: Reals, damping: float) -> bool:
    """Write the factor of a symmetric matrix and damping into its lower triangle; whether it has one."""
    for i in range(len(matrix)):
        matrix[i, i] += damping
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i > j:
                matrix[i, j] = total / matrix[j, j]
            elif total > 0.0:
                matrix[i, i] = math.sqrt(total)
            else:
                return False
    return True


@lean
def solve_factored(matrix: Reals, right: Reals) -> None:
    """Write the solution of a system, by the factor of its matrix, in place of its right side."""
    n = len(right)
    for i in range(n):
        total = right[i]
        for k in range(i):
            total -= matrix[i, k] * right[k]
        right[i] = total / matrix[i, i]
    for i in range(n - 1, -1, -1):
        total = right[i]
        for k in range(i + 1, n):
            total -= matrix[k, i] * right[k]
        right[i] = total / matrix[i, i]
