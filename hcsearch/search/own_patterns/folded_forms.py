"""Fold angles of a folded form: a second frame of a FOLD file, with the same faces, placed in space as rigid panels.

Each face is turned as a whole, and the turn between two faces about their common edge is the fold angle there. Faces
may have separate points, as faces of thick panels have.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.search.own_patterns.fold_values import FrameValues
from hcsearch.shape.mesh import sides_of

FOLDED_ANGLE_TOLERANCE = 0.5
"""Stated fold angles (degrees) within this distance of 0 or 180 count as 0 or 180, as points are rounded; edges that
two faces share may differ by it in direction."""


class FoldedFormError(ValueError):
    """A folded form whose faces are not the rigid panels of its pattern."""


class ListedSheet(NamedTuple):
    """A flat pattern as a file lists it.

    points : (k, 3). faces : numbers of points. corners : the same without points in the middle of sides. edges : pairs
    of points.
    """

    points: Reals
    faces: Sequence[Sequence[int]]
    corners: Sequence[Sequence[int]]
    edges: Sequence[tuple[int, int]]


def folded_form_angles(
    values: FrameValues, sheet: ListedSheet, form: FrameValues, tolerance: float
) -> list[float | None]:
    """Return the fold angles of the edges in a folded form, degrees, positive for valleys; None for borders and slits.

    values, sheet : of the flat pattern. form : the frame of the folded form. tolerance : greatest distance of a corner
    from its place on a rigid panel, in the unit of the pattern.

    Angles within `FOLDED_ANGLE_TOLERANCE` of 0 or 180 count as these; the letter gives the sign of 180, which is
    positive without a letter. FoldedFormError where faces are not congruent, or turn against the assignment of their
    edge; InputFileError for unsound values of the frame.
    """
    points, faces, edges = sheet.points, sheet.faces, sheet.edges
    letters = values.of_edges("edges_assignment") if values.edges(len(points)) else None
    marks = ["U"] * len(edges) if letters is None else [str(letter).upper() for letter in letters]
    turns = _turns(values, sheet, form, tolerance)
    normals = [np.cross(points[list(face)], np.roll(points[list(face)], -1, axis=0)).sum(axis=0) for face in faces]
    up = np.sum(normals, axis=0)
    up = up / (np.linalg.norm(up) or 1.0)
    on_left: dict[tuple[int, int], int] = {}
    for number, (face, normal) in enumerate(zip(faces, normals, strict=True)):
        ring = face if float(normal @ up) >= 0.0 else face[::-1]  # some programs list faces clockwise
        on_left |= dict.fromkeys(sides_of(ring), number)
    angles: list[float | None] = []
    for k, ((a, b), letter) in enumerate(zip(edges, marks, strict=True)):
        left, right = on_left.get((a, b)), on_left.get((b, a))
        if letter in "BC" or left is None or right is None:
            if letter in "MV":
                raise FoldedFormError(f"edge {k} ({letter}) is not a side of two faces in faces_vertices")
            angles.append(None)
            continue
        along = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
        angle = _turn_between(turns[left], turns[right], along, up)
        if angle is None:
            raise FoldedFormError(f"faces {left} and {right} do not turn about edge {k}, which they share")
        angles.append(_signed(k, letter, angle))
    return angles


def _turns(values: FrameValues, sheet: ListedSheet, form: FrameValues, tolerance: float) -> list[Reals]:
    """Return the rotation of each face from the pattern to the folded form, (3, 3), by least squares."""
    unit, own_unit = form.unit()[0], values.unit()[0]
    points, places = sheet.points, form.points()
    if unit is not None and own_unit is not None:
        places = places * (unit / own_unit)
    placed = form.faces(len(places))
    if len(placed) != len(sheet.faces):
        raise FoldedFormError(f"it has {len(placed)} faces, and the pattern lists {len(sheet.faces)}")
    turns = []
    for number, (face, corners, folded) in enumerate(zip(sheet.faces, sheet.corners, placed, strict=True)):
        flat = face if len(face) == len(folded) else corners
        if len(flat) != len(folded):
            raise FoldedFormError(f"face {number} has {len(folded)} corners, and {len(face)} in the pattern")
        start, end = points[list(flat)], places[list(folded)]
        start, end = start - start.mean(axis=0), end - end.mean(axis=0)
        left, _, right = np.linalg.svd(end.T @ start)
        turn = left @ np.diag([1.0, 1.0, np.linalg.det(left) * np.linalg.det(right)]) @ right
        off = float(np.linalg.norm(start @ turn.T - end, axis=1).max())
        if off > tolerance:
            raise FoldedFormError(
                f"face {number} is not congruent to that of the pattern: a corner is {off:.3g} off its place on a "
                f"rigid panel, and up to {tolerance:.3g} is allowed"
            )
        turns.append(turn)
    return turns


def _turn_between(left: Reals, right: Reals, along: Reals, up: Reals) -> float | None:
    """Return the turn of the right face against the left one about their edge, degrees; None where that is no turn."""
    axis, other_axis = left @ along, right @ along
    if float(axis @ other_axis) < math.cos(math.radians(FOLDED_ANGLE_TOLERANCE)):
        return None
    one, two = left @ up, right @ up
    return math.degrees(math.atan2(float(np.cross(two, one) @ axis), float(one @ two)))


def _signed(edge: int, letter: str, angle: float) -> float:
    """Return the fold angle of an edge without rounding errors; FoldedFormError where its letter contradicts it."""
    size = abs(angle)
    if size < FOLDED_ANGLE_TOLERANCE:
        return 0.0
    if letter in "FJ":
        raise FoldedFormError(f"edge {edge} stays flat ({letter}), and its faces turn by {size:.3g} degrees")
    if size > 180.0 - FOLDED_ANGLE_TOLERANCE:
        return -180.0 if letter == "M" else 180.0
    if letter in "MV" and (angle > 0.0) != (letter == "V"):
        name, other = ("mountain", "valley") if letter == "M" else ("valley", "mountain")
        raise FoldedFormError(f"edge {edge} is a {name}, and its faces turn by {size:.3g} degrees as at a {other}")
    return angle
