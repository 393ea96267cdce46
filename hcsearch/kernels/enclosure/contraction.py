"""Contraction of a box of fold angles onto the closed states that it may hold.

Any combination of the equations of closure bounds each fold angle by what the others leave. The combinations that are
tried weigh each equation by what is not known of it: with the columns V of all terms that may take either sign, each at
its greatest, those of least square (V^T y)^2 for a given slope y . M_j, or value, are solutions of V V^T y = M_j.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.expansion import EQUATIONS, Expansion, Rings, expand, new_expansion
from hcsearch.typing import Reals

LEAST_GAIN = 0.1
"""A box is contracted again where it has become smaller by this share."""
SWEEPS = 3
"""A box is contracted no more often than this."""
PAD = 1e-14
"""What contracted bounds are moved outward by (rad): a quotient of numbers up to 4 is rounded by less."""
LEAST_SLOPE = 1e-9
"""A combination bounds no angle of which it has a smaller slope."""


class Contraction(NamedTuple):
    """Tables: the expansion; middles, radii, shares : (n,), of a box, and by how much each angle leaves it undecided.

    gram : (r, r), V V^T and its factor. centred : (r,), values with the mean of squares. mix : (r,), a combination.
    slopes, least, most : (n,), of it, and what each term of it is at least and at most.
    """

    expansion: Expansion
    middles: Reals
    radii: Reals
    shares: Reals
    gram: Reals
    centred: Reals
    mix: Reals
    slopes: Reals
    least: Reals
    most: Reals


@compiled
def new_contraction(rings: Rings) -> Contraction:
    """Empty tables."""
    n, r = rings.folds, EQUATIONS * (len(rings.starts) - 1)
    return Contraction(
        new_expansion(rings),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros((r, r)),
        np.zeros(r),
        np.zeros(r),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
    )


@lean
def contract(rings: Rings, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box, (n,) each, onto the closed states in it; False where it is proved to hold none."""
    n = len(low)
    for _ in range(SWEEPS):
        before = after = 0.0
        for h in range(n):
            work.middles[h] = 0.5 * (low[h] + high[h])
            work.radii[h] = 0.5 * (high[h] - low[h]) * (1.0 + 1e-15) + 1e-15
            work.shares[h] = work.radii[h]
            before += high[h] - low[h]
        expand(rings, work.middles, work.radii, work.expansion)
        if not weigh(work):
            return True
        if not _use(work.centred, low, high, True, work):
            return False
        for h in range(n):
            if high[h] - low[h] > PAD and not _use(work.expansion.slopes[:, h], low, high, False, work):
                return False
        for h in range(n):
            after += high[h] - low[h]
        if after > (1.0 - LEAST_GAIN) * before:
            break
    return True


