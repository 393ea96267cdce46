"""Gauges of zonotopes: the greatest multiple of a vector that is a sum of bounded multiples of given columns.

With the columns the rows of a basis of closed rates, the vector the power of springs in it, and the bounds the friction
of hinges, this is the linear program of torque margins (`springs.flight.torque_margin`). It has few rows, and is solved
thousands of times: by the simplex method with bounded variables, on a full tableau (Dantzig 1963, chapter 18).
"""

from __future__ import annotations

import math

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, Signs, WholeNumbers
from hcsearch.kernels.compiling.compiled import compiled

PIVOT_TOLERANCE, PRICE_TOLERANCE = 1e-10, 1e-10
"""Entries of the tableau below the first count as 0; a variable enters where its price exceeds the second."""
GREEDY_PIVOTS_PER_COLUMN, MAX_PIVOTS_PER_COLUMN = 3, 40
"""Pivots, per column, after which Bland's rule chooses them, as it does not cycle; and after which the search ends."""


@compiled
def largest_multiple(columns: Reals, target: Reals, lower: Reals, upper: Reals, weights: Reals, prices: Reals) -> float:
    """Return the greatest t >= 0 for which t target = sum y_i columns_i with lower <= y <= upper.

    It is infinite where there is no greatest, and NaN where the search does not end. Where it is infinite, the weights
    are those of the target itself, none beyond 0 on a side on which it is bounded, and the prices are 0.

    columns : (n, m), of norms up to about 1; target : (m,), of norm 1. lower <= 0 <= upper : (n,), of size 1 or
    infinite. weights : (n,), written: y. prices : (m,), written: z, with z . target = 1, whose products with columns
    are at least 0 where y is at its upper bound, at most 0 where at its lower one, else 0: the dual solution.
    places : (n,), written: 1 where y is held at its upper bound, -1 at its lower one, else 0.
    """
    n, m = columns.shape
    width = n + 1 + m  # the columns, that of t, and those of artificial variables, which are 0
    tableau = np.zeros((m + 1, width))
    values, lows, highs = np.zeros(width), np.zeros(width), np.zeros(width)
    basis, is_basic = np.empty(m, np.int64), np.zeros(width, np.bool_)
    for r in range(m):
        for j in range(n):
            tableau[r, j] = columns[j, r]
        tableau[r, n] = -target[r]
        tableau[r, n + 1 + r] = 1.0
        basis[r] = n + 1 + r
        is_basic[n + 1 + r] = True
    lows[:n], highs[:n] = lower, upper
    highs[n], tableau[m, n] = math.inf, 1.0
    for pivot in range(MAX_PIVOTS_PER_COLUMN * width):
        entering = _entering(tableau[m], values, lows, highs, is_basic, pivot < GREEDY_PIVOTS_PER_COLUMN * width)
        if entering < 0:
            prices[:] = tableau[m, n + 1 :]
            weights[:] = values[:n]
            return float(values[n])
        step, row = _step_of(tableau, entering, values, lows, highs, basis)
        sign = 1.0 if tableau[m, entering] > 0.0 else -1.0
        if math.isinf(step):
            values[:] = 0.0
            values[entering] = sign
            for r in range(m):
                values[basis[r]] = -sign * tableau[r, entering]
            weights[:] = values[:n] / values[n]
            prices[:] = 0.0
            return math.inf
        change = sign * step
        values[entering] += change
        for r in range(m):
            values[basis[r]] -= change * tableau[r, entering]
        if row < 0:  # it goes to its other bound
            values[entering] = highs[entering] if change > 0.0 else lows[entering]
            continue
        leaving = basis[row]
        low = abs(values[leaving] - lows[leaving]) < abs(values[leaving] - highs[leaving])
        values[leaving] = lows[leaving] if low else highs[leaving]
        basis[row], is_basic[leaving], is_basic[entering] = entering, False, True
        _pivot(tableau, row, entering)
    return math.nan


