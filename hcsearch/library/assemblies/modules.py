"""Modules I, II and III of squares and half squares, and the arrays that they make (thesis 6.2).

The figures are known from their text only. What it fixes and what is chosen among patterns that satisfy it all is
said with each assembly; docs/explanation/assemblies.md has the alternatives and the searches.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from hcsearch.basics.arrays import Reals
from hcsearch.library.assemblies.assembly import Assembly, Parameters
from hcsearch.library.assemblies.sheets import doubled, folded_to, sheet
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern, overlay

ODD = ((1, 3), (1, 3))
"""Grid lines of module III that are creases."""


def module_i(parameters: Parameters) -> Pattern:
    """Module I: four vertices around a square, two corners cut (thesis Fig. 6.6a)."""
    return sheet(("./<", "///", ">/."), parameters.side, parameters.thickness)


def module_ii(parameters: Parameters) -> Pattern:
    """Module II: one vertex, inverted, and its images in two mirrors, slit along the second (thesis Fig. 6.9).

    The hinges on that mirror lie on the face of the diagonals: on the other one panels overlap when folded.
    """
    side = parameters.side
    vertex = sheet(("\\.", ".\\"), side, parameters.thickness).inverted()
    half = doubled(vertex.moved(shift=(0.0, 2 * side)), "x", 2 * side)
    return doubled(half, "y", 2 * side, MOUNTAIN_CREASE)


def module_iii(parameters: Parameters) -> Pattern:
    """Module III: four vertices two squares apart that share a diagonal crease (thesis Fig. 6.11)."""
    return sheet(("././", "/./.", "././", "/./."), parameters.side, parameters.thickness, ODD)


def module_iii_4_1(parameters: Parameters) -> Pattern:
    """Module III with two corners halved and a square put on: 16 squares that cover four when folded."""
    rows = ("J/./.", "/./. ", "././ ", "/./F ")
    return sheet(rows, parameters.side, parameters.thickness, ODD)


def modules_i_pair(parameters: Parameters) -> Pattern:
    """Two modules I that share four squares, one square right and one down (thesis Fig. 6.8a).

    Each is drawn with the diagonal that the other one's crease makes through its whole square.
    """
    side, thickness = parameters.side, parameters.thickness
    grey = sheet(("./<", "///", ">//"), side, thickness)
    red = sheet(("//<", "///", ">/."), side, thickness)
    return overlay([grey, red.moved(shift=(side, -side))])


def modules_i_block(parameters: Parameters) -> Pattern:
    """Four modules I around the corner of a whole square, joined along both mirrors (thesis Fig. 6.8b)."""
    return doubled(doubled(module_i(parameters), "x", 3 * parameters.side), "y", 0.0)


def modules_i_row(parameters: Parameters) -> Pattern:
    """Four modules I in a row, each the mirror image of the next (thesis Fig. 6.8c)."""
    return doubled(doubled(module_i(parameters), "x", 3 * parameters.side), "x", 6 * parameters.side)


def modules_i_ring(parameters: Parameters) -> Pattern:
    """Four modules I around a cut corner, joined along one mirror and hinged along the other (thesis Fig. 6.8d)."""
    side = parameters.side
    return doubled(doubled(module_i(parameters), "x", 3 * side), "y", 3 * side, VALLEY_CREASE)


def modules_ii(parameters: Parameters) -> Pattern:
    """Modules II side by side, and one more embedded wherever four of them meet (thesis Fig. 6.10).

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
    """Modules III that overlap by half a module (thesis Fig. 6.12).

    size : columns and rows of modules; two by one unless given.
    """
    return _array(module_iii(parameters), *(parameters.size or (2, 1)), 2 * parameters.side)


def _array(module: Pattern, columns: int, rows: int, step: float) -> Pattern:
    """Copies of a module on a square lattice, laid together where they overlap."""
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
    """An assembly of section 6.2, with its state half-way along (6.4)."""

    def between(parameters: Parameters) -> Reals:
        return folded_to(build(parameters), math.pi / 2)

    if "size" in uses:  # stated of the size shown
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
