"""Jobs in processes of their own (`run.worker`), with a limit of time, and peak memory measured."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from hcsearch_bench.run import worker
from hcsearch_bench.run.process import run_measured
from hcsearch_bench.run.timing import Row

OWN_LIMIT = 900.0  # seconds for a process of ours, kernels compiled on first use included
# Graphillion has threads that wait by spinning: on busy cores they cost seconds where one thread needs milliseconds
_ONE_CORE = {"OMP_NUM_THREADS": "1"}


@dataclass(frozen=True)
class JobResult:
    """The row that a job gave, and the most memory its process held; note : why there is no row.

    late : whether the job took longer than it was allowed.
    """

    peak_mib: float
    note: str = ""
    row: Row = field(default_factory=dict)
    late: bool = False


def run_job(job: Callable[..., Row], limit: float, **arguments: Any) -> JobResult:
    """Run a function for at most `limit` seconds on the wall; one that fails or takes longer has a result too."""
    command = [sys.executable, "-m", worker.__name__, job.__module__, job.__qualname__, json.dumps(arguments)]
    done = run_measured(command, limit, _ONE_CORE)
    if done.status is None:
        return JobResult(done.peak_mib, f"over {limit:g} s", late=True)
    if done.status:
        last = (done.error.strip().splitlines() or [f"exit code {done.status}"])[-1]
        return JobResult(done.peak_mib, f"failed: {last}")
    return JobResult(done.peak_mib, row=json.loads(done.output.splitlines()[-1]))
