"""Elements of the unit search: foldings with rigid flat creases, on regular grids or with isosceles triangles.

Among pairs of opposite creases, only the flat creases of a two-stack folding can be rigid: any other crease is closed
in the stacks, where its panels lie on each other, while they lie side by side in the flat state.

In the stacks every panel lies on one of two base triangles, which are adjacent along the flat creases. Unfolding each
stack by reflections about its creases gives the flat state, where the second flat crease must fit and panels that
share a corner on the regular grid must still share it. Source: thesis 5.3.2, which requires it for the circuit of ten.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

from hcsearch.basics.errors import PatternError, SizeError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.designs.twisting import twist
from hcsearch.library.assemblies.named_assembly import check_base_angle
from hcsearch.library.assemblies.packages import flat_overlap
from hcsearch.library.unit_search.unit_proofs import closes_when_folded, has_locked_end
from hcsearch.motion.kinematics.numerical_rank import generic_rank
from hcsearch.search.enumeration import PolygonSearch, search_all
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.mesh import SAME_POINT_SHARE, polygon_mesh
from hcsearch.shape.pattern import Pattern


@dataclass(frozen=True)
class Element:
    """A folding with rigid flat creases.

    merged : whether panels that meet on a mirror axis through the flat creases are merged.
    shape : for isosceles triangles, the corner of the apex and the position of outer triangles; empty on regular grids.
    alpha : base angle of isosceles triangles in degrees; None on regular grids.
    """

    folding: Folding
    merged: bool
    pattern: Pattern
    shape: str = ""
    alpha: float | None = None

    @property
    def name(self) -> str:
        """The folding's notation, with the merging, shape and base angle of the element."""
        parts = [self.folding.notation, "merged" if self.merged else "", self.shape]
        if self.alpha is not None:
            parts.append(f"alpha={self.alpha:g}")
        return " ".join(filter(None, parts))

    @cached_property
    def linkage(self) -> Linkage:
        """The element as a linkage."""
        return Linkage(self.pattern)

    @cached_property
    def dof(self) -> int | None:
        """Degrees of freedom at a generic state; None if undecided."""
        return generic_rank(self.linkage).nullity

    @cached_property
    def locked(self) -> bool:
        """Whether its folded or its flat state is proved locked."""
        return has_locked_end(self.linkage)


@dataclass(frozen=True)
class RigidPair:
    """The effect of making two opposite creases of a design rigid.

    verdict : `no fold` where these creases are not the flat ones of a folding, `twisted`, `locked`, or `element`.
    dof : degrees of freedom with the pair rigid. dof_merged : with mirror pairs of panels merged, too. Both are None
        where there is no such element or the number is undecided.
    """

    crease: int
    opposite: int
    verdict: str
    dof: int | None = None
    dof_merged: int | None = None


def rigid_pairs(circuit: Circuit) -> list[RigidPair]:
    """Return for each pair of opposite creases whether both can be rigid, and the remaining freedom."""
    half = circuit.n // 2
    known = {folding.crease: folding for folding in foldings(circuit)}
    return [_rigid_pair(known.get(crease), crease, half) for crease in range(half if circuit.n % 2 == 0 else 0)]


def _rigid_pair(folding: Folding | None, crease: int, half: int) -> RigidPair:
    if folding is None:
        return RigidPair(crease, crease + half, "no fold")
    if twist(folding):
        return RigidPair(crease, crease + half, "twisted")
    unmerged, *merged = elements_of(folding)
    verdict = "locked" if unmerged.locked else "element"
    return RigidPair(crease, crease + half, verdict, unmerged.dof, merged[0].dof if merged else None)


def elements_of(folding: Folding) -> list[Element]:
    """Return the element of a folding on its regular grid, and the one with merged mirror pairs if there are any."""
    size = default_panel(folding.circuit.grid.name)
    variants = [Element(folding, False, folding.pattern(size))]
    if folding.mirror_pairs:
        variants.append(Element(folding, True, folding.pattern(size, flat_pairs="merged")))
    return variants


def elements_of_designs(grid: str, n: int) -> Iterator[Element]:
    """Yield the elements with a folded state from all untwisted foldings of n panels."""
    for folding in untwisted_foldings_of(grid, n):
        for element in elements_of(folding):
            if element.linkage.n_hinges and closes_when_folded(element.linkage):
                yield element


def untwisted_foldings_of(grid: str, n: int) -> Iterator[Folding]:
    """Yield the untwisted foldings of all designs of n panels; SizeError for an odd or too small n."""
    tiling = grid_named(grid)
    if n % 2 or n < 4:
        raise SizeError(f"{n} panels do not fold into two stacks: give an even number from 4 up")
    search = PolygonSearch(tiling, n) if n < 14 else search_all(tiling, n, "untwisted")
    for batch in search.batches():
        for word in batch.words.tolist():
            circuit = Circuit(tiling, tuple(word))
            yield from (folding for folding in foldings(circuit) if not twist(folding))


BaseTriangleAngles = tuple[float, float, float]
"""Angles (rad) of the base triangle behind the first flat crease: at its right end, at its left end, and opposite."""
TriangleCorner = tuple[int, int]
BaseTriangle = Mapping[TriangleCorner, complex]

PARALLELOGRAM_KIND, KITE_KIND = "parallelogram", "kite"


