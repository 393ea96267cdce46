"""The pipeline: runs a stage where its result is missing or older, one transaction a batch."""

from hcsearch.search.pipeline.estimate import Counted, check_room, count_designs, counting_seconds, estimate
from hcsearch.search.pipeline.run import Funnel, Plan, RunSummary, finished_shards, run_dry, run_into
from hcsearch.search.pipeline.workers import Crew
from hcsearch.system.terminal import duration

__all__ = [
    "Counted",
    "Crew",
    "Funnel",
    "Plan",
    "RunSummary",
    "check_room",
    "count_designs",
    "counting_seconds",
    "duration",
    "estimate",
    "finished_shards",
    "run_dry",
    "run_into",
]
