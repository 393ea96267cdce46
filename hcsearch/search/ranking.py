"""Ranking: weighted scores of designs, the Pareto front, and the designs of a database in the order of their scores.

The worth of a value depends on nothing but the value, by a fixed scale: a score that is stored means the same after
more designs have come in, and in another database. Scales taken from the rows at hand, such as min-max scaling or the
norms of TOPSIS, would change with each row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import moocore
import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import QueryError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, Result, save_scores, select
from hcsearch.store.columns import RANKING_CRITERIA, BetterDirection, Quantity
from hcsearch.store.conditions import nearest_names_hint


def complete_weights(given: Mapping[str, float]) -> dict[str, float]:
    """Weights of all criteria, in the order of the table: 1 where none is given.

    QueryError: a criterion that there is not, a weight that is negative or not finite, or no weight but 0.
    """
    names = [quantity.name for quantity in RANKING_CRITERIA]
    for name, weight in given.items():
        if name not in names:
            raise QueryError(f"no criterion {name!r}{nearest_names_hint(name, names)}: weigh {', '.join(names)}")
        if not (math.isfinite(weight) and weight >= 0):
            raise QueryError(f"the weight {weight} of {name} is out of range: give 0 or more; 0 leaves it out")
    weights = {name: float(given.get(name, 1.0)) for name in names}
    if not any(weights.values()):
        raise QueryError("every weight is 0, so nothing is left to rank by: give one criterion a positive weight")
    return weights


def criterion_worth(criterion: Quantity, values: NDArray[np.floating[Any]]) -> Reals:
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
    for criterion in RANKING_CRITERIA:
        if weight := weights[criterion.name] / greatest:
            score = score + weight * criterion_worth(criterion, columns[criterion.name])
            total += weight
    return score / total


def pareto_front(values: NDArray[np.floating[Any]], better: Sequence[BetterDirection]) -> NDArray[np.bool_]:
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


def _levels(column: NDArray[np.floating[Any]], better: BetterDirection) -> NDArray[np.float64]:
    """Numbers in the order of worth, the least for a missing value: moocore knows neither NaN nor infinity."""
    known = ~np.isnan(column)
    levels = np.zeros(len(column))
    _, order = np.unique(column[known] if better == "higher" else -column[known], return_inverse=True)
    levels[known] = 1.0 + order
    return levels


_NAMES = tuple(quantity.name for quantity in RANKING_CRITERIA)


@dataclass(frozen=True)
class RankedDesigns:
    """The designs that a query selects, without those known not to deploy, best first.

    result : columns rank (equal scores share one), id, circuit, score, pareto (1 on the front), and the criteria that
        have a weight. left_out : ids of the designs known not to deploy: no folding, twisted, or locked.
    """

    result: Result
    left_out: tuple[int, ...]


def rank_designs(
    database: Database, query: str = "", weights: Mapping[str, float] | None = None, scene: str = DEFAULT_SCENE_NAME
) -> RankedDesigns:
    """Rank the designs that a query selects in a scene by the criteria with a positive weight.

    weights : 1 for each criterion that is not named; QueryError as in `complete_weights` and `select`.
    """
    chosen = complete_weights(weights or {})
    counted = [quantity for quantity in RANKING_CRITERIA if chosen[quantity.name]]
    selected = select(database, query, columns=("deployable", "id", "circuit", *_NAMES), sort="id", scene=scene)
    rows = [row for row in selected.rows if row[0] != 0]
    values = np.array([row[3:] for row in rows], float).reshape(len(rows), len(_NAMES))  # None becomes NaN
    columns = dict(zip(_NAMES, values.T, strict=True))
    scores = weighted_score(columns, chosen)
    known = np.column_stack([columns[quantity.name] for quantity in counted])
    front = pareto_front(known, [quantity.better for quantity in counted])
    order = np.argsort(-scores, kind="stable")
    scores, front = scores[order], front[order]
    places = np.searchsorted(-scores, -scores) + 1
    at = [3 + _NAMES.index(quantity.name) for quantity in counted]
    ranked = [
        (place, *rows[i][1:3], score, on_front, *(rows[i][k] for k in at))
        for place, i, score, on_front in zip(
            *(column.tolist() for column in (places, order, scores, front.astype(int))), strict=True
        )
    ]
    names = ("rank", "id", "circuit", "score", "pareto", *(quantity.name for quantity in counted))
    return RankedDesigns(Result(names, tuple(ranked)), tuple(row[1] for row in selected.rows if row[0] == 0))


def save_ranks(database: Database, ranked: RankedDesigns, scene: str = DEFAULT_SCENE_NAME) -> None:
    """Store the scores in the column `score` of `designs`, in one transaction; NULL for designs that were left out."""
    known = {design: score for _, design, _, score, *_ in ranked.result.rows}
    save_scores(database, known | dict.fromkeys(ranked.left_out), scene)
