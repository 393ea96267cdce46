"""Elements of the search: designs whose opposite flat creases are rigid, also of triangles that are not equilateral.

Of all pairs of opposite creases only the flat ones of a two-stack folding can be rigid without losing the fold: any
other crease is closed in the stacks, its panels lie on each other there and beside each other in the flat state.

In the stacks every panel lies on one of two base triangles, beside each other along the flat creases. Unfolding each
stack by reflections about its creases gives the flat state, where the second flat crease must fit and panels that
share a corner on the regular grid must still share it. Source: thesis 5.3.2, which asks it of the circuit of ten.
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

    merged : whether panels that meet on a mirror axis through the flat creases are made one.
    shape : of isosceles triangles, which corner is the apex and how the outer triangles lie; empty on regular grids.
    alpha : base angle of isosceles triangles in degrees; None on regular grids.
    """

    folding: Folding
    merged: bool
    pattern: Pattern
    shape: str = ""
    alpha: float | None = None

    @property
    def name(self) -> str:
        """The folding's notation, with what else makes the element."""
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
        """Degrees of freedom at a generic state; None undecided."""
        return generic_rank(self.linkage).nullity

    @cached_property
    def locked(self) -> bool:
        """Whether its folded or its flat state is proved locked."""
        return has_locked_end(self.linkage)


@dataclass(frozen=True)
class RigidPair:
    """What becomes of a design when two opposite creases are made rigid.

    verdict : `no fold` where other creases are flat or none are, `twisted`, `locked`, or `element`.
    dof : degrees of freedom with the pair rigid; dof_merged : with mirror pairs of panels made one too; None where
        there is no such element, or it is undecided.
    """

    crease: int
    opposite: int
    verdict: str
    dof: int | None = None
    dof_merged: int | None = None


def rigid_pairs(circuit: Circuit) -> list[RigidPair]:
    """Each pair of opposite creases of a design: whether both can be rigid, and what freedom that leaves."""
    half = circuit.n // 2
    known = {folding.crease: folding for folding in foldings(circuit)}
    return [_rigid_pair(known.get(crease), crease, half) for crease in range(half if circuit.n % 2 == 0 else 0)]


def _rigid_pair(folding: Folding | None, crease: int, half: int) -> RigidPair:
    if folding is None:
        return RigidPair(crease, crease + half, "no fold")
    if twist(folding):
        return RigidPair(crease, crease + half, "twisted")
    plain, *merged = elements_of(folding)
    verdict = "locked" if plain.locked else "element"
    return RigidPair(crease, crease + half, verdict, plain.dof, merged[0].dof if merged else None)


def elements_of(folding: Folding) -> list[Element]:
    """The element of a folding on its regular grid, and the one with mirror pairs merged where there are some."""
    size = default_panel(folding.circuit.grid.name)
    variants = [Element(folding, False, folding.pattern(size))]
    if folding.mirror_pairs:
        variants.append(Element(folding, True, folding.pattern(size, flat_pairs="merged")))
    return variants


def elements_of_designs(grid: str, n: int) -> Iterator[Element]:
    """The elements of all untwisted foldings of all designs of n panels, those without a folded state left out."""
    for folding in untwisted_foldings_of(grid, n):
        for element in elements_of(folding):
            if element.linkage.n_hinges and closes_when_folded(element.linkage):
                yield element


def untwisted_foldings_of(grid: str, n: int) -> Iterator[Folding]:
    """The untwisted foldings of all designs of n panels."""
    tiling = grid_named(grid)
    if n % 2 or n < 4:
        raise SizeError(f"{n} panels do not fold into two stacks: give an even number from 4 up")
    search = PolygonSearch(tiling, n) if n < 14 else search_all(tiling, n, "untwisted")
    for batch in search.batches():
        for word in batch.words.tolist():
            circuit = Circuit(tiling, tuple(word))
            yield from (folding for folding in foldings(circuit) if not twist(folding))


BaseTriangleAngles = tuple[float, float, float]
"""Of the base triangle after the first flat crease: at its right end and its left end, seen across it, and beyond."""
TriangleCorner = tuple[int, int]
BaseTriangle = Mapping[TriangleCorner, complex]

PARALLELOGRAM_KIND, KITE_KIND = "parallelogram", "kite"


def isosceles_elements(n: int, alpha: float) -> Iterator[Element]:
    """Elements of all untwisted foldings of n triangles that isosceles ones make with closed slits.

    alpha : base angle in degrees. The shape of an element names its outer panels and the place of the apex: across from
        the flat crease in a rhombus, on its right or on its left in a parallelogram or a kite.
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
    """The five ways to give the base triangles an apex: name, kind of outer panels, angles in rad."""
    check_base_angle(alpha)
    a, c = math.radians(alpha), math.radians(180 - 2 * alpha)
    shapes = [("rhombus", PARALLELOGRAM_KIND, (a, a, c))]
    for kind in (PARALLELOGRAM_KIND, KITE_KIND):
        shapes += [(f"{kind} right", kind, (c, a, a)), (f"{kind} left", kind, (a, c, a))]
    return shapes


def element_with_triangles(
    folding: Folding, angles: BaseTriangleAngles, kind: str, *, merged: bool = False
) -> Pattern | None:
    """The folding's element with other triangles; None where they do not fit or overlap.

    kind : whether the two triangles at a flat crease are each other turned by pi (a parallelogram) or reflected.
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
    """Places of each panel's corners in the flat state, by the corners of the regular grid, counterclockwise.

    The side across from the second greatest angle has length 1.
    Each stack is unfolded from its lowest panel up; the two meet at the first flat crease, and need not at the second.
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
    """The base triangle after the flat crease, which runs along the real axis from its left end at 0."""
    (beyond,) = (corner for corner in corners if corner not in edge)
    k = corners.index(beyond)
    # counterclockwise after the corner beyond comes the left end, as seen from the crease into the panel
    left, right = corners[(k + 1) % 3], corners[(k + 2) % 3]
    sines = [math.sin(angle) for angle in angles]
    scale = sorted(sines)[1]
    width, side = sines[2] / scale, sines[1] / scale
    turn = complex(math.cos(math.pi - angles[0]), math.sin(math.pi - angles[0]))
    return {left: 0j, right: complex(width), beyond: width + side * turn}


def _beside(
    start: BaseTriangle, edge: list[TriangleCorner], corners: list[TriangleCorner], kind: str
) -> dict[TriangleCorner, complex]:
    """The other base triangle, on the other side of the flat crease."""
    a, b = edge
    (own,) = (place for corner, place in start.items() if corner not in edge)
    (beyond,) = (corner for corner in corners if corner not in edge)
    place = start[a] + start[b] - own if kind == PARALLELOGRAM_KIND else _mirror(own, start[a], start[b])
    return {a: start[a], b: start[b], beyond: place}


def _reflected(triangle: BaseTriangle, corners: list[TriangleCorner]) -> dict[TriangleCorner, complex]:
    """The next triangle of a stack, unfolded: the last one reflected about the crease between them."""
    a, b = (corner for corner in corners if corner in triangle)
    (beyond,) = (corner for corner in corners if corner not in triangle)
    (own,) = (place for corner, place in triangle.items() if corner not in (a, b))
    return {a: triangle[a], b: triangle[b], beyond: _mirror(own, triangle[a], triangle[b])}


def _mirror(point: complex, a: complex, b: complex) -> complex:
    along = (b - a) / abs(b - a)
    return a + along * ((point - a) / along).conjugate()
