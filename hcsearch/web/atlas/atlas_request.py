"""The request for an atlas: the designs that it holds, and the versions that its contents depend on."""

from __future__ import annotations

import platform
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from hcsearch.basics.errors import NotationError, SizeError
from hcsearch.designs.grid import GRIDS, grid_of
from hcsearch.search.stages.order import STAGES, stage_numbers, stages_until
from hcsearch.store import file_library_versions

LEAST_PANELS = 3
"""The fewest panels through which a closed walk goes."""
_LIBRARIES = ("alembic", "jinja2", "numba", "numpy", "scipy", "sqlalchemy")
"""Libraries whose versions may change last digits of results, or bytes of files."""


@dataclass(frozen=True)
class AtlasRequest:
    """All designs with up to n panels on some grids, taken through the stages up to one.

    grids : names of grids, in alphabetical order. n : the greatest number of panels. until : the last stage.
    """

    grids: tuple[str, ...]
    n: int
    until: str

    @property
    def sizes(self) -> list[tuple[str, int]]:
        """Grid and number of panels of the searches, in the order in which designs are numbered."""
        return [(grid, n) for grid in self.grids for n in range(LEAST_PANELS, self.n + 1)]

    @property
    def title(self) -> str:
        """The title of the atlas."""
        return f"Atlas of thick-panel designs with up to {self.n} panels"

    def has_run(self, stage: str) -> bool:
        """Return whether the designs are taken through a stage."""
        names = list(STAGES)
        return names.index(stage) <= names.index(self.until)

    def record(self) -> dict[str, Any]:
        """Return the request with the versions of all that its files depend on, as plain data."""
        return {"grids": list(self.grids), "n": self.n, "until": self.until, "versions": self._versions()}

    def _versions(self) -> dict[str, str]:
        numbers = stage_numbers(stages_until(self.until))
        return {
            "hcsearch": version("hcsearch"),
            "python": platform.python_version(),
            **{name: version(name) for name in _LIBRARIES},
            **file_library_versions(),
            "zlib": zlib.ZLIB_RUNTIME_VERSION,
            **{f"stage {name}": str(number) for name, number in numbers.items()},
        }


def atlas_request(grids: Sequence[str], n: int, until: str | None) -> AtlasRequest:
    """Return the request for the given grids, and the last stage unless one is named; errors name the remedy."""
    if n < LEAST_PANELS:
        raise SizeError(f"n = {n} is too small: a closed walk needs {LEAST_PANELS} panels or more")
    if not grids:
        raise NotationError(f"an atlas needs a grid: name one or more of {', '.join(GRIDS)}, or leave grids out")
    last = list(STAGES)[-1] if until is None else until
    stages_until(last)
    return AtlasRequest(tuple(sorted({grid_of(grid).name for grid in grids})), int(n), last)
