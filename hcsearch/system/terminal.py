"""What people read on terminals: numbers, and notices beside the result on stderr, which no program reads."""

from __future__ import annotations

import sys
from contextlib import suppress

from hcsearch.basics.errors import one_line

PLAIN = 1e7
"""Below this a number is written out: 160, not 1.6e+02."""


def say(sentence: str) -> None:
    """Write a sentence as one line on stderr, if anyone is there to read it; nothing where it is empty."""
    if sentence and sys.stderr is not None:
        with suppress(OSError, ValueError):  # a closed stream is a ValueError
            print(one_line(sentence), file=sys.stderr)


def short(value: float, digits: int = 4) -> str:
    """A number to so many digits; only numbers from `PLAIN` on, and very small ones, have powers of ten."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < PLAIN else text
