"""What a user should know beside the result: lines on stderr, which no program reads as the output."""

from __future__ import annotations

import sys
from contextlib import suppress

from hcsearch.errors import one_line


def say(sentence: str) -> None:
    """Write a sentence as one line on stderr, if anyone is there to read it; nothing where it is empty."""
    if sentence and sys.stderr is not None:
        with suppress(OSError, ValueError):  # a closed stream is a ValueError
            print(one_line(sentence), file=sys.stderr)
