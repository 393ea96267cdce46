"""Which triangles make an 8R element: linear equations for their angles, solved exactly (thesis 5.3.2, eq. 5.28).

Ten congruent triangles that fold onto two of them are mirror images of each other across every crease that folds. So
the triangles on both sides of such a crease have the same angle at each of its ends, and going round an end of the
slit the sector changes only at the flat crease, in a parallelogram to the angle at the crease's other end. Angles are
in units of pi: first, second, third.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Equation = tuple[Sequence[int], int]
"""Coefficients of the three angles, and what they sum to, in units of pi."""

TRIANGLE: Equation = ((1, 1, 1), 1)
PRINTED: tuple[Equation, ...] = (((0, 4, 2), 2), ((4, 0, 2), 2))
"""The equations (5.28), one for each of the thesis's two arrangements, or for each end of the slit."""
ISOSCELES: Equation = ((1, -1, 0), 0)
EQUILATERAL: tuple[Equation, ...] = (((3, 0, 0), 1), ((0, 3, 0), 1))


def round_slit_end(mirrored: bool) -> Equation:
    """Sum of the sectors round one end of the slit: P3, both triangles of P4, P5, P6, P7.

    Two sectors before the flat crease are the third angle; the four behind it are the angle at the crease's other end,
    the second, where P4 is a parallelogram, and the third again where its triangles are mirror images (a kite).
    """
    return ((0, 0, 6), 2) if mirrored else ((0, 4, 2), 2)


def follows(statement: Equation, equations: Sequence[Equation]) -> bool:
    """Whether a linear equation holds for all solutions of others: Gauss's elimination in fractions."""
    rows = [[Fraction(x) for x in (*coefficients, total)] for coefficients, total in equations]
    target = [Fraction(x) for x in (*statement[0], statement[1])]
    for column in range(len(target) - 1):
        pivot = next((row for row in rows if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        for row in (*rows, target):
            share = row[column] / pivot[column]
            row[:] = [x - share * y for x, y in zip(row, pivot, strict=True)]
    return not any(target)
