"""What the bench `stability` deploys: strips and rings of panels, assemblies, foldings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from hcsearch.basics.array_values import Reals

if TYPE_CHECKING:
    from hcsearch.shape.linkage import Linkage
    from hcsearch.springs.deployment.compiled_scene import CompiledScene


SIDE = 0.050
"""Of the panels of strips and rings (m)."""
THICK = 0.12
"""Thickness over width of all panels unless it is swept: 6 mm of 50."""
WIDTHS = {"thesis-4x4": 0.040}
"""Of panels that are not as wide as SIDE (m)."""


@dataclass(frozen=True)
class StabilitySubject:
    """What is deployed: `strip` or `ring` of panels, an assembly, or a design and its crease.

    ratio : thickness over width. flat : whether it starts exactly flat, which no deployment does.
    """

    name: str
    panels: int = 2
    ratio: float = THICK
    flat: bool = False

    def __str__(self) -> str:
        several = f"{self.name} of {self.panels}" if self.name in {"strip", "ring"} else self.name
        return f"{several}, flat" if self.flat else several

    @property
    def linkage(self) -> Linkage:
        """Its panels and hinges."""
        return _linkage(self.name, self.panels, self.ratio)

    def start_of(self, compiled: CompiledScene) -> Reals:
        """Coordinates of the joints at the start."""
        return np.zeros_like(compiled.start) if self.flat else compiled.start


@cache
def _linkage(name: str, panels: int, ratio: float) -> Linkage:
    from hcsearch.designs.circuit import Circuit
    from hcsearch.designs.folding import Folding, foldings
    from hcsearch.designs.grid import grid_named
    from hcsearch.library.assemblies import ASSEMBLIES
    from hcsearch.shape.linkage import Linkage

    size = (SIDE, SIDE, ratio * SIDE)
    if name == "strip":
        return _strip(panels, ratio * SIDE)
    if name == "ring":
        columns = panels // 2
        word = (0,) * (columns - 1) + (1,) + (2,) * (columns - 1) + (3,)
        return foldings(Circuit(grid_named("square"), word))[-1].linkage(size)
    if name in ASSEMBLIES:
        defaults = ASSEMBLIES[name].defaults
        width = WIDTHS.get(name, SIDE)
        sized = defaults if ratio == THICK else replace(defaults, thickness=ratio * width)
        return Linkage(ASSEMBLIES[name].build(sized))
    return Folding.from_notation(name).linkage(size)


def _strip(panels: int, thickness: float) -> Linkage:
    """Squares in a row that fold like a map, on alternating faces; the first one is held."""
    from hcsearch.shape.linkage import Linkage
    from hcsearch.shape.pattern import MOUNTAIN_CREASE, VALLEY_CREASE, Pattern

    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    facets = tuple(tuple((SIDE * (k + x), SIDE * y) for x, y in corners) for k in range(panels))
    creases = {(k, k + 1): MOUNTAIN_CREASE if k % 2 else VALLEY_CREASE for k in range(panels - 1)}
    return Linkage(Pattern.from_polygons(facets, creases, thickness))
