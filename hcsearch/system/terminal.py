"""What people read on terminals: numbers, times and sizes, and notices beside the result on stderr."""

from __future__ import annotations

import sys
from contextlib import suppress

from hcsearch.basics.errors import one_line

MAX_PLAIN_NUMBER = 1e7
"""Below this a number is written out: 160, not 1.6e+02."""


def write_notice(sentence: str) -> None:
    """Write a sentence as one line on stderr, if anyone is there to read it; nothing where it is empty."""
    if sentence and sys.stderr is not None:
        with suppress(OSError, ValueError):  # a closed stream is a ValueError
            print(one_line(sentence), file=sys.stderr)


def short_number(value: float, digits: int = 4) -> str:
    """A number to so many digits; only numbers from `MAX_PLAIN_NUMBER` on, and very small ones, have powers of ten."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < MAX_PLAIN_NUMBER else text


def duration_text(seconds: float) -> str:
    """A time for people, to two digits."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds > 1.5 * size:
            return f"{short_number(seconds / size, 2)} {unit}"
    return f"{short_number(seconds, 2)} seconds"


def number_text(count: float) -> str:
    """A number to two digits, written out."""
    return f"{float(f'{count:.2g}'):,.0f}"


def bytes_text(count: float) -> str:
    """Bytes, to two digits."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count > scale:
            return f"{short_number(count / scale, 2)} {unit}"
    return f"{short_number(count / 1e3, 2)} kB"
