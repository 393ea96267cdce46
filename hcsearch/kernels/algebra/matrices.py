"""Products of rows of tables by number, and Cholesky factors of small symmetric matrices."""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import lean


@lean
def row_product(one: Reals, i: int, two: Reals, j: int, n: int) -> float:
    """The scalar product of the first n entries of row i of a table and row j of another.

    np.dot would ask BLAS: other last bits on another processor, and a library that takes longer to load than many
    kernels to run.
    """
    value = 0.0
    for k in range(n):
        value += one[i, k] * two[j, k]
    return value


@lean
def subtract_row(one: Reals, i: int, part: float, two: Reals, j: int, n: int) -> None:
    """Take a part of row j of a table off the first n entries of row i of another."""
    for k in range(n):
        one[i, k] -= part * two[j, k]


@lean
def divide_row(table: Reals, i: int, by: float, n: int) -> None:
    """Divide the first n entries of row i."""
    for k in range(n):
        table[i, k] /= by


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
