"""Proofs that two panels overlap at all closed states of a box: a segment of one pierces the other throughout.

A segment pierces a prism where its ends are above and below the outline of the prism at some height, and it passes
through that outline. Two convex prisms that overlap nearly always are pierced by some segment between a few points.

The heights of both ends of a segment, and the distances of their projections inside each side of an outline, are
expanded to second order about the middle of the box, with the third order bounded, as closure is. Since only closed
states count, each is combined with the closure equations so that the least remains unknown (docs/explanation/locks.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import Vector3, cross, dot, put_vector, scaled_vector, vector_at, vector_difference
from hcsearch.kernels.compiling.compiled import compiled
from hcsearch.kernels.enclosure.combinations import add_shares, combine_equations, solve_combinations, weigh_equations
from hcsearch.kernels.enclosure.contraction import Contraction
from hcsearch.kernels.enclosure.expansion import HALF_POSE_ROUNDING, HingeRings, expand_closure
from hcsearch.kernels.enclosure.plates import FacetView, Plates, new_facet_view, view_facet, viewed_point


class Piercings(NamedTuple):
    """The deepest piercings at a state.

    Row 2 p is of the first facet of pair p by a segment of the second, row 2 p + 1 of the second by the first.
    depths : (2 p,), 0 without. ends : (2 p, 2), samples, the upper one first. heights : (2 p,), of the outline.
    places : (s, 3), samples in the frame of the facet, and within : (s, k), distance of each inside each side.
    """

    depths: Reals
    ends: WholeNumbers
    heights: Reals
    places: Reals
    within: Reals


@compiled
def new_piercings(plates: Plates) -> Piercings:
    """Return empty tables."""
    rows, s, k = 2 * len(plates.pairs), plates.samples.shape[1], plates.sides.shape[1]
    return Piercings(np.zeros(rows), np.zeros((rows, 2), np.int64), np.zeros(rows), np.zeros((s, 3)), np.zeros((s, k)))


@compiled
def write_piercings(plates: Plates, angles: Reals, radii: Reals, sight: FacetView, work: Piercings) -> float:
    """Write the deepest piercing of each pair at a state, (n,); return the greatest depth.

    radii : (n,), of a box about the state, by which the paths between panels are chosen.
    """
    deepest = 0.0
    for p in range(len(plates.pairs)):
        work.depths[2 * p] = work.depths[2 * p + 1] = 0.0
        for order in range(2):
            view_facet(plates, p, order, angles, radii, sight)
            facet, other = plates.pairs[p, order], plates.pairs[p, 1 - order]
            if not _near(plates, facet, other, sight, work):
                break
            row = 2 * p + order
            work.depths[row] = _deepest(plates, facet, other, row, work)
            deepest = max(deepest, work.depths[row])
    return deepest


@compiled
def _near(plates: Plates, facet: int, other: int, sight: FacetView, work: Piercings) -> bool:
    """Whether the balls about two facets meet and their heights overlap; writes the samples of the second."""
    away = vector_difference(viewed_point(sight, plates.middles, other), vector_at(plates.middles, facet, 0))
    reach = plates.reaches[facet] + plates.reaches[other]
    if dot(away, away) > reach * reach:
        return False
    lowest, highest = math.inf, -math.inf
    for i in range(plates.counts[other, 0]):
        place = viewed_point(sight, plates.samples[other], i)
        put_vector(work.places, i, 0, place)
        lowest, highest = min(lowest, place[2]), max(highest, place[2])
    low, high = plates.levels[facet]
    meets: bool = lowest < high and highest > low
    return meets


@compiled
def _deepest(plates: Plates, facet: int, other: int, row: int, work: Piercings) -> float:
    """Write the deepest piercing of a facet by segments of another one; return its depth, 0 without one.

    The depth is the distance by which either may be moved along the normals of the outline, or upright, and still
    pierces.
    """
    low, high = plates.levels[facet]
    sides = plates.counts[facet, 2]
    for i in range(plates.counts[other, 0]):
        x, y = work.places[i, 0], work.places[i, 1]
        for k in range(sides):
            work.within[i, k] = (
                plates.sides[facet, k, 2] - plates.sides[facet, k, 0] * x - plates.sides[facet, k, 1] * y
            )
    best = 0.0
    for q in range(plates.counts[other, 1]):
        i, j = plates.segments[other, q]
        if work.places[i, 2] < work.places[j, 2]:
            i, j = j, i
        up, down = work.places[i, 2], work.places[j, 2]
        height = min(max(0.5 * (up + down), low), high)
        above, below = up - height, height - down
        depth = min(above, below)
        if depth <= best:
            continue
        along = vector_difference(vector_at(work.places, i, 0), vector_at(work.places, j, 0))
        factor = 1.0 / math.sqrt(dot(along, along))
        for k in range(sides):
            depth = min(depth, factor * (below * work.within[i, k] + above * work.within[j, k]))
            if depth <= best:
                break
        if depth > best:
            best = depth
            work.ends[row, 0], work.ends[row, 1], work.heights[row] = i, j, height
    return best


OVERLAP_NONE, OVERLAP_AT_MIDDLE, OVERLAP_THROUGHOUT = 0, 1, 2
"""Result for a box: no overlap is known at its middle; panels overlap there; they overlap in all of the box, proved."""
MAX_TESTED_PIERCINGS = 3
"""Greatest number of piercings that are tested in a box, the deepest first."""
CLEAR_PIERCING_DEPTH = 1e-5
"""Piercing depth, in sizes of the pattern, up to which panels count as clear."""
TRACE_UPPER, TRACE_LOWER, TRACE_CROSSING, TRACE_ALONG = 0, 1, 2, 3
"""Rows of traced points: both ends of a segment, its crossing of the outline at the middle, and the vector between."""
FORM_HEIGHT, FORM_RISE, FORM_INSIDE, FORM_LEAN, FORM_IN_UPPER, FORM_IN_LOWER = 2, 3, 4, 5, 6, 7
"""Rows of forms after the heights of the ends above and below the outline: the height of the crossing above the
outline, the rise from the lower to the upper end; and, of a side, the distance of the crossing inside it, the lean
of the segment, and the distances of both ends inside it."""


class Overlaps(NamedTuple):
    """Work tables of the test of boxes.

    levers : (4, n, 3), of the traced points, velocities by the hinges between. bends : (4, q, 3), by two of these,
    times their radii. rests : (4,), bounds of third orders. rounding : (4,). forms : (8, n), values, errors, spreads :
    (8,), functions value + form . d + error of offsets d, and the greatest value of the form. slopes : (n,), of a
    combination. shares : (n,), contribution of each angle to its unknown part; kept_shares : (n,), those of the deepest
    piercing.
    """

    plates: Plates
    sight: FacetView
    piercings: Piercings
    levers: Reals
    bends: Reals
    rests: Reals
    rounding: Reals
    forms: Reals
    values: Reals
    errors: Reals
    spreads: Reals
    slopes: Reals
    shares: Reals
    kept_shares: Reals


@compiled
def new_overlaps(rings: HingeRings, plates: Plates) -> Overlaps:
    """Return empty tables."""
    n = rings.hinge_count
    return Overlaps(
        plates,
        new_facet_view(n),
        new_piercings(plates),
        np.zeros((4, n, 3)),
        np.zeros((4, n * (n + 1) // 2, 3)),
        np.zeros(4),
        np.zeros(4),
        np.zeros((8, n)),
        np.zeros(8),
        np.zeros(8),
        np.zeros(8),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
    )


@compiled
def clear_at(state: Reals, work: Overlaps) -> bool:
    """Whether no panels are known to overlap at a state, (n,)."""
    if len(work.plates.pairs) == 0:
        return True
    for h in range(len(state)):
        work.slopes[h] = 0.0
    return write_piercings(work.plates, state, work.slopes, work.sight, work.piercings) < CLEAR_PIERCING_DEPTH


@compiled
def overlap_in_box(rings: HingeRings, low: Reals, high: Reals, closure: Contraction, work: Overlaps) -> int:
    """Return NONE, AT_MIDDLE or THROUGHOUT for the closed states of a box, (n,); AT_MIDDLE writes `kept_shares`."""
    if len(work.plates.pairs) == 0:
        return OVERLAP_NONE
    middles, radii, depths = closure.middles, closure.radii, work.piercings.depths
    for h in range(len(low)):
        middles[h] = 0.5 * (low[h] + high[h])
        radii[h] = 0.5 * (high[h] - low[h]) * (1.0 + 1e-15) + 1e-15
    if write_piercings(work.plates, middles, radii, work.sight, work.piercings) <= 0.0:
        return OVERLAP_NONE
    expand_closure(rings, middles, radii, closure.expansion)
    if not weigh_equations(radii, closure.expansion, closure.combinations):
        return OVERLAP_NONE
    for k in range(MAX_TESTED_PIERCINGS):
        row = 0
        for candidate in range(len(depths)):
            if depths[candidate] > depths[row]:
                row = candidate
        if depths[row] <= 0.0:
            break
        if _lasts(row, middles, radii, closure, work):
            return OVERLAP_THROUGHOUT
        depths[row] = 0.0
        for h in range(len(low) if k == 0 else 0):
            work.kept_shares[h] = work.shares[h]
    return OVERLAP_AT_MIDDLE


@compiled
def _lasts(row: int, middles: Reals, radii: Reals, closure: Contraction, work: Overlaps) -> bool:
    """Whether a piercing lasts in all of a box; if not, `shares` are those of the condition that fails."""
    plates, pair, order = work.plates, row // 2, row % 2
    facet, other = plates.pairs[pair, order], plates.pairs[pair, 1 - order]
    view_facet(plates, pair, order, middles, radii, work.sight)
    ends, height = work.piercings.ends[row], work.piercings.heights[row]
    upper = viewed_point(work.sight, plates.samples[other], ends[0])
    lower = viewed_point(work.sight, plates.samples[other], ends[1])
    along = vector_difference(upper, lower)
    crossing = vector_difference(upper, scaled_vector((upper[2] - height) / along[2], along))
    _trace(TRACE_UPPER, upper, 1.0, radii, work)
    _trace(TRACE_LOWER, lower, 1.0, radii, work)
    _form(TRACE_UPPER, TRACE_UPPER, (0.0, 0.0, 1.0), upper[2] - height, radii, work)
    _form(TRACE_LOWER, TRACE_LOWER, (0.0, 0.0, -1.0), height - lower[2], radii, work)
    for end in (TRACE_UPPER, TRACE_LOWER):
        for h in range(len(radii)):
            work.slopes[h] = work.forms[end, h]
        if not _positive(work.values[end], work.errors[end], radii, closure, work):
            return False
    _trace(TRACE_CROSSING, crossing, 1.0, radii, work)
    _trace(TRACE_ALONG, along, 0.0, radii, work)
    _form(TRACE_CROSSING, FORM_HEIGHT, (0.0, 0.0, 1.0), crossing[2] - height, radii, work)
    _form(TRACE_ALONG, FORM_RISE, (0.0, 0.0, 1.0), along[2], radii, work)
    for side in range(plates.counts[facet, 2]):
        x, y, far = plates.sides[facet, side]
        _form(TRACE_UPPER, FORM_IN_UPPER, (-x, -y, 0.0), far - x * upper[0] - y * upper[1], radii, work)
        _form(TRACE_LOWER, FORM_IN_LOWER, (-x, -y, 0.0), far - x * lower[0] - y * lower[1], radii, work)
        if _least(FORM_IN_UPPER, work) > 0.0 and _least(FORM_IN_LOWER, work) > 0.0:
            continue
        _form(TRACE_CROSSING, FORM_INSIDE, (-x, -y, 0.0), far - x * crossing[0] - y * crossing[1], radii, work)
        _form(TRACE_ALONG, FORM_LEAN, (x, y, 0.0), x * along[0] + y * along[1], radii, work)
        value, error = _crossing(work)
        if not _positive(value, error, radii, closure, work):
            return False
    return True


@compiled
def _trace(traced: int, place: Vector3, point: float, radii: Reals, work: Overlaps) -> None:
    """Write how a traced point moves in a box: levers, bends, and bounds of the remainder (locks.md, 2).

    point : 1; 0 for a vector between two points, which does not depend on the places of hinges.
    """
    sight, levers = work.sight, work.levers[traced]
    m, displacement, total, rest = sight.length[0], 0.0, 0.0, 0.0
    far = math.sqrt(dot(place, place))
    for k in range(m):
        total += radii[sight.steps[k]]
    remaining = total
    for k in range(m - 1, -1, -1):
        arm = vector_difference(place, scaled_vector(point, vector_at(sight.places, k, 0)))
        radius, lever = radii[sight.steps[k]], cross(vector_at(sight.axes, k, 0), arm)
        put_vector(levers, k, 0, lever)
        reach = math.sqrt(dot(lever, lever)) + displacement
        far = max(far, reach)
        displacement += radius * reach
        next_remaining = max(remaining - radius, 0.0)
        rest += reach * (remaining * remaining * remaining - next_remaining * next_remaining * next_remaining)
        remaining = next_remaining
    work.rests[traced] = rest / 6.0 * (1.0 + 1e-12)
    work.rounding[traced] = HALF_POSE_ROUNDING * (m + 1) * (1.0 + 2.0 * far) * (1.0 + total * (1.0 + total))
    q = 0
    for i in range(m):
        axis, radius = vector_at(sight.axes, i, 0), radii[sight.steps[i]]
        for j in range(i, m):
            size = radius * radii[sight.steps[j]] * (0.5 if i == j else 1.0)
            put_vector(work.bends[traced], q, 0, scaled_vector(size, cross(axis, vector_at(levers, j, 0))))
            q += 1


@compiled
def _form(traced: int, row: int, normal: Vector3, value: float, radii: Reals, work: Overlaps) -> None:
    """Write the value at the middle of a box plus the motion of a traced point along a unit vector, as a form."""
    m, q, spread = work.sight.length[0], 0, 0.0
    error = work.rests[traced] + work.rounding[traced]
    for h in range(len(radii)):
        work.forms[row, h] = 0.0
    for k in range(m):
        h, slope = work.sight.steps[k], dot(normal, vector_at(work.levers[traced], k, 0))
        work.forms[row, h] = slope
        spread += abs(slope) * radii[h]
    for i in range(m):
        for j in range(i, m):
            bend = dot(normal, vector_at(work.bends[traced], q, 0))
            if i == j:  # a square lies between 0 and its greatest value
                bend *= 0.5
                value += bend
            error += abs(bend)
            q += 1
    work.values[row], work.errors[row], work.spreads[row] = value, error, spread


@compiled
def _least(row: int, work: Overlaps) -> float:
    """The lower bound of a form in a box."""
    bound: float = work.values[row] - (work.errors[row] + work.spreads[row]) * (1.0 + 1e-12) - 1e-14
    return bound


@compiled
def _crossing(work: Overlaps) -> tuple[float, float]:
    """Write the slopes of the crossing's distance inside a side, times the segment's rise; return its value and error.

    That is the rise times the distance of the crossing inside, plus the height of the crossing times the segment's
    lean.
    """
    value = error = sizes = 0.0
    for h in range(len(work.slopes)):
        work.slopes[h] = 0.0
    for first, second in ((FORM_RISE, FORM_INSIDE), (FORM_HEIGHT, FORM_LEAN)):
        a, b, s, t = work.values[first], work.values[second], work.spreads[first], work.spreads[second]
        value += a * b
        error += s * t + work.errors[first] * (abs(b) + t + work.errors[second]) + work.errors[second] * (abs(a) + s)
        sizes += (abs(a) + s) * (abs(b) + t)
        for h in range(len(work.slopes)):
            work.slopes[h] += a * work.forms[second, h] + b * work.forms[first, h]
    return value, error * (1.0 + 1e-12) + 1e-14 * sizes


@compiled
def _positive(value: float, error: float, radii: Reals, closure: Contraction, work: Overlaps) -> bool:
    """Whether value + slopes . d exceeds an error at all closed states of a box; if not, write `shares`.

    A combination of the closure equations, which is 0 there, is added: that of the least sum of squares of all terms.
    """
    n, shares, combinations = len(radii), work.shares, closure.combinations
    low, sizes = value - error, abs(value) + error
    for h in range(n):
        shares[h] = abs(work.slopes[h]) * radii[h]
        low -= shares[h]
        sizes += shares[h]
    if low > 4e-16 * (n + 4) * sizes:
        return True
    for i in range(len(combinations.weights)):
        combinations.weights[i] = 0.0
        for h in range(n):
            combinations.weights[i, 0] -= combinations.weighted[h, i] * work.slopes[h]
    solve_combinations(combinations)
    combine_equations(radii, closure.expansion, combinations)
    if not combinations.errors[0] < math.inf:
        return False
    low = value + combinations.values[0] - error - combinations.errors[0]
    sizes += abs(combinations.values[0]) + combinations.errors[0]
    for h in range(n):
        sizes += abs(combinations.coefficients[h, 0]) * radii[h]
        shares[h] = abs(work.slopes[h] + combinations.coefficients[h, 0]) * radii[h]
        low -= shares[h]
    add_shares(radii, closure.expansion, shares, combinations)
    return bool(low > 4e-16 * (n + 4) * sizes)
