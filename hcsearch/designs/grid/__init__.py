"""The nine grids and arrays of their cells, in exact integers."""

from hcsearch.designs.grid.arrays import Array, check_size
from hcsearch.designs.grid.patches import parse_array
from hcsearch.designs.grid.tessellation import LatticePoint
from hcsearch.designs.grid.tilings import GRIDS, Cell, Grid, LatticeIsometry, grid_named, grid_of

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
