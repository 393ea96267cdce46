"""The memory that a search for paths takes, and the largest array that it may be given."""

from __future__ import annotations

from hcsearch.errors import SizeError

MOST_BYTES = 2_000_000_000
"""Memory that a search may take."""
_FIXED, _EACH, _PAIR = 250_000_000, 300_000, 900
"""Bytes: without panels; for each panel, as of states in trees; for each two, as of gaps in a state."""


def check_size(n: int) -> None:
    """Refuse more panels than fit into the memory, before anything is computed; SizeError."""
    wanted = _bytes(n)
    if wanted > MOST_BYTES:
        most = next(k for k in range(n - n % 100, 0, -100) if _bytes(k) <= MOST_BYTES)
        raise SizeError(
            f"planning the motions of {n:,} panels takes about {wanted / 1e9:.1f} GB of memory, more than "
            f"{MOST_BYTES / 1e9:g} GB: take at most {most:,} panels"
        )


def _bytes(n: int) -> int:
    """Memory that a search among n panels takes, at most."""
    return _FIXED + n * (_EACH + _PAIR * n)
