"""The pipeline: runs a stage where its result is missing or older, one transaction a batch."""

from hcsearch.pipeline.run import Funnel, Plan, Summary, run_dry, run_into
from hcsearch.pipeline.stages import BUILT, PLANNED, check_keep, stages_until

__all__ = ["BUILT", "PLANNED", "Funnel", "Plan", "Summary", "check_keep", "run_dry", "run_into", "stages_until"]
