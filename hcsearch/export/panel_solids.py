"""Panels as solids: closed meshes of the prisms over their facets, in the flat state."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from hcsearch.equality import ByValue
from hcsearch.errors import HcsearchError
from hcsearch.labels import Labels, is_name, ranges
from hcsearch.linkage import Linkage
from hcsearch.pattern import Pattern, Point
from hcsearch.typing import Reals, Whole

Side = Literal["top", "bottom", "side", "valley", "mountain"]
"""What a face is: top or bottom of the panel, a wall without a hinge, or one with a hinge on its top or bottom edge."""

SAME = 1e-6
"""Corners of facets of a panel nearer than this share of the pattern's size are one."""
MILLIMETRES = 1e3


@dataclass(frozen=True)
class Face:
    """A plane face: its corners in order, counterclockwise as seen from outside; numbers of vertices."""

    side: Side
    corners: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Solid(ByValue):
    """A panel: a prism over a polygon that is made of its facets; rigid creases and slits inside it are closed.

    points : (n, 2), corners of its facets, m. wall : (m, 2), the outline's edges, numbers of points, with the panel on
    the left. facets : its facets as numbers of points.
    """

    points: Reals
    facets: tuple[tuple[int, ...], ...]
    wall: Whole
    sides: tuple[Side, ...]
    thickness: float

    @property
    def vertices(self) -> Reals:
        """Points of the bottom face, then of the top face, (2 n, 3), m."""
        n = len(self.points)
        heights = np.repeat([0.0, self.thickness], n)
        return np.column_stack([np.vstack([self.points, self.points]), heights])

    @property
    def faces(self) -> list[Face]:
        """Bottom and top faces of each facet, and the walls."""
        n = len(self.points)
        faces = [Face("bottom", tuple(reversed(facet))) for facet in self.facets]
        faces += [Face("top", tuple(k + n for k in facet)) for facet in self.facets]
        walls = zip(self.wall.tolist(), self.sides, strict=True)
        return faces + [Face(side, (a, b, b + n, a + n)) for (a, b), side in walls]

    @property
    def triangles(self) -> Whole:
        """The faces as triangles, (n, 3), numbers of vertices."""
        return np.array([t for face in self.faces for t in fan(face.corners)], np.int64)

    @property
    def outlines(self) -> list[list[int]]:
        """The outline as closed walks of numbers of points: the outer one counterclockwise, those of holes clockwise.

        The outer one comes first.
        """
        after = dict(self.wall.tolist())
        walks = []
        while after:
            start, to = after.popitem()
            walk = [start]
            while to != start:
                walk.append(to)
                to = after.pop(to)
            walks.append(walk)
        return sorted(walks, key=lambda walk: -_area(self.points[walk]))


def fan(corners: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Triangles of a convex polygon."""
    return [(corners[0], b, c) for b, c in pairwise(corners[1:])]


def solid_of(pattern: Pattern, panel: int) -> Solid:
    """The solid of a panel; its corners are those of the flat state."""
    points: list[Point] = []
    facets = []
    for facet in pattern.panels[panel]:
        facets.append(tuple(_number(points, corner, SAME * pattern.size) for corner in pattern.facets[facet]))
    edges = {(a, b) for facet in facets for a, b in zip(facet, (*facet[1:], facet[0]), strict=True)}
    wall = [(a, b) for a, b in edges if (b, a) not in edges]
    if len(dict(wall)) < len(wall):
        raise HcsearchError(f"panel {panel} touches itself in a corner, which no solid may: leave its facets hinged")
    wall.sort()
    table = np.array(points)
    return Solid(table, tuple(facets), np.array(wall), _sides(pattern, panel, table, wall), pattern.thickness)


def wanted_panels(labels: Labels, name: str | None) -> tuple[int, ...] | None:
    """The panel of a name, None for all where no name is given; HcsearchError where there is none of that name."""
    if name is None:
        return None
    if not is_name(name):
        raise HcsearchError(f"there is no panel {name!r}: the panels are {ranges(labels.panels)}")
    return (labels.panel(name),)


def placed(pose: Reals, vertices: Reals) -> Reals:
    """Vertices, (n, 3), where a pose (3, 4) takes them."""
    moved: Reals = vertices @ pose[:, :3].T + pose[:, 3]
    return moved


def solids_of(linkage: Linkage) -> list[Solid]:
    """The solids of all panels."""
    return [solid_of(linkage.pattern, panel) for panel in range(linkage.n_panels)]


def _sides(pattern: Pattern, panel: int, points: Reals, wall: list[tuple[int, int]]) -> tuple[Side, ...]:
    """Which walls carry a hinge: by the middles of the creases, as hinges on one line are one."""
    near = SAME * pattern.size
    creased: list[tuple[Side, Reals]] = []
    for pair, crease in pattern.creases.items():
        if crease.face is not None and panel in (pattern.panel_of[pair[0]], pattern.panel_of[pair[1]]):
            side: Side = "valley" if crease.face == "top" else "mountain"
            creased.append((side, np.mean(pattern.edges[pair], axis=0)))
    sides: list[Side] = []
    for a, b in wall:
        middle = 0.5 * (points[a] + points[b])
        sides.append(next((side for side, at in creased if np.linalg.norm(at - middle) < near), "side"))
    return tuple(sides)


def _number(points: list[Point], corner: Point, near: float) -> int:
    for k, point in enumerate(points):
        if math.dist(point, corner) < near:
            return k
    points.append(corner)
    return len(points) - 1


def _area(polygon: Reals) -> float:
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
