"""Colours and dashes of curves: the same in plots of pages, in pictures and in benches."""

from __future__ import annotations

from typing import NamedTuple

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#c061a0", "#b58900", "#3a9bdc", "#8c5a3c", "#808080")
"""After Okabe and Ito, so that colour-blind readers tell them apart; mid tones, for light and dark pages."""
DASHES: tuple[tuple[float, ...], ...] = ((), (4.0, 1.5), (1.0, 1.5), (5.0, 1.5, 1.0, 1.5))
"""Strokes and gaps, in widths of the line; solid lines have none."""
LOOKS = len(COLOURS) * len(DASHES)
"""Looks there are; the next ones are the first again."""


class CurveLook(NamedTuple):
    """A colour, and one of `DASHES`."""

    colour: str
    dashes: tuple[float, ...]


def curve_look(number: int) -> CurveLook:
    """Look of a curve; those of `LOOKS` curves differ, and of neighbours in both colour and dashes."""
    return CurveLook(COLOURS[number % len(COLOURS)], DASHES[(number + number // len(COLOURS)) % len(DASHES)])