@compiled
def _entering(prices: Reals, values: Reals, lows: Reals, highs: Reals, is_basic: Flags, greedy: bool) -> int:
    """Return the variable whose change raises t most per unit, or the first that raises it; -1 if none does."""
    best, gain = -1, PRICE_TOLERANCE
    for j in range(len(values)):
        if is_basic[j] or lows[j] == highs[j]:
            continue
        price = abs(prices[j])
        room = highs[j] - values[j] if prices[j] > 0.0 else values[j] - lows[j]
        if price > gain and room > 0.0:
            if not greedy:
                return j
            best, gain = j, price
    return best


@compiled
def _step_of(
    tableau: Reals, entering: int, values: Reals, lows: Reals, highs: Reals, basis: WholeNumbers
) -> tuple[float, int]:
    """Return how far a variable can enter, and the row that stops it, -1 for its own bound.

    Of rows that stop it together the one with the greatest entry is taken, for accuracy.
    """
    m = len(basis)
    sign = 1.0 if tableau[m, entering] > 0.0 else -1.0
    step = highs[entering] - values[entering] if sign > 0.0 else values[entering] - lows[entering]
    row, size = -1, 0.0
    for r in range(m):
        slope = -sign * tableau[r, entering]
        if abs(slope) <= PIVOT_TOLERANCE:
            continue
        value = values[basis[r]]
        room = (highs[basis[r]] - value if slope > 0.0 else value - lows[basis[r]]) / abs(slope)
        room = max(room, 0.0)
        if room < step - PIVOT_TOLERANCE or (room <= step + PIVOT_TOLERANCE and abs(slope) > size and row >= 0):
            step, row, size = min(room, step), r, abs(slope)
    return step, row


@compiled
def _pivot(tableau: Reals, row: int, column: int) -> None:
    """Make a column a unit vector by row operations."""
    height, width = tableau.shape
    scale = 1.0 / tableau[row, column]
    for j in range(width):
        tableau[row, j] *= scale
    for r in range(height):
        factor = tableau[r, column]
        if r != row and factor != 0.0:
            for j in range(width):
                tableau[r, j] -= factor * tableau[row, j]


LOST_POWER_SHARE = 1e-12
"""Power of closed rates below this share of the torques' size is rounding."""


@compiled
def solve_margin(basis: Reals, torques: Reals, friction: Reals, senses: Signs, rates: Reals, moments: Reals) -> float:
    """Return the greatest power of torques on closed rates over that lost to friction; NaN where that is not found.

    basis : (n, m), orthonormal columns, of the closed rates. torques, friction : (n,), N m. senses : (n,), 1 where a
    hinge has rates of at least 0 only, -1 of at most 0, else 0. rates : (n,), written: the best ones, of power 1 per
    N m of torques. moments : (n,), written: what friction has to bear at each hinge, N m.
    """
    n, m = basis.shape
    target, size, scale = np.zeros(m), 0.0, 0.0
    for j in range(n):
        size += torques[j] ** 2
        scale = max(scale, friction[j])
        for k in range(m):
            target[k] += torques[j] * basis[j, k]
    length = math.sqrt(np.sum(target**2))
    rates[:] = 0.0
    moments[:] = 0.0
    if length <= LOST_POWER_SHARE * math.sqrt(size):
        return 0.0
    scale = scale or 1.0
    lower, upper = np.empty(n), np.empty(n)
    for j in range(n):  # hinges at a stop press against it without friction
        upper[j] = math.inf if senses[j] < 0 else friction[j] / scale
        lower[j] = -math.inf if senses[j] > 0 else -friction[j] / scale
    prices = np.empty(m)
    multiple = largest_multiple(basis, target / length, lower, upper, moments, prices)
    if math.isnan(multiple):
        return multiple
    if math.isinf(multiple):
        moments *= length
        return 0.0
    for j in range(n):
        for k in range(m):
            rates[j] += basis[j, k] * prices[k]
    if multiple == 0.0:
        return math.inf
    moments *= length / multiple
    return length / (scale * multiple)


@compiled
def solve_margins(
    bases: Reals,
    torques: Reals,
    friction: Reals,
    senses: Signs,
    margins: Reals,
    rates: Reals,
    moments: Reals,
) -> None:
    """Write `solve_margin` of k states: bases (k, n, m), friction (n,), margins (k,), all others (k, n)."""
    for k in range(len(bases)):
        margins[k] = solve_margin(bases[k], torques[k], friction, senses[k], rates[k], moments[k])
