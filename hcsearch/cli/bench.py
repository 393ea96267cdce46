"""`hcsearch bench`: measurements."""

from __future__ import annotations

import click


@click.group()
def bench() -> None:
    """Measure and compare."""
