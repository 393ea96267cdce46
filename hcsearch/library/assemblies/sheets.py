"""Sheets of squares and half squares, and the motion of the vertex they share (thesis 6.2).

The special Yoshimura vertex, turned by 45 degrees, has four creases along the lines of a square grid, on one face, and
two along one diagonal, on the other. All modules of section 6.2 are sheets of such vertices or mirror images of them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Literal

import numpy as np

from hcsearch.basics.arrays import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.shape.mesh import SAME_POINT_SHARE, Facet
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, FacetPair, Pattern, overlay

Axis = Literal["x", "y"]
Lines = tuple[Collection[int], Collection[int]]

_CORNERS: tuple[tuple[float, float], ...] = ((0, 0), (1, 0), (1, 1), (0, 1))
_SW, _SE, _NE, _NW = _CORNERS
_MIDDLE = (0.5, 0.5)
CELLS: dict[str, tuple[Facet, ...]] = {
    ".": (_CORNERS,),
    "/": ((_SW, _SE, _NE), (_SW, _NE, _NW)),
    "\\": ((_SW, _SE, _NW), (_SE, _NE, _NW)),
    ">": ((_SE, _NE, _MIDDLE), (_MIDDLE, _NE, _NW)),
    "<": ((_SW, _SE, _MIDDLE), (_SW, _MIDDLE, _NW)),
    "J": ((_SW, _SE, _NE),),
    "F": ((_SW, _NE, _NW),),
    " ": (),
}
"""Facets of a unit square by the letter that draws it: whole, divided along either diagonal, divided along / with the
upper right or the lower left half left of it, the lower right or the upper left half alone, none."""


def sheet(rows: Sequence[str], side: float, thickness: float, lines: Lines | None = None) -> Pattern:
    """A sheet of squares, its lower left corner at the origin; mountains on the grid, valleys on the diagonals.

    rows : letters of `CELLS`, the top row first.
    side, thickness : of a square, in metres.
    lines : the grid lines that are creases, x = i and y = j in squares: all unless given. The others are rigid.
    """
    facets = []
    for j, row in enumerate(reversed(rows)):
        for i, letter in enumerate(row):
            for facet in CELLS[letter]:
                facets.append(tuple((side * (i + x), side * (j + y)) for x, y in facet))
    pattern = Pattern.from_polygons(facets, {}, thickness)
    creases: dict[FacetPair, Crease] = {}
    for pair in pattern.edges:
        (ax, ay), (bx, by) = pattern.segment(pair)
        if _oblique(bx - ax, by - ay, side):
            creases[pair] = VALLEY_CREASE
        else:
            k, at = (0, ax) if abs(bx - ax) < 0.5 * side else (1, ay)
            creases[pair] = MOUNTAIN_CREASE if lines is None or round(at / side) in lines[k] else RIGID_CREASE
    return pattern.with_creases(creases)


def mirrored(pattern: Pattern, axis: Axis, at: float) -> Pattern:
    """The pattern reflected in the line x = at or y = at (metres); every hinge keeps its face."""
    turn, shift = (math.pi, (2 * at, 0.0)) if axis == "x" else (0.0, (0.0, 2 * at))
    return pattern.moved(turn, shift, over=True).inverted()


def doubled(pattern: Pattern, axis: Axis, at: float, hinge: Crease | None = None) -> Pattern:
    """A pattern and its mirror image in the line x = at or y = at (metres), joined along that line as in `joined`."""
    return joined(overlay([pattern, mirrored(pattern, axis, at)]), axis, at, hinge)


def joined(pattern: Pattern, axis: Axis, at: float, hinge: Crease | None = None) -> Pattern:
    """The pattern with its slits on the line x = at or y = at (metres) closed.

    hinge : what joins squares there, while everything else stays slit; without it all panels that meet are merged, as
        their relative rotation is unnecessary between mirror images (thesis 6.2.1).
    """
    k = 0 if axis == "x" else 1
    near = SAME_POINT_SHARE * pattern.size
    creases: dict[FacetPair, Crease] = {}
    for pair in pattern.edges:
        if pair in pattern.creases or any(abs(end[k] - at) > near for end in pattern.segment(pair)):
            continue
        if hinge is None:
            creases[pair] = RIGID_CREASE
        elif all(len(pattern.faces[facet]) == len(_CORNERS) for facet in pair):
            creases[pair] = hinge
    return pattern.with_creases(creases)


def folded_to(pattern: Pattern, grid: float) -> Reals:
    """Fold angles of a module or an array of modules where the creases on the grid are folded by `grid` (rad).

    Thesis (6.4) in fold angles rho = pi - phi: grid creases fold alike, tan(rho / 2) = cos(pi / 4) tan(grid / 2) on
    the diagonals. Hinges along the grid but on the face of the diagonals join mirror images, and tan(rho / 2) =
    tan(grid / 2) / 2 closes the loops around the slit exactly; this is not in the thesis.
    """
    oblique = [_oblique(h.end[0] - h.start[0], h.end[1] - h.start[1], pattern.size) for h in pattern.hinges]
    if not any(oblique):
        raise PatternError("a pattern without diagonal hinges is no array of modules: take one of section 6.2")
    face = pattern.hinges[oblique.index(True)].face
    factors = [
        math.sqrt(0.5) if diagonal else 0.5 if hinge.face == face else 1.0
        for diagonal, hinge in zip(oblique, pattern.hinges, strict=True)
    ]
    return np.array([2 * math.atan2(k * math.sin(grid / 2), math.cos(grid / 2)) for k in factors])


def _oblique(dx: float, dy: float, size: float) -> bool:
    return min(abs(dx), abs(dy)) > SAME_POINT_SHARE * size
