"""The pipeline: runs a stage where its result is missing or older, one transaction a batch."""

from hcsearch.search.pipeline.amounts import duration
from hcsearch.search.pipeline.counting import Counted, count_designs, counting_seconds
from hcsearch.search.pipeline.estimate import check_room, estimate
from hcsearch.search.pipeline.run import Funnel, Plan, Summary, finished_shards, run_dry, run_into
from hcsearch.search.pipeline.workers import Crew

__all__ = [
    "Counted",
    "Crew",
    "Funnel",
    "Plan",
    "Summary",
    "check_room",
    "count_designs",
    "counting_seconds",
    "duration",
    "estimate",
    "finished_shards",
    "run_dry",
    "run_into",
]
