"""Closure of loops in a box of fold angles: the expansion to second order about its middle, and bounds of third order.

A loop is cut into two halves, which lead from a first panel to a panel in the middle. The loop is closed where both
place that panel alike: nine equations of its rotation and three of the place of one of its points. With K_i the cross
product with the axis of hinge i, a half turns the panel by exp(d_1 K_1) exp(d_2 K_2) ... from the middle of the box;
no product of rotations and cross products is longer than 1, so no exponential enters a bound
(docs/explanation/locks.md).

The third order of a half is the sum over i <= j <= k of d_i d_j d_k K_i K_j K_k, the bends of j and k turned by i.
Bounding it term by term is two to three times as narrow as bounding it by the sum of all radii, and takes longer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import (
    Vector3,
    cross,
    dot,
    put_vector,
    scaled_vector,
    vector_at,
    vector_difference,
    vector_sum,
)
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.linkage.loops import fold_on

EQUATIONS_PER_LOOP = 12
"""Equations of a loop: the nine entries of a rotation by rows, and the place of a point."""
HALF_POSE_ROUNDING = 4e-15
"""Rounding error of the pose of a half for each of its hinges, relative to 1 and the distance of hinges: a product of
rotations is a sum of three products of two entries, each known to a few units in the last place, as the hinges'
places are."""


class HingeRings(NamedTuple):
    """Loops of hinges in the flat state; lengths are in its size, places about the middle of each loop.

    starts : (n_loops + 1,), where each loop begins. hinges : (k,), the hinges in order. directions, points : (k, 3),
    of each hinge's line, in the sense in which the loop crosses it. hinge_count : n.
    """

    starts: WholeNumbers
    hinges: WholeNumbers
    directions: Reals
    points: Reals
    hinge_count: int


class Expansion(NamedTuple):
    """Closure equations about the middle of a box: values + slopes d + bends d d = a remainder that is bounded.

    values : (r,). slopes : (r, n). bends : (q, 12), of the products of two hinges `pairs`, (q, 2), in the loop
    `bend_loops`, (q,); for a hinge with itself half of the product's coefficient. bend_count : (1,), number of these.
    third_order_bounds, fourth_order_bounds : (n_loops, 2): of the greatest singular value of the rotation's part, and
    of the length of the place's. errors : (n_loops,), of rounding in each equation. cuts : (n_loops, 2), hinges of the
    loop before the first panel, and before the one in the middle. steps : (k,), the hinges of both halves of each loop,
    from the first panel to the middle one. ends : (2 n_loops + 1,), of halves. axes, levers : (k, 3) and turned : (k,
    3, 3), of hinges by their place in `steps`. poses : (2, 3, 4).
    """

    values: Reals
    slopes: Reals
    bends: Reals
    pairs: WholeNumbers
    bend_loops: WholeNumbers
    bend_count: WholeNumbers
    third_order_bounds: Reals
    fourth_order_bounds: Reals
    errors: Reals
    cuts: WholeNumbers
    steps: WholeNumbers
    ends: WholeNumbers
    axes: Reals
    levers: Reals
    turned: Reals
    poses: Reals


@compiled
def new_expansion(rings: HingeRings) -> Expansion:
    """Return empty tables."""
    loops, max_bends = len(rings.starts) - 1, 0
    for loop in range(loops):
        m = rings.starts[loop + 1] - rings.starts[loop]
        max_bends += m * (m + 1) // 2
    r, k, cuts = EQUATIONS_PER_LOOP * loops, len(rings.hinges), np.zeros((loops, 2), np.int64)
    for loop in range(loops):
        cuts[loop, 1] = (rings.starts[loop + 1] - rings.starts[loop]) // 2
    return Expansion(
        np.zeros(r),
        np.zeros((r, rings.hinge_count)),
        np.zeros((max_bends, EQUATIONS_PER_LOOP)),
        np.zeros((max_bends, 2), np.int64),
        np.zeros(max_bends, np.int64),
        np.zeros(1, np.int64),
        np.zeros((loops, 2)),
        np.zeros((loops, 2)),
        np.zeros(loops),
        cuts,
        np.zeros(k, np.int64),
        np.zeros(2 * loops + 1, np.int64),
        np.zeros((k, 3)),
        np.zeros((k, 3)),
        np.zeros((k, 3, 3)),
        np.zeros((2, 3, 4)),
    )


@compiled
def expand_closure(rings: HingeRings, angles: Reals, radii: Reals, expansion: Expansion) -> None:
    """Write the equations about a state, for angles that differ from it by up to the radii, (n,) each.

    Loops are cut at `expansion.cuts`.
    """
    write_first_order(rings, angles, expansion)
    expansion.bend_count[0] = 0
    for loop in range(len(rings.starts) - 1):
        for kind in range(2):
            expansion.third_order_bounds[loop, kind] = expansion.fourth_order_bounds[loop, kind] = 0.0
        total, far = 0.0, 1.0
        for half in (2 * loop, 2 * loop + 1):
            _write_bends(rings, half, expansion)
            turned, reach = _add_rests(rings, half, radii, expansion)
            total += turned
            far = max(far, reach)
        count = rings.starts[loop + 1] - rings.starts[loop]
        expansion.errors[loop] = HALF_POSE_ROUNDING * count * (1.0 + 2.0 * far) * (1.0 + total * (1.0 + total))


@compiled
def cut_loops(rings: HingeRings, radii: Reals, turn: int, cuts: WholeNumbers) -> None:
    """Choose where each loop is cut: bounds of third order are cubic in the sum of the radii of either half.

    turn : 0 for the most even cut, 1 for the next most even one, and so on.
    """
    for loop in range(len(rings.starts) - 1):
        start, m = rings.starts[loop], rings.starts[loop + 1] - rings.starts[loop]
        total, before, chosen = 0.0, -1.0, -1
        for k in range(m):
            total += radii[rings.hinges[start + k]]
        for _ in range(turn + 1):
            least_uneven, next_one = math.inf, chosen
            for first in range(m):
                half_sum = 0.0
                for k in range(first, m):
                    uneven, place = abs(2.0 * half_sum - total), first * m + k
                    later = uneven > before or (uneven == before and place > chosen)
                    if later and uneven < least_uneven:
                        least_uneven, next_one = uneven, place
                    half_sum += radii[rings.hinges[start + k]]
            before, chosen = least_uneven, next_one
        cuts[loop, 0], cuts[loop, 1] = chosen // m, chosen % m


@compiled
def keep_cuts(source: WholeNumbers, target: WholeNumbers) -> None:
    """Copy the cuts of all loops, (n_loops, 2)."""
    for loop in range(len(source)):
        target[loop, 0], target[loop, 1] = source[loop, 0], source[loop, 1]


@compiled
def write_first_order(rings: HingeRings, angles: Reals, expansion: Expansion) -> None:
    """Write the values and slopes of the equations at a state, with the present cuts."""
    expansion.slopes[:] = 0.0
    for loop in range(len(rings.starts) - 1):
        _lay_out(rings, loop, expansion)
        middle = _middle(rings, loop, expansion)
        first, second, row = expansion.poses[0], expansion.poses[1], EQUATIONS_PER_LOOP * loop
        _place(rings, 2 * loop, angles, first, expansion)
        _place(rings, 2 * loop + 1, angles, second, expansion)
        here, there = moved_point(first, middle), moved_point(second, middle)
        for i in range(3):
            x, y, z = second[i, 0], second[i, 1], second[i, 2]
            for j in range(3):  # the rotation from the one pose to the other, in the room of the second
                second[i, j] = x * first[j, 0] + y * first[j, 1] + z * first[j, 2]
                expansion.values[row + 3 * i + j] = (1.0 if i == j else 0.0) - second[i, j]
        for i in range(3):
            expansion.values[row + 9 + i] = here[i] - there[i]
            for j in range(3):
                first[i, j] = 1.0 if i == j else 0.0
        _write_slopes(2 * loop, 1.0, here, first, rings, expansion)
        _write_slopes(2 * loop + 1, -1.0, there, second, rings, expansion)


@compiled
def _lay_out(rings: HingeRings, loop: int, expansion: Expansion) -> None:
    """Write the hinges of both halves of a loop, from its first panel to its middle one."""
    start, end = rings.starts[loop], rings.starts[loop + 1]
    first, middle = start + expansion.cuts[loop, 0], start + expansion.cuts[loop, 1]
    place = start
    for k in range(first, middle):
        expansion.steps[place] = k
        place += 1
    expansion.ends[2 * loop], expansion.ends[2 * loop + 1], expansion.ends[2 * loop + 2] = start, place, end
    for k in range(first - 1, first - 1 - (end - place), -1):
        expansion.steps[place] = k if k >= start else k + end - start
        place += 1


@compiled
def _middle(rings: HingeRings, loop: int, expansion: Expansion) -> Vector3:
    """A point of the middle panel, in the flat state."""
    start, m = rings.starts[loop], rings.starts[loop + 1] - rings.starts[loop]
    k = expansion.cuts[loop, 1]
    before, after = vector_at(rings.points, start + (k - 1) % m, 0), vector_at(rings.points, start + k % m, 0)
    return scaled_vector(0.5, vector_sum(before, after))


@compiled
def _place(rings: HingeRings, half: int, angles: Reals, pose: Reals, expansion: Expansion) -> None:
    """Write the axes of a folded half, points of them into `levers`, and the pose at its end."""
    sense = 1.0 if half % 2 == 0 else -1.0
    for i in range(3):
        for j in range(4):
            pose[i, j] = 1.0 if i == j else 0.0
    for place in range(expansion.ends[half], expansion.ends[half + 1]):
        k = expansion.steps[place]
        u, p = vector_at(rings.directions, k, 0), vector_at(rings.points, k, 0)
        for i in range(3):
            expansion.axes[place, i] = sense * (pose[i, 0] * u[0] + pose[i, 1] * u[1] + pose[i, 2] * u[2])
        put_vector(expansion.levers, place, 0, moved_point(pose, p))
        fold_on(pose, rings.directions[k], rings.points[k], sense * angles[rings.hinges[k]])


@compiled
def moved_point(pose: Reals, point: Vector3) -> Vector3:
    """Return a point moved by a pose."""
    x, y, z = point
    return (
        pose[0, 0] * x + pose[0, 1] * y + pose[0, 2] * z + pose[0, 3],
        pose[1, 0] * x + pose[1, 1] * y + pose[1, 2] * z + pose[1, 3],
        pose[2, 0] * x + pose[2, 1] * y + pose[2, 2] * z + pose[2, 3],
    )


@compiled
def _write_slopes(
    half: int, sign: float, middle: Vector3, last: Reals, rings: HingeRings, expansion: Expansion
) -> None:
    """Write the slopes of a half, levers in place of points, and `turned`: cross products of axes with a rotation."""
    row = EQUATIONS_PER_LOOP * (half // 2)
    g = last[0, 0], last[0, 1], last[0, 2], last[1, 0], last[1, 1], last[1, 2], last[2, 0], last[2, 1], last[2, 2]
    for place in range(expansion.ends[half], expansion.ends[half + 1]):
        h, axis = rings.hinges[expansion.steps[place]], vector_at(expansion.axes, place, 0)
        lever = cross(axis, vector_difference(middle, vector_at(expansion.levers, place, 0)))
        put_vector(expansion.levers, place, 0, lever)
        for j in range(3):
            column = cross(axis, (g[j], g[3 + j], g[6 + j]))
            for i in range(3):
                expansion.turned[place, i, j] = column[i]
                expansion.slopes[row + 3 * i + j, h] += sign * column[i]
        for i in range(3):
            expansion.slopes[row + 9 + i, h] += sign * lever[i]


@compiled
def _write_bends(rings: HingeRings, half: int, expansion: Expansion) -> None:
    """Write the second-order terms of a half, for all products of two hinges."""
    sign, q = 1.0 if half % 2 == 0 else -1.0, expansion.bend_count[0]
    for i in range(expansion.ends[half], expansion.ends[half + 1]):
        axis = vector_at(expansion.axes, i, 0)
        for j in range(i, expansion.ends[half + 1]):
            f = 0.5 * sign if i == j else sign
            expansion.pairs[q, 0] = rings.hinges[expansion.steps[i]]
            expansion.pairs[q, 1] = rings.hinges[expansion.steps[j]]
            expansion.bend_loops[q] = half // 2
            bend, turned = expansion.bends[q], expansion.turned[j]
            for s in range(3):
                column = cross(axis, (turned[0, s], turned[1, s], turned[2, s]))
                bend[s], bend[3 + s], bend[6 + s] = f * column[0], f * column[1], f * column[2]
            shift = cross(axis, vector_at(expansion.levers, j, 0))
            bend[9], bend[10], bend[11] = f * shift[0], f * shift[1], f * shift[2]
            q += 1
    expansion.bend_count[0] = q


@compiled
def _add_rests(rings: HingeRings, half: int, radii: Reals, expansion: Expansion) -> tuple[float, float]:
    """Add the third and fourth orders of a half; return the sum of its radii, and the greatest reach of its hinges.

    Third derivatives along a line are sums over three hinges i <= j <= k of d_i d_j d_k K_i K_j K_k, with rotations
    between, and so are fourth ones. For the place, the lever of the last hinge, k, is turned instead.
    """
    first, end, loop = expansion.ends[half], expansion.ends[half + 1], half // 2
    displacement = total = place = fourth = far = 0.0
    for k in range(first, end):
        total += radii[rings.hinges[expansion.steps[k]]]
    remaining = total
    for k in range(end - 1, first - 1, -1):
        lever, radius = vector_at(expansion.levers, k, 0), radii[rings.hinges[expansion.steps[k]]]
        reach = math.sqrt(dot(lever, lever)) + displacement  # what lies between it and the panel moves that by `more`
        far = max(far, reach)
        displacement += radius * reach
        next_remaining = max(remaining - radius, 0.0)
        place += reach * (remaining * remaining * remaining - next_remaining * next_remaining * next_remaining)
        a, b = remaining, next_remaining
        fourth += reach * (a * a * a * a - b * b * b * b)
        remaining = next_remaining
    expansion.third_order_bounds[loop, 0] += total**3 / 6.0
    expansion.third_order_bounds[loop, 1] += place / 6.0
    expansion.fourth_order_bounds[loop, 0] += total**4 / 24.0
    expansion.fourth_order_bounds[loop, 1] += fourth / 24.0
    return total, far


@compiled
def bound_third_order(radii: Reals, hinges: WholeNumbers, expansion: Expansion, weights: Reals) -> float:
    """Bound the third and higher orders of the first combination, a column of (r, m), without rounding.

    radii : (n,), of the box. hinges : (k,), of `HingeRings`. With the bend of j and k as columns b, and the
    combination's entries for them as columns y, y . (a_i x b) = a_i . (b x y). Twice the same hinge has half the
    weight, thrice a sixth, of which a bend with itself has a half already.
    """
    total, q = 0.0, 0
    for half in range(len(expansion.ends) - 1):
        row, first, end = EQUATIONS_PER_LOOP * (half // 2), expansion.ends[half], expansion.ends[half + 1]
        for j in range(first, end):
            radius = radii[hinges[expansion.steps[j]]]
            for k in range(j, end):
                product = _turned(row, q, expansion, weights)
                size = (0.5 if j < k else 1.0 / 3.0) * radius * abs(dot(vector_at(expansion.axes, j, 0), product))
                for i in range(first, j):
                    size += radii[hinges[expansion.steps[i]]] * abs(dot(vector_at(expansion.axes, i, 0), product))
                total += radius * radii[hinges[expansion.steps[k]]] * size
                q += 1
    for loop in range(len(expansion.fourth_order_bounds)):
        turns = shifts = 0.0
        for i in range(EQUATIONS_PER_LOOP * loop, EQUATIONS_PER_LOOP * loop + 9):
            turns += weights[i, 0] * weights[i, 0]
        for i in range(EQUATIONS_PER_LOOP * loop + 9, EQUATIONS_PER_LOOP * loop + 12):
            shifts += weights[i, 0] * weights[i, 0]
        total += (
            math.sqrt(2.0 * turns) * expansion.fourth_order_bounds[loop, 0]
            + math.sqrt(shifts) * expansion.fourth_order_bounds[loop, 1]
        )
    return total * (1.0 + 1e-12)


@compiled
def _turned(row: int, q: int, expansion: Expansion, weights: Reals) -> Vector3:
    """The sum of cross products of the columns of a bend with those of the first combination."""
    bend = expansion.bends[q]
    product = cross((bend[9], bend[10], bend[11]), (weights[row + 9, 0], weights[row + 10, 0], weights[row + 11, 0]))
    for s in range(3):
        column = bend[s], bend[3 + s], bend[6 + s]
        product = vector_sum(
            product, cross(column, (weights[row + s, 0], weights[row + 3 + s, 0], weights[row + 6 + s, 0]))
        )
    return product
