"""The third order of a combination of the equations of closure in a box, term by term, with the fourth order bounded.

The third order of a half is the sum over i <= j <= k of d_i d_j d_k K_i K_j K_k, the bends of j and k turned by i. This
bounds it two to three times as narrowly as the sum of all radii does, and takes longer.
"""

from __future__ import annotations

import math

from hcsearch.basics.arrays import Reals, WholeNumbers
from hcsearch.kernels.algebra.vectors import Vector3, cross, dot, vector_at, vector_sum
from hcsearch.kernels.compiling.compiled import lean
from hcsearch.kernels.enclosure.expansion import EQUATIONS_PER_LOOP, Expansion


@lean
def bound_third_order(radii: Reals, hinges: WholeNumbers, own: Expansion, mixes: Reals) -> float:
    """What third and higher orders of the first combination, a column of (r, m), come to at most but for rounding.

    radii : (n,), of the box. hinges : (k,), of `Rings`. With the bend of j and k as columns b, and the combination's
    entries for them as columns y, y . (a_i x b) = a_i . (b x y). Twice the same hinge has half the weight, thrice a
    sixth, of which a bend with itself has a half already.
    """
    total, q = 0.0, 0
    for half in range(len(own.ends) - 1):
        row, first, end = EQUATIONS_PER_LOOP * (half // 2), own.ends[half], own.ends[half + 1]
        for j in range(first, end):
            one = radii[hinges[own.steps[j]]]
            for k in range(j, end):
                way = _turned(row, q, own, mixes)
                size = (0.5 if j < k else 1.0 / 3.0) * one * abs(dot(vector_at(own.axes, j, 0), way))
                for i in range(first, j):
                    size += radii[hinges[own.steps[i]]] * abs(dot(vector_at(own.axes, i, 0), way))
                total += one * radii[hinges[own.steps[k]]] * size
                q += 1
    for loop in range(len(own.fourths)):
        turns = shifts = 0.0
        for i in range(EQUATIONS_PER_LOOP * loop, EQUATIONS_PER_LOOP * loop + 9):
            turns += mixes[i, 0] * mixes[i, 0]
        for i in range(EQUATIONS_PER_LOOP * loop + 9, EQUATIONS_PER_LOOP * loop + 12):
            shifts += mixes[i, 0] * mixes[i, 0]
        total += math.sqrt(2.0 * turns) * own.fourths[loop, 0] + math.sqrt(shifts) * own.fourths[loop, 1]
    return total * (1.0 + 1e-12)


@lean
def _turned(row: int, q: int, own: Expansion, mixes: Reals) -> Vector3:
    """The sum of cross products of the columns of a bend with those of the first combination."""
    bend = own.bends[q]
    way = cross((bend[9], bend[10], bend[11]), (mixes[row + 9, 0], mixes[row + 10, 0], mixes[row + 11, 0]))
    for s in range(3):
        column = bend[s], bend[3 + s], bend[6 + s]
        way = vector_sum(way, cross(column, (mixes[row + s, 0], mixes[row + 3 + s, 0], mixes[row + 6 + s, 0])))
    return way
