"""Screws as six numbers: angular velocity, then velocity at the origin."""

from __future__ import annotations

from hcsearch.basics.arrays import Reals
from hcsearch.kernels.compiling.compiled import lean


@lean
def add_bracket(one: Reals, two: Reals, total: Reals) -> None:
    """Add the Lie bracket of two screws, (6,) each, to a third."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        total[i] += one[j] * two[k] - one[k] * two[j]
        total[3 + i] += one[j] * two[3 + k] - one[k] * two[3 + j]
        total[3 + i] += one[3 + j] * two[k] - one[3 + k] * two[j]