def isosceles_elements(n: int, alpha: float) -> Iterator[Element]:
    """Yield elements of isosceles triangles with closed slits from all untwisted foldings of n triangles.

    alpha : base angle in degrees. The shape of an element names its outer panels and the position of the apex: opposite
        the flat crease in a rhombus, at its right or left end in a parallelogram or a kite.
    """
    for folding in untwisted_foldings_of("triangle", n):
        for shape, kind, angles in isosceles_shapes(alpha):
            pattern = element_with_triangles(folding, angles, kind)
            if pattern is None:
                continue
            variants = [Element(folding, False, pattern, shape, alpha)]
            if folding.mirror_pairs:
                merged = element_with_triangles(folding, angles, kind, merged=True)
                variants += [] if merged is None else [Element(folding, True, merged, shape, alpha)]
            yield from (
                element for element in variants if element.linkage.n_hinges and closes_when_folded(element.linkage)
            )


def isosceles_shapes(alpha: float) -> list[tuple[str, str, BaseTriangleAngles]]:
    """Return the five shapes of isosceles base triangles: name, kind of outer panels, angles in rad."""
    check_base_angle(alpha)
    a, c = math.radians(alpha), math.radians(180 - 2 * alpha)
    shapes = [("rhombus", PARALLELOGRAM_KIND, (a, a, c))]
    for kind in (PARALLELOGRAM_KIND, KITE_KIND):
        shapes += [(f"{kind} right", kind, (c, a, a)), (f"{kind} left", kind, (a, c, a))]
    return shapes


def element_with_triangles(
    folding: Folding, angles: BaseTriangleAngles, kind: str, *, merged: bool = False
) -> Pattern | None:
    """Return the folding's element with triangles of other angles; None where they do not fit or overlap.

    kind : whether the two triangles at a flat crease are related by a rotation by pi (parallelogram) or a reflection.
    """
    triangles = unfolded_corners(folding, angles, kind)
    places: dict[TriangleCorner, complex] = {}
    for triangle in triangles:
        for corner, place in triangle.items():
            if abs(places.setdefault(corner, place) - place) > SAME_POINT_SHARE:
                return None
    length, _, thickness = default_panel("triangle")
    vertices, faces = polygon_mesh(
        [tuple((length * place.real, length * place.imag) for place in triangle.values()) for triangle in triangles]
    )
    regular = folding.pattern((length, length, thickness), flat_pairs="merged" if merged else "rigid")
    try:
        pattern = replace(regular, vertices=vertices, faces=faces)
    except PatternError:  # two facets lie on one side of an edge
        return None
    return pattern if flat_overlap(pattern) == 0.0 else None


def unfolded_corners(folding: Folding, angles: BaseTriangleAngles, kind: str) -> list[dict[TriangleCorner, complex]]:
    """Return the positions of each panel's corners in the flat state, by corners of the regular grid, counterclockwise.

    The side opposite the second greatest angle has length 1. Each stack is unfolded from its lowest panel upwards; the
    stacks meet at the first flat crease, but not necessarily at the second.
    """
    circuit = folding.circuit
    regular = list(map(circuit.grid.lattice_corners, circuit.cells))
    n, (first, second) = circuit.n, folding.stacks
    edge = [corner for corner in regular[first[0]] if corner in regular[second[0]]]
    start = _first(regular[first[0]], edge, angles)
    beside = _beside(start, edge, regular[second[0]], kind)
    triangles: list[dict[TriangleCorner, complex]] = [{} for _ in range(n)]
    for stack, triangle in ((first, start), (second, beside)):
        triangles[stack[0]] = triangle
        for below, panel in pairwise(stack):
            triangles[panel] = _reflected(triangles[below], regular[panel])
    return [
        {corner: triangle[corner] for corner in corners} for corners, triangle in zip(regular, triangles, strict=True)
    ]


def _first(
    corners: list[TriangleCorner], edge: list[TriangleCorner], angles: BaseTriangleAngles
) -> dict[TriangleCorner, complex]:
    """Return the base triangle behind the flat crease, which lies on the real axis with its left end at 0."""
    (opposite,) = (corner for corner in corners if corner not in edge)
    k = corners.index(opposite)
    # counterclockwise after the opposite corner comes the left end, seen from the crease into the panel
    left_end, right_end = corners[(k + 1) % 3], corners[(k + 2) % 3]
    sines = [math.sin(angle) for angle in angles]
    scale = sorted(sines)[1]
    width, side = sines[2] / scale, sines[1] / scale
    turn = complex(math.cos(math.pi - angles[0]), math.sin(math.pi - angles[0]))
    return {left_end: 0j, right_end: complex(width), opposite: width + side * turn}


def _beside(
    start: BaseTriangle, edge: list[TriangleCorner], corners: list[TriangleCorner], kind: str
) -> dict[TriangleCorner, complex]:
    """Return the other base triangle, on the near side of the flat crease."""
    a, b = edge
    (apex,) = (place for corner, place in start.items() if corner not in edge)
    (opposite,) = (corner for corner in corners if corner not in edge)
    place = start[a] + start[b] - apex if kind == PARALLELOGRAM_KIND else _mirror(apex, start[a], start[b])
    return {a: start[a], b: start[b], opposite: place}


def _reflected(triangle: BaseTriangle, corners: list[TriangleCorner]) -> dict[TriangleCorner, complex]:
    """Return the next triangle of a stack, unfolded: the last one reflected about their common crease."""
    a, b = (corner for corner in corners if corner in triangle)
    (opposite,) = (corner for corner in corners if corner not in triangle)
    (apex,) = (place for corner, place in triangle.items() if corner not in (a, b))
    return {a: triangle[a], b: triangle[b], opposite: _mirror(apex, triangle[a], triangle[b])}


def _mirror(point: complex, a: complex, b: complex) -> complex:
    along = (b - a) / abs(b - a)
    return a + along * ((point - a) / along).conjugate()
