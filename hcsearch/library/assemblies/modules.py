"""Modules I, II and III of squares and half squares, their arrays, and the vertex motion of sheets (thesis 6.2).

The special Yoshimura vertex, turned by 45 degrees, has four creases along the lines of a square grid, on one face, and
two along one diagonal, on the other. All modules of section 6.2 are sheets of such vertices or mirror images of them.

The figures are known from their description only. Each assembly notes which features were chosen among patterns that
satisfy it; docs/explanation/assemblies.md has the alternatives and the searches.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Literal

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.basics.errors import PatternError
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.shape.mesh import SAME_POINT_SHARE, Facet
from hcsearch.shape.pattern import MOUNTAIN_CREASE, RIGID_CREASE, VALLEY_CREASE, Crease, FacetPair, Pattern, overlay

FoldAxis = Literal["x", "y"]
CreaseLines = tuple[Collection[int], Collection[int]]

_CORNERS: tuple[tuple[float, float], ...] = ((0, 0), (1, 0), (1, 1), (0, 1))
_SW, _SE, _NE, _NW = _CORNERS
_MIDDLE = (0.5, 0.5)
CELL_FACETS: dict[str, tuple[Facet, ...]] = {
    ".": (_CORNERS,),
    "/": ((_SW, _SE, _NE), (_SW, _NE, _NW)),
    "\\": ((_SW, _SE, _NW), (_SE, _NE, _NW)),
    ">": ((_SE, _NE, _MIDDLE), (_MIDDLE, _NE, _NW)),
    "<": ((_SW, _SE, _MIDDLE), (_SW, _MIDDLE, _NW)),
    "J": ((_SW, _SE, _NE),),
    "F": ((_SW, _NE, _NW),),
    " ": (),
}
"""Facets of a unit square by letter: whole (.), divided along a diagonal (/ and \\), the upper right (>) or the lower
left (<) half divided in two, the lower right (J) or the upper left (F) half alone, empty (space)."""


def square_sheet(rows: Sequence[str], side: float, thickness: float, lines: CreaseLines | None = None) -> Pattern:
    """Return a sheet of squares with its lower left corner at the origin; mountains on the grid, valleys on diagonals.

    rows : letters of `CELL_FACETS`, the top row first.
    side, thickness : of a square, in metres.
    lines : grid lines with creases, x = i and y = j in squares; all unless given. The others are rigid.
    """
    facets = []
    for j, row in enumerate(reversed(rows)):
        for i, letter in enumerate(row):
            for facet in CELL_FACETS[letter]:
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


def mirrored_pattern(pattern: Pattern, axis: FoldAxis, at: float) -> Pattern:
    """Reflect a pattern in the line x = at or y = at (metres); every hinge keeps its face."""
    turn, shift = (math.pi, (2 * at, 0.0)) if axis == "x" else (0.0, (0.0, 2 * at))
    return pattern.moved(turn, shift, over=True).inverted()


def doubled_pattern(pattern: Pattern, axis: FoldAxis, at: float, hinge: Crease | None = None) -> Pattern:
    """A pattern with its mirror image in the line x = at or y = at (m), joined as in `pattern_joined_along`."""
    return pattern_joined_along(overlay([pattern, mirrored_pattern(pattern, axis, at)]), axis, at, hinge)


def pattern_joined_along(pattern: Pattern, axis: FoldAxis, at: float, hinge: Crease | None = None) -> Pattern:
    """Close the slits of a pattern on the line x = at or y = at (metres).

    hinge : crease between squares there, while other slits remain; without it all panels that meet are merged, since
        mirror images need no relative rotation (thesis 6.2.1).
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


