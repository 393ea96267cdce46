"""Files that other programs read: crease patterns, sheets, pictures, tables, solids and models of simulators.

`FORMATS` lists the formats, a module each; `export` writes one to a file.
"""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.export.formats import FORMATS, Format
    from hcsearch.export.writing import export

_HOMES = {"formats": ("FORMATS", "Format"), "writing": ("export",)}

__all__ = ["FORMATS", "Format", "export"]

__getattr__ = importing(__name__, _HOMES)
