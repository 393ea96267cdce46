"""hcsearch: Hamiltonian-circuit designs of thick-panel arrays that fold into two stacks.

>>> from hcsearch import enumerate_circuits, foldings, twist
>>> [[twist(folding) for folding in foldings(circuit)] for circuit in enumerate_circuits("hex", n=6)]
[[], [0], [], []]

Names are looked up on first use, so that the command line starts without loading what it does not need.
"""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False  # as type checkers know it; `typing` takes longer to load than Ctrl-C may go unanswered
if TYPE_CHECKING:
    from hcsearch.circuit import Circuit
    from hcsearch.enumeration import ArrayCount, ArraySearch, PolygonSearch, count_array, enumerate_circuits
    from hcsearch.errors import HcsearchError
    from hcsearch.folding import Folding, foldings
    from hcsearch.grid import GRIDS, Array, Grid, parse_array
    from hcsearch.linkage import Linkage
    from hcsearch.pattern import Pattern
    from hcsearch.store import open_database, open_readonly, select, select_sql
    from hcsearch.twisting import gauss_linking, twist

_HOMES = {
    "circuit": ("Circuit",),
    "enumeration": ("ArrayCount", "ArraySearch", "PolygonSearch", "count_array", "enumerate_circuits"),
    "errors": ("HcsearchError",),
    "folding": ("Folding", "foldings"),
    "grid": ("GRIDS", "Array", "Grid", "parse_array"),
    "linkage": ("Linkage",),
    "pattern": ("Pattern",),
    "store": ("open_database", "open_readonly", "select", "select_sql"),
    "twisting": ("gauss_linking", "twist"),
}

__all__ = [
    "GRIDS",
    "Array",
    "ArrayCount",
    "ArraySearch",
    "Circuit",
    "Folding",
    "Grid",
    "HcsearchError",
    "Linkage",
    "Pattern",
    "PolygonSearch",
    "count_array",
    "enumerate_circuits",
    "foldings",
    "gauss_linking",
    "open_database",
    "open_readonly",
    "parse_array",
    "select",
    "select_sql",
    "twist",
]

__getattr__ = importing(__name__, _HOMES)
