"""Linear programs over a box cut by a subspace, many goals over one such set.

The greatest c . y with R y = 0 and |y_i| <= 1 is, by duality, the least sum of |c - R' m| over multipliers m. The dual
simplex method with bound flipping descends on that sum: a basis of r columns holds r residuals at zero, and each step
lets one of them grow to the point where the sum is least along it. With r of 6 to 24 and some hundred columns a program
takes some microseconds, where the call of a general solver takes milliseconds. Every sum of |c - R' m| bounds the
greatest value from above, so a value is never too small, even where rounding ends the descent early.

Source: I. Barrodale, F. D. K. Roberts, SIAM J. Numer. Anal. 10 (1973) 839-848; A. Koberstein, The dual simplex method,
Paderborn 2005, 3.2 (bound flipping).
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled

BOX_FEASIBILITY = 1e-9
"""By how much a coordinate of the best point may exceed its bound of 1."""
MAX_DUALITY_GAP = 1e-10
"""Relative difference of the bound and of the value at the point above which a program is solved anew."""
LEAST_BOX_PIVOT = 1e-9
"""Entries of the table that count as zero: rows are orthonormal, so that entries are about 1."""


@compiled
def _pivot(table: Reals, row: int, column: int) -> None:
    """Clear a column of the table but for a 1 in a row."""
    scale = 1.0 / table[row, column]
    for j in range(table.shape[1]):
        table[row, j] *= scale
    for i in range(table.shape[0]):
        factor = table[i, column]
        if i != row and factor != 0.0:
            for j in range(table.shape[1]):
                table[i, j] -= factor * table[row, j]


@compiled
def first_box_table(rows: Reals, table: Reals, basis: WholeNumbers) -> None:
    """Write the table B^-1 (R | 1), shape (r, n + r), of a basis of r columns of independent rows, shape (r, n)."""
    r, n = rows.shape
    table[:] = 0.0
    for i in range(r):
        table[i, :n] = rows[i]
        table[i, n + i] = 1.0
    for i in range(r):
        best = 0
        for j in range(n):
            if abs(table[i, j]) > abs(table[i, best]):
                best = j
        _pivot(table, i, best)
        basis[i] = best


@compiled
def _entering(table: Reals, row: int, sense: float, slope: float, residuals: Reals, point: Reals) -> int:
    """Return the column whose residual vanishes where the sum is least, and flip those that change sign before; or -1.

    sense : sign with which the residual of the row's basic column grows. slope : of the sum at the start, negative.
    """
    n = len(residuals)
    while True:
        best, least = -1, math.inf
        for j in range(n):
            rate = sense * table[row, j]
            if abs(rate) > LEAST_BOX_PIVOT and rate * point[j] < 0.0:
                length = -residuals[j] / rate
                if length < least or (length == least and best >= 0 and abs(rate) > abs(table[row, best])):
                    best, least = j, length
        if best < 0:
            return -1
        slope += 2.0 * abs(table[row, best])
        if slope >= 0.0:
            return best
        point[best] = -point[best]


@compiled
def _climb(goal: Reals, table: Reals, basis: WholeNumbers, residuals: Reals, point: Reals) -> None:
    """Descend from a basis to the best one for a goal, and write its point, shape (n,)."""
    r, n = len(basis), len(goal)
    for j in range(n):
        residuals[j] = goal[j]
        for i in range(r):
            residuals[j] -= goal[basis[i]] * table[i, j]
        point[j] = 1.0 if residuals[j] >= 0.0 else -1.0
    for i in range(r):
        residuals[basis[i]] = 0.0
        point[basis[i]] = 0.0
    for _ in range(20 * (n + r)):
        worst, leaving, value = BOX_FEASIBILITY, -1, 0.0
        for i in range(r):
            coordinate = 0.0
            for j in range(n):
                coordinate -= table[i, j] * point[j]
            if abs(coordinate) - 1.0 > worst:
                worst, leaving, value = abs(coordinate) - 1.0, i, coordinate
        if leaving < 0:
            break
        sense = 1.0 if value > 0.0 else -1.0
        entering = _entering(table, leaving, sense, -worst, residuals, point)
        if entering < 0:  # by rounding alone: the sum has a least value
            break
        length = -residuals[entering] / (sense * table[leaving, entering])
        for j in range(n):
            residuals[j] += sense * length * table[leaving, j]
        residuals[entering] = point[entering] = 0.0
        residuals[basis[leaving]] = sense * length
        point[basis[leaving]] = sense
        _pivot(table, leaving, entering)
        basis[leaving] = entering
    _write_basic(table, basis, point)


@compiled
def _write_basic(table: Reals, basis: WholeNumbers, point: Reals) -> None:
    """Write the coordinates of the basic columns, which close the rows, kept within their bounds."""
    for i in range(len(basis)):
        point[basis[i]] = 0.0
    for i in range(len(basis)):
        coordinate = 0.0
        for j in range(len(point)):
            is_basic = False
            for k in range(len(basis)):
                is_basic = is_basic or basis[k] == j
            if not is_basic:
                coordinate -= table[i, j] * point[j]
        point[basis[i]] = coordinate


@compiled
def _best(
    rows: Reals,
    goal: Reals,
    start: tuple[Reals, WholeNumbers],
    work: tuple[Reals, WholeNumbers, Reals],
    multipliers: Reals,
    point: Reals,
) -> float:
    """Write the multipliers and the point of the best basis for a goal, and return the sum that bounds its value.

    work : the table and the basis of the last goal, which is often near the best one of the next. Where rounding has
    piled up in them, the descent begins anew from `start`.
    """
    bound = _best_from(rows, goal, work, multipliers, point)
    value = 0.0
    for j in range(len(goal)):
        value += goal[j] * point[j]
    if bound - value > MAX_DUALITY_GAP * bound:
        _copy_table(start, work)
        bound = _best_from(rows, goal, work, multipliers, point)
    return bound


@compiled
def _best_from(
    rows: Reals, goal: Reals, work: tuple[Reals, WholeNumbers, Reals], multipliers: Reals, point: Reals
) -> float:
    """As `_best`, from the basis of a table."""
    r, n = rows.shape
    table, basis, residuals = work
    _climb(goal, table, basis, residuals, point)
    for k in range(r):
        multipliers[k] = 0.0
        for i in range(r):
            multipliers[k] += goal[basis[i]] * table[i, n + k]
    bound = 0.0
    for j in range(n):
        residual = goal[j]
        for k in range(r):
            residual -= rows[k, j] * multipliers[k]
        bound += abs(residual)
    return bound


@compiled
def _copy_table(start: tuple[Reals, WholeNumbers], work: tuple[Reals, WholeNumbers, Reals]) -> None:
    """Copy the first table and its basis, entry by entry, as assigning tables would copy them first."""
    for i in range(len(start[1])):
        work[1][i] = start[1][i]
        for j in range(start[0].shape[1]):
            work[0][i, j] = start[0][i, j]


@compiled
def greatest_in_box(rows: Reals, goals: Reals, values: Reals, multipliers: Reals, points: Reals) -> None:
    """Write the greatest value of each goal over |y_i| <= 1 with R y = 0.

    rows : orthonormal, shape (r, n). goals : shape (k, n). values : shape (k,), never below the greatest value.
    multipliers : shape (k, r), with values = sum |goal - R' m|. points : shape (k, n), where the values are attained.
    """
    r, n = rows.shape
    start = (np.empty((r, n + r)), np.empty(r, np.int64))
    work = (np.empty((r, n + r)), np.empty(r, np.int64), np.empty(n))
    first_box_table(rows, start[0], start[1])
    _copy_table(start, work)
    for k in range(len(goals)):
        values[k] = _best(rows, goals[k], start, work, multipliers[k], points[k])


FARTHEST_PRECISION = 1e-9
"""Relative precision of the farthest point of a plane image."""
FARTHEST_ROUNDING = 1e-12
"""Lengths below this share of the sum of all images of errors are rounding."""
MAX_FARTHEST_DIRECTIONS = 256
"""Greatest number of directions in which the farthest point of one image is searched."""


@compiled
def farthest_in_box(rows: Reals, images: Reals, distances: Reals) -> None:
    """Write the greatest length of plane vectors M y over |y_i| <= 1 with R y = 0.

    images : matrices M, shape (k, 2, n). distances : shape (k,), never below the greatest length, and above it by no
    more than `FARTHEST_PRECISION` of it and rounding, unless that takes more than `MAX_FARTHEST_DIRECTIONS`.

    The image is a polygon, symmetric about 0. In the sector between two directions it lies within both support lines,
    so no point there is farther than where these meet: a sector is halved at the direction of that corner until it
    holds nothing farther than the farthest vertex that was found.
    """
    r, n = rows.shape
    start = (np.empty((r, n + r)), np.empty(r, np.int64))
    work = (np.empty((r, n + r)), np.empty(r, np.int64), np.empty(n))
    first_box_table(rows, start[0], start[1])
    _copy_table(start, work)
    goal, multipliers, point = np.empty(n), np.empty(r), np.empty(n)
    sectors = np.empty((MAX_FARTHEST_DIRECTIONS, 4))  # two angles and the supports there
    for k in range(len(images)):
        longest, farthest, rounding = 0.0, 0.0, 0.0
        for j in range(n):
            rounding += FARTHEST_ROUNDING * math.hypot(images[k, 0, j], images[k, 1, j])
        top, searched = 0, 4
        supports = np.empty(4)
        for i in range(4):
            angle = i * math.pi / 3.0
            for j in range(n):
                goal[j] = math.cos(angle) * images[k, 0, j] + math.sin(angle) * images[k, 1, j]
            supports[i] = _best(rows, goal, start, work, multipliers, point)
            longest = max(longest, _length(images[k], point))
        for i in range(3):
            sectors[top] = i * math.pi / 3.0, (i + 1) * math.pi / 3.0, supports[i], supports[i + 1]
            top += 1
        while top > 0:
            top -= 1
            low, high, first, second = sectors[top]
            corner, place = _corner(high - low, first, second)
            if corner <= longest * (1.0 + FARTHEST_PRECISION) + rounding or searched == MAX_FARTHEST_DIRECTIONS:
                farthest = max(farthest, corner)
                continue
            middle = low + place
            for j in range(n):
                goal[j] = math.cos(middle) * images[k, 0, j] + math.sin(middle) * images[k, 1, j]
            support = _best(rows, goal, start, work, multipliers, point)
            longest = max(longest, _length(images[k], point))
            searched += 1
            sectors[top] = low, middle, first, support
            sectors[top + 1] = middle, high, support, second
            top += 2
        distances[k] = farthest


@compiled
def _length(image: Reals, point: Reals) -> float:
    """Return the length of the image of a point."""
    x = y = 0.0
    for j in range(len(point)):
        x += image[0, j] * point[j]
        y += image[1, j] * point[j]
    return math.hypot(x, y)


@compiled
def _corner(turn: float, first: float, second: float) -> tuple[float, float]:
    """Return the greatest length within a sector and two support lines, and the angle from the first line to it.

    turn : angle of the sector, below pi. Where the lines meet outside of the sector, the nearer line bounds it; the
    sector is halved in the middle then.
    """
    along = (second - first * math.cos(turn)) / math.sin(turn)
    place = math.atan2(along, first)
    if 0.0 < place < turn:
        return math.hypot(first, along), place
    bound = min(first / math.cos(turn), second) if place >= turn else min(first, second / math.cos(turn))
    return max(bound, 0.0), 0.5 * turn
