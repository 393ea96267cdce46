"""Panels as solids: closed meshes of the prisms over their facets, in the flat state."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.labels import Labels, is_label, label_ranges
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import sides_of
from hcsearch.shape.pattern import Pattern

FaceKind = Literal["top", "bottom", "side", "valley", "mountain"]
"""What a face is: top or bottom of the panel, a wall without a hinge, or one with a hinge on its top or bottom edge."""

MILLIMETRES_PER_METRE = 1e3


@dataclass(frozen=True)
class SolidFace:
    """A plane face: its corners in order, counterclockwise as seen from outside; numbers of vertices."""

    side: FaceKind
    corners: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class PanelSolid(ByValue):
    """A panel: a prism over a polygon that is made of its facets; rigid creases and slits inside it are closed.

    points : (n, 2), corners of its facets, m. facets : its facets as numbers of points. outlines : closed walks of
    points, the outer one counterclockwise and first, then those of holes, clockwise. wall : (m, 2), their edges with
    the panel on the left, sorted. sides : what each of these is.
    """

    points: Reals
    facets: tuple[tuple[int, ...], ...]
    outlines: tuple[tuple[int, ...], ...]
    wall: WholeNumbers
    sides: tuple[FaceKind, ...]
    thickness: float

    @property
    def vertices(self) -> Reals:
        """Points of the bottom face, then of the top face, (2 n, 3), m."""
        n = len(self.points)
        heights = np.repeat([0.0, self.thickness], n)
        return np.column_stack([np.vstack([self.points, self.points]), heights])

    @property
    def faces(self) -> list[SolidFace]:
        """Bottom and top faces of each facet, and the walls."""
        n = len(self.points)
        faces = [SolidFace("bottom", tuple(reversed(facet))) for facet in self.facets]
        faces += [SolidFace("top", tuple(k + n for k in facet)) for facet in self.facets]
        walls = zip(self.wall.tolist(), self.sides, strict=True)
        return faces + [SolidFace(side, (a, b, b + n, a + n)) for (a, b), side in walls]

    @property
    def triangles(self) -> WholeNumbers:
        """The faces as triangles, (n, 3), numbers of vertices."""
        return np.array([t for face in self.faces for t in fan_triangles(face.corners)], np.int64)


def fan_triangles(corners: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Triangles of a convex polygon."""
    return [(corners[0], b, c) for b, c in pairwise(corners[1:])]


def panel_solid_of(pattern: Pattern, panel: int) -> PanelSolid:
    """The solid of a panel; its corners are those of the flat state."""
    faces = [pattern.faces[facet] for facet in pattern.panels[panel]]
    vertices = list(dict.fromkeys(chain.from_iterable(faces)))
    number = {vertex: k for k, vertex in enumerate(vertices)}
    outlines = pattern.outlines[panel]
    corners = list(chain.from_iterable(outlines))
    if len(set(corners)) < len(corners):
        raise HcsearchError(f"panel {panel} touches itself in a corner, which no solid may: leave its facets hinged")
    kinds: dict[frozenset[int], FaceKind] = {
        frozenset(pattern.edges[pair]): "valley" if crease.face == "top" else "mountain"
        for pair, crease in pattern.creases.items()
        if crease.face is not None
    }
    wall = sorted((number[a], number[b]) for walk in outlines for a, b in sides_of(walk))
    return PanelSolid(
        np.array([pattern.vertices[vertex] for vertex in vertices]),
        tuple(tuple(number[vertex] for vertex in face) for face in faces),
        tuple(tuple(number[vertex] for vertex in walk) for walk in outlines),
        np.array(wall),
        tuple(kinds.get(frozenset((vertices[a], vertices[b])), "side") for a, b in wall),
        pattern.thickness,
    )


def wanted_panels(labels: Labels, name: str | None) -> tuple[int, ...] | None:
    """The panel of a name, None for all where no name is given; HcsearchError where there is none of that name."""
    if name is None:
        return None
    if not is_label(name):
        raise HcsearchError(f"there is no panel {name!r}: the panels are {label_ranges(labels.panels)}")
    return (labels.panel(name),)


def placed_vertices(pose: Reals, vertices: Reals) -> Reals:
    """Vertices, (n, 3), where a pose (3, 4) takes them."""
    moved: Reals = vertices @ pose[:, :3].T + pose[:, 3]
    return moved


def all_panel_solids(linkage: Linkage) -> list[PanelSolid]:
    """The solids of all panels."""
    return [panel_solid_of(linkage.pattern, panel) for panel in range(linkage.n_panels)]
