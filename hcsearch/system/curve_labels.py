"""Labels on curves instead of a legend: which curves coincide, and where a text on a curve covers no other curve."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals

PlacePoint = tuple[float, float]

COINCIDING_ANGLE = 0.5
"""Difference in degrees up to which fold angles are drawn as one curve: less than half the width of its line."""
_STEEPEST = 1.0
"""Greatest rise of a curve under its label, in heights of the label."""
_FAR = 3.0
"""Distance to other curves above which a place is as good as any, in heights of the label."""


class LabelFrame(NamedTuple):
    """The part of a picture that holds the centres of labels and their widths, and their height."""

    left: float
    right: float
    low: float
    high: float
    height: float


def coinciding(columns: Reals, within: float) -> list[list[int]]:
    """Group columns of an array, shape (k, n), that nowhere differ from the first of their group by more than a value.

    Return the numbers of the columns of each group, in the order of their first ones.
    """
    groups: list[list[int]] = []
    for number, column in enumerate(columns.T):
        for group in groups:
            if float(np.abs(column - columns[:, group[0]]).max(initial=0.0)) <= within:
                group.append(number)
                break
        else:
            groups.append([number])
    return groups


def label_places(
    curves: Sequence[Sequence[PlacePoint]], widths: Sequence[float], frame: LabelFrame
) -> list[PlacePoint | None]:
    """Return the centre of a label on each curve, None where it would cover another curve or label.

    curves : points with rising x. widths : of the labels.
    """
    reaches = [0.5 * width + 0.25 * frame.height for width in widths]
    xs = np.linspace(frame.left, frame.right, 2 + int((frame.right - frame.left) / (0.5 * frame.height)))
    heights = np.array([_heights(curve, xs) for curve in curves])
    places: list[PlacePoint | None] = []
    for number, reach in enumerate(reaches):
        best, most = None, 0.0
        for x, y in zip(xs, heights[number], strict=True):
            under = np.abs(xs - x) <= reach
            if not np.isfinite(y) or x - reach < frame.left or x + reach > frame.right:
                continue
            others = np.delete(heights[:, under], number, axis=0)
            rise = float(np.nanmax(np.abs(heights[number, under] - y)))
            room = float(np.nanmin(np.abs(others - y), initial=_FAR * frame.height)) if others.size else np.inf
            gaps = (_gap((x, y), place, reach + other) for place, other in zip(places, reaches, strict=False))
            room = min(room, *gaps, np.inf)
            inside = frame.low <= y <= frame.high
            if inside and rise <= _STEEPEST * frame.height and min(room, _FAR * frame.height) > most:
                best, most = (float(x), float(y)), min(room, _FAR * frame.height)
        places.append(best if most > frame.height else None)
    return places


def _heights(curve: Sequence[PlacePoint], xs: Reals) -> Reals:
    """Return a curve at some places, not a number outside of it."""
    if not curve:
        return np.full(len(xs), np.nan)
    at, values = (np.array(axis, float) for axis in zip(*curve, strict=True))
    heights: Reals = np.interp(xs, at, values, left=np.nan, right=np.nan)
    return heights


def _gap(place: PlacePoint, other: PlacePoint | None, reach: float) -> float:
    """Return the distance in height between two labels, infinite where they lie beside each other or one is missing.

    reach : half of the width of both together.
    """
    return np.inf if other is None or abs(place[0] - other[0]) >= reach else abs(place[1] - other[1])