@lean
def weigh(work: Contraction) -> bool:
    """Write V V^T, factored (Cholesky), and the centred values; whether it has a factor."""
    own, gram, centred = work.expansion, work.gram, work.centred
    r, n = own.slopes.shape
    gram[:] = 0.0
    for i in range(r):
        centred[i] = own.values[i]
        for j in range(i + 1):
            total = 0.0
            for h in range(n):
                total += own.slopes[i, h] * own.slopes[j, h] * work.radii[h] * work.radii[h]
            gram[i, j] = total
    for q in range(own.filled[0]):
        one, two = own.pairs[q]
        weight, row = work.radii[one] * work.radii[two], EQUATIONS * own.owners[q]
        if one == two:  # a square lies between 0 and its greatest value
            weight *= 0.5
            for i in range(EQUATIONS):
                centred[row + i] += weight * own.bends[q, i]
        square = weight * weight
        if square < 1e-30:
            continue
        for i in range(EQUATIONS):
            part = square * own.bends[q, i]
            if part != 0.0:
                for j in range(i + 1):
                    gram[row + i, row + j] += part * own.bends[q, j]
    trace = 0.0
    for i in range(r):
        rest = own.rests[i // EQUATIONS, 0 if i % EQUATIONS < 9 else 1]
        gram[i, i] += (2.0 if i % EQUATIONS < 9 else 1.0) * rest * rest
        trace += gram[i, i]
    return _factor(gram, 1e-12 * trace)


@lean
def _factor(gram: Reals, damping: float) -> bool:
    """Write the Cholesky factor of a symmetric matrix and damping into its lower triangle."""
    for i in range(len(gram)):
        gram[i, i] += damping
        for j in range(i + 1):
            total = gram[i, j]
            for k in range(j):
                total -= gram[i, k] * gram[j, k]
            if i > j:
                gram[i, j] = total / gram[j, j]
            elif total > 0.0:
                gram[i, i] = math.sqrt(total)
            else:
                return False
    return True


@lean
def _use(right: Reals, low: Reals, high: Reals, sharing: bool, work: Contraction) -> bool:
    """Contract a box by the combination for a right side; False where it excludes all of the box.

    sharing : whether to write what each angle contributes to what is not known.
    """
    mix, n = work.mix, len(low)
    greatest = solve(right, work)
    if not 0.0 < greatest < math.inf:
        return True
    for i in range(len(mix)):
        mix[i] /= greatest
    value, error = terms(sharing, work)
    sizes = abs(value) + error
    below, above = value - error, value + error
    for h in range(n):
        x, y = work.slopes[h] * (low[h] - work.middles[h]), work.slopes[h] * (high[h] - work.middles[h])
        work.least[h], work.most[h] = min(x, y), max(x, y)
        below += work.least[h]
        above += work.most[h]
        sizes += abs(x) + abs(y)
    rounding = 4e-16 * (n + 4) * sizes
    below -= rounding
    above += rounding
    if below > 0.0 or above < 0.0:
        return False
    for h in range(n):
        slope = work.slopes[h]
        if abs(slope) < LEAST_SLOPE:
            continue
        one, two = -(above - work.most[h]) / slope, -(below - work.least[h]) / slope
        least = max(low[h], work.middles[h] + min(one, two) - PAD)
        most = min(high[h], work.middles[h] + max(one, two) + PAD)
        if least > most:
            return False
        low[h], high[h] = least, most
    return True


@lean
def solve(right: Reals, work: Contraction) -> float:
    """Write the combination for a right side, (r,), by the factor that `weigh` wrote; its greatest entry."""
    mix, gram = work.mix, work.gram
    r, greatest = len(mix), 0.0
    for i in range(r):
        total = right[i]
        for k in range(i):
            total -= gram[i, k] * mix[k]
        mix[i] = total / gram[i, i]
    for i in range(r - 1, -1, -1):
        total = mix[i]
        for k in range(i + 1, r):
            total -= gram[k, i] * mix[k]
        mix[i] = total / gram[i, i]
        greatest = max(greatest, abs(mix[i]))
    return greatest


@lean
def terms(sharing: bool, work: Contraction) -> tuple[float, float]:
    """Write the slopes of a combination; its value, and what is not known of it but for those, with rounding.

    A third order of the rotation is a sum of products of cross products: matrices of rank 2 whose singular values are
    no more than 1, so that the combination of their entries is no more than the root of twice its own square.
    """
    own, mix = work.expansion, work.mix
    r, n = own.slopes.shape
    value = error = 0.0
    for h in range(n):
        work.slopes[h] = 0.0
    for i in range(r):
        value += mix[i] * own.values[i]
        for h in range(n):
            work.slopes[h] += mix[i] * own.slopes[i, h]
    for loop in range(len(own.rests)):
        turns = shifts = size = 0.0
        for i in range(EQUATIONS * loop, EQUATIONS * loop + 9):
            turns += mix[i] * mix[i]
            size += abs(mix[i])
        for i in range(EQUATIONS * loop + 9, EQUATIONS * loop + 12):
            shifts += mix[i] * mix[i]
            size += abs(mix[i])
        error += (math.sqrt(2.0 * turns) * own.rests[loop, 0] + math.sqrt(shifts) * own.rests[loop, 1]) * (1.0 + 1e-12)
        error += size * own.errors[loop]
    rest = error
    for q in range(own.filled[0]):
        row, one, two, bend = EQUATIONS * own.owners[q], own.pairs[q, 0], own.pairs[q, 1], 0.0
        for i in range(EQUATIONS):
            bend += mix[row + i] * own.bends[q, i]
        size = bend * work.radii[one] * work.radii[two]
        if one == two:
            value += 0.5 * size
            size *= 0.5
        error += abs(size)
        if sharing:
            work.shares[one] += abs(size)
            work.shares[two] += abs(size)
    if sharing:
        total = 0.0
        for h in range(n):
            total += work.radii[h]
        for h in range(n):
            # `shares` began with the radii
            work.shares[h] += abs(work.slopes[h]) * work.radii[h] - work.radii[h]
            work.shares[h] += 3.0 * rest * work.radii[h] / total
    return value, error
