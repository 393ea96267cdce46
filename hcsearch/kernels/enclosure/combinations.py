"""Linear combinations of the closure equations in a box, weighted by the unknown terms of the equations.

With the columns V of all terms that may take either sign, each at its greatest, the combinations y of least square
(V^T y)^2 for given right sides are solutions of V V^T y = right side (docs/explanation/locks.md). Several right sides
are solved at once, as lanes: they share everything else.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.kernels.algebra import factor_symmetric
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.expansion import EQUATIONS_PER_LOOP, Expansion, HingeRings

COMBINATION_LANE_COUNT = 8
"""Number of combinations that are computed at once."""
ROTATION_EQUATION_COUNT = 9
"""Rotation equations of a loop; the others are of the place of a point."""


class Combinations(NamedTuple):
    """Work tables of the combinations; k terms, r equations.

    terms : (k, r), coefficients in the equations of each angle, then of each product of two. sizes : (k,), greatest
    values of these terms. weighted : (k, r), terms times squares of sizes. centred : (r,), values with the mean of
    squares. gram : (r, r), V V^T and its factor. weights : (r, LANES), right sides, then combinations. coefficients :
    (k, LANES), of each angle and product in these. values, errors, third_orders : (LANES,), of each at the middle of
    the box, its greatest change without that of slopes, and the third-order part of this change. sums : (3, LANES),
    over equations.
    """

    terms: Reals
    sizes: Reals
    weighted: Reals
    centred: Reals
    gram: Reals
    weights: Reals
    coefficients: Reals
    values: Reals
    errors: Reals
    third_orders: Reals
    sums: Reals


@compiled
def new_combinations(rings: HingeRings, expansion: Expansion) -> Combinations:
    """Return empty tables."""
    r, k, lanes = len(expansion.values), rings.hinge_count + len(expansion.bends), COMBINATION_LANE_COUNT
    terms, weighted, gram = np.zeros((k, r)), np.zeros((k, r)), np.zeros((r, r))
    sizes, centred = np.zeros(k), np.zeros(r)
    weights, coefficients, sums = np.zeros((r, lanes)), np.zeros((k, lanes)), np.zeros((3, lanes))
    values, errors, third_orders = np.zeros(lanes), np.zeros(lanes), np.zeros(lanes)
    return Combinations(
        terms, sizes, weighted, centred, gram, weights, coefficients, values, errors, third_orders, sums
    )


@compiled
def weigh_equations(radii: Reals, expansion: Expansion, work: Combinations) -> bool:
    """Write V V^T, factored (Cholesky), and the centred values; return whether it has a factor."""
    _write_terms(radii, expansion, work)
    gram, trace = work.gram, 0.0
    _write_gram(len(radii) + expansion.bend_count[0], work)
    for i in range(len(gram)):
        turns = i % EQUATIONS_PER_LOOP < ROTATION_EQUATION_COUNT
        bound = expansion.third_order_bounds[i // EQUATIONS_PER_LOOP, 0 if turns else 1]
        gram[i, i] += (2.0 if turns else 1.0) * bound * bound
        trace += gram[i, i]
    return factor_symmetric(gram, 1e-12 * trace)


@compiled
def _write_terms(radii: Reals, expansion: Expansion, work: Combinations) -> None:
    """Write terms, sizes, weighted terms and centred values; a square ranges from 0 to its greatest value."""
    n, r = len(radii), len(expansion.values)
    for i in range(r):
        work.centred[i] = expansion.values[i]
    for h in range(n):
        work.sizes[h], square = radii[h], radii[h] * radii[h]
        for i in range(r):
            work.terms[h, i] = expansion.slopes[i, h]
            work.weighted[h, i] = square * expansion.slopes[i, h]
    for q in range(expansion.bend_count[0]):
        first, second = expansion.pairs[q]
        row, k, size = EQUATIONS_PER_LOOP * expansion.bend_loops[q], n + q, radii[first] * radii[second]
        if r > EQUATIONS_PER_LOOP:
            for i in range(r):
                work.terms[k, i] = work.weighted[k, i] = 0.0
        if first == second:
            size *= 0.5
            for i in range(EQUATIONS_PER_LOOP):
                work.centred[row + i] += size * expansion.bends[q, i]
        work.sizes[k], square = size, size * size
        for i in range(EQUATIONS_PER_LOOP):
            work.terms[k, row + i] = expansion.bends[q, i]
            work.weighted[k, row + i] = square * expansion.bends[q, i]


@compiled
def _write_gram(count: int, work: Combinations) -> None:
    """Write the lower triangle of V V^T, in blocks of three by three, whose sums stay in registers."""
    gram, weighted, terms = work.gram, work.weighted, work.terms
    for i in range(0, len(gram), 3):
        for j in range(0, i + 3, 3):
            s00 = s01 = s02 = s10 = s11 = s12 = s20 = s21 = s22 = 0.0
            for k in range(count):
                x, y, z = weighted[k, i], weighted[k, i + 1], weighted[k, i + 2]
                u, v, w = terms[k, j], terms[k, j + 1], terms[k, j + 2]
                s00 += x * u
                s01 += x * v
                s02 += x * w
                s10 += y * u
                s11 += y * v
                s12 += y * w
                s20 += z * u
                s21 += z * v
                s22 += z * w
            gram[i, j], gram[i, j + 1], gram[i, j + 2] = s00, s01, s02
            gram[i + 1, j], gram[i + 1, j + 1], gram[i + 1, j + 2] = s10, s11, s12
            gram[i + 2, j], gram[i + 2, j + 1], gram[i + 2, j + 2] = s20, s21, s22


@compiled
def solve_combinations(work: Combinations) -> None:
    """Replace the right sides in `weights` by their combinations, with the factor of `weigh_equations`."""
    weights, gram = work.weights, work.gram
    r = len(gram)
    for i in range(r):
        for k in range(i):
            part = gram[i, k]
            for c in range(COMBINATION_LANE_COUNT):
                weights[i, c] -= part * weights[k, c]
        part = 1.0 / gram[i, i]
        for c in range(COMBINATION_LANE_COUNT):
            weights[i, c] *= part
    for i in range(r - 1, -1, -1):
        for k in range(i + 1, r):
            part = gram[k, i]
            for c in range(COMBINATION_LANE_COUNT):
                weights[i, c] -= part * weights[k, c]
        part = 1.0 / gram[i, i]
        for c in range(COMBINATION_LANE_COUNT):
            weights[i, c] *= part


@compiled
def combine_equations(radii: Reals, expansion: Expansion, work: Combinations) -> None:
    """Write values, coefficients and errors of the combinations in `weights`."""
    n, count = len(radii), len(radii) + expansion.bend_count[0]
    values, errors, weights = work.values, work.errors, work.weights
    for c in range(COMBINATION_LANE_COUNT):
        values[c] = 0.0
    for i in range(len(weights)):
        for c in range(COMBINATION_LANE_COUNT):
            values[c] += weights[i, c] * work.centred[i]
    _write_parts(count, work.terms, work.weights, work.coefficients)
    _write_rests(expansion, work)
    for k in range(n, count):
        size = work.sizes[k]
        for c in range(COMBINATION_LANE_COUNT):
            errors[c] += size * abs(work.coefficients[k, c])


@compiled
def _write_parts(count: int, terms: Reals, weights: Reals, coefficients: Reals) -> None:
    """Write the product of terms and combinations, twelve equations at a time, so that a row stays in registers."""
    for k in range(count):
        for c in range(COMBINATION_LANE_COUNT):
            coefficients[k, c] = 0.0
    for i in range(0, len(weights), EQUATIONS_PER_LOOP):
        for k in range(count):
            a, b, d, e = terms[k, i], terms[k, i + 1], terms[k, i + 2], terms[k, i + 3]
            f, g, h, j = terms[k, i + 4], terms[k, i + 5], terms[k, i + 6], terms[k, i + 7]
            p, q, s, t = terms[k, i + 8], terms[k, i + 9], terms[k, i + 10], terms[k, i + 11]
            for c in range(COMBINATION_LANE_COUNT):
                coefficients[k, c] += (
                    a * weights[i, c]
                    + b * weights[i + 1, c]
                    + d * weights[i + 2, c]
                    + e * weights[i + 3, c]
                    + f * weights[i + 4, c]
                    + g * weights[i + 5, c]
                    + h * weights[i + 6, c]
                    + j * weights[i + 7, c]
                    + p * weights[i + 8, c]
                    + q * weights[i + 9, c]
                    + s * weights[i + 10, c]
                    + t * weights[i + 11, c]
                )


@compiled
def _write_rests(expansion: Expansion, work: Combinations) -> None:
    """Write bounds of the third order, and errors as the sum of these and rounding.

    A third order of the rotation is a sum of products of cross products: matrices of rank 2 whose singular values are
    no more than 1, so that the combination of their entries is no more than the root of twice its own square.
    """
    third_orders, errors, weights, sums = work.third_orders, work.errors, work.weights, work.sums
    for c in range(COMBINATION_LANE_COUNT):
        third_orders[c] = errors[c] = 0.0
    for loop in range(len(expansion.third_order_bounds)):
        row, rounding = EQUATIONS_PER_LOOP * loop, expansion.errors[loop]
        turn, shift = expansion.third_order_bounds[loop]
        for c in range(COMBINATION_LANE_COUNT):
            sums[0, c] = sums[1, c] = sums[2, c] = 0.0
        for i in range(EQUATIONS_PER_LOOP):
            kind = 0 if i < ROTATION_EQUATION_COUNT else 1
            for c in range(COMBINATION_LANE_COUNT):
                sums[kind, c] += weights[row + i, c] * weights[row + i, c]
                sums[2, c] += abs(weights[row + i, c])
        for c in range(COMBINATION_LANE_COUNT):
            third_orders[c] += (math.sqrt(2.0 * sums[0, c]) * turn + math.sqrt(sums[1, c]) * shift) * (1.0 + 1e-12)
            errors[c] += rounding * sums[2, c]
    for c in range(COMBINATION_LANE_COUNT):
        errors[c] += third_orders[c]


@compiled
def add_shares(radii: Reals, expansion: Expansion, shares: Reals, work: Combinations) -> None:
    """Add to `shares`, (n,), by how much each angle's higher orders leave the first combination unknown."""
    n, total = len(radii), 0.0
    for h in range(n):
        total += radii[h]
    for q in range(expansion.bend_count[0]):
        size = abs(work.coefficients[n + q, 0]) * work.sizes[n + q]
        shares[expansion.pairs[q, 0]] += size
        shares[expansion.pairs[q, 1]] += size
    for h in range(n):
        shares[h] += 3.0 * work.third_orders[0] * radii[h] / total
