"""Gaps of many pairs of hulls in one call, so that their time can be measured."""

from __future__ import annotations

from hcsearch.basics.array_values import Reals, WholeNumbers
from hcsearch.kernels.algebra import vector_at
from hcsearch.kernels.collision.gjk import hull_gap
from hcsearch.kernels.compiling.compiled import compiled


@compiled
def write_hull_gaps(
    first: Reals,
    n_first: WholeNumbers,
    second: Reals,
    n_second: WholeNumbers,
    directions: Reals,
    corners: WholeNumbers,
    gaps: Reals,
) -> None:
    """Write the gaps of pairs of hulls, and the directions and simplices at which the searches end; see `hull_gap`.

    first, second : (k, >= n, 3). n_first, n_second : (k,). directions, corners : (k, 3), (k, 4), directions and
        simplices from which the searches start, overwritten; 0 and -1 for none. gaps : (k,).
    """
    for k in range(len(gaps)):
        direction, simplex = vector_at(directions, k, 0), (corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3])
        gaps[k], direction, simplex = hull_gap(first[k], n_first[k], second[k], n_second[k], direction, simplex)
        directions[k, 0], directions[k, 1], directions[k, 2] = direction
        corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3] = simplex
