"""Linkages that tests name."""

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.circuit import Circuit
from hcsearch.flat_pairs import folding_linkage
from hcsearch.folding import folding_of
from hcsearch.linkage import Linkage


def linkage_named(name: str) -> Linkage:
    """An assembly with its own sizes, or a folding as DESIGN:CREASE."""
    if name in ASSEMBLIES:
        return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))
    circuit, crease = name.rsplit(":", 1)
    return folding_linkage(folding_of(Circuit.from_notation(circuit).canonical(), int(crease)))
