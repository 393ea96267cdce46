"""The three tilings and arrays of their cells, in exact integers."""

from hcsearch.designs.grid.arrays import Array, check_size, parse_array
from hcsearch.designs.grid.tilings import GRIDS, Cell, Grid, LatticeIsometry, LatticePoint, grid_named, grid_of

__all__ = [
    "GRIDS",
    "Array",
    "Cell",
    "Grid",
    "LatticeIsometry",
    "LatticePoint",
    "check_size",
    "grid_named",
    "grid_of",
    "parse_array",
]
