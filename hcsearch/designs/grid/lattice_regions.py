"""The cells of a grid at some lattice points, and those within some regions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hcsearch.designs.grid.tessellation import LatticePoint
from hcsearch.designs.grid.tilings import Cell, Grid

SQUARES = ("square", "rectangle", "right45")
"""Grids whose cells are squares or rectangles, or parts of squares."""
HEXAGONS = ("hex", "rhombus", "kite", "right30")
"""Grids whose cells are hexagons or parts of them; of all but `hex`, the cells of one lattice point are a hexagon."""
TRIANGLES = ("triangle", "kite", "right30", "obtuse")
"""Grids whose cells are equilateral triangles or parts of them, with lattice points in the triangles' corners."""


def blocks(grid: Grid, places: Sequence[LatticePoint]) -> list[Cell]:
    """All cells at some lattice points."""
    return [(*place, kind) if grid.kinds > 1 else place for place in places for kind in range(grid.kinds)]


def within(grid: Grid, regions: Sequence[Sequence[tuple[float, float]]]) -> list[Cell]:
    """The cells in any of some convex regions with corners at lattice points or halves of these, counterclockwise."""
    origin, (ax, ay), (bx, by) = (grid.point((x, y, 0)) for x, y in ((0, 0), (1, 0), (0, 1)))
    scale = grid.corner_scale
    basis = (scale * (ax - origin[0]), scale * (ay - origin[1]), scale * (bx - origin[0]), scale * (by - origin[1]))
    found: dict[Cell, None] = {}
    for region in regions:
        corners = [(basis[0] * x + basis[2] * y, basis[1] * x + basis[3] * y) for x, y in region]
        sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
        (left, right), (low, high) = (
            (math.floor(min(values)) - 1, math.ceil(max(values)) + 1) for values in zip(*region, strict=True)
        )
        for cell in blocks(grid, [(x, y) for y in range(low, high) for x in range(left, right)]):
            if all(
                (qx - px) * (y - py) - (qy - py) * (x - px) >= 0
                for x, y in grid.lattice_corners(cell)
                for (px, py), (qx, qy) in sides
            ):
                found[cell] = None
    return list(found)
