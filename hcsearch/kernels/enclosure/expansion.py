"""Closure of loops in a box of fold angles: expanded to second order about its middle, with the third order bounded.

A loop is cut into two halves, which lead from its first panel to the panel in its middle. The loop is closed where both
place that panel alike: nine equations of its rotation and three of the place of one of its points. With K_i the cross
product with the axis of hinge i, a half turns the panel by exp(d_1 K_1) exp(d_2 K_2) ... from the middle of the box;
no product of rotations and cross products is longer than 1, so no exponential enters a bound
(docs/explanation/locks.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.algebra.vectors import Vector, at, cross, dot, minus, put
from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.linkage.loops import fold_on
from hcsearch.typing import Reals, Whole

EQUATIONS = 12
"""Equations of a loop: the nine entries of a rotation by rows, and a place."""
ROUNDING = 4e-15
"""Error of the pose of a half for each of its hinges, over 1 and the distance of hinges: a product of rotations is a
sum of three products of two entries, each known to a few units in the last place, as the hinges' places are."""


class Halves(NamedTuple):
    """Loops, each as two chains of hinges from its first panel to the panel in its middle; lengths are in its size.

    starts : (2 n_loops + 1,), where each half begins. hinges : (k,), which hinge comes next. directions, points :
    (k, 3), its line in the flat state, in the sense in which it is crossed. middles : (n_loops, 3), a point of the
    panel in the middle, in the flat state. folds : n, number of hinges.
    """

    starts: Whole
    hinges: Whole
    directions: Reals
    points: Reals
    middles: Reals
    folds: int


class Expansion(NamedTuple):
    """Equations of closure about the middle of a box: values + slopes d + bends d d = a rest that is bounded.

    values : (r,). slopes : (r, n). bends : (q, 12), of the products of two hinges `pairs`, (q, 2), in the loop
    `owners`, (q,); of one hinge with itself the half of it stands there. rests : (n_loops, 2), what third orders come
    to at most: the greatest singular value of the rotation's, and the length of the place's. errors : (n_loops,), of
    rounding in each equation. axes, levers : (k, 3) and turned : (k, 3, 3), of hinges. poses : (2, 3, 4).
    """

    values: Reals
    slopes: Reals
    bends: Reals
    pairs: Whole
    owners: Whole
    rests: Reals
    errors: Reals
    axes: Reals
    levers: Reals
    turned: Reals
    poses: Reals


@compiled
def new_expansion(halves: Halves) -> Expansion:
    """Empty tables, but for the pairs of hinges."""
    loops = len(halves.middles)
    count = 0
    for half in range(2 * loops):
        m = halves.starts[half + 1] - halves.starts[half]
        count += m * (m + 1) // 2
    pairs, owners = np.zeros((count, 2), np.int64), np.zeros(count, np.int64)
    q = 0
    for half in range(2 * loops):
        for i in range(halves.starts[half], halves.starts[half + 1]):
            for j in range(i, halves.starts[half + 1]):
                pairs[q, 0], pairs[q, 1], owners[q] = halves.hinges[i], halves.hinges[j], half // 2
                q += 1
    r, k = EQUATIONS * loops, len(halves.hinges)
    return Expansion(
        np.zeros(r),
        np.zeros((r, halves.folds)),
        np.zeros((count, EQUATIONS)),
        pairs,
        owners,
        np.zeros((loops, 2)),
        np.zeros(loops),
        np.zeros((k, 3)),
        np.zeros((k, 3)),
        np.zeros((k, 3, 3)),
        np.zeros((2, 3, 4)),
    )


@lean
def expand(halves: Halves, angles: Reals, radii: Reals, expansion: Expansion) -> None:
    """Write the equations about a state, for angles that differ by no more than the radii, (n,) each."""
    write_first_order(halves, angles, expansion)
    q = 0
    for loop in range(len(halves.middles)):
        expansion.rests[loop, 0] = expansion.rests[loop, 1] = 0.0
        total, far = 0.0, 1.0
        for half in (2 * loop, 2 * loop + 1):
            sign = 1.0 if half == 2 * loop else -1.0
            q = _write_bends(halves, half, sign, q, expansion)
            turned, reach = _add_rests(halves, half, radii, expansion)
            total += turned
            far = max(far, reach)
        count = halves.starts[2 * loop + 2] - halves.starts[2 * loop]
        expansion.errors[loop] = ROUNDING * count * (1.0 + 2.0 * far) * (1.0 + total * (1.0 + total))


