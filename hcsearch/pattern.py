"""Flat patterns of thick panels: facets, the creases between them that carry hinges or are rigid, and slits.

A pattern is drawn in the flat state, in metres, seen from above. Its atoms are convex facets that meet edge to edge;
facets joined by rigid creases are one panel, and every edge that is shared but is no crease is a slit. Designs of the
search and the assemblies of the thesis are all of this kind, and joining two of them is the union of their facets.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from hcsearch.errors import PatternError
from hcsearch.isometries import Isometry

Point = tuple[float, float]
Facet = tuple[Point, ...]
Face = Literal["top", "bottom"]
Fold = Literal["mountain", "valley", "flat"]
Pair = tuple[int, int]

SAME = 1e-7
"""Points nearer than this share of a facet's size are the same."""


@dataclass(frozen=True)
class Crease:
    """What joins two facets along the edge they share.

    face : the face that carries the hinge (top for a valley, bottom for a mountain); None where the edge is rigid.
    closes : whether the hinge is closed in the folded state (fold angle pi); a hinge between two panels of an
        outer layer stays flat there (fold angle 0).
    """

    face: Face | None
    closes: bool = True

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


RIGID = Crease(None, closes=False)
VALLEY, MOUNTAIN = Crease("top"), Crease("bottom")


@dataclass(frozen=True)
class Hinge:
    """A revolute joint between two panels, along one line of one face.

    first, second : panels; going from `start` to `end`, the first lies on the left.
    """

    first: int
    second: int
    face: Face
    start: Point
    end: Point
    closes: bool = True

    @property
    def crease(self) -> Crease:
        """The crease along the hinge."""
        return Crease(self.face, self.closes)


