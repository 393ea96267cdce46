"""The weighted score of a design: the mean worth of its criteria, each between 0 and 1.

The worth of a value depends on nothing but the value, by a fixed scale: a score that is stored means the same after
more designs have come in, and in another database. Scales taken from the rows at hand, such as min-max scaling or the
norms of TOPSIS, would change with each row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import QueryError
from hcsearch.store.columns import CRITERIA, Quantity
from hcsearch.store.conditions import nearest


def complete_weights(given: Mapping[str, float]) -> dict[str, float]:
    """Weights of all criteria, in the order of the table: 1 where none is given.

    QueryError: a criterion that there is not, a weight that is negative or not finite, or no weight but 0.
    """
    names = [quantity.name for quantity in CRITERIA]
    for name, weight in given.items():
        if name not in names:
            raise QueryError(f"no criterion {name!r}{nearest(name, names)}: weigh {', '.join(names)}")
        if not (math.isfinite(weight) and weight >= 0):
            raise QueryError(f"the weight {weight} of {name} is out of range: give 0 or more; 0 leaves it out")
    weights = {name: float(given.get(name, 1.0)) for name in names}
    if not any(weights.values()):
        raise QueryError("every weight is 0, so nothing is left to rank by: give one criterion a positive weight")
    return weights


def worth(criterion: Quantity, values: NDArray[np.floating[Any]]) -> Reals:
    """Worth of values x of a criterion, x / (x + half) where higher is better, half / (x + half) where lower is.

    0 for NaN, a missing value, as for the worst there can be; negative values count as 0. Strictly monotonic but for
    rounding, so that even a very good value is worth less than a better one.
    """
    assert criterion.half is not None
    counted = np.maximum(values, 0.0)  # NaN stays
    # In these forms each rounded step is monotonic: a better value is never worth less, not even by the last digit.
    with np.errstate(divide="ignore", over="ignore"):
        ratio = criterion.half / counted if criterion.better == "higher" else counted / criterion.half
    return np.where(np.isnan(values), 0.0, 1.0 / (1.0 + ratio))


def weighted_score(columns: Mapping[str, NDArray[np.floating[Any]]], weights: Mapping[str, float]) -> Reals:
    """Scores of rows, 0 to 1: the weighted mean of the worth of their criteria.

    columns : values of each criterion of positive weight, shape (n_rows,), NaN where missing: it counts with worth 0
        and its full weight, so a design without a criterion is never better than one with it.
    weights : as `complete_weights` gives them; only their ratios count.
    """
    greatest = max(weights.values())  # divided first: sums of weights may overflow
    total, score = 0.0, np.zeros(())
    for criterion in CRITERIA:
        if weight := weights[criterion.name] / greatest:
            score = score + weight * worth(criterion, columns[criterion.name])
            total += weight
    return score / total
