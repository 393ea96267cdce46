"""Ranks of designs by the criteria of the quantity table: a weighted score, and the Pareto front."""

from hcsearch.search.ranking.designs import Ranked, rank_designs, save_ranks
from hcsearch.search.ranking.pareto import pareto_front
from hcsearch.search.ranking.scoring import complete_weights, weighted_score

__all__ = ["Ranked", "complete_weights", "pareto_front", "rank_designs", "save_ranks", "weighted_score"]
