"""Products, differences and quotients of rows of tables, by row number: a view of a row takes longer to make."""

from __future__ import annotations

from hcsearch.basics.arrays import Reals
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
