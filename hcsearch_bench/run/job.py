"""Jobs in processes of their own, with a limit of time, and peak memory measured.

`python -m hcsearch_bench.run.job MODULE FUNCTION ARGUMENTS`, the inside of such a process, prints a row as JSON.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

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
    command = [sys.executable, "-m", "hcsearch_bench.run.job", job.__module__, job.__qualname__, json.dumps(arguments)]
    done = run_measured(command, limit, _ONE_CORE)
    if done.status is None:
        return JobResult(done.peak_mib, f"over {limit:g} s", late=True)
    if done.status:
        last = (done.error.strip().splitlines() or [f"exit code {done.status}"])[-1]
        return JobResult(done.peak_mib, f"failed: {last}")
    return JobResult(done.peak_mib, row=json.loads(done.output.splitlines()[-1]))


if __name__ == "__main__":
    job = getattr(import_module(sys.argv[1]), sys.argv[2])
    print(json.dumps(job(**json.loads(sys.argv[3]))))