@dataclass(frozen=True, repr=False)
class Pattern:
    """A flat pattern of panels of one thickness; `Folding.pattern` makes that of a folding.

    facets : convex polygons whose corners run counterclockwise, in metres; facets that are joined by rigid creases
    are one panel.
    creases : how pairs of facets (i, j), i < j, that share a whole edge are joined; other shared edges are slits.
    thickness : the thickness of all panels, in metres.
    loops : closed walks over creases, one around each element that an assembly distinguishes; empty for a design.
    of_circuit : whether facets are the panels of a circuit in its order, so that hinges have the numbers of creases.
    """

    facets: tuple[Facet, ...]
    creases: Mapping[Pair, Crease]
    thickness: float
    loops: tuple[tuple[Pair, ...], ...] = field(default=())
    of_circuit: bool = False

    def __repr__(self) -> str:
        hinges, thickness = len(self.hinges), f"{1e3 * self.thickness:g} mm"
        return f"<Pattern of {len(self.facets)} facets, {len(self.panels)} panels, {hinges} hinges, {thickness} thick>"

    def __hash__(self) -> int:
        return hash((self.facets, frozenset(self.creases.items()), self.thickness))

    def __post_init__(self) -> None:
        if not self.thickness > 0:
            raise PatternError(f"panels {self.thickness * 1e3:g} mm thick do not exist: give a positive thickness")
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
    def size(self) -> float:
        """The side of a square of a panel's mean area, in metres, by which gaps are divided to compare with angles."""
        return math.sqrt(self.area / len(self.panels))

    @cached_property
    def area(self) -> float:
        """Area of the flat pattern, in square metres."""
        return sum(map(facet_area, self.facets))

    @cached_property
    def _tolerance(self) -> float:
        return SAME * math.sqrt(min(map(facet_area, self.facets)))

    @cached_property
    def edges(self) -> dict[Pair, tuple[Point, Point]]:
        """Edges shared by two facets (i, j), i < j, from start to end with facet i on the left."""
        corners = Places(self._tolerance)
        sides: dict[tuple[int, int], tuple[int, Point, Point]] = {}
        shared = {}
        for number, facet in enumerate(self.facets):
            for a, b in zip(facet, (*facet[1:], facet[0]), strict=True):
                ends = corners.number(a), corners.number(b)
                if ends in sides:
                    raise PatternError(f"facets {sides[ends][0]} and {number} overlap: they lie on one side of an edge")
                sides[ends] = (number, a, b)
        for (a_key, b_key), (number, a, b) in sides.items():
            other = sides.get((b_key, a_key))
            if other is not None and number < other[0]:
                shared[number, other[0]] = (a, b)
        return shared

    @cached_property
    def panel_of(self) -> tuple[int, ...]:
        """The panel to which each facet belongs."""
        of = [0] * len(self.facets)
        for number, panel in enumerate(self.panels):
            for facet in panel:
                of[facet] = number
        return tuple(of)

    @cached_property
    def panels(self) -> tuple[tuple[int, ...], ...]:
        """The facets of each panel; panels are in the order of their first facets."""
        import networkx as nx  # noqa: PLC0415 - most of what imports this module makes no pattern

        graph = nx.Graph()
        graph.add_nodes_from(range(len(self.facets)))
        graph.add_edges_from(pair for pair, crease in self.creases.items() if crease.face is None)
        return tuple(sorted(tuple(sorted(part)) for part in nx.connected_components(graph)))

    @cached_property
    def hinges(self) -> tuple[Hinge, ...]:
        """The hinges; creases between the same two panels on one line of one face are one hinge."""
        return self._joints[0]

    @cached_property
    def _joints(self) -> tuple[tuple[Hinge, ...], dict[Pair, int]]:
        """The hinges, and which of them each crease is part of."""
        hinges: list[Hinge] = []
        between: dict[Pair, list[int]] = {}
        number: dict[Pair, int] = {}
        for pair in self.creases:
            hinge = self._hinge(pair)
            if hinge is None:
                continue
            known = between.setdefault((hinge.first, hinge.second), [])
            for k in known:
                if _one_line(hinges[k], hinge, self._tolerance):
                    hinges[k] = _spanning(hinges[k], hinge)
                    number[pair] = k
                    break
            else:
                number[pair] = len(hinges)
                known.append(len(hinges))
                hinges.append(hinge)
        return tuple(hinges), number

    def _hinge(self, pair: Pair) -> Hinge | None:
        crease = self.creases[pair]
        if crease.face is None:
            return None
        first, second = self.panel_of[pair[0]], self.panel_of[pair[1]]
        start, end = self.edges[pair]
        if first > second:
            first, second, start, end = second, first, end, start
        return Hinge(first, second, crease.face, start, end, crease.closes)

    def hinge_of(self, pair: Pair) -> int:
        """The number of the hinge to which the crease between two facets belongs."""
        return self._joints[1][min(pair), max(pair)]

    @property
    def kutzbach(self) -> int:
        """Degrees of freedom by the Kutzbach criterion, 6(n-1)-5j for n panels and j hinges (thesis eq. 2.4)."""
        return 6 * (len(self.panels) - 1) - 5 * len(self.hinges)

    def with_creases(self, creases: Mapping[Pair, Crease]) -> Pattern:
        """The pattern with some creases replaced; rigid ones merge panels (thesis 3.2.1 and 4.1.1)."""
        return replace(self, creases={**self.creases, **creases})

    def placed(self, isometry: Isometry) -> Pattern:
        """The image of the pattern under an isometry (m); a reflection turns the sheet over and exchanges its faces."""
        over = isometry.reflects
        facets = tuple(tuple(map(isometry.image, facet if not over else reversed(facet))) for facet in self.facets)
        creases = {pair: crease.inverted if over else crease for pair, crease in self.creases.items()}
        return replace(self, facets=facets, creases=creases)

    def moved(self, turn: float = 0.0, shift: Point = (0.0, 0.0), *, over: bool = False) -> Pattern:
        """The pattern turned about the origin by an angle (rad) and shifted (m).

        over : turn the sheet over first, about the x axis: top and bottom are exchanged with the reflection.
        """
        return self.placed(Isometry.by(turn, shift, reflects=over))

    def inverted(self) -> Pattern:
        """The same drawing with mountains and valleys exchanged."""
        return replace(self, creases={pair: crease.inverted for pair, crease in self.creases.items()})


