"""Square panels: chains that fold like a map, and rings in two stacks."""

from __future__ import annotations

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import grid_named
from hcsearch.shape.linkage import Linkage
from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern

SIDE, THICKNESS = 0.050, 0.006
"""Of panels, unless they are of another thickness (m)."""


def chain(panels: int, thickness: float = THICKNESS) -> Linkage:
    """Squares in a row fold like a map, on alternating faces; the first one is held."""
    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    facets = tuple(tuple((SIDE * (k + x), SIDE * y) for x, y in corners) for k in range(panels))
    creases = {(k, k + 1): MOUNTAIN_CREASE if k % 2 else VALLEY_CREASE for k in range(panels - 1)}
    return Linkage(Pattern.from_polygons(facets, creases, thickness))


def ring_folding(columns: int) -> Folding:
    """A ring of 2 x `columns` squares stands in two stacks when folded."""
    word = (0,) * (columns - 1) + (1,) + (2,) * (columns - 1) + (3,)
    return foldings(Circuit(grid_named("square"), word))[-1]
