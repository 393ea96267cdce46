"""Export foldings and assemblies to files for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import Way
from hcsearch.cases.case import Case
from hcsearch.cases.databases import Place
from hcsearch.cases.replay import Replay
from hcsearch.cases.replay_sources import ReplaySource
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.export.export_files import checked_export_settings, export_files, replay_contents, replay_export_format
from hcsearch.export.formats import export_format_of
from hcsearch.scenes import Scene
from hcsearch.system.outputs import check_output, replacing_file
from hcsearch.system.terminal import write_notice


def save(
    what: str | Folding | Circuit | Case | Replay,
    path: str | Path,
    scene: Scene | str | None = None,
    *,
    format: str | None = None,  # noqa: A002 - named as the option
    motion: ReplaySource | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    values: Mapping[str, object] | None = None,
    **settings: Any,
) -> list[Path]:
    """Write a folding or an assembly to a file for another program, as `hcsearch export` does; return the paths.

    what, scene, panel, flat_pairs, db : as in `deploy`; a Linkage cannot be exported. A Replay is written by itself:
        it has its scene and its motion.
    path : the file; its ending sets the format. format : the format, if the ending does not determine it.
    motion : the motion to export, `path` or `springs`. values : other values of the scene, as in `deploy`.
    settings : options of the format, such as `state="folded"` or `kerf_mm=0.2`; names of lengths end in `_mm`.

    >>> from hcsearch import Folding, save
    >>> [path.name for path in save(Folding.from_notation("hex:0234550132:4"), "sheet.svg", kerf_mm=0.2)]
    ['sheet.svg']
    """
    check_kinds(save, locals())
    if isinstance(what, Replay):
        if settings or any(value is not None for value in (scene, motion, panel, flat_pairs, db, values)):
            raise HcsearchError("a Replay has its scene and its motion, and no settings: give its file alone")
        check_output(path)
        return _written(path, replay_contents(what, replay_export_format(str(path), format)))
    export_format = export_format_of(str(path), format)
    export_settings = replace(checked_export_settings(export_format, settings), stem=Path(path).stem)
    check_output(path)
    case_arguments = {"scene": scene, "panel": panel, "flat_pairs": flat_pairs, "values": values}
    exported, files = export_files(what, export_format, export_settings, motion, db, **case_arguments)
    paths = _written(path, files)
    write_notice(exported.sentence)
    return paths


def _written(path: str | Path, files: Mapping[str, bytes]) -> list[Path]:
    """Write the files of an export, all of them or none; return their paths. files : contents by ending."""
    paths = [Path(path), *(Path(path).with_suffix(ending) for ending in list(files)[1:])]
    with ExitStack() as stack:
        for target, content in zip(paths, files.values(), strict=True):
            stack.enter_context(replacing_file(target)).write_bytes(content)
    return paths
