"""Numbers in strokes, of seven segments and a plus, for machines that have no fonts."""

from __future__ import annotations

from hcsearch.shape.mesh import PlanePoint

WIDE, APART, BELOW = 0.5, 0.3, 0.25
"""Width of a digit, the space after it, and that above a line below, over its height."""

# corners of the seven segments, left and right, at heights 1, 1/2 and 0; X, Y of a plus; G, H, I of a 1
_PATHS: dict[str, tuple[str, ...]] = {
    "0": ("ABFEA",),
    "1": ("GHI",),
    "2": ("ABDCEF",),
    "3": ("ABDFE", "CD"),
    "4": ("ACD", "BDF"),
    "5": ("BACDFE",),
    "6": ("BACEFDC",),
    "7": ("ABF",),
    "8": ("ABFEA", "CD"),
    "9": ("DCABFE",),
    "+": ("CD", "XY"),
}
_CORNERS: dict[str, PlanePoint] = {
    "A": (0.0, 1.0),
    "B": (WIDE, 1.0),
    "C": (0.0, 0.5),
    "D": (WIDE, 0.5),
    "E": (0.0, 0.0),
    "F": (WIDE, 0.0),
    "X": (0.5 * WIDE, 0.5 - 0.5 * WIDE),
    "Y": (0.5 * WIDE, 0.5 + 0.5 * WIDE),
    "G": (0.1 * WIDE, 0.8),
    "H": (0.5 * WIDE, 1.0),
    "I": (0.5 * WIDE, 0.0),
}


def strokes(text: str, middle: PlanePoint, height: float, *, underlined: bool = False) -> list[list[PlanePoint]]:
    """Polylines of a text of digits and pluses, of a height, about a point."""
    step = WIDE + APART
    wide = step * len(text) - APART
    left, low = middle[0] - 0.5 * height * wide, middle[1] - 0.5 * height
    lines = [
        [(left + height * (k * step + _CORNERS[c][0]), low + height * _CORNERS[c][1]) for c in path]
        for k, mark in enumerate(text)
        for path in _PATHS[mark]
    ]
    below = low - BELOW * height
    return [*lines, [(left, below), (left + height * wide, below)]] if underlined else lines
