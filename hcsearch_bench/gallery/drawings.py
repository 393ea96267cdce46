"""Drawings of the grids, of foldings and of sheets, which the README and pages of the documentation show."""

from __future__ import annotations

import re
from collections.abc import Iterator
from tempfile import TemporaryDirectory
from typing import Any

from hcsearch.api.exporting import save
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings
from hcsearch.designs.grid import GRIDS, Grid, parse_array
from hcsearch.designs.twisting import twist
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.shape.drawing import draw_graph

_PATCHES = {"triangle": "h2", "rectangle": "4x3", "hex": "h2", "rhombus": "h2", "right45": "4x4"}
"""The array in the drawing of each grid; of the others a hexagon of side 1."""
_SMALLEST = 6
"""Least number of panels of the designs that are drawn."""
_FOLDINGS = {
    "hexagons-3-4-3": "hex:0234550132:3",
    "rectangles-6x5": "rectangle:123300322300000122100112321232:1",
    "triangles-10": "triangle:0123434501:1",
    "worked-folding": "rectangle:12333011:3",
}
"""Foldings that explain the marks of drawings, by the name of the file."""
_CUT_FOLDING = "hex:0234550132:4"
_SHEET_LINE = 1.0
"""Width of the lines in pictures of sheets, mm; those for a cutter are hairlines."""
_WITHOUT_FOLDING = "hex:012345"


def drawings() -> Iterator[tuple[str, str]]:
    """Yield (name of the file, SVG text) of every drawing, of each grid its graph of cells and smallest folding."""
    for grid in GRIDS.values():
        if grid.name == "square":  # drawn as a rectangle
            continue
        array = parse_array(grid, _PATCHES.get(grid.name, "h1"))
        yield f"grid-{grid.name}.svg", draw_graph(grid, array.cells) + "\n"
        yield f"folding-{grid.name}.svg", _smallest_folding(grid) + "\n"
    for name, notation in _FOLDINGS.items():
        yield f"{name}.svg", Folding.from_notation(notation)._repr_svg_() + "\n"
    yield "no-folding.svg", Circuit.from_notation(_WITHOUT_FOLDING)._repr_svg_() + "\n"
    yield "sheet.svg", _sheet(sheet="assembled")
    yield "sheet-panels.svg", _sheet(sheet="panels")


def _sheet(**options: Any) -> str:
    """A sheet to cut, with lines and a ground that are seen on a page."""
    with TemporaryDirectory() as name:
        (file,) = save(_CUT_FOLDING, f"{name}/sheet.svg", **options)
        text = file.read_text(encoding="utf-8")
    text, thickened = re.subn(r'stroke-width="[\d.]+"', f'stroke-width="{_SHEET_LINE}"', text)
    assert thickened, text
    return text.replace("</title>\n", '</title>\n <rect width="100%" height="100%" fill="#ffffff"/>\n', 1)


def _smallest_folding(grid: Grid) -> str:
    """The drawing of the first folding without twist of the least number of panels."""
    for n in range(_SMALLEST, 20, 2):
        for batch in PolygonSearch(grid, n).batches():
            for word in batch.words.tolist():
                for folding in foldings(Circuit(grid, tuple(word))):
                    if twist(folding) == 0:
                        return folding._repr_svg_()
    raise AssertionError(f"the {grid.name} grid has no folding without twist of fewer than 20 panels")
