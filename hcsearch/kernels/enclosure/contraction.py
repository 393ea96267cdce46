"""Contraction of a box of fold angles onto the closed states that it may hold.

Any combination of the equations of closure bounds each fold angle by what the others leave. Those that are tried are of
least square for a given slope of one angle, and for a given value.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.kernels.compiling.compiled import compiled, lean
from hcsearch.kernels.enclosure.combinations import (
    LANES,
    Combinations,
    add_shares,
    combine,
    new_combinations,
    solve,
    weigh,
)
from hcsearch.kernels.enclosure.expansion import Expansion, Rings, expand, new_expansion
from hcsearch.kernels.enclosure.third_order import third_order
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
    """Tables; middles, radii, shares : (n,), of a box, and by how much each angle leaves it undecided.

    least, most : (n,), what each slope of a combination comes to.
    """

    expansion: Expansion
    combinations: Combinations
    middles: Reals
    radii: Reals
    shares: Reals
    least: Reals
    most: Reals


@compiled
def new_contraction(rings: Rings) -> Contraction:
    """Empty tables."""
    n, expansion = rings.folds, new_expansion(rings)
    combinations = new_combinations(rings, expansion)
    return Contraction(expansion, combinations, np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))


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
        if not weigh(work.radii, work.expansion, work.combinations):
            return True
        for first in range(0, n + 1, LANES):
            if not _use(rings, first, low, high, work):
                return False
        for h in range(n):
            after += high[h] - low[h]
        if after > (1.0 - LEAST_GAIN) * before:
            break
    return True


@lean
def _use(rings: Rings, first: int, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box by some combinations; False where one excludes all of it. Number 0 is that of the values."""
    n, own = len(low), work.combinations
    last = min(n + 1 - first, LANES)
    for i in range(len(own.mixes)):
        for c in range(LANES):
            own.mixes[i, c] = 0.0
        for c in range(last):
            own.mixes[i, c] = work.expansion.slopes[i, first + c - 1] if first + c > 0 else own.centred[i]
    solve(own)
    _scale(own)
    combine(work.radii, work.expansion, own)
    if first == 0:
        _refine(rings, work)
        for h in range(n):
            work.shares[h] = abs(own.parts[h, 0]) * work.radii[h]
        add_shares(work.radii, work.expansion, work.shares, own)
    for c in range(last):
        h = first + c - 1
        if (h < 0 or high[h] - low[h] > PAD) and not _bound(c, low, high, work):
            return False
    return True


@lean
def _refine(rings: Rings, work: Contraction) -> None:
    """Bound the third order of the first combination term by term."""
    own = work.combinations
    gain = own.thirds[0] - third_order(work.radii, rings.hinges, work.expansion, own.mixes)
    if gain > 0.0:
        own.thirds[0] -= gain
        own.errors[0] -= gain


@lean
def _scale(own: Combinations) -> None:
    """Scale the greatest entry of each combination to 1; one that is none becomes 0, and bounds nothing."""
    greatest = own.sums[0]
    for c in range(LANES):
        greatest[c] = 0.0
    for i in range(len(own.mixes)):
        for c in range(LANES):
            greatest[c] = max(greatest[c], abs(own.mixes[i, c]))
    for c in range(LANES):
        if 0.0 < greatest[c] < math.inf:
            greatest[c] = 1.0 / greatest[c]
        else:
            greatest[c] = 0.0
            for i in range(len(own.mixes)):
                own.mixes[i, c] = 0.0
    for i in range(len(own.mixes)):
        for c in range(LANES):
            own.mixes[i, c] *= greatest[c]


@lean
def _bound(c: int, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box by one combination; False where it excludes all of the box."""
    own, n = work.combinations, len(low)
    value, error = own.values[c], own.errors[c]
    sizes = abs(value) + error
    below, above = value - error, value + error
    for h in range(n):
        slope = own.parts[h, c]
        x, y = slope * (low[h] - work.middles[h]), slope * (high[h] - work.middles[h])
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
        slope = own.parts[h, c]
        if abs(slope) < LEAST_SLOPE:
            continue
        one, two = -(above - work.most[h]) / slope, -(below - work.least[h]) / slope
        least = max(low[h], work.middles[h] + min(one, two) - PAD)
        most = min(high[h], work.middles[h] + max(one, two) + PAD)
        if least > most:
            return False
        low[h], high[h] = least, most
    return True