def overlay(patterns: Sequence[Pattern]) -> Pattern:
    """The union of patterns drawn on one plane: facets that coincide are one, and so are their creases.

    A crease that is rigid in one pattern merges its panels in the union. PatternError where hinges lie on different
    faces, where a hinge of one pattern runs through a panel of another, or where two facets lie on one side of an
    edge; facets that overlap without sharing an edge are for the caller to exclude.
    """
    tolerance = min(pattern._tolerance for pattern in patterns)
    centres = Places(tolerance)
    facets: list[Facet] = []
    creases: dict[Pair, Crease] = {}
    loops: list[tuple[Pair, ...]] = []
    for pattern in patterns:
        number = [centres.number(_centre(facet)) for facet in pattern.facets]
        for facet, k in zip(pattern.facets, number, strict=True):
            if k == len(facets):
                facets.append(facet)
            elif not _same(facet, facets[k], tolerance):
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
    return Pattern(tuple(facets), creases, patterns[0].thickness, tuple(loops))


_SHARE, _REACH = 0.25, 0.26
"""The tolerance as a share of the cells that points are looked up in, and how far a point looks, rounding included."""


class Places:
    """Numbers of points of the plane, the same for points nearer than a tolerance."""

    def __init__(self, tolerance: float) -> None:
        self._step = tolerance / _SHARE
        self._near = tolerance
        self._known: dict[tuple[int, int], list[tuple[Point, int]]] = {}
        self._count = 0

    def number(self, point: Point) -> int:
        """The number of a point: that of the first one that is the same."""
        x, y = point[0] / self._step, point[1] / self._step
        rows = range(math.floor(y - _REACH), math.floor(y + _REACH) + 1)
        for i in range(math.floor(x - _REACH), math.floor(x + _REACH) + 1):
            for j in rows:
                for other, number in self._known.get((i, j), ()):
                    if math.dist(point, other) < self._near:
                        return number
        self._known.setdefault((math.floor(x), math.floor(y)), []).append((point, self._count))
        self._count += 1
        return self._count - 1


def facet_area(facet: Sequence[Point]) -> float:
    """Area of a polygon whose corners run counterclockwise."""
    sides = zip(facet, (*facet[1:], facet[0]), strict=True)
    return 0.5 * sum(x * to_y - y * to_x for (x, y), (to_x, to_y) in sides)


def _centre(facet: Iterable[Point]) -> Point:
    x, y = np.mean(list(facet), axis=0)
    return (float(x), float(y))


def _same(one: Facet, two: Facet, tolerance: float) -> bool:
    """Whether two facets have the same corners."""
    return len(one) == len(two) and all(min(math.dist(p, q) for q in two) < 4 * tolerance for p in one)


def _one_line(one: Hinge, two: Hinge, tolerance: float) -> bool:
    """Whether two hinges join the same panels on one line of one face."""
    if (one.first, one.second, one.face, one.closes) != (two.first, two.second, two.face, two.closes):
        return False
    ux, uy = one.end[0] - one.start[0], one.end[1] - one.start[1]
    length = math.hypot(ux, uy)
    return all(
        abs(ux * (p[1] - one.start[1]) - uy * (p[0] - one.start[0])) < tolerance * length for p in (two.start, two.end)
    )


def _spanning(one: Hinge, two: Hinge) -> Hinge:
    """One hinge over the extent of two on one line."""
    ux, uy = one.end[0] - one.start[0], one.end[1] - one.start[1]
    ends = sorted((one.start, one.end, two.start, two.end), key=lambda p: ux * p[0] + uy * p[1])
    return replace(one, start=ends[0], end=ends[-1])
