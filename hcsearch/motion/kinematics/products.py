"""The bilinear form of a second-order closure error, which is known as a quadratic one."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from hcsearch.basics.arrays import Reals


def bilinear_products(vectors: Reals, bend: Callable[[Reals], Reals]) -> Reals:
    """Values of the form that `bend` is of a vector with itself, for all pairs, shape (n, n, n_rows).

    vectors : (n, n_hinges), velocities. bend : second-order closure error of moving with one, (n_rows,).
    """
    own = np.array([bend(vector) for vector in vectors])
    values = np.empty((len(vectors), len(vectors), own.shape[1]))
    for i, j in combinations_with_replacement(range(len(vectors)), 2):
        values[i, j] = values[j, i] = own[i] if i == j else 0.5 * (bend(vectors[i] + vectors[j]) - own[i] - own[j])
    return values