@lean
def write_first_order(halves: Halves, angles: Reals, expansion: Expansion) -> None:
    """Write the values and slopes of the equations at a state."""
    expansion.slopes[:] = 0.0
    for loop in range(len(halves.middles)):
        _place(halves, 2 * loop, angles, expansion.poses[0], expansion)
        _place(halves, 2 * loop + 1, angles, expansion.poses[1], expansion)
        one, two, row = expansion.poses[0], expansion.poses[1], EQUATIONS * loop
        between = expansion.turned[halves.starts[2 * loop]]  # room: the rotation from the one pose to the other
        for i in range(3):
            expansion.values[row + 9 + i] = 0.0
            for j in range(3):
                between[i, j] = two[i, 0] * one[j, 0] + two[i, 1] * one[j, 1] + two[i, 2] * one[j, 2]
                expansion.values[row + 3 * i + j] = (1.0 if i == j else 0.0) - between[i, j]
        middle = at(halves.middles, loop, 0)
        here, there = _moved(one, middle), _moved(two, middle)
        for i in range(3):
            expansion.values[row + 9 + i] = here[i] - there[i]
        # the second half first, as the first one's tables are the room
        _write_slopes(halves, 2 * loop + 1, -1.0, there, between, expansion)
        for i in range(3):
            for j in range(3):
                expansion.poses[1, i, j] = 1.0 if i == j else 0.0
        _write_slopes(halves, 2 * loop, 1.0, here, expansion.poses[1], expansion)


@lean
def _place(halves: Halves, half: int, angles: Reals, pose: Reals, expansion: Expansion) -> None:
    """Write the axes of a half where it is folded, points of them into `levers`, and the pose that it comes to."""
    for i in range(3):
        for j in range(4):
            pose[i, j] = 1.0 if i == j else 0.0
    for k in range(halves.starts[half], halves.starts[half + 1]):
        u, p = at(halves.directions, k, 0), at(halves.points, k, 0)
        for i in range(3):
            expansion.axes[k, i] = pose[i, 0] * u[0] + pose[i, 1] * u[1] + pose[i, 2] * u[2]
        put(expansion.levers, k, 0, _moved(pose, p))
        fold_on(pose, halves.directions[k], halves.points[k], angles[halves.hinges[k]])


@lean
def _moved(pose: Reals, point: Vector) -> Vector:
    """A point that is moved by a pose."""
    x, y, z = point
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3],
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3],
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3],
    )


@lean
def _write_slopes(halves: Halves, half: int, sign: float, middle: Vector, last: Reals, expansion: Expansion) -> None:
    """Write the slopes of a half, levers in place of points, and `turned`: cross products of axes with a rotation."""
    row = EQUATIONS * (half // 2)
    g = last[0, 0], last[0, 1], last[0, 2], last[1, 0], last[1, 1], last[1, 2], last[2, 0], last[2, 1], last[2, 2]
    for k in range(halves.starts[half], halves.starts[half + 1]):
        h, axis = halves.hinges[k], at(expansion.axes, k, 0)
        lever = cross(axis, minus(middle, at(expansion.levers, k, 0)))
        put(expansion.levers, k, 0, lever)
        for j in range(3):
            column = cross(axis, (g[j], g[3 + j], g[6 + j]))
            for i in range(3):
                expansion.turned[k, i, j] = column[i]
                expansion.slopes[row + 3 * i + j, h] += sign * column[i]
        for i in range(3):
            expansion.slopes[row + 9 + i, h] += sign * lever[i]


@lean
def _write_bends(halves: Halves, half: int, sign: float, q: int, expansion: Expansion) -> int:
    """Write the products of two hinges of a half from a row on; the row after them."""
    for i in range(halves.starts[half], halves.starts[half + 1]):
        axis = at(expansion.axes, i, 0)
        for j in range(i, halves.starts[half + 1]):
            f = 0.5 * sign if i == j else sign
            own = expansion.bends[q]
            for s in range(3):
                column = cross(axis, (expansion.turned[j, 0, s], expansion.turned[j, 1, s], expansion.turned[j, 2, s]))
                own[s], own[3 + s], own[6 + s] = f * column[0], f * column[1], f * column[2]
            shift = cross(axis, at(expansion.levers, j, 0))
            own[9], own[10], own[11] = f * shift[0], f * shift[1], f * shift[2]
            q += 1
    return q


@lean
def _add_rests(halves: Halves, half: int, radii: Reals, expansion: Expansion) -> tuple[float, float]:
    """Add the third order of a half; the sum of its radii, and how far the middle panel may be from its hinges.

    Third derivatives along a line are sums over three hinges i <= j <= k of d_i d_j d_k K_i K_j K_k, with rotations
    between. Of the place, what is turned is the lever of the last one, k.
    """
    first, end, loop = halves.starts[half], halves.starts[half + 1], half // 2
    more = total = place = far = 0.0
    for k in range(first, end):
        total += radii[halves.hinges[k]]
    left = total
    for k in range(end - 1, first - 1, -1):
        lever, own = at(expansion.levers, k, 0), radii[halves.hinges[k]]
        reach = math.sqrt(dot(lever, lever)) + more  # what lies between it and the panel moves that by `more`
        far = max(far, reach)
        more += own * reach
        place += reach * (left * left * left - (left - own) ** 3)
        left -= own
    expansion.rests[loop, 0] += total**3 / 6.0
    expansion.rests[loop, 1] += place / 6.0
    return total, far
