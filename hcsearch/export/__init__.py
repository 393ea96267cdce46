"""Files that other programs read: crease patterns, sheets, pictures, tables, solids and models of simulators.

`FORMATS` lists the formats, a module each.
"""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.export.formats import FORMATS, Format

_HOMES = {"formats": ("FORMATS", "Format")}

__all__ = ["FORMATS", "Format"]

__getattr__ = importing(__name__, _HOMES)
