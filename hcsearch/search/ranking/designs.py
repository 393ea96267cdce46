"""Designs of a database in the order of their scores."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.search.ranking.pareto import pareto_front
from hcsearch.search.ranking.scoring import complete_weights, weighted_score
from hcsearch.store import Database, Result, save_scores, select
from hcsearch.store.columns import CRITERIA

_NAMES = tuple(quantity.name for quantity in CRITERIA)


@dataclass(frozen=True)
class Ranked:
    """The designs that a query selects, without those known not to deploy, best first.

    result : columns rank (equal scores share one), id, circuit, score, pareto (1 on the front), and the criteria that
        have a weight. left_out : ids of the designs known not to deploy: no folding, twisted, or locked.
    """

    result: Result
    left_out: tuple[int, ...]


def rank_designs(
    database: Database, query: str = "", weights: Mapping[str, float] | None = None, scene: str = DEFAULT_SCENE_NAME
) -> Ranked:
    """Rank the designs that a query selects in a scene by the criteria with a positive weight.

    weights : 1 for each criterion that is not named; QueryError as in `complete_weights` and `select`.
    """
    chosen = complete_weights(weights or {})
    counted = [quantity for quantity in CRITERIA if chosen[quantity.name]]
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
    return Ranked(Result(names, tuple(ranked)), tuple(row[1] for row in selected.rows if row[0] == 0))


def save_ranks(database: Database, ranked: Ranked, scene: str = DEFAULT_SCENE_NAME) -> None:
    """Store the scores in the column `score` of `designs`, in one transaction; NULL for designs that were left out."""
    known = {design: score for _, design, _, score, *_ in ranked.result.rows}
    save_scores(database, known | dict.fromkeys(ranked.left_out), scene)
