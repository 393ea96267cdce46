"""Envelopes: the boxes into which folded arrays must go, by name from a catalogue or by three lengths in mm."""

from __future__ import annotations

import re
import tomllib
from functools import cache
from importlib.resources import files
from itertools import permutations

from hcsearch.basics.errors import SceneError

EnvelopeSides = tuple[float, float, float]
"""Sides of a box in mm, the longest first."""
_LENGTH = r"[0-9]{1,7}(?:\.[0-9]{1,6})?"
_BOX = re.compile(rf"({_LENGTH})x({_LENGTH})x({_LENGTH})", re.ASCII)


@cache
def envelope_catalogue() -> dict[str, EnvelopeSides]:
    """Return the envelopes of the catalogue by name, sides in mm."""
    table = tomllib.loads(files("hcsearch.scenes").joinpath("envelopes.toml").read_text(encoding="utf-8"))
    catalogue = {name: _ordered(sides) for name, sides in table["sides_mm"].items()}
    rails, height = 2.0 * table["side"]["rail_width_mm"], table["side"]["height_mm"]
    sides = {f"{name}-side": _ordered((box[0], box[1] - rails, height)) for name, box in catalogue.items()}
    return catalogue | sides


def envelope_sides(text: str) -> EnvelopeSides:
    """Return the sides of an envelope in mm; SceneError for anything but a name of the catalogue or three lengths."""
    named = {name.lower(): sides for name, sides in envelope_catalogue().items()}.get(text.strip().lower())
    if named is not None:
        return named
    match = _BOX.fullmatch(text.strip())
    if match is None or not all(float(length) > 0.0 for length in match.groups()):
        raise SceneError(
            f"there is no envelope {text[:40]!r}: write one of {', '.join(envelope_catalogue())}, or three lengths in "
            "mm, such as 100x100x340"
        )
    return _ordered([float(length) for length in match.groups()])


def box_placements(sides: EnvelopeSides) -> list[EnvelopeSides]:
    """Return the ways to lay a box into another one with parallel sides: its sides in every order, each once."""
    return sorted({(a, b, c) for a, b, c in permutations(sides)})


def _ordered(sides: list[float] | tuple[float, ...]) -> EnvelopeSides:
    shortest, middle, longest = sorted(sides)
    return longest, middle, shortest
