"""Circuits of triangles that are not equilateral: foldings whose slits stay closed with other base triangles.

In the stacks every panel lies on one of two base triangles, beside each other along the flat creases. Unfolding each
stack by reflections about its creases gives the flat state, where the second flat crease must fit and panels that
share a corner on the regular grid must still share it. Source: thesis 5.3.2, which asks it of the circuit of ten.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from hcsearch.basics.errors import PatternError
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.library.assemblies.assembly import check_base_angle
from hcsearch.library.assemblies.packages import flat_overlap
from hcsearch.library.unit_search.elements import Element, untwisted
from hcsearch.library.unit_search.proofs import closes
from hcsearch.shape.mesh import SAME_POINT_SHARE, polygon_mesh
from hcsearch.shape.pattern import Pattern

Angles = tuple[float, float, float]
"""Of the base triangle after the first flat crease: at its right end and its left end, seen across it, and beyond."""
Corner = tuple[int, int]
Triangle = Mapping[Corner, complex]

PARALLELOGRAM, KITE = "parallelogram", "kite"


def isosceles_elements(n: int, alpha: float) -> Iterator[Element]:
    """Elements of all untwisted foldings of n triangles that isosceles ones make with closed slits.

    alpha : base angle in degrees. The shape of an element names its outer panels and the place of the apex: across from
        the flat crease in a rhombus, on its right or on its left in a parallelogram or a kite.
    """
    for folding in untwisted("triangle", n):
        for shape, kind, angles in isosceles_shapes(alpha):
            pattern = with_triangles(folding, angles, kind)
            if pattern is None:
                continue
            variants = [Element(folding, False, pattern, shape, alpha)]
            if folding.mirror_pairs:
                merged = with_triangles(folding, angles, kind, merged=True)
                variants += [] if merged is None else [Element(folding, True, merged, shape, alpha)]
            yield from (element for element in variants if element.linkage.n_hinges and closes(element.linkage))


def isosceles_shapes(alpha: float) -> list[tuple[str, str, Angles]]:
    """The five ways to give the base triangles an apex: name, kind of outer panels, angles in rad."""
    check_base_angle(alpha)
    a, c = math.radians(alpha), math.radians(180 - 2 * alpha)
    shapes = [("rhombus", PARALLELOGRAM, (a, a, c))]
    for kind in (PARALLELOGRAM, KITE):
        shapes += [(f"{kind} right", kind, (c, a, a)), (f"{kind} left", kind, (a, c, a))]
    return shapes


def with_triangles(folding: Folding, angles: Angles, kind: str, *, merged: bool = False) -> Pattern | None:
    """The folding's element with other triangles; None where they do not fit or overlap.

    kind : whether the two triangles at a flat crease are each other turned by pi (a parallelogram) or reflected.
    """
    triangles = unfold(folding, angles, kind)
    places: dict[Corner, complex] = {}
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


def unfold(folding: Folding, angles: Angles, kind: str) -> list[dict[Corner, complex]]:
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
    triangles: list[dict[Corner, complex]] = [{} for _ in range(n)]
    for stack, triangle in ((first, start), (second, beside)):
        triangles[stack[0]] = triangle
        for below, panel in pairwise(stack):
            triangles[panel] = _reflected(triangles[below], regular[panel])
    return [
        {corner: triangle[corner] for corner in corners} for corners, triangle in zip(regular, triangles, strict=True)
    ]


def _first(corners: list[Corner], edge: list[Corner], angles: Angles) -> dict[Corner, complex]:
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


def _beside(start: Triangle, edge: list[Corner], corners: list[Corner], kind: str) -> dict[Corner, complex]:
    """The other base triangle, on the other side of the flat crease."""
    a, b = edge
    (own,) = (place for corner, place in start.items() if corner not in edge)
    (beyond,) = (corner for corner in corners if corner not in edge)
    place = start[a] + start[b] - own if kind == PARALLELOGRAM else _mirror(own, start[a], start[b])
    return {a: start[a], b: start[b], beyond: place}


def _reflected(triangle: Triangle, corners: list[Corner]) -> dict[Corner, complex]:
    """The next triangle of a stack, unfolded: the last one reflected about the crease between them."""
    a, b = (corner for corner in corners if corner in triangle)
    (beyond,) = (corner for corner in corners if corner not in triangle)
    (own,) = (place for corner, place in triangle.items() if corner not in (a, b))
    return {a: triangle[a], b: triangle[b], beyond: _mirror(own, triangle[a], triangle[b])}


def _mirror(point: complex, a: complex, b: complex) -> complex:
    along = (b - a) / abs(b - a)
    return a + along * ((point - a) / along).conjugate()
