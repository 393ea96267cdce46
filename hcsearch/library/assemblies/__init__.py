"""Named assemblies of the thesis, and the operations that construct them."""

from hcsearch.library.assemblies import eight_r, modules, squares, tessellations
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters

ASSEMBLIES: dict[str, Assembly] = {
    entry.name: entry for module in (eight_r, tessellations, squares, modules) for entry in module.ASSEMBLIES
}
"""All named assemblies, in the order of the thesis's chapters 5, 4 and 6."""

__all__ = ["ASSEMBLIES", "Assembly", "Parameters"]
