"""Labels on curves instead of a legend: which curves coincide, and where a text covers no other curve."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals

PlacePoint = tuple[float, float]
_Taken = tuple[PlacePoint, float]
"""The centre of another label, and half of the width of both together."""

COINCIDING_ANGLE = 0.5
"""Difference in degrees up to which fold angles are drawn as one curve: less than half the width of its line."""
_STEEPEST = 1.0
"""Greatest rise of a curve under its label, in heights of the label."""
_FAR = 3.0
"""Distance to other curves above which a place is as good as any, in heights of the label."""
_LEAST_ROOM = 0.75
"""Distance in height that a label beside its curve keeps from all curves, in heights of the label."""
_BESIDE = (0.5, 1.0, 1.5, 2.0)
"""Distances from a curve to a label beside it, in heights of the label, in the order in which they are tried."""


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
    """Return the centre of a label on each curve, else beside it, None where it would cover a curve or a label.

    curves : points with rising x. widths : of the labels of the first curves; the others have none.
    """
    xs = np.linspace(frame.left, frame.right, 2 + int((frame.right - frame.left) / (0.5 * frame.height)))
    heights = np.array([_heights(curve, xs) for curve in curves])
    reaches = [0.5 * width + 0.25 * frame.height for width in widths]
    places: list[PlacePoint | None] = [None] * len(widths)
    for place_of in (_place_on, _place_beside):
        for number, reach in enumerate(reaches):
            if places[number] is None:
                taken = [(at, reach + other) for at, other in zip(places, reaches, strict=True) if at is not None]
                places[number] = place_of(number, heights, xs, reach, frame, taken)
    return places


def _place_on(
    number: int, heights: Reals, xs: Reals, reach: float, frame: LabelFrame, taken: Sequence[_Taken]
) -> PlacePoint | None:
    """Return the place on a curve with the most room; reach : half of the width of the label."""
    best, most = None, frame.height
    for x, y in zip(xs, heights[number], strict=True):
        under = np.abs(xs - x) <= reach
        if not np.isfinite(y) or x - reach < frame.left or x + reach > frame.right:
            continue
        others = np.delete(heights[:, under], number, axis=0)
        rise = float(np.nanmax(np.abs(heights[number, under] - y)))
        room = min(_room(others, y, frame), *(_gap((x, y), *label) for label in taken), np.inf)
        inside = frame.low <= y <= frame.high
        if inside and rise <= _STEEPEST * frame.height and room > most:
            best, most = (float(x), float(y)), room
    return best


def _place_beside(
    number: int, heights: Reals, xs: Reals, reach: float, frame: LabelFrame, taken: Sequence[_Taken]
) -> PlacePoint | None:
    """Return the place left or right of a steep curve, as near as possible and with the most room."""
    others = np.array([_held(curve) for curve in np.delete(heights, number, axis=0)]).reshape(-1, len(xs))
    for distance in (share * frame.height for share in _BESIDE):
        best, most = None, _LEAST_ROOM * frame.height
        for (x, y), side in itertools.product(zip(xs, heights[number], strict=True), (1.0, -1.0)):
            centre, away = x + side * (distance + reach), side * (xs - x)
            inside = frame.low <= y <= frame.high and frame.left <= centre - reach and centre + reach <= frame.right
            if not inside:
                continue
            # as far beyond the label as the curve is before it, so that no other curve is nearer
            near = (away >= distance) & (away <= 2.0 * (distance + reach))
            # a curve between them would be nearer, too: it would come from one side of the height of the label
            sides = np.sign(others[:, (away >= 0.0) & (away <= distance)] - y)
            parted = bool(((sides == sides[:, :1]) & (sides != 0.0) | np.isnan(sides)).all())
            own, other = (_room(lines[:, near], y, frame) for lines in (heights[[number]], others))
            room = min(own, other, *(_gap((centre, y), *label) for label in taken))
            if parted and room > most:
                best, most = (float(centre), float(y)), room
        if best is not None:
            return best
    return None


def _room(heights: Reals, y: float, frame: LabelFrame) -> float:
    """Return the least distance of curves to a height, at most that above which a place is as good as any."""
    most = _FAR * frame.height
    return float(np.nanmin(np.abs(heights - y), initial=most)) if heights.size else most


def _heights(curve: Sequence[PlacePoint], xs: Reals) -> Reals:
    """Return a curve at some places, not a number outside of it."""
    if not curve:
        return np.full(len(xs), np.nan)
    at, values = (np.array(axis, float) for axis in zip(*curve, strict=True))
    heights: Reals = np.interp(xs, at, values, left=np.nan, right=np.nan)
    return heights


def _held(curve: Reals) -> Reals:
    """Return a curve that goes on level beyond its ends: a label there would seem to name all that end together."""
    known = np.flatnonzero(np.isfinite(curve))
    held: Reals = np.interp(np.arange(len(curve)), known, curve[known]) if len(known) else curve
    return held


def _gap(place: PlacePoint, other: PlacePoint, reach: float) -> float:
    """Return the distance in height between two labels, infinite where they lie beside each other.

    reach : half of the width of both together.
    """
    return np.inf if abs(place[0] - other[0]) >= reach else abs(place[1] - other[1])
