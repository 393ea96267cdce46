"""Contraction of boxes of fold angles onto their closed states, and Newton's method within a box.

Any combination of the closure equations bounds each fold angle by the ranges of the others. The combinations in use
are those of least square for a given slope of one angle, and for a given value. Their bounds depend on where the loops
are cut into halves: a box is tried first with the best cuts of the box that it is a part of, then with others.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Flags, Reals, WholeNumbers
from hcsearch.kernels.algebra import factor_symmetric, solve_factored
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.combinations import (
    COMBINATION_LANE_COUNT,
    Combinations,
    add_shares,
    combine_equations,
    new_combinations,
    solve_combinations,
    weigh_equations,
)
from hcsearch.kernels.enclosure.expansion import (
    Expansion,
    HingeRings,
    bound_third_order,
    cut_loops,
    expand_closure,
    keep_cuts,
    new_expansion,
    write_first_order,
)

MIN_REPEAT_GAIN_SHARE = 0.1
"""Least relative decrease of a box for a third contraction."""
MIN_FIRST_GAIN_SHARE = 0.01
"""Least relative decrease of a box by the first combinations for which the others are used, too."""
MAX_CONTRACTION_SWEEPS = 3
"""Greatest number of contractions of a box."""
ALTERNATIVE_CUT_COUNT = 3
"""Number of alternative cuts of the loops that take turns beside the initial one of a box."""
BOUND_PADDING = 1e-14
"""Outward shift (rad) of contracted bounds: a quotient of numbers up to 4 is rounded by less."""
MIN_COMBINATION_SLOPE = 1e-9
"""A combination is used to bound only angles of which its slope is at least this."""


class Contraction(NamedTuple):
    """Work tables of a contraction.

    middles, radii, shares : (n,), of a box, and the contribution of each angle to its undecided part. slope_minima,
    slope_maxima : (n,), of each slope term of a combination. cuts : (n_loops, 2), where the loops are cut with the best
    result, and best_shares : (n,), the shares with these. cut_trial_count : (1,), how often other cuts were tried.
    """

    expansion: Expansion
    combinations: Combinations
    middles: Reals
    radii: Reals
    shares: Reals
    slope_minima: Reals
    slope_maxima: Reals
    cuts: WholeNumbers
    best_shares: Reals
    cut_trial_count: WholeNumbers


@compiled
def new_contraction(rings: HingeRings) -> Contraction:
    """Return empty tables."""
    n, expansion = rings.hinge_count, new_expansion(rings)
    return Contraction(
        expansion,
        new_combinations(rings, expansion),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        expansion.cuts.copy(),
        np.zeros(n),
        np.zeros(1, np.int64),
    )


@compiled
def contract_box(rings: HingeRings, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box, (n,) each, onto its closed states; return False where it is proved to hold none.

    Loops are cut at `work.expansion.cuts` at first; afterwards that holds the best cuts.
    """
    n, best_known, shrunk = len(low), -1.0, False
    keep_cuts(work.expansion.cuts, work.cuts)
    _centre(low, high, work)
    for h in range(n):
        work.best_shares[h] = work.radii[h]
    for sweep in range(MAX_CONTRACTION_SWEEPS):
        if sweep > 1 and not shrunk:
            break
        if sweep > 0 and not _cut_otherwise(rings, work) and not shrunk:
            continue
        expand_closure(rings, work.middles, work.radii, work.expansion)
        if not weigh_equations(work.radii, work.expansion, work.combinations):
            continue
        before = after = _width(low, high)
        for first in range(0, n + 1, COMBINATION_LANE_COUNT):
            if not _use(rings, first, low, high, work):
                return False
            known = _known(work) if first == 0 else -1.0
            if known > best_known:
                best_known = known
                keep_cuts(work.expansion.cuts, work.cuts)
                for h in range(n):
                    work.best_shares[h] = work.shares[h]
            after = _width(low, high)
            if after > (1.0 - MIN_FIRST_GAIN_SHARE) * before:
                break
        shrunk = after < (1.0 - MIN_REPEAT_GAIN_SHARE) * before
        _centre(low, high, work)
    keep_cuts(work.cuts, work.expansion.cuts)
    for h in range(n):
        work.shares[h] = work.best_shares[h]
    return True


@compiled
def _centre(low: Reals, high: Reals, work: Contraction) -> None:
    """Write the middles and radii of a box."""
    for h in range(len(low)):
        work.middles[h] = 0.5 * (low[h] + high[h])
        work.radii[h] = 0.5 * (high[h] - low[h]) * (1.0 + 1e-15) + 1e-15


