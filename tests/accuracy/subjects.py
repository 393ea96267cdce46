"""Linkages of which the accuracy is measured."""

from functools import cache

from hcsearch.designs.folding import Folding
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.shape.linkage import Linkage

FOLDING = "hex:0234550132:4"


@cache
def linkage_named(name):
    """The linkage of a folding or an assembly."""
    if name in ASSEMBLIES:
        return Linkage(ASSEMBLIES[name].build(ASSEMBLIES[name].defaults))
    return Folding.from_notation(name).linkage()
