"""Ranking of designs: weighted scores, the Pareto front, and the designs of a database in order of their scores.

The worth of a value depends only on the value, by a fixed scale, so a stored score keeps its meaning when designs are
added, and in another database. Scales that depend on the rows, such as min-max scaling or the norms of TOPSIS, would
change with each row.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import moocore
import numpy as np
from numpy.typing import NDArray

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import QueryError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, Result, save_scores, select
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.store.conditions import nearest_names_hint
from hcsearch.store.quantity import BetterDirection, Quantity


def complete_weights(weights: Mapping[str, float]) -> dict[str, float]:
    """Return weights of all criteria, in the order of the table; the table's own weights where none is given.

    QueryError for an unknown criterion, a weight that is negative or not finite, and where all weights are 0.
    """
    names = [quantity.name for quantity in RANKING_CRITERIA]
    for name, weight in weights.items():
        if name not in names:
            raise QueryError(f"no criterion {name!r}{nearest_names_hint(name, names)}: weigh {', '.join(names)}")
        if not (math.isfinite(weight) and weight >= 0):
            raise QueryError(f"the weight {weight} of {name} is out of range: give 0 or more; 0 leaves it out")
    complete = {quantity.name: float(weights.get(quantity.name, quantity.weight)) for quantity in RANKING_CRITERIA}
    if not any(complete.values()):
        raise QueryError("every weight is 0, so nothing is left to rank by: give one criterion a positive weight")
    return complete


def criterion_worth(criterion: Quantity, values: NDArray[np.floating[Any]]) -> Reals:
    """Return the worth of values x of a criterion: x / (x + half) where higher is better, else half / (x + half).

    The worth of NaN, a missing value, is 0, the lowest possible; negative values count as 0. Strictly monotonic except
    for rounding, so even a very good value is worth less than a better one.
    """
    assert criterion.half is not None
    counted = np.maximum(values, 0.0)  # NaN stays
    # in these forms each rounded operation is monotonic, so a better value is never worth less
    with np.errstate(divide="ignore", over="ignore"):
        ratio = criterion.half / counted if criterion.better == "higher" else counted / criterion.half
    return np.where(np.isnan(values), 0.0, 1.0 / (1.0 + ratio))


def weighted_score(columns: Mapping[str, NDArray[np.floating[Any]]], weights: Mapping[str, float]) -> Reals:
    """Return scores of rows, 0 to 1: the weighted mean of the worth of their criteria.

    columns : values of each criterion of positive weight, shape (n_rows,), NaN where missing: this counts as worth 0
        with full weight, so a design without a value is never better than one with it.
    weights : from `complete_weights`; only their ratios count.
    """
    greatest = max(weights.values())  # divided first, since sums of weights may overflow
    total, score = 0.0, np.zeros(())
    for criterion in RANKING_CRITERIA:
        if weight := weights[criterion.name] / greatest:
            score = score + weight * criterion_worth(criterion, columns[criterion.name])
            total += weight
    return score / total


def pareto_front(values: NDArray[np.floating[Any]], better: Sequence[BetterDirection]) -> NDArray[np.bool_]:
    """Return whether each row is on the Pareto front: no other row is as good in all criteria and better in one.

    values : shape (n_rows, n_criteria); NaN for a missing value, which is worse than any other.
    better : `higher` or `lower` for each criterion. Equal rows are on the front together; without criteria all are.

    Only the order of values counts, so units do not matter. Computed by the package moocore by dimension sweep and
    divide and conquer, O(n log^(m-2) n) for m > 3 criteria (Kung, Luccio and Preparata, J. ACM 22, 1975).
    """
    if not values.size:
        return np.ones(len(values), bool)
    levels = [_levels(column, direction) for column, direction in zip(values.T, better, strict=True)]
    front: NDArray[np.bool_] = moocore.is_nondominated(np.column_stack(levels), maximise=True, keep_weakly=True)
    return front


def _levels(column: NDArray[np.floating[Any]], better: BetterDirection) -> NDArray[np.float64]:
    """Replace values by ranks in order of worth, 0 for a missing value, since moocore accepts no NaN or infinity."""
    known = ~np.isnan(column)
    levels = np.zeros(len(column))
    _, order = np.unique(column[known] if better == "higher" else -column[known], return_inverse=True)
    levels[known] = 1.0 + order
    return levels


_NAMES = tuple(quantity.name for quantity in RANKING_CRITERIA)


@dataclass(frozen=True)
class RankedDesigns:
    """The designs selected by a query, best first, without those known not to deploy.

    result : columns rank (shared by equal scores), id, circuit, score, pareto (1 on the front), and the criteria with
        a positive weight. unranked_ids : ids of the designs known not to deploy: no folding, twisted, or locked.
    location : of the database, for messages.
    """

    result: Result
    unranked_ids: tuple[int, ...]
    location: str = field(compare=False)


def rank_designs(
    database: Database, query: str = "", weights: Mapping[str, float] | None = None, scene: str = DEFAULT_SCENE_NAME
) -> RankedDesigns:
    """Rank the designs selected by a query in a scene by the criteria with a positive weight.

    weights : by criterion, 1 unless given; QueryError as in `complete_weights` and `select`.
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
    unranked_ids = tuple(row[1] for row in selected.rows if row[0] == 0)
    return RankedDesigns(Result(names, tuple(ranked)), unranked_ids, database.location)


def save_ranks(database: Database, ranked: RankedDesigns, scene: str = DEFAULT_SCENE_NAME) -> None:
    """Store scores in the column `score` of `designs`, in one transaction; NULL for unranked designs."""
    scores = {design: score for _, design, _, score, *_ in ranked.result.rows}
    save_scores(database, scores | dict.fromkeys(ranked.unranked_ids), scene)
