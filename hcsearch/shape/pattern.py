"""Flat patterns of thick panels: facets, the creases between them that carry hinges or are rigid, and slits.

A pattern is drawn in the flat state, in metres, seen from above. It consists of convex facets that meet edge to edge;
facets joined by rigid creases are one panel, and every shared edge that is no crease is a slit. Designs of the search
and the assemblies of the thesis are all of this kind, and two of them are joined by the union of their facets.

A pattern is stored as an indexed mesh: a table of vertices, and the vertex numbers of each facet. Facets that meet in a
point name the same vertex, so that no reader has to compare coordinates.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, islice
from typing import Literal

import numpy as np

from hcsearch.basics.errors import PatternError
from hcsearch.shape.isometries import Isometry
from hcsearch.shape.mesh import (
    Edge,
    Facet,
    PlanePoint,
    components,
    distinct_points,
    facet_area,
    outline_of,
    polygon_mesh,
    same_point_distance,
    sides_of,
)

PanelFace = Literal["top", "bottom"]
Fold = Literal["mountain", "valley", "flat"]
FacetPair = tuple[int, int]


@dataclass(frozen=True)
class Crease:
    """The joint of two facets along their shared edge.

    face : the face that carries the hinge (top for a valley, bottom for a mountain); None where the edge is rigid.
    closes : whether the hinge is turned in the folded state; a hinge between two panels of an outer layer stays flat
        there (fold angle 0).
    angle : its fold angle there if it is: pi, where it is closed, or less, rad.
    """

    face: PanelFace | None
    closes: bool = True
    angle: float = math.pi

    @property
    def fold(self) -> Fold:
        """Mountain or valley, as seen from above; flat where the edge is rigid or its hinge stays flat."""
        if not self.closes:
            return "flat"
        return "valley" if self.face == "top" else "mountain"

    @property
    def inverted(self) -> Crease:
        """The same crease with the sheet turned over."""
        if self.face is None:
            return self
        return replace(self, face="bottom" if self.face == "top" else "top")


RIGID_CREASE = Crease(None, closes=False)
VALLEY_CREASE, MOUNTAIN_CREASE = Crease("top"), Crease("bottom")


@dataclass(frozen=True)
class Hinge:
    """A revolute joint between two panels, along one line of one face.

    first, second : panels; going from `start` to `end`, the first lies on the left.
    """

    first: int
    second: int
    face: PanelFace
    start: PlanePoint
    end: PlanePoint
    closes: bool = True
    angle: float = math.pi

    @property
    def crease(self) -> Crease:
        """The crease along the hinge."""
        return Crease(self.face, self.closes, self.angle)

    @property
    def folded_angle(self) -> float:
        """The fold angle in the folded state, rad."""
        return self.angle if self.closes else 0.0


@dataclass(frozen=True, repr=False)
class Pattern:
    """A flat pattern of panels of one thickness; `Folding.pattern` makes that of a folding.

    Parameters
    ----------
    vertices
        Points in metres, each once.
    faces
        The vertices of each facet by number, counterclockwise; facets are convex, and those that are joined by rigid
        creases are one panel.
    creases
        How pairs of facets (i, j), i < j, that share a whole edge are joined; other shared edges are slits.
    thickness
        The thickness of all panels, in metres.
    loops
        Closed walks over creases, one around each element that an assembly distinguishes; empty for a design.
    of_circuit
        Whether facets are the panels of a circuit in its order, so that hinges have the numbers of creases.
    """

    vertices: tuple[PlanePoint, ...]
    faces: tuple[tuple[int, ...], ...]
    creases: Mapping[FacetPair, Crease]
    thickness: float
    loops: tuple[tuple[FacetPair, ...], ...] = field(default=())
    of_circuit: bool = False

    @staticmethod
    def from_polygons(
        polygons: Sequence[Facet],
        creases: Mapping[FacetPair, Crease],
        thickness: float,
        loops: tuple[tuple[FacetPair, ...], ...] = (),
    ) -> Pattern:
        """Make the pattern whose facets are convex polygons, corners counterclockwise, in metres.

        Corners nearer than `mesh.SAME_POINT_SHARE` times the smallest facet's size are one vertex.
        """
        return Pattern(*polygon_mesh(polygons), creases, thickness, loops)

    def __repr__(self) -> str:
        hinges, thickness = len(self.hinges), f"{1e3 * self.thickness:g} mm"
        return f"<Pattern of {len(self.faces)} facets, {len(self.panels)} panels, {hinges} hinges, {thickness} thick>"

    def __hash__(self) -> int:
        return hash((self.vertices, self.faces, frozenset(self.creases.items()), self.thickness))

    def __post_init__(self) -> None:
        if not self.thickness > 0:
            raise PatternError(f"panels {self.thickness * 1e3:g} mm thick do not exist: give a positive thickness")
        if set(chain.from_iterable(self.faces)) != set(range(len(self.vertices))):
            raise PatternError(
                f"faces name vertices by the numbers 0 to {len(self.vertices) - 1}, each at least once: "
                "use Pattern.from_polygons for facets that are given by their corners"
            )
        for pair in self.creases:
            if pair not in self.edges:
                raise PatternError(
                    f"facets {pair[0]} and {pair[1]} share no edge: a crease joins neighbours, given in rising order"
                )
        for first, second in (pair for pair, crease in self.creases.items() if crease.face is not None):
            if self.panel_of[first] == self.panel_of[second]:
                raise PatternError(
                    f"facets {first} and {second} have a hinge between them but belong to one panel: rigid creases "
                    "lead around it; leave the hinge out or fewer creases rigid"
                )

    @cached_property
    def facets(self) -> tuple[Facet, ...]:
        """The corners of each facet, counterclockwise, in metres."""
        return tuple(tuple(self.vertices[v] for v in face) for face in self.faces)

    @cached_property
    def size(self) -> float:
        """The root of the mean area of a panel, in metres, by which gaps are divided for comparison with angles."""
        return math.sqrt(self.area / len(self.panels))

    @cached_property
    def area(self) -> float:
        """Area of the flat pattern, in square metres."""
        return sum(map(facet_area, self.facets))

    @cached_property
    def _same_distance(self) -> float:
        return same_point_distance(self.facets)

    @cached_property
    def edges(self) -> dict[FacetPair, Edge]:
        """Edges shared by two facets (i, j), i < j: their vertices, from start to end with facet i on the left."""
        left: dict[Edge, int] = {}
        for number, face in enumerate(self.faces):
            for side in sides_of(face):
                if side in left:
                    raise PatternError(f"facets {left[side]} and {number} overlap: they lie on one side of an edge")
                left[side] = number
        beside = ((first, left.get((end, start), -1), (start, end)) for (start, end), first in left.items())
        return {(first, second): edge for first, second, edge in beside if first < second}

    def segment(self, pair: FacetPair) -> tuple[PlanePoint, PlanePoint]:
        """The edge shared by two facets, from start to end with the first facet on the left; in metres."""
        start, end = self.edges[pair]
        return self.vertices[start], self.vertices[end]

    @cached_property
    def outlines(self) -> tuple[tuple[tuple[int, ...], ...], ...]:
        """The boundary of each panel as closed walks of vertices with the panel on the left.

        The outer walk comes first, counterclockwise; walks around holes are clockwise. Slits inside a panel are closed.
        """
        return tuple(outline_of([self.faces[facet] for facet in panel], self.vertices) for panel in self.panels)

    @cached_property
    def panel_of(self) -> tuple[int, ...]:
        """The panel to which each facet belongs."""
        panel_numbers = [0] * len(self.faces)
        for number, panel in enumerate(self.panels):
            for facet in panel:
                panel_numbers[facet] = number
        return tuple(panel_numbers)

    @cached_property
    def panels(self) -> tuple[tuple[int, ...], ...]:
        """The facets of each panel; panels are in the order of their first facets."""
        rigid = (pair for pair, crease in self.creases.items() if crease.face is None)
        return tuple(tuple(sorted(part)) for part in components(range(len(self.faces)), rigid))

    @cached_property
    def hinges(self) -> tuple[Hinge, ...]:
        """The hinges; creases between the same two panels on one line of one face are one hinge."""
        return self._joints[0]

    @cached_property
    def _joints(self) -> tuple[tuple[Hinge, ...], dict[FacetPair, int]]:
        """The hinges, and the number of the hinge to which each crease belongs."""
        hinges: list[Hinge] = []
        between: dict[FacetPair, list[int]] = {}
        number: dict[FacetPair, int] = {}
        for pair in self.creases:
            hinge = self._hinge(pair)
            if hinge is None:
                continue
            known = between.setdefault((hinge.first, hinge.second), [])
            for k in known:
                if _one_line(hinges[k], hinge, self._same_distance):
                    hinges[k] = _spanning(hinges[k], hinge)
                    number[pair] = k
                    break
            else:
                number[pair] = len(hinges)
                known.append(len(hinges))
                hinges.append(hinge)
        return tuple(hinges), number

    def _hinge(self, pair: FacetPair) -> Hinge | None:
        crease = self.creases[pair]
        if crease.face is None:
            return None
        first, second = self.panel_of[pair[0]], self.panel_of[pair[1]]
        start, end = self.segment(pair)
        if first > second:
            first, second, start, end = second, first, end, start
        return Hinge(first, second, crease.face, start, end, crease.closes, crease.angle)

    def hinge_of(self, pair: FacetPair) -> int:
        """The number of the hinge to which the crease between two facets belongs."""
        return self._joints[1][min(pair), max(pair)]

    @property
    def kutzbach(self) -> int:
        """Degrees of freedom by the Kutzbach criterion, 6(n-1)-5j for n panels and j hinges (thesis eq. 2.4)."""
        return 6 * (len(self.panels) - 1) - 5 * len(self.hinges)

    def with_creases(self, creases: Mapping[FacetPair, Crease]) -> Pattern:
        """The pattern with some creases replaced; rigid ones merge panels (thesis 3.2.1 and 4.1.1)."""
        return replace(self, creases={**self.creases, **creases})

    def placed(self, isometry: Isometry) -> Pattern:
        """The image of the pattern under an isometry (m); a reflection turns the sheet over and exchanges its faces."""
        vertices = tuple(map(isometry.image, self.vertices))
        if not isometry.reflects:
            return replace(self, vertices=vertices)
        faces = tuple(face[::-1] for face in self.faces)
        creases = {pair: crease.inverted for pair, crease in self.creases.items()}
        return replace(self, vertices=vertices, faces=faces, creases=creases)

    def moved(self, turn: float = 0.0, shift: PlanePoint = (0.0, 0.0), *, over: bool = False) -> Pattern:
        """The pattern rotated about the origin and shifted.

        Parameters
        ----------
        turn
            The angle, rad.
        shift
            The vector, m.
        over
            Turn the sheet over first, about the x axis: this reflects it and exchanges top and bottom.
        """
        return self.placed(Isometry.by(turn, shift, reflects=over))

    def inverted(self) -> Pattern:
        """The same drawing with mountains and valleys exchanged."""
        return replace(self, creases={pair: crease.inverted for pair, crease in self.creases.items()})


def overlay(patterns: Sequence[Pattern]) -> Pattern:
    """The union of patterns drawn on one plane: facets that coincide are merged, and so are their creases.

    A crease that is rigid in one pattern merges its panels in the union. PatternError where hinges lie on different
    faces, where a hinge of one pattern runs through a panel of another, or where two facets lie on one side of an
    edge; facets that overlap without sharing an edge are for the caller to exclude.
    """
    tolerance = min(pattern._same_distance for pattern in patterns)
    vertices, numbers = distinct_points([point for pattern in patterns for point in pattern.vertices], tolerance)
    _, centres = distinct_points([_centre(facet) for pattern in patterns for facet in pattern.facets], tolerance)
    corners, middles = iter(numbers), iter(centres)
    faces: list[tuple[int, ...]] = []
    creases: dict[FacetPair, Crease] = {}
    loops: list[tuple[FacetPair, ...]] = []
    for pattern in patterns:
        vertex = list(islice(corners, len(pattern.vertices)))
        number = list(islice(middles, len(pattern.faces)))
        for face, k in zip(pattern.faces, number, strict=True):
            corner_numbers = tuple(vertex[v] for v in face)
            if k == len(faces):
                faces.append(corner_numbers)
            elif set(corner_numbers) != set(faces[k]):
                raise PatternError(f"a facet laid onto facet {k} has another outline: facets coincide, or lie apart")
        for (i, j), crease in pattern.creases.items():
            pair = (min(number[i], number[j]), max(number[i], number[j]))
            if creases.setdefault(pair, crease) != crease:
                raise PatternError(
                    f"facets {pair[0]} and {pair[1]} are joined in different ways by patterns laid together"
                )
        for loop in pattern.loops:
            walk = tuple((min(number[i], number[j]), max(number[i], number[j])) for i, j in loop)
            if walk not in loops:
                loops.append(walk)
    thicknesses = {pattern.thickness for pattern in patterns}
    if len(thicknesses) > 1:
        raise PatternError("patterns of different thickness cannot be laid together: give them one")
    return Pattern(vertices, tuple(faces), creases, patterns[0].thickness, tuple(loops))


def _centre(facet: Iterable[PlanePoint]) -> PlanePoint:
    x, y = np.mean(list(facet), axis=0)
    return (float(x), float(y))


def _one_line(first: Hinge, second: Hinge, tolerance: float) -> bool:
    """Whether two hinges join the same panels on one line of one face."""
    if (first.first, first.second, first.crease) != (second.first, second.second, second.crease):
        return False
    ux, uy = first.end[0] - first.start[0], first.end[1] - first.start[1]
    length = math.hypot(ux, uy)
    return all(
        abs(ux * (p[1] - first.start[1]) - uy * (p[0] - first.start[0])) < tolerance * length
        for p in (second.start, second.end)
    )


def _spanning(first: Hinge, second: Hinge) -> Hinge:
    """The hinge that spans two hinges on one line."""
    ux, uy = first.end[0] - first.start[0], first.end[1] - first.start[1]
    ends = sorted((first.start, first.end, second.start, second.end), key=lambda p: ux * p[0] + uy * p[1])
    return replace(first, start=ends[0], end=ends[-1])
