"""Linkages that tests name."""

from hcsearch.assemblies import ASSEMBLIES
from hcsearch.flat_pairs import folding_linkage
from hcsearch.folding import Folding
from hcsearch.linkage import Linkage


def linkage_named(name: str) -> Linkage:
    """An assembly with its own sizes, or a folding as DESIGN:CREASE."""
    if name in ASSEMBLIES:
        return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))
    return folding_linkage(Folding.from_notation(name))
