"""The inside of a job's process: `python -m hcsearch.bench.worker NAME ARGUMENTS` prints one row as JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable

from hcsearch.bench import counting, engines, folding, listing
from hcsearch.bench.timing import Row


def jobs() -> dict[str, Callable[..., Row]]:
    """All jobs by name."""
    return engines.JOBS | listing.JOBS | folding.JOBS | counting.JOBS


if __name__ == "__main__":
    print(json.dumps(jobs()[sys.argv[1]](**json.loads(sys.argv[2]))))
