"""Search for flat arrays of thick panels that fold into two stacks.

`parse_array`, `enumerate_circuits`, `foldings` and `twist` give arrays, their circuits, and how these fold. `deploy`,
`tune`, `replay` and `save` simulate a folding, choose its springs, play its motion, and export it. `enumerate_into`
searches into a database; `read` and `rank` read it as pandas tables. docs/howto/python.md shows all of this.

>>> from hcsearch import enumerate_circuits, foldings, twist
>>> [[twist(folding) for folding in foldings(circuit)] for circuit in enumerate_circuits("hex", n=6)]
[[], [0], [], []]
"""

# names are imported on first use, so that the command line starts without loading what it does not need

from __future__ import annotations

TYPE_CHECKING = False  # as type checkers know it; `typing` takes longer to load than Ctrl-C may go unanswered
if TYPE_CHECKING:
    from hcsearch.api.deploying import deploy
    from hcsearch.api.enumerating import enumerate_into
    from hcsearch.api.exporting import save
    from hcsearch.api.querying import rank, read
    from hcsearch.api.replaying import replay
    from hcsearch.api.tuning import tune
    from hcsearch.circuit import Circuit
    from hcsearch.deployment.deployed import Deployed
    from hcsearch.enumeration import ArrayCount, ArraySearch, PolygonSearch, count_array, enumerate_circuits
    from hcsearch.errors import HcsearchError
    from hcsearch.folding import Folding, foldings
    from hcsearch.grid import GRIDS, Array, Grid, parse_array
    from hcsearch.linkage import Linkage
    from hcsearch.pattern import Pattern
    from hcsearch.pipeline import Funnel
    from hcsearch.replays.replay import Replay
    from hcsearch.scenes import SCENES, Scene
    from hcsearch.store import open_database, open_readonly, select, select_sql
    from hcsearch.tuning.tuning import Tuning
    from hcsearch.twisting import gauss_linking, twist

    __version__: str

_HOMES = {
    "api.deploying": ("deploy",),
    "api.enumerating": ("enumerate_into",),
    "api.exporting": ("save",),
    "api.querying": ("rank", "read"),
    "api.replaying": ("replay",),
    "api.tuning": ("tune",),
    "circuit": ("Circuit",),
    "deployment.deployed": ("Deployed",),
    "enumeration": ("ArrayCount", "ArraySearch", "PolygonSearch", "count_array", "enumerate_circuits"),
    "errors": ("HcsearchError",),
    "folding": ("Folding", "foldings"),
    "grid": ("GRIDS", "Array", "Grid", "parse_array"),
    "linkage": ("Linkage",),
    "pattern": ("Pattern",),
    "pipeline": ("Funnel",),
    "replays.replay": ("Replay",),
    "scenes": ("SCENES", "Scene"),
    "store": ("open_database", "open_readonly", "select", "select_sql"),
    "system.release": ("__version__",),
    "tuning.tuning": ("Tuning",),
    "twisting": ("gauss_linking", "twist"),
}

__all__ = [
    "GRIDS",
    "SCENES",
    "Array",
    "ArrayCount",
    "ArraySearch",
    "Circuit",
    "Deployed",
    "Folding",
    "Funnel",
    "Grid",
    "HcsearchError",
    "Linkage",
    "Pattern",
    "PolygonSearch",
    "Replay",
    "Scene",
    "Tuning",
    "__version__",
    "count_array",
    "deploy",
    "enumerate_circuits",
    "enumerate_into",
    "foldings",
    "gauss_linking",
    "open_database",
    "open_readonly",
    "parse_array",
    "rank",
    "read",
    "replay",
    "save",
    "select",
    "select_sql",
    "tune",
    "twist",
]


def __getattr__(name: str) -> object:
    # not above: the command line loads this module before it can answer Ctrl-C
    from hcsearch.system.lazy import importing  # noqa: PLC0415
    from hcsearch.system.notebooks import register_view  # noqa: PLC0415

    register_view(_notebook_view)
    return importing(__name__, _HOMES)(name)


def _notebook_view(value: object) -> str | None:
    """Return the HTML of a value in a notebook."""
    from hcsearch.api.notebooks import html_of  # noqa: PLC0415 - loads the player

    return html_of(value)


def __dir__() -> list[str]:
    return __all__
