"""Terminal output for people: formatted numbers, times and sizes, and notices on stderr."""

from __future__ import annotations

import sys
from contextlib import suppress

from hcsearch.basics.errors import one_line

MAX_PLAIN_NUMBER = 1e7
"""Numbers below this are written without an exponent: 160, not 1.6e+02."""


def write_notice(sentence: str) -> None:
    """Write a sentence as one line to stderr; ignored where it is empty or stderr is closed."""
    if sentence and sys.stderr is not None:
        with suppress(OSError, ValueError):  # a closed stream is a ValueError
            print(one_line(sentence), file=sys.stderr)


def short_number(value: float, digits: int = 4) -> str:
    """Format a number to some significant digits; only `MAX_PLAIN_NUMBER` and more, or tiny ones, get an exponent."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < MAX_PLAIN_NUMBER else text


def tolerance_text(tolerance: float) -> str:
    """Format a tolerance to one digit with its exponent, such as 1e-6."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


def duration_text(seconds: float) -> str:
    """Format a duration in a suitable unit, to two digits."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds > 1.5 * size:
            return f"{short_number(seconds / size, 2)} {unit}"
    return f"{short_number(seconds, 2)} seconds"


def number_text(count: float) -> str:
    """Format a number to two digits, without an exponent."""
    return f"{float(f'{count:.2g}'):,.0f}"


def bytes_text(count: float) -> str:
    """Format a number of bytes, to two digits."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if count > scale:
            return f"{short_number(count / scale, 2)} {unit}"
    return f"{short_number(count / 1e3, 2)} kB"
