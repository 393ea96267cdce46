"""What the bench `stability` deploys: strips and rings of panels, assemblies, foldings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from hcsearch.basics.array_values import Reals
from hcsearch.designs.folding import Folding
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.shape.linkage import Linkage
from hcsearch.springs.deployment.compiled_scene import CompiledScene
from hcsearch_bench.subjects.squares import SIDE, chain, ring_folding

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
    size = (SIDE, SIDE, ratio * SIDE)
    if name == "strip":
        return chain(panels, ratio * SIDE)
    if name == "ring":
        return ring_folding(panels // 2).linkage(size)
    if name in ASSEMBLIES:
        defaults = ASSEMBLIES[name].defaults
        width = WIDTHS.get(name, SIDE)
        sized = defaults if ratio == THICK else replace(defaults, thickness=ratio * width)
        return Linkage(ASSEMBLIES[name].build(sized))
    return Folding.from_notation(name).linkage(size)
