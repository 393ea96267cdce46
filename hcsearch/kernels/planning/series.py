"""The closure of a loop as a power series in the share of a step, about the middle of the loop."""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, cross
from hcsearch.kernels.compiling.compiled import compiled

SERIES_ORDER_COUNT = 8
"""Number of orders of the series, from 0."""


@compiled
def write_series(
    screws: Reals, order: WholeNumbers, course: Reals, columns: Reals, terms: Reals, slopes: Reals
) -> None:
    """Write the coefficients of the twist of T - 1, and of its derivative, by order.

    screws : (6, m), of the hinges. order : the hinges of the loop. course : (m, 4), angles change by s b + s^2 c + s^3
    d, the columns from 1 on. columns : (m, k), directions, times s, of the wanted derivatives. terms : (ORDERS, 6) and
    slopes : (ORDERS, 6, k), written; the derivative is that over s.
    """
    k = columns.shape[1]
    shape = (SERIES_ORDER_COUNT, 4, 4)
    product, change = np.zeros(shape), np.zeros((k, SERIES_ORDER_COUNT, 4, 4))
    turn, slope, room = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for i in range(4):
        product[0, i, i] = 1.0
    for h in order:
        _factor(screws[:, h], course[h], turn, slope)
        for j in range(k):
            room[:] = 0.0
            _add_product(change[j], turn, 1.0, room)
            _add_product(product, slope, columns[h, j], room)
            change[j] = room
        room[:] = 0.0
        _add_product(product, turn, 1.0, room)
        product[:] = room
    for n in range(SERIES_ORDER_COUNT):
        for i in range(6):
            terms[n, i] = _twist(product[n], i)
            for j in range(k):
                slopes[n, i, j] = _twist(change[j, n], i)


@compiled
def _factor(screw: Reals, course: Reals, turn: Reals, slope: Reals) -> None:
    """Write the series of exp(x S) of a screw, x a cubic in the share, and of its derivative with respect to x."""
    matrix, power = np.zeros((4, 4)), np.zeros((4, 4))
    matrix[0, 1], matrix[0, 2], matrix[1, 2] = -screw[2], screw[1], -screw[0]
    matrix[1, 0], matrix[2, 0], matrix[2, 1] = screw[2], -screw[1], screw[0]
    matrix[0, 3], matrix[1, 3], matrix[2, 3] = screw[3], screw[4], screw[5]
    scalar, before = np.zeros(SERIES_ORDER_COUNT), np.zeros(SERIES_ORDER_COUNT)  # x^n / n!, and x^(n-1) / (n-1)!
    scalar[0] = 1.0
    for i in range(4):
        power[i, i] = 1.0
    turn[:] = 0.0
    slope[:] = 0.0
    for n in range(SERIES_ORDER_COUNT + 1):
        for order in range(SERIES_ORDER_COUNT):
            for i in range(3):
                for j in range(4):
                    turn[order, i, j] += scalar[order] * power[i, j]
                    slope[order, i, j] += before[order] * power[i, j]
            turn[order, 3, 3] = 1.0 if order == 0 else 0.0
        before[:] = scalar
        for order in range(SERIES_ORDER_COUNT - 1, -1, -1):
            total = 0.0
            for i in range(1, min(order, 3) + 1):
                total += course[i] * scalar[order - i]
            scalar[order] = total / (n + 1)
        power = power @ matrix


@compiled
def _add_product(first: Reals, second: Reals, factor: float, total: Reals) -> None:
    """Add the product of two matrix series, times a factor."""
    for n in range(SERIES_ORDER_COUNT):
        for order in range(n + 1):
            for i in range(4):
                for j in range(4):
                    value = 0.0
                    for k in range(4):
                        value += first[order, i, k] * second[n - order, k, j]
                    total[n, i, j] += factor * value


@compiled
def _twist(matrix: Reals, i: int) -> float:
    """An entry of the twist of a matrix: of the skew part of its rotation, or of its translation."""
    if i > 2:
        return float(matrix[i - 3, 3])
    j, k = (i + 1) % 3, (i + 2) % 3
    return float(0.5 * (matrix[k, j] - matrix[j, k]))


CENTRING_ROUNDS = 6
"""Iterations that bring the middle of a loop nearer to its lines: a middle far off them makes bounds loose."""


@compiled
def centre_screws(jacobian: Reals, row: int, hinges: WholeNumbers, middle: Reals, moments: Reals) -> float:
    """Shift the screws of a loop, six rows from one on, to its middle and scale them to its unit of length, returned.

    The unit is the root mean square moment. hinges : those that are counted. middle : (3,), and moments : (m,), of
    those hinges, written.
    """
    count = len(hinges)
    middle[:] = 0.0
    for _ in range(CENTRING_ROUNDS):
        _move_middle(jacobian, row, hinges, middle)
    total = 0.0
    for h in hinges:
        for i in range(3):
            total += jacobian[row + 3 + i, h] ** 2 / count
    length = max(math.sqrt(total), 1e-3)
    for h in hinges:
        moment = 0.0
        for i in range(3):
            jacobian[row + 3 + i, h] /= length
            moment += jacobian[row + 3 + i, h] ** 2
        moments[h] = math.sqrt(moment)
    return length


@compiled
def _move_middle(jacobian: Reals, row: int, hinges: WholeNumbers, middle: Reals) -> None:
    """Move the middle of a loop to the mean of the nearest points of its lines."""
    count = len(hinges)
    x = y = z = 0.0
    for h in hinges:
        foot = cross(_part(jacobian, row, h), _part(jacobian, row + 3, h))
        x, y, z = x + foot[0] / count, y + foot[1] / count, z + foot[2] / count
    for h in hinges:
        moved = cross((x, y, z), _part(jacobian, row, h))
        for i in range(3):
            jacobian[row + 3 + i, h] -= moved[i]
    middle[0] += x
    middle[1] += y
    middle[2] += z


@compiled
def _part(jacobian: Reals, row: int, h: int) -> Vector3:
    """Three entries of a column from a row on."""
    return jacobian[row, h], jacobian[row + 1, h], jacobian[row + 2, h]
