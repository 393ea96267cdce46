"""The middle of a loop: a point near its lines, about which screws are short, and its unit of length."""

from __future__ import annotations

import math

from hcsearch.basics.arrays import Reals, WholeNumbers
from hcsearch.kernels.algebra.vectors import Vector3, cross
from hcsearch.kernels.compiling.compiled import lean

CENTRING_ROUNDS = 6
"""How often the middle of a loop is brought nearer to its lines: one that is far off them makes bounds loose."""


@lean
def centre_screws(jacobian: Reals, row: int, hinges: WholeNumbers, middle: Reals, moments: Reals) -> float:
    """Write the screws of a loop, six rows from one on, about its middle and in its own unit of length, returned.

    That is the root of their mean square moment. hinges : those that are counted. middle : (3,), and moments : (m,), of
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


@lean
def _move_middle(jacobian: Reals, row: int, hinges: WholeNumbers, middle: Reals) -> None:
    """Move the middle of a loop to the mean of the points of its lines that are nearest to it."""
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


@lean
def _part(jacobian: Reals, row: int, h: int) -> Vector3:
    """Three entries of a column from a row on."""
    return jacobian[row, h], jacobian[row + 1, h], jacobian[row + 2, h]
