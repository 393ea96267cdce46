"""How many circuits there are, before any is listed: published growth of self-avoiding polygons and walks."""

from __future__ import annotations

import math

from hcsearch.designs.grid import Grid

# Connective constant mu and amplitude B: polygons of n steps up to translation number B mu^n n^(-5/2), n even where
# the lattice has two colours. Jensen and Guttmann, J. Phys. A 32 (1999) 4867 (square lattice); Jensen, J. Phys.: Conf.
# Ser. 42 (2006) 163 (honeycomb; mu proved by Duminil-Copin and Smirnov) and J. Stat. Mech. (2004) P10008 (triangular).
_GROWTH = {
    "hex": (4.150797, 0.264),
    "square": (2.638159, 0.562),
    "rectangle": (2.638159, 0.562),
    "triangle": (math.sqrt(2 + math.sqrt(2)), 1.272),
}


def connective_constant(grid: Grid) -> float:
    """Factor by which one more step multiplies the number of walks."""
    return _GROWTH[grid.name][0]


def expected_circuits(grid: Grid, n: int) -> float:
    """Number of circuits of n panels up to symmetry, to a few per cent from n = 16 on."""
    growth, amplitude = _GROWTH[grid.name]
    circuits: float = amplitude * growth**n / n**2.5
    return circuits / len(grid.point_group)
