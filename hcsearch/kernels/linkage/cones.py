"""Motions of one-sided hinges: cones of velocities, and wrenches that hold the hinges shut.

Hinges are given as lines or screws, oriented in the sense in which they can turn, in the order of their loop;
velocities x >= 0 keep the loop closed to first order when sum x_i screw_i = 0. `locks.end_locks` draws the conclusions.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import add_bracket, scalar_product
from hcsearch.kernels.compiling.compiled import compiled, small

MAX_EXTREME_RAYS = 2048
"""Greatest number of extreme rays; cones with more are left undecided."""

END_LOCKED, END_PASSED, END_OPEN = 1, 2, 0
"""Verdicts of `settle_ends` on an end: locked at first order; passed, as some motion exists to second order or there
are too many rays to decide; open, as no motion was found that is possible to second order."""


@compiled
def _orthogonalise(columns: Reals, chosen: WholeNumbers, k: int, q: Reals, r: Reals) -> None:
    """Orthogonalise the k-th chosen column against those before it, twice for accuracy: one step of QR."""
    height = columns.shape[1]
    for c in range(height):
        q[k, c] = columns[chosen[k], c]
    for j in range(k):
        r[j, k] = 0.0
    for _ in range(2):
        for j in range(k):
            component = 0.0
            for c in range(height):
                component += q[j, c] * q[k, c]
            r[j, k] += component
            for c in range(height):
                q[k, c] -= component * q[j, c]
    length = 0.0
    for c in range(height):
        length += q[k, c] ** 2
    r[k, k] = math.sqrt(length)
    for c in range(height):
        q[k, c] /= r[k, k]


@compiled
def _least_squares(q: Reals, r: Reals, target: Reals, count: int, weights: Reals) -> None:
    """Write the least-squares weights of the first `count` orthogonalised columns."""
    for i in range(count - 1, -1, -1):
        value = 0.0
        for c in range(len(target)):
            value += q[i, c] * target[c]
        for j in range(i + 1, count):
            value -= r[i, j] * weights[j]
        weights[i] = value / r[i, i]


@small
@compiled
def nonnegative_least_squares(columns: Reals, target: Reals, x: Reals, residual: Reals) -> None:
    """Write the x >= 0 for which sum x_i columns_i is nearest to a target, and the residual (Lawson and Hanson).

    The product of the residual with any column not used is at most 1e-11.

    columns : shape (n, height), of about unit length.
    """
    n, height = columns.shape
    x[:] = 0.0
    residual[:] = target
    chosen = np.empty(min(n, height), np.int64)
    is_chosen = np.zeros(n, np.bool_)
    weights = np.empty(len(chosen))
    q, r = np.empty((len(chosen), height)), np.empty((len(chosen), len(chosen)))
    count = factored = 0
    for _ in range(20 * n):
        best, gain = -1, 1e-11
        for j in range(n):
            if not is_chosen[j]:
                value = 0.0
                for c in range(height):
                    value += residual[c] * columns[j, c]
                if value > gain:
                    best, gain = j, value
        if best < 0 or count == len(chosen):
            return
        chosen[count] = best
        is_chosen[best] = True
        count += 1
        while count > 0:
            for k in range(factored, count):
                _orthogonalise(columns, chosen, k, q, r)
            factored = count
            _least_squares(q, r, target, count, weights)
            step = 1.0
            for i in range(count):
                if weights[i] <= 0.0:
                    weight_before = x[chosen[i]]
                    step = min(step, weight_before / (weight_before - weights[i]) if weight_before > 0.0 else 0.0)
            for i in range(count):
                x[chosen[i]] += step * (weights[i] - x[chosen[i]])
            if step == 1.0:
                break
            kept_count = 0
            for i in range(count):
                if weights[i] > 0.0 or x[chosen[i]] > 1e-14:
                    chosen[kept_count] = chosen[i]
                    kept_count += 1
                else:
                    factored = min(factored, i)
                    is_chosen[chosen[i]] = False
                    x[chosen[i]] = 0.0
            if kept_count == count:  # rounding: the last column made no difference
                return
            count = kept_count
        for c in range(height):
            residual[c] = target[c]
            for i in range(count):
                residual[c] -= columns[chosen[i], c] * x[chosen[i]]


@compiled
def find_locking_wrench(lines: WholeNumbers, wrench: WholeNumbers) -> bool:
    """Search a wrench that holds every hinge shut; return whether its power on every line is positive, exactly.

    Then only x = 0 satisfies sum x_i line_i = 0 with x >= 0 (Gordan), and the linkage is locked. False is inconclusive:
    the hinges may move, or the margin may be too small to detect.

    lines : shape (n, 5). wrench : shape (5,), written.
    """
    n, width = lines.shape
    scale = np.ones(width + 1)
    for c in range(width):
        greatest = 0
        for i in range(n):
            greatest = max(greatest, abs(lines[i, c]))
        scale[c] = max(1, greatest)
    columns = np.ones((n, width + 1))
    for i in range(n):
        for c in range(width):
            columns[i, c] = lines[i, c] / scale[c]
    target = np.zeros(width + 1)
    target[width] = 1.0
    x, residual = np.empty(n), np.empty(width + 1)
    nonnegative_least_squares(columns, target, x, residual)
    largest = 0.0
    for c in range(width):
        residual[c] /= scale[c]
        largest = max(largest, abs(residual[c]))
    if largest == 0.0:
        return False
    for c in range(width):
        wrench[c] = np.int64(np.round(-residual[c] / largest * (1 << 30)))
    for i in range(n):
        power = np.int64(0)
        for c in range(width):
            power += lines[i, c] * wrench[c]
        if power <= 0:
            return False
    return True


@small
@compiled
def cone_rays(columns: Reals, rays: Reals) -> int:
    """Write the extreme rays, each of sum 1, of the cone of x >= 0 with sum x_i columns_i = 0; return their number.

    Double description method: equations are added one after the other; two rays on different sides of a new equation
    combine to a new ray if they are adjacent, that is, if no third ray is 0 wherever both are. The joint support of
    adjacent rays has at most two entries more than equations have been added, so that only such pairs are compared to
    all other rays. Returns -1 if there is no room for the intermediate rays, or if rounding hides whether an equation
    depends on the earlier ones.

    columns : shape (n, height), of about unit length, n at most 63. rays : shape (most, n).
    """
    n, height = columns.shape
    capacity = len(rays)
    supports = np.empty(capacity, np.int64)
    values = np.empty(capacity)
    if n > min(capacity, 63):
        return -1
    rays[:n] = 0.0
    for i in range(n):
        rays[i, i] = 1.0
        supports[i] = np.int64(1) << i
    count = n
    equations = np.empty((height, n))
    equation_count = 0
    for row in range(height):
        # orthogonalised against the earlier equations, so that nearly dependent ones do not spoil the rays
        equation = columns[:, row].copy()
        for _ in range(2):
            for earlier in range(row):
                equation -= scalar_product(equations[earlier], equation) * equations[earlier]
        length = np.sqrt(scalar_product(equation, equation))
        if length <= 1e-11:
            equations[row] = 0.0
            continue
        if length < 1e-6:  # neither dependent nor independent: rounding would decide
            return -1
        equations[row] = equation / length
        for k in range(count):
            value = scalar_product(rays[k], equations[row])
            values[k] = value if abs(value) > 1e-11 else 0.0
        ray_count = count
        for p in range(count):
            if values[p] <= 0.0:
                continue
            for q in range(count):
                if values[q] >= 0.0:
                    continue
                joint = supports[p] | supports[q]
                if not _at_most(joint, equation_count + 2):
                    continue
                adjacent = True
                for k in range(count):
                    if k not in (p, q) and supports[k] | joint == joint:
                        adjacent = False
                        break
                if not adjacent:
                    continue
                if ray_count == capacity:
                    return -1
                total = 0.0
                support = np.int64(0)
                for i in range(n):
                    value = rays[p, i] * -values[q] + rays[q, i] * values[p]
                    rays[ray_count, i] = value
                    total += value
                for i in range(n):
                    rays[ray_count, i] /= total
                    if rays[ray_count, i] > 1e-11:
                        support |= np.int64(1) << i
                    else:
                        rays[ray_count, i] = 0.0
                supports[ray_count] = support
                ray_count += 1
        kept_count = 0
        for k in range(ray_count):
            if k >= count or values[k] == 0.0:
                rays[kept_count] = rays[k]
                supports[kept_count] = supports[k]
                kept_count += 1
        count = kept_count
        equation_count += 1
    return int(count)


@compiled
def _at_most(support: int, size: int) -> bool:
    """Return whether a bit set has at most `size` members."""
    for _ in range(size):
        support &= support - 1
    return support == 0


@compiled
def _bend(screws: Reals, x: Reals, bend: Reals) -> None:
    """Write the sum over i < j of x_i x_j [S_i, S_j]."""
    before = np.zeros(6)
    bend[:] = 0.0
    for k in range(len(x)):
        if x[k] == 0.0:
            continue
        s = screws[k] * x[k]
        add_bracket(before, s, bend)
        before += s


@compiled
def _extends_to_second_order(screws: Reals, x: Reals, columns: Reals) -> bool:
    """Return whether velocities x >= 0 that keep a loop closed to first order extend to second order.

    Accelerations are free where x > 0, and not negative elsewhere. columns : work table of shape (2 n, 6).
    """
    n = len(x)
    bend = np.empty(6)
    _bend(screws, x, bend)
    length = np.sqrt(scalar_product(bend, bend))
    if length < 1e-12:
        return True
    column_count = n
    for i in range(n):
        columns[i] = screws[i] / np.sqrt(scalar_product(screws[i], screws[i]))
        if x[i] > 1e-9:  # smaller values may be zeros changed by rounding
            columns[column_count] = -columns[i]
            column_count += 1
    weights, residual = np.empty(column_count), np.empty(6)
    nonnegative_least_squares(columns[:column_count], -bend / length, weights, residual)
    return bool(scalar_product(residual, residual) < 1e-18)


@compiled
def _some_extreme_rays(columns: Reals, corners: Reals) -> None:
    """Write some extreme rays of the cone of `cone_rays`, one per row, possibly repeated; the cone must not be {0}."""
    n, height = columns.shape
    weighted = np.empty((n, height + 1))
    weighted[:, :height] = columns
    target = np.zeros(height + 1)
    target[height] = 1.0
    residual = np.empty(height + 1)
    for row in range(len(corners)):
        for i in range(n):
            weighted[i, height] = 0.1 + (i * 0.6180339887498949 + row * 0.7548776662466927) % 1.0
        nonnegative_least_squares(weighted, target, corners[row], residual)


@compiled
def _level_shares(screws: Reals, first_ray: Reals, second_ray: Reals, shares: Reals) -> int:
    """Write the s in (0, 1) for which (1 - s) one + s two has no second-order rotation about z; return their number."""
    bend = np.empty(6)
    _bend(screws, first_ray, bend)
    first_turn = bend[2]
    _bend(screws, second_ray, bend)
    second_turn = bend[2]
    _bend(screws, first_ray + second_ray, bend)
    mixed_turn = bend[2] - first_turn - second_turn
    # first (1 - s)^2 + across s (1 - s) + last s^2 = 0
    a, b = first_turn - mixed_turn + second_turn, mixed_turn - 2.0 * first_turn
    root = b * b - 4.0 * a * first_turn
    if root < 0.0:
        return 0
    q = -0.5 * (b + (np.sqrt(root) if b >= 0.0 else -np.sqrt(root)))
    count = 0
    for top, bottom in ((q, a), (first_turn, q)):
        if abs(bottom) > 1e-14 and 0.0 < top / bottom < 1.0:
            shares[count] = top / bottom
            count += 1
    return count


@compiled
def yields_second_order(screws: Reals, rays: Reals) -> bool:
    """Return whether some velocities of the one-sided hinges of a loop extend to second order; False is inconclusive.

    The rays are tried, their pairwise sums, and those combinations of two without second-order rotation about z: as all
    screws are horizontal, no acceleration can compensate such a rotation.

    screws : shape (n, 6), in the order of the loop, oriented in the sense in which the hinges can move. rays : of the
        cone of velocities to first order.
    """
    columns = np.empty((2 * len(screws), 6))
    shares = np.empty(2)
    for ray in rays:
        if _extends_to_second_order(screws, ray, columns):
            return True
    for i in range(len(rays)):
        for j in range(i):
            if _extends_to_second_order(screws, rays[i] + rays[j], columns):
                return True
            for k in range(_level_shares(screws, rays[i], rays[j], shares)):
                if _extends_to_second_order(screws, (1.0 - shares[k]) * rays[i] + shares[k] * rays[j], columns):
                    return True
    return False


@compiled
def settle_ends(lines: WholeNumbers, screws: Reals, ends: NDArray[np.int8]) -> None:
    """Write `END_LOCKED`, `END_PASSED` or `END_OPEN` for each of many loops.

    lines : shape (n_loops, n, 5), whole; screws : shape (n_loops, n, 6), the same hinges in metres.
    """
    n = screws.shape[1]
    level = np.empty((n, 5))
    rays, corners = np.empty((MAX_EXTREME_RAYS, n)), np.empty((6, n))
    wrench = np.empty(5, np.int64)
    for i in range(len(lines)):
        if find_locking_wrench(lines[i], wrench):
            ends[i] = END_LOCKED
            continue
        level[:, :2], level[:, 2:] = screws[i, :, :2], screws[i, :, 3:]
        _some_extreme_rays(level, corners)  # mostly sufficient, and far cheaper than all rays
        if yields_second_order(screws[i], corners):
            ends[i] = END_PASSED
            continue
        count = cone_rays(level, rays)
        ends[i] = END_PASSED if count < 0 or yields_second_order(screws[i], rays[:count]) else END_OPEN