@compiled
def _width(low: Reals, high: Reals) -> float:
    """The sum of the sides of a box."""
    total = 0.0
    for h in range(len(low)):
        total += high[h] - low[h]
    return total


@compiled
def _cut_otherwise(rings: HingeRings, work: Contraction) -> bool:
    """Cut the loops in the next alternative way; return whether that differs from the best cuts."""
    cuts, differs = work.expansion.cuts, False
    cut_loops(rings, work.radii, work.cut_trial_count[0] % ALTERNATIVE_CUT_COUNT, cuts)
    work.cut_trial_count[0] += 1
    for loop in range(len(cuts)):
        differs = differs or cuts[loop, 0] != work.cuts[loop, 0] or cuts[loop, 1] != work.cuts[loop, 1]
    return differs


@compiled
def _known(work: Contraction) -> float:
    """The first combination's value in the middle of a box, relative to its greatest change in the box."""
    combinations = work.combinations
    differs = combinations.errors[0]
    for h in range(len(work.radii)):
        differs += abs(combinations.coefficients[h, 0]) * work.radii[h]
    return abs(combinations.values[0]) / differs if differs > 0.0 else 0.0


@compiled
def _use(rings: HingeRings, first: int, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box by some combinations, number 0 that of the values; return False where one excludes all of it."""
    n, combinations = len(low), work.combinations
    last = min(n + 1 - first, COMBINATION_LANE_COUNT)
    for i in range(len(combinations.weights)):
        for c in range(COMBINATION_LANE_COUNT):
            combinations.weights[i, c] = 0.0
        for c in range(last):
            combinations.weights[i, c] = (
                work.expansion.slopes[i, first + c - 1] if first + c > 0 else combinations.centred[i]
            )
    solve_combinations(combinations)
    _scale(combinations)
    combine_equations(work.radii, work.expansion, combinations)
    if first == 0:
        _refine(rings, work)
        for h in range(n):
            work.shares[h] = abs(combinations.coefficients[h, 0]) * work.radii[h]
        add_shares(work.radii, work.expansion, work.shares, combinations)
    for c in range(last):
        h = first + c - 1
        if (h < 0 or high[h] - low[h] > BOUND_PADDING) and not _bound(c, low, high, work):
            return False
    return True


@compiled
def _refine(rings: HingeRings, work: Contraction) -> None:
    """Bound the third order of the first combination term by term."""
    combinations = work.combinations
    gain = combinations.third_orders[0] - bound_third_order(
        work.radii, rings.hinges, work.expansion, combinations.weights
    )
    if gain > 0.0:
        combinations.third_orders[0] -= gain
        combinations.errors[0] -= gain


@compiled
def _scale(combinations: Combinations) -> None:
    """Scale the greatest entry of each combination to 1; one that is not finite becomes 0 and bounds nothing."""
    greatest = combinations.sums[0]
    for c in range(COMBINATION_LANE_COUNT):
        greatest[c] = 0.0
    for i in range(len(combinations.weights)):
        for c in range(COMBINATION_LANE_COUNT):
            greatest[c] = max(greatest[c], abs(combinations.weights[i, c]))
    for c in range(COMBINATION_LANE_COUNT):
        if 0.0 < greatest[c] < math.inf:
            greatest[c] = 1.0 / greatest[c]
        else:
            greatest[c] = 0.0
            for i in range(len(combinations.weights)):
                combinations.weights[i, c] = 0.0
    for i in range(len(combinations.weights)):
        for c in range(COMBINATION_LANE_COUNT):
            combinations.weights[i, c] *= greatest[c]


@compiled
def _bound(c: int, low: Reals, high: Reals, work: Contraction) -> bool:
    """Contract a box by one combination; return False where it excludes all of the box."""
    combinations, n = work.combinations, len(low)
    value, error = combinations.values[c], combinations.errors[c]
    sizes = abs(value) + error
    below, above = value - error, value + error
    for h in range(n):
        slope = combinations.coefficients[h, c]
        x, y = slope * (low[h] - work.middles[h]), slope * (high[h] - work.middles[h])
        work.slope_minima[h], work.slope_maxima[h] = min(x, y), max(x, y)
        below += work.slope_minima[h]
        above += work.slope_maxima[h]
        sizes += abs(x) + abs(y)
    rounding = 4e-16 * (n + 4) * sizes
    below -= rounding
    above += rounding
    if below > 0.0 or above < 0.0:
        return False
    for h in range(n):
        slope = combinations.coefficients[h, c]
        if abs(slope) < MIN_COMBINATION_SLOPE:
            continue
        first, second = -(above - work.slope_maxima[h]) / slope, -(below - work.slope_minima[h]) / slope
        new_low = max(low[h], work.middles[h] + min(first, second) - BOUND_PADDING)
        new_high = min(high[h], work.middles[h] + max(first, second) + BOUND_PADDING)
        if new_low > new_high:
            return False
        low[h], high[h] = new_low, new_high
    return True


MAX_NEWTON_STEPS = 20
"""Greatest number of steps; most closed states are reached in seven."""
NEWTON_RESIDUAL = 1e-7
"""Residual norm of the equations at a closed state."""
STALL_STEP_COUNT, STALL_RESIDUAL_SHARE = 5, 0.5
"""Newton's method is given up where this many steps leave more than this share of the residual."""


class Newton(NamedTuple):
    """Normal equations, (n, n) each: of all angles, and of those that are not held at an edge of the box.

    right, step, edge : (n,), the right side, the step, and the step to the edge. held : (n,).
    """

    normal: Reals
    free: Reals
    right: Reals
    step: Reals
    edge: Reals
    held: Flags


@compiled
def new_newton(rings: HingeRings) -> Newton:
    """Return empty tables."""
    n = rings.hinge_count
    tables, lists = (np.zeros((n, n)), np.zeros((n, n))), (np.zeros(n), np.zeros(n), np.zeros(n))
    return Newton(tables[0], tables[1], lists[0], lists[1], lists[2], np.zeros(n, np.bool_))


@compiled
def close_within_box(
    rings: HingeRings, low: Reals, high: Reals, state: Reals, expansion: Expansion, work: Newton
) -> float:
    """Move a state to a closed one within a box, (n,) each; return the residual norm there."""
    residual, before = math.inf, math.inf
    for step in range(MAX_NEWTON_STEPS):
        write_first_order(rings, state, expansion)
        total = 0.0
        for i in range(len(expansion.values)):
            total += expansion.values[i] * expansion.values[i]
        residual = math.sqrt(total)
        if residual < NEWTON_RESIDUAL:
            break
        if step % STALL_STEP_COUNT == 0:
            if residual > STALL_RESIDUAL_SHARE * before:
                break
            before = residual
        _write_normal(1e-3 * residual + 1e-12, expansion, work)
        if not _write_step(low, high, state, work):
            break
        moved = 0.0
        for h in range(len(state)):
            state[h] = min(max(state[h] + work.step[h], low[h]), high[h])
            moved = max(moved, abs(work.step[h]))
        if moved < 1e-10:
            break
    return residual


@compiled
def _write_normal(damping: float, expansion: Expansion, work: Newton) -> None:
    """Write the normal equations of a step."""
    r, n = expansion.slopes.shape
    for h in range(n):
        work.right[h] = 0.0
        for k in range(n):
            work.normal[h, k] = 0.0
    for i in range(r):
        for h in range(n):
            slope = expansion.slopes[i, h]
            if slope != 0.0:
                work.right[h] -= slope * expansion.values[i]
                for k in range(n):
                    work.normal[h, k] += slope * expansion.slopes[i, k]
    for h in range(n):
        work.normal[h, h] += damping


@compiled
def _write_step(low: Reals, high: Reals, state: Reals, work: Newton) -> bool:
    """Write a step that ends within the bounds; return whether there is one.

    Angles that would leave the bounds end there, and the others are computed without them.
    """
    n, held, edge, free, step = len(state), work.held, work.edge, work.free, work.step
    for h in range(n):
        held[h] = False
    within = False
    while not within:
        for h in range(n):
            step[h] = edge[h] if held[h] else work.right[h]
            for k in range(n):
                if held[h] or held[k]:
                    free[h, k] = 1.0 if h == k else 0.0
                    if held[k] and not held[h]:
                        step[h] -= work.normal[h, k] * edge[k]
                else:
                    free[h, k] = work.normal[h, k]
        if not factor_symmetric(free, 0.0):
            return False
        solve_factored(free, step)
        within = True
        for h in range(n):
            if not held[h] and not low[h] <= state[h] + step[h] <= high[h]:
                edge[h] = (low[h] if step[h] < 0.0 else high[h]) - state[h]
                held[h], within = True, False
    return True
