"""Products of rows of tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hcsearch.kernels.compiled import lean

Reals = NDArray[np.float64]


@lean
def inner(a: Reals, b: Reals) -> float:
    """The scalar product of two rows.

    np.dot would ask BLAS: other last bits on another processor, and a library that takes longer to load than many
    kernels to run.
    """
    value = 0.0
    for k in range(len(a)):
        value += a[k] * b[k]
    return value
