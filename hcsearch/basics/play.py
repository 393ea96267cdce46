"""Play between panels, as commands, pages and databases state it: gaps in millimetres, and how much to leave."""

from __future__ import annotations

import math

MILLIMETRE_DECIMALS = 6
"""Gaps are stated to so many digits of a millimetre, a nanometre: what is less is rounding, and stated as 0."""


def millimetres(length: float | None) -> float | None:
    """A gap or a margin (m) in millimetres, rounded to a nanometre; None where there is none."""
    if length is None or math.isnan(length):
        return None
    return round(1e3 * length, MILLIMETRE_DECIMALS) + 0.0  # not -0


def play_sentence(needed_margin: float | None) -> str | None:
    """How much to leave between faces for a motion that needs a margin (mm) on every face; None without one.

    Two faces that would touch are two margins apart once either panel is smaller by one.
    """
    if needed_margin is None:
        return None
    smaller = f"panels {needed_margin:.4g} mm smaller on every face, and hinges where they are"
    return f"leave {2.0 * needed_margin:.4g} mm between faces: certified clear with {smaller}"
