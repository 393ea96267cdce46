"""Which marks of a picture are seen: those that marks drawn after them cover wholly need not be written."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

_FLAT_AREA = 1.0
"""Area below which a polygon is drawn by its outline alone, square units of the picture."""
_SLIVER = 0.05
"""Area that may remain uncovered, square units of the picture: nobody sees it."""


def ink_of(points: Sequence[tuple[float, float]], width: float, *, is_face: bool) -> BaseGeometry:
    """Return what a mark covers: a filled polygon with its outline, or a line; width : of the line, with round ends."""
    shape = shapely.Polygon(points) if is_face else shapely.LineString(points)
    if is_face and shape.area < _FLAT_AREA:
        shape = shapely.LineString([*points, points[0]])
    return shape.buffer(0.5 * width, quad_segs=4)


def seen(inks: Sequence[BaseGeometry]) -> list[bool]:
    """Return for each mark, from back to front, whether any part of it is seen."""
    shapes = np.array(inks, dtype=object)
    shapely.prepare(shapes)
    left, top, right, bottom = shapely.bounds(shapes).T
    found = []
    for number, shape in enumerate(shapes):
        meets = (left < right[number]) & (left[number] < right) & (top < bottom[number]) & (top[number] < bottom)
        meets[: number + 1] = False
        found.append(_is_seen(shape, shapes[meets]))
    return found


def _is_seen(shape: BaseGeometry, above: np.ndarray) -> bool:
    # most marks that are seen show a corner, which is quick to find
    corners = shapely.get_coordinates(shape)
    if not shapely.intersects_xy(above[:, None], corners[:, 0], corners[:, 1]).any(axis=0).all():
        return True
    for other in above:
        shape = shape.difference(other)
        if shape.area < _SLIVER:
            return False
    return True
