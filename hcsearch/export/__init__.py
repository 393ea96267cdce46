"""Files that other programs read and write: patterns, sheets, solids, mechanisms and motions; and checks of patterns.

`FORMATS` lists the formats, a module each; `export` writes one to a file. `read_fold` reads a pattern back,
`recognise` sees the design in it, and `check_circuit` takes a circuit through every stage.
"""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.export.checking import check_circuit
    from hcsearch.export.fold_reading import pattern_of, read_fold
    from hcsearch.export.formats import FORMATS, Format
    from hcsearch.export.recognition import recognise
    from hcsearch.export.writing import export

_HOMES = {
    "checking": ("check_circuit",),
    "fold_reading": ("pattern_of", "read_fold"),
    "formats": ("FORMATS", "Format"),
    "recognition": ("recognise",),
    "writing": ("export",),
}

__all__ = ["FORMATS", "Format", "check_circuit", "export", "pattern_of", "read_fold", "recognise"]

__getattr__ = importing(__name__, _HOMES)
