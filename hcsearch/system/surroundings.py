"""What the surroundings of the program say: environment variables."""

from __future__ import annotations

import os


def default_database() -> str:
    """HCSEARCH_DB, else hcsearch.sqlite in the current folder."""
    return os.environ.get("HCSEARCH_DB") or "hcsearch.sqlite"
