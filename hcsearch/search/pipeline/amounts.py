"""Times, numbers and sizes as people write them."""

from __future__ import annotations

from hcsearch.system.terminal import short


def duration(seconds: float) -> str:
    """A time for people, to two digits."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds > 1.5 * size:
            return f"{short(seconds / size, 2)} {unit}"
    return f"{short(seconds, 2)} seconds"


def number(count: float) -> str:
    """A number to two digits, written out."""
    return f"{float(f'{count:.2g}'):,.0f}"


def size(count: float) -> str:
    """Bytes, to two digits."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count > scale:
            return f"{short(count / scale, 2)} {unit}"
    return f"{short(count / 1e3, 2)} kB"
