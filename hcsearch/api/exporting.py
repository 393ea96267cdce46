"""Files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.asking import Setting
from hcsearch.api.places import located
from hcsearch.circuit import Circuit
from hcsearch.export.writing import export
from hcsearch.folding import Folding
from hcsearch.replays.sources import By
from hcsearch.scenes import FlatPairs, Scene


def save(
    what: str | Folding | Circuit,
    path: str | Path,
    scene: Scene | str | None = None,
    *,
    format: str | None = None,  # noqa: A002 - as the command's option
    by: By | None = None,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    **settings: Any,
) -> list[Path]:
    """Write a folding or an assembly to a file that other programs read, as `hcsearch export` does; gives the paths.

    The file's ending names the format, or `format` does. by : which motion, `path` or `springs`. settings : those of
    the format, such as `state="folded"` or `kerf_mm=0.2`. The others as of `deploy`.

    >>> from hcsearch import Folding, save
    >>> [path.name for path in save(Folding.from_notation("hex:0234550132:4"), "sheet.svg", kerf_mm=0.2)]
    ['sheet.svg']
    """
    design = what.notation if isinstance(what, Circuit) else what  # a circuit has an array, whatever its foldings
    request = Setting(scene, located(db), panel, across, flat_pairs, merge).request(design)
    return export(request, path, format, motion=by, **settings)
