"""Numbers as people read them."""

from __future__ import annotations

_TINY = 1e-9
"""What rounding leaves of a zero, in any unit that pages have."""


def written(value: object) -> str:
    """Write a value, numbers in four digits; `-` for NULL. `written` of parts.js writes the same."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return "0" if abs(value) < _TINY else f"{value:.4g}"
    return str(value)
