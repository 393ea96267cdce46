"""Times, numbers and sizes as people write them."""

from __future__ import annotations


def duration(seconds: float) -> str:
    """A time for people, to two digits."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds > 1.5 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} seconds"


def number(count: float) -> str:
    """A number to two digits, written out."""
    return f"{float(f'{count:.2g}'):,.0f}"


def size(count: float) -> str:
    """Bytes, to two digits."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count > scale:
            return f"{count / scale:.2g} {unit}"
    return f"{count / 1e3:.2g} kB"
