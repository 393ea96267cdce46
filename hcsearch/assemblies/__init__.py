"""Named assemblies of the thesis, and the general operations that make them."""

from importlib import import_module
from importlib.util import find_spec

from hcsearch.assemblies.assembly import Assembly, Parameters

ASSEMBLIES: dict[str, Assembly] = {
    found.name: found
    for module in ("eight_r", "units", "tessellations", "squares", "modules")
    if find_spec(f"hcsearch.assemblies.{module}")
    for found in import_module(f"hcsearch.assemblies.{module}").ASSEMBLIES
}

__all__ = ["ASSEMBLIES", "Assembly", "Parameters"]
