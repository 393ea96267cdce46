"""Linear algebra for kernels: vectors, matrices and screws, as tuples or as parts of table rows.

A vector is (x, y, z); a symmetric matrix is (xx, yy, zz, xy, xz, yz); the compiler keeps such tuples in registers. A
rotation is nine entries of a table row, by rows. Values are read from and written to a row of a table, from a given
column on.
"""

from __future__ import annotations

import math

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.compiling.compiled import compiled

Vector3 = tuple[float, float, float]
SymmetricMatrix = tuple[float, float, float, float, float, float]


@compiled
def vector_at(table: Reals, i: int, column: int) -> Vector3:
    """Return the vector in row i from a column on."""
    return table[i, column], table[i, column + 1], table[i, column + 2]


@compiled
def put_vector(table: Reals, i: int, column: int, v: Vector3) -> None:
    """Write a vector into row i from a column on."""
    table[i, column], table[i, column + 1], table[i, column + 2] = v


@compiled
def add_vector(table: Reals, i: int, column: int, v: Vector3) -> None:
    """Add a vector to row i from a column on."""
    table[i, column] += v[0]
    table[i, column + 1] += v[1]
    table[i, column + 2] += v[2]


@compiled
def vector_sum(a: Vector3, b: Vector3) -> Vector3:
    """Return the sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def vector_difference(a: Vector3, b: Vector3) -> Vector3:
    """Return the first vector minus the second."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def scaled_vector(s: float, a: Vector3) -> Vector3:
    """Return a number times a vector."""
    return s * a[0], s * a[1], s * a[2]


@compiled
def dot(a: Vector3, b: Vector3) -> float:
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def cross(a: Vector3, b: Vector3) -> Vector3:
    """Return the vector product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def rotated(table: Reals, i: int, column: int, a: Vector3) -> Vector3:
    """Return the 3 x 3 matrix in row i from a column on times a vector."""
    x, y, z = vector_at(table, i, column), vector_at(table, i, column + 3), vector_at(table, i, column + 6)
    return dot(x, a), dot(y, a), dot(z, a)


@compiled
def rotated_back(table: Reals, i: int, column: int, a: Vector3) -> Vector3:
    """Return the transpose of the 3 x 3 matrix in row i from a column on times a vector."""
    x, y, z = vector_at(table, i, column), vector_at(table, i, column + 3), vector_at(table, i, column + 6)
    return (
        x[0] * a[0] + y[0] * a[1] + z[0] * a[2],
        x[1] * a[0] + y[1] * a[1] + z[1] * a[2],
        x[2] * a[0] + y[2] * a[1] + z[2] * a[2],
    )


@compiled
def symmetric_at(table: Reals, i: int, column: int) -> SymmetricMatrix:
    """Return the symmetric matrix in row i from a column on."""
    k = column
    return table[i, k], table[i, k + 1], table[i, k + 2], table[i, k + 3], table[i, k + 4], table[i, k + 5]


@compiled
def add_symmetric(table: Reals, i: int, column: int, s: SymmetricMatrix) -> None:
    """Add a symmetric matrix to row i from a column on."""
    for k in range(6):
        table[i, column + k] += s[k]


@compiled
def outer_product(s: float, a: Vector3) -> SymmetricMatrix:
    """Return the symmetric matrix s a a^T."""
    x, y, z = scaled_vector(s, a)
    return x * a[0], y * a[1], z * a[2], x * a[1], x * a[2], y * a[2]


@compiled
def apply_symmetric(s: SymmetricMatrix, a: Vector3) -> Vector3:
    """Return a symmetric matrix times a vector."""
    return (
        s[0] * a[0] + s[3] * a[1] + s[4] * a[2],
        s[3] * a[0] + s[1] * a[1] + s[5] * a[2],
        s[4] * a[0] + s[5] * a[1] + s[2] * a[2],
    )


@compiled
def rotated_symmetric(table: Reals, i: int, column: int, s: SymmetricMatrix) -> SymmetricMatrix:
    """Return R S R^T for the rotation R in row i from a column on."""
    rx, ry, rz = vector_at(table, i, column), vector_at(table, i, column + 3), vector_at(table, i, column + 6)
    x, y, z = apply_symmetric(s, rx), apply_symmetric(s, ry), apply_symmetric(s, rz)
    return dot(rx, x), dot(ry, y), dot(rz, z), dot(rx, y), dot(rx, z), dot(ry, z)


@compiled
def rotation(axis: Vector3, angle: float) -> tuple[Vector3, Vector3, Vector3]:
    """Return the columns of the rotation about a unit axis, minus the identity."""
    s = math.sin(angle)
    c = 2.0 * math.sin(0.5 * angle) ** 2  # 1 - cos, exact for small angles
    x, y, z = axis
    return (
        (-c * (y * y + z * z), c * x * y + s * z, c * x * z - s * y),
        (c * x * y - s * z, -c * (x * x + z * z), c * y * z + s * x),
        (c * x * z + s * y, c * y * z - s * x, -c * (x * x + y * y)),
    )


@compiled
def turn_row(r: Vector3, columns: tuple[Vector3, Vector3, Vector3]) -> Vector3:
    """Return a row of the product of a rotation with another, whose columns come from `rotation`."""
    x, y, z = columns
    return r[0] + dot(r, x), r[1] + dot(r, y), r[2] + dot(r, z)


@compiled
def add_bracket(a: Reals, b: Reals, total: Reals) -> None:
    """Add the Lie bracket of two screws, (6,) each, to a total."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        total[i] += a[j] * b[k] - a[k] * b[j]
        total[3 + i] += a[j] * b[3 + k] - a[k] * b[3 + j]
        total[3 + i] += a[3 + j] * b[k] - a[3 + k] * b[j]


@compiled
def scalar_product(first: Reals, second: Reals) -> float:
    """Return the scalar product of two rows; a library call would take longer for vectors this short."""
    total = 0.0
    for i in range(len(first)):
        total += first[i] * second[i]
    return total


@compiled
def row_product(first: Reals, i: int, second: Reals, j: int, n: int) -> float:
    """Return the scalar product of the first n entries of row i of one table and row j of another.

    np.dot would call BLAS, whose last bits depend on the processor, and which takes longer to load than many kernels to
    run.
    """
    value = 0.0
    for k in range(n):
        value += first[i, k] * second[j, k]
    return value


@compiled
def subtract_row(target: Reals, i: int, factor: float, source: Reals, j: int, n: int) -> None:
    """Subtract `factor` times row j of one table from row i of another, in the first n entries."""
    for k in range(n):
        target[i, k] -= factor * source[j, k]


@compiled
def divide_row(table: Reals, i: int, divisor: float, n: int) -> None:
    """Divide the first n entries of row i by a number."""
    for k in range(n):
        table[i, k] /= divisor


@compiled
def factor_symmetric(matrix: Reals, damping: float) -> bool:
    """Factor a symmetric matrix plus damping in its lower triangle (Cholesky); return False if it is not definite."""
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


@compiled
def solve_factored(matrix: Reals, right: Reals) -> None:
    """Solve a system in place of its right side, by the factor from `factor_symmetric`."""
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
