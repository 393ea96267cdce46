"""Exact checks, in whole numbers, of proofs that an end of the motion is locked.

Least squares and linear programs find a wrench in floating point (`end_locks`). Here it is checked with the screws of
`lattice`. At first order its powers must be positive, which small errors do not change. At second order it must have
no power at all on hinges that can turn: its free entries are kept, and the others are solved for. The rays of
K = {x >= 0, A x = 0, C x >= 0} are computed anew by double description (Motzkin et al. 1953), so that none is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import gcd, lcm

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.motion.locks.lattice import ExactArray, WholeEnd, reduced_rows

Ray = tuple[int, ...]


def proves_first_order(end: WholeEnd, rows: ExactArray, wrench: Reals, forces: Reals) -> bool:
    """Whether a wrench, with forces f >= 0 at contacts, loads every hinge: y . A_i > sum of f_k C_ki, exactly.

    rows : contacts in whole numbers, shape (k, n_hinges). wrench, forces : as in `end_locks.LockVerdict`, for these
    contacts.
    """
    pushes = end.force(forces)
    powers = end.columns @ end.wrench(wrench) - rows.T @ pushes
    return bool((pushes >= 0).all() and (powers > 0).all())


def proves_second_order(end: WholeEnd, rows: ExactArray, wrench: Reals) -> bool:
    """Whether a wrench near a given one excludes at second order all motions that are possible at first order.

    Its powers are not negative, and y . b is positive on K except at 0: for sums of rays r it has the form
    sum s_i s_j y . b_ij, which is positive where every y . b_ii outweighs the negative y . b_ij of its row.
    """
    rays = extreme_rays(_equations(end.columns, rows))
    if not rays:  # nothing turns even at first order
        return True
    turns: ExactArray = np.array(rays, object)[:, : len(end.columns)]
    turning = turns.any(axis=0).astype(bool)
    exact = _powerless(end.columns[turning], end.wrench(wrench))
    if not (end.columns @ exact >= 0).all():
        return False
    return has_dominant_diagonal(turns @ end.bends(exact) @ turns.T, [int(total) for total in turns.sum(axis=1)])


def _equations(columns: ExactArray, rows: ExactArray) -> list[list[int]]:
    """The equations A x = 0, and C x - s = 0 with s >= 0, the speeds at which contacts part."""
    n, k = len(columns), len(rows)
    slack: ExactArray = -np.eye(k, dtype=np.int64).astype(object)
    closure = np.concatenate([columns.T, np.zeros((columns.shape[1], k), object)], axis=1)
    parting = np.concatenate([rows.reshape(k, n), slack], axis=1)
    equations: list[list[int]] = np.concatenate([closure, parting]).tolist()
    return equations


def extreme_rays(equations: Sequence[Sequence[int]]) -> list[Ray]:
    """All extreme rays, in lowest terms, of the cone of x >= 0 that satisfy whole equations, shape (k, n).

    The equations are added one after the other, first those that make fewest new rays. Two rays on different sides of
    one make a new ray where they span a face of two dimensions: no third has its zeros wherever both have.
    """
    n = len(equations[0]) if equations else 0
    rays: list[Ray] = [tuple(int(i == k) for i in range(n)) for k in range(n)]
    supports = [1 << k for k in range(n)]
    remaining = [[(i, value) for i, value in enumerate(equation) if value] for equation in equations]
    added = 0
    while remaining:
        values = [[sum([value * ray[i] for i, value in terms]) for ray in rays] for terms in remaining]
        pairs = [sum([value > 0 for value in row]) * sum([value < 0 for value in row]) for row in values]
        first = pairs.index(min(pairs))
        del remaining[first]
        if any(values[first]):
            rays, supports = _add_equation(rays, supports, values[first], added)
            added += 1
    return rays


def _add_equation(rays: list[Ray], supports: list[int], values: list[int], added: int) -> tuple[list[Ray], list[int]]:
    """Rays and their supports after one more equation, given its values on the rays."""
    unchanged = [k for k, value in enumerate(values) if not value]
    new_rays, new_supports = [rays[k] for k in unchanged], [supports[k] for k in unchanged]
    above, below = ([k for k, value in enumerate(values) if sign * value > 0] for sign in (1, -1))
    for p in above:
        for q in below:
            joint = supports[p] | supports[q]
            # a face of two dimensions has at most two entries more than equations that were added
            if joint.bit_count() > added + 2 or not _spans_face(joint, supports):
                continue
            ray = [b * values[p] - a * values[q] for a, b in zip(rays[p], rays[q], strict=True)]
            divisor = gcd(*ray)
            new_rays.append(tuple([value // divisor for value in ray]))
            new_supports.append(joint)
    return new_rays, new_supports


def _spans_face(joint: int, supports: list[int]) -> bool:
    """Whether at most two of the rays lie in the face of a support."""
    inside = 0
    for support in supports:
        if support | joint == joint:
            inside += 1
            if inside > 2:
                return False
    return True


def _powerless(columns: ExactArray, wrench: ExactArray) -> ExactArray:
    """A whole wrench near a given one, up to a positive factor, that has no power on some screws, shape (k, n_rows).

    By Gauss's elimination; entries without a pivot are kept.
    """
    pivots = reduced_rows(columns)
    entries = _whole(wrench)
    multiple = lcm(*(pivot[column] for column, pivot in pivots.items()))
    powers = {
        column: sum(a * b for i, (a, b) in enumerate(zip(pivot, entries, strict=True)) if i not in pivots)
        for column, pivot in pivots.items()
    }
    exact = [value * multiple for value in entries]
    for column, pivot in pivots.items():
        exact[column] = -powers[column] * (multiple // pivot[column])
    return np.array(exact, object)


def _whole(fractions: ExactArray) -> list[int]:
    """The least positive multiple of fractions that is whole."""
    denominator = lcm(*(value.denominator for value in fractions))
    return [value.numerator * (denominator // value.denominator) for value in fractions]


def has_dominant_diagonal(form: ExactArray, sizes: Sequence[int]) -> bool:
    """Whether the diagonal of a whole symmetric form, shape (m, m), outweighs the negative entries of its rows.

    Then it is strictly copositive: with x = t / sizes >= 0 and q_ij = form_ij / (sizes_i sizes_j) its value is at least
    the sum over i of (q_ii - sum of |q_ij| over negative ones) t_i^2, as 2 t_i t_j <= t_i^2 + t_j^2.
    """
    for i, row in enumerate(form.tolist()):
        negative = sum((Fraction(-value, sizes[j]) for j, value in enumerate(row) if value < 0 and j != i), Fraction(0))
        if not Fraction(row[i], sizes[i]) > negative:
            return False
    return True
