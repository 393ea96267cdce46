"""Numbers as people write them on terminals."""

from __future__ import annotations

PLAIN = 1e7
"""Below this a number is written out: 160, not 1.6e+02."""


def short(value: float, digits: int = 4) -> str:
    """A number to so many digits; only numbers from `PLAIN` on, and very small ones, have powers of ten."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < PLAIN else text
