"""What the machine gives to the program: processor cores, and variables of the environment."""

from __future__ import annotations

import os


def usable_cores() -> int:
    """Cores that this process may use, which can be fewer than the machine has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def default_database() -> str:
    """HCSEARCH_DB, else hcsearch.sqlite in the current folder."""
    return os.environ.get("HCSEARCH_DB") or "hcsearch.sqlite"
