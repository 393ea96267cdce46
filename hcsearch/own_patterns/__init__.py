"""Patterns of the user's own: FOLD files read, recognised as designs, and taken through every stage.

`read_fold` reads a file, `recognise` sees the design in it, and `check_circuit` takes a circuit through every stage.
"""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.own_patterns.checking import check_circuit
    from hcsearch.own_patterns.fold_reading import pattern_of, read_fold
    from hcsearch.own_patterns.recognition import recognise

_HOMES = {
    "checking": ("check_circuit",),
    "fold_reading": ("pattern_of", "read_fold"),
    "recognition": ("recognise",),
}

__all__ = ["check_circuit", "pattern_of", "read_fold", "recognise"]

__getattr__ = importing(__name__, _HOMES)
