"""Torque margins at the ends of the motion in fractions, where hinges lie on a lattice and both are known exactly.

At an end every hinge is at a stop and turns one way. With x >= 0 the turns that whole screws ask for (`locks.lattice`)
the margin of first order is the greatest of a . x / b . x over the x with sum x_i screw_i = 0, and the least k with
a_i + screw_i . y <= k b_i for some wrench y. Floating point names the hinges at which the second condition is an
equation. Then x, y and k follow from equations in fractions, and inequalities in fractions prove k from both sides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.motion.locks.lattice import WholeEnd, reduced_rows, whole_end
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.flight.torque_margin import allowed_senses, closed_rates, torque_margins

Fractions = list[Fraction]


def exact_end_margin(
    linkage: Linkage, angles: Reals, torques: Reals, friction: Reals, *, arriving: bool = False
) -> Fraction | None:
    """Return the torque margin of first order at the packed or the flat end, exactly; None where that is not proved.

    torques, friction : (n_hinges,), N m; the margin is that of these doubles. arriving : of motions that end there.
    It is not proved where the linkage is on no tiling, hinges have lengths of irrational ratio, no hinge resists or the
    margin is infinite, or where floating point names the wrong hinges.
    """
    end = whole_end(linkage, angles)
    lengths = None if end is None else _rational_lengths(end)
    if end is None or lengths is None:
        return None
    senses = allowed_senses(angles, arriving=arriving)
    scaled = list(zip(senses.tolist(), lengths, strict=True))
    powers = [
        Fraction(torque) * sense * length for torque, (sense, length) in zip(torques.tolist(), scaled, strict=True)
    ]
    losses = [Fraction(value) * length for value, (_, length) in zip(friction.tolist(), scaled, strict=True)]
    if not any(powers):
        return Fraction(0)
    rates = closed_rates(linkage.closure(angles)[1][None])
    program = torque_margins(rates, torques[None], friction, senses[None])
    turning = np.flatnonzero(program.places[0]).tolist()
    # others that the program never moved bear no moment at all
    free = np.flatnonzero((program.places[0] == 0) & (program.moments[0] == 0.0)).tolist()
    return _proved_margin(end.columns.tolist(), powers, losses, turning, free)


def _rational_lengths(end: WholeEnd) -> Fractions | None:
    """Return the lengths of hinges' whole directions over that of the first; None where one is irrational."""
    squares = [end.frame.square(*direction) for direction in end.directions.tolist()]
    roots = [math.isqrt(square * squares[0]) for square in squares]
    if any(root * root != square * squares[0] for root, square in zip(roots, squares, strict=True)):
        return None
    return [Fraction(root, squares[0]) for root in roots]


def _proved_margin(
    columns: Sequence[Sequence[int]], powers: Fractions, losses: Fractions, turning: list[int], free: list[int]
) -> Fraction | None:
    """Return the greatest ratio of powers to losses; None unless it is proved.

    turning : hinges that turn, at which friction bears its most. free : others, at which it bears nothing.
    """
    rows = [list(row) for row in zip(*(columns[hinge] for hinge in turning), strict=True)]
    kernel = _kernel([[*map(Fraction, row)] for row in rows], len(turning))
    if len(kernel) != 1:
        return None
    turns = kernel[0] if sum(kernel[0]) > 0 else [-turn for turn in kernel[0]]
    lost = sum(losses[hinge] * turn for hinge, turn in zip(turning, turns, strict=True))
    if min(turns) < 0 or not lost:
        return None
    margin = sum((powers[hinge] * turn for hinge, turn in zip(turning, turns, strict=True)), Fraction(0)) / lost
    left = [power - margin * loss for power, loss in zip(powers, losses, strict=True)]
    borne = [left[hinge] for hinge in turning] + [powers[hinge] for hinge in free]
    wrench = _bearing_wrench([columns[hinge] for hinge in turning + free], borne)
    if margin < 0 or wrench is None:
        return None
    held = all(
        rest + sum(part * value for part, value in zip(wrench, column, strict=True)) <= 0
        for rest, column in zip(left, columns, strict=True)
    )
    return margin if held else None


def _bearing_wrench(columns: Sequence[Sequence[int]], left: Fractions) -> Fractions | None:
    """Return a wrench whose powers on columns are the negatives of given numbers, or None."""
    rows = [[*map(Fraction, column), rest] for column, rest in zip(columns, left, strict=True)]
    for solution in _kernel(rows, len(rows[0])):
        if solution[-1]:
            return [value / solution[-1] for value in solution[:-1]]
    return None


def _kernel(rows: Sequence[Fractions], width: int) -> list[Fractions]:
    """Return a basis of the vectors that are orthogonal to rows of fractions, by elimination in whole numbers."""
    whole = [[int(value * math.lcm(*(part.denominator for part in row))) for value in row] for row in rows]
    pivots = reduced_rows(np.array(whole, object).reshape(-1, width))
    basis = []
    for free in (column for column in range(width) if column not in pivots):
        vector = [Fraction(0)] * width
        vector[free] = Fraction(1)
        for column, row in pivots.items():
            vector[column] = Fraction(-row[free], row[column])
        basis.append(vector)
    return basis
