"""Panels as solids: closed surface meshes of the prisms over their facets, in the flat state."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import ByValue, Reals, WholeNumbers
from hcsearch.basics.errors import HcsearchError
from hcsearch.shape.labels import Labels, is_label, label_ranges
from hcsearch.shape.mesh import sides_of
from hcsearch.shape.pattern import Pattern

FaceKind = Literal["top", "bottom", "side", "valley", "mountain"]
"""The kind of a face: top or bottom of the panel, a side wall without a hinge, or a wall with a hinge at its top edge
(valley) or bottom edge (mountain)."""

MILLIMETRES_PER_METRE = 1e3


@dataclass(frozen=True)
class SolidFace:
    """A plane face; corners : indices of its vertices, counterclockwise as seen from outside."""

    side: FaceKind
    corners: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class PanelSolid(ByValue):
    """A panel: a prism over the union of its facets; rigid creases and slits inside it are closed.

    points : (n, 2), corners of its facets, m. facets : its facets as indices of points. outlines : closed walks
    along points, the outer one first and counterclockwise, then those of holes, clockwise. wall : (m, 2), their edges
    with the panel on the left, sorted. sides : the kind of each of these.
    """

    points: Reals
    facets: tuple[tuple[int, ...], ...]
    outlines: tuple[tuple[int, ...], ...]
    wall: WholeNumbers
    sides: tuple[FaceKind, ...]
    thickness: float

    @property
    def vertices(self) -> Reals:
        """Vertices of the bottom face, then of the top face, (2 n, 3), m."""
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
        """The faces divided into triangles, (n, 3), indices of vertices."""
        return np.array([t for face in self.faces for t in fan_triangles(face.corners)], np.int64)


def fan_triangles(corners: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Divide a convex polygon into a fan of triangles."""
    return [(corners[0], b, c) for b, c in pairwise(corners[1:])]


def panel_solid_of(pattern: Pattern, panel: int) -> PanelSolid:
    """Return the solid of a panel in the flat state; HcsearchError where the panel touches itself in a corner."""
    faces = [pattern.faces[facet] for facet in pattern.panels[panel]]
    vertices = list(dict.fromkeys(chain.from_iterable(faces)))
    number = {vertex: k for k, vertex in enumerate(vertices)}
    outlines = pattern.outlines[panel]
    corners = list(chain.from_iterable(outlines))
    if len(set(corners)) < len(corners):
        raise HcsearchError(f"panel {panel} touches itself in a corner, which no solid may: leave its facets hinged")
    hinged = {frozenset(pattern.edges[pair]): crease.face for pair, crease in pattern.creases.items() if crease.face}
    kinds: dict[frozenset[int], FaceKind]
    kinds = {edge: "valley" if face == "top" else "mountain" for edge, face in hinged.items()}
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
    """Return the panel of a name, or None (all panels) without a name; HcsearchError for an unknown name."""
    if name is None:
        return None
    if not is_label(name):
        raise HcsearchError(f"there is no panel {name!r}: the panels are {label_ranges(labels.panels)}")
    return (labels.panel(name),)


def placed_vertices(pose: Reals, vertices: Reals) -> Reals:
    """Transform vertices (n, 3) by a pose (3, 4)."""
    moved: Reals = vertices @ pose[:, :3].T + pose[:, 3]
    return moved
