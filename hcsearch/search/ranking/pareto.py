"""The Pareto front: rows that no other row dominates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moocore
import numpy as np
from numpy.typing import NDArray

from hcsearch.store.columns import Better


def pareto_front(values: NDArray[np.floating[Any]], better: Sequence[Better]) -> NDArray[np.bool_]:
    """Whether each row is on the front: no other row is as good in all criteria and better in one.

    values : shape (n_rows, n_criteria); NaN where a value is missing, which is worse than any value there is.
    better : `higher` or `lower`, of each criterion. Equal rows are on the front together; without criteria all are.

    Only the order of values counts, so the unit of a criterion changes nothing. By dimension sweep and divide and
    conquer, O(n log^(m-2) n) for m > 3 criteria (Kung, Luccio and Preparata, J. ACM 22, 1975), of the package moocore.
    """
    if not values.size:
        return np.ones(len(values), bool)
    levels = [_levels(column, way) for column, way in zip(values.T, better, strict=True)]
    front: NDArray[np.bool_] = moocore.is_nondominated(np.column_stack(levels), maximise=True, keep_weakly=True)
    return front


def _levels(column: NDArray[np.floating[Any]], better: Better) -> NDArray[np.float64]:
    """Numbers in the order of worth, the least for a missing value: moocore knows neither NaN nor infinity."""
    known = ~np.isnan(column)
    levels = np.zeros(len(column))
    _, order = np.unique(column[known] if better == "higher" else -column[known], return_inverse=True)
    levels[known] = 1.0 + order
    return levels
