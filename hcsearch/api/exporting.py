"""Files for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.asking import Setting
from hcsearch.api.kinds import check_kinds
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
    motion: By | None = None,
    panel: str | None = None,
    across: str | None = None,
    flat_pairs: FlatPairs | None = None,
    merge: bool = False,
    db: str | Path | None = None,
    **settings: Any,
) -> list[Path]:
    """Write a folding or an assembly to a file for another program, as `hcsearch export` does; return the paths.

    what, scene, panel, across, flat_pairs, merge, db : as in `deploy`; a Linkage cannot be exported.
    path : the file; its ending sets the format. format : the format, if the ending does not tell it.
    motion : the motion to export, `path` or `springs`.
    settings : options of the format, such as `state="folded"` or `kerf_mm=0.2`; names of lengths end in `_mm`.

    >>> from hcsearch import Folding, save
    >>> [path.name for path in save(Folding.from_notation("hex:0234550132:4"), "sheet.svg", kerf_mm=0.2)]
    ['sheet.svg']
    """
    check_kinds(save, locals())
    design = what.notation if isinstance(what, Circuit) else what  # a circuit has an array, whatever its foldings
    request = Setting(scene, located(db), panel, across, flat_pairs, merge).request(design)
    return export(request, path, format, motion=motion, **settings)
