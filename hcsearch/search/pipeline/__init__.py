"""The pipeline: runs stages whose results are missing or outdated, one transaction per batch."""

from hcsearch.search.pipeline.estimate import (
    DesignCount,
    check_disk_room,
    count_designs,
    counting_seconds,
    estimate_run,
)
from hcsearch.search.pipeline.run import Funnel, Plan, RunSummary, finished_shards, run_dry, run_into
from hcsearch.search.pipeline.workers import WorkerPool
from hcsearch.system.terminal import duration_text

__all__ = [
    "DesignCount",
    "Funnel",
    "Plan",
    "RunSummary",
    "WorkerPool",
    "check_disk_room",
    "count_designs",
    "counting_seconds",
    "duration_text",
    "estimate_run",
    "finished_shards",
    "run_dry",
    "run_into",
]