def module_fold_angles(pattern: Pattern, grid: float) -> Reals:
    """Return the fold angles of modules whose creases on the grid are folded by `grid` (rad).

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


MODULE_III_LINES = ((1, 3), (1, 3))
"""Grid lines of module III with creases."""


def module_i(parameters: Parameters) -> Pattern:
    """Return module I: four vertices around a square, two corners cut (thesis Fig. 6.6a)."""
    return square_sheet(("./<", "///", ">/."), parameters.side, parameters.thickness)


def module_ii(parameters: Parameters) -> Pattern:
    """Return module II: one inverted vertex and its images in two mirrors, slit along the second (thesis Fig. 6.9).

    The hinges on that mirror lie on the face of the diagonals: on the other face panels overlap when folded.
    """
    side = parameters.side
    vertex = square_sheet(("\\.", ".\\"), side, parameters.thickness).inverted()
    half = doubled_pattern(vertex.moved(shift=(0.0, 2 * side)), "x", 2 * side)
    return doubled_pattern(half, "y", 2 * side, MOUNTAIN_CREASE)


def module_iii(parameters: Parameters) -> Pattern:
    """Return module III: four vertices two squares apart that share a diagonal crease (thesis Fig. 6.11)."""
    return square_sheet(("././", "/./.", "././", "/./."), parameters.side, parameters.thickness, MODULE_III_LINES)


def module_iii_4_1(parameters: Parameters) -> Pattern:
    """Return module III with two corners halved and a square added: 16 squares that cover four when folded."""
    rows = ("J/./.", "/./. ", "././ ", "/./F ")
    return square_sheet(rows, parameters.side, parameters.thickness, MODULE_III_LINES)


def modules_i_pair(parameters: Parameters) -> Pattern:
    """Return two modules I that share four squares, one square right and one down (thesis Fig. 6.8a).

    Each is drawn with the diagonal crease of the other one in their shared whole square.
    """
    side, thickness = parameters.side, parameters.thickness
    grey = square_sheet(("./<", "///", ">//"), side, thickness)
    red = square_sheet(("//<", "///", ">/."), side, thickness)
    return overlay([grey, red.moved(shift=(side, -side))])


def modules_i_block(parameters: Parameters) -> Pattern:
    """Return four modules I around the corner of a whole square, joined along both mirrors (thesis Fig. 6.8b)."""
    return doubled_pattern(doubled_pattern(module_i(parameters), "x", 3 * parameters.side), "y", 0.0)


def modules_i_row(parameters: Parameters) -> Pattern:
    """Return four modules I in a row, each the mirror image of the next (thesis Fig. 6.8c)."""
    return doubled_pattern(doubled_pattern(module_i(parameters), "x", 3 * parameters.side), "x", 6 * parameters.side)


def modules_i_ring(parameters: Parameters) -> Pattern:
    """Return four modules I around a cut corner, joined along one mirror, hinged along the other (thesis Fig. 6.8d)."""
    side = parameters.side
    return doubled_pattern(doubled_pattern(module_i(parameters), "x", 3 * side), "y", 3 * side, VALLEY_CREASE)


def modules_ii(parameters: Parameters) -> Pattern:
    """Return modules II side by side, with one more embedded wherever four of them meet (thesis Fig. 6.10).

    size : columns and rows of modules; two by two unless given.
    """
    columns, rows = parameters.size or (2, 2)
    module = module_ii(parameters)
    side_by_side = _array(module, columns, rows, 4 * parameters.side)
    if min(columns, rows) == 1:
        return side_by_side
    embedded = _array(module, columns - 1, rows - 1, 4 * parameters.side)
    return overlay([side_by_side, embedded.moved(shift=(2 * parameters.side, 2 * parameters.side))])


def modules_iii(parameters: Parameters) -> Pattern:
    """Return modules III that overlap by half a module (thesis Fig. 6.12).

    size : columns and rows of modules; two by one unless given.
    """
    return _array(module_iii(parameters), *(parameters.size or (2, 1)), 2 * parameters.side)


def _array(module: Pattern, columns: int, rows: int, step: float) -> Pattern:
    """Return copies of a module on a square lattice, merged where they overlap."""
    return overlay([module.moved(shift=(step * i, step * j)) for i in range(columns) for j in range(rows)])


def _assembly(
    name: str,
    title: str,
    source: str,
    build: Callable[[Parameters], Pattern],
    published: Mapping[str, object],
    *notes: str,
    uses: tuple[str, ...] = ("side", "thickness"),
) -> Assembly:
    """Return the entry of an assembly of section 6.2, with its half-way state along (6.4)."""

    def between(parameters: Parameters) -> Reals:
        return module_fold_angles(build(parameters), math.pi / 2)

    if "size" in uses:  # published for the size shown
        return Assembly(name, title, source, uses, build, between, published_at_defaults=published, notes=notes)
    return Assembly(name, title, source, uses, build, between, published=published, notes=notes)


ASSEMBLIES = (
    _assembly(
        "module-i",
        "Module I",
        "section 6.2.1, Figs. 6.6 and 6.7",
        module_i,
        {"panels": 16, "dof": 1, "deployment_ratio": "8:1"},
        "two corners are cut: their outer halves would lie in each other's place when folded",
    ),
    _assembly(
        "modules-i-pair",
        "Two modules I on one square",
        "section 6.2.1, Fig. 6.8(a)",
        modules_i_pair,
        {"dof": 1},
        "chosen: shifted by two squares and one they fold onto one square too, but no diagonal creases coincide",
    ),
    _assembly(
        "modules-i-four-b",
        "Four modules I in a block",
        "section 6.2.1, Fig. 6.8(b)",
        modules_i_block,
        {"dof": 1},
        "the four whole squares in the middle are one panel",
    ),
    _assembly(
        "modules-i-four-c",
        "Four modules I in a row",
        "section 6.2.1, Fig. 6.8(c)",
        modules_i_row,
        {"dof": 1},
        "chosen: a bent row of four (an L) folds onto the same four squares; an S or a T overlaps",
    ),
    _assembly(
        "modules-i-four-d",
        "Four modules I around a void",
        "section 6.2.1, Fig. 6.8(d)",
        modules_i_ring,
        {"dof": 1},
        "merged along both mirrors it does not close; hinged along one it must be on the face of the diagonals",
    ),
    _assembly(
        "module-ii",
        "Module II",
        "section 6.2.2, Fig. 6.9",
        module_ii,
        {"dof": 1, "deployment_ratio": "8:1"},
        "the two hinges in the middle lie on the face of the diagonals: on the other one panels overlap when folded",
    ),
    _assembly(
        "modules-ii-five",
        "Modules II with modules embedded",
        "section 6.2.2, Fig. 6.10",
        modules_ii,
        {"dof": 1},
        "more rows can be added; the panels of a third column take the places of the first when folded",
        uses=("side", "thickness", "size"),
    ),
    _assembly(
        "module-iii",
        "Module III",
        "section 6.2.3, Fig. 6.11",
        module_iii,
        {"dof": 1, "deployment_ratio": "4:1"},
        "chosen: of two creases each way on the lines of 4x4 squares only these close, and two such modules cover four",
        "the thesis has 4:1; that is the ratio to the 2 by 2 squares around the package, which covers three of them",
    ),
    _assembly(
        "module-iii-4-1",
        "Module III with another outline",
        "section 6.2.3",
        module_iii_4_1,
        {},
        "not in the thesis: 16 squares that do cover four, in a package of uneven height, as any such package must be",
    ),
    _assembly(
        "modules-iii-pair",
        "Modules III in a row",
        "section 6.2.3, Fig. 6.12",
        modules_iii,
        {"dof": 1},
        "more columns can be added, or more rows, but not both: with both, panels overlap when folded",
        uses=("side", "thickness", "size"),
    ),
)
