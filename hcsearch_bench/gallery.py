"""Pictures of the nine grids for docs/reference/grids.md and the README: `python -m hcsearch_bench.gallery DIR`."""

from __future__ import annotations

import sys
from pathlib import Path

from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import foldings
from hcsearch.designs.grid import GRIDS, Grid, parse_array
from hcsearch.designs.twisting import twist
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.shape.drawing import draw_graph

_PATCHES = {"triangle": "h2", "rectangle": "4x3", "hex": "h2", "rhombus": "h2", "right45": "4x4"}
"""The array in the picture of each grid; of the others a hexagon of side 1."""
_SMALLEST = 6
"""Least number of panels of the designs that are drawn."""


def write_gallery(folder: Path) -> None:
    """Write a picture of each tiling with its graph of cells, and of its smallest folding without twist."""
    for grid in GRIDS.values():
        if grid.name == "square":  # drawn as a rectangle
            continue
        array = parse_array(grid, _PATCHES.get(grid.name, "h1"))
        (folder / f"grid-{grid.name}.svg").write_text(draw_graph(grid, array.cells) + "\n", encoding="utf-8")
        (folder / f"folding-{grid.name}.svg").write_text(_smallest_folding(grid) + "\n", encoding="utf-8")


def _smallest_folding(grid: Grid) -> str:
    """The drawing of the first folding without twist of the least number of panels."""
    for n in range(_SMALLEST, 20, 2):
        for batch in PolygonSearch(grid, n).batches():
            for word in batch.words.tolist():
                for folding in foldings(Circuit(grid, tuple(word))):
                    if twist(folding) == 0:
                        return folding._repr_svg_()
    raise AssertionError(f"the {grid.name} grid has no folding without twist of fewer than 20 panels")


if __name__ == "__main__":
    write_gallery(Path(sys.argv[1]))
