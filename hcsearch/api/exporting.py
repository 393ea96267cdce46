"""Export foldings, assemblies and the designs of a query to files for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcsearch import store
from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError, QueryError
from hcsearch.basics.vocabulary import ReplaySource, Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.export.bulk_export import BulkRequest, SavedDesigns, designs_of_query, export_designs
from hcsearch.export.bulk_targets import bulk_kind_of, open_bulk_target
from hcsearch.export.export_files import (
    check_export_loads,
    check_export_motion,
    checked_export_settings,
    export_files,
    replay_contents,
)
from hcsearch.export.formats import export_format_of
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place, reading_database
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.stored_scenes import scene_asked_for
from hcsearch.system.outputs import check_output, replacing_file
from hcsearch.system.terminal import write_notice
from hcsearch.system.work_steps import Progress


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

    Parameters
    ----------
    what, scene, panel, flat_pairs, db
        As in `deploy`; a Linkage cannot be exported. A Replay is written by itself: it has its scene and its motion.
    path
        The file; its ending sets the format.
    format
        The format, if the ending does not determine it.
    motion
        The motion to export, `path` or `springs`.
    values
        Other values of the scene, as in `deploy`.
    **settings
        Options of the format, such as `state="folded"` or `kerf_mm=0.2`; names of lengths end in `_mm`.

    Returns
    -------
    list of Path
        The files that were written.

    Examples
    --------
    >>> from hcsearch import Folding, save
    >>> [path.name for path in save(Folding.from_notation("hex:0234550132:4"), "sheet.svg", kerf_mm=0.2)]
    ['sheet.svg']
    """
    check_kinds(save, locals())
    if isinstance(what, Replay):
        if settings or any(value is not None for value in (scene, motion, panel, flat_pairs, db, values)):
            raise HcsearchError("a Replay has its scene and its motion, and no settings: give its file alone")
        check_output(path)
        return _written(path, replay_contents(what, str(path), format))
    export_format = export_format_of(str(path), format)
    export_settings = replace(
        checked_export_settings(export_format, settings), stem=Path(path).stem, ending=Path(path).suffix.lower()
    )
    check_export_loads(export_format, values, motion, export_settings.state)
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


def save_designs(
    query: str,
    path: str | Path,
    scene: str | None = None,
    *,
    format: str | None = None,  # noqa: A002 - named as the option
    motion: ReplaySource | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    values: Mapping[str, object] | None = None,
    progress: Progress | None = None,
    **settings: Any,
) -> SavedDesigns:
    """Write a file for each design of a query, as `hcsearch export` does; return what was written.

    Parameters
    ----------
    query
        Conditions, as in `read`.
    path
        A folder, an archive `NAME.zip`, or one file of a format of graphs, one a line. Files are named by the id of the
        design and the crease of its best folding, as in `17-4.dxf`; a design without verdicts that say which is the
        best has a file for each folding. Files that a folder has from an earlier call with the same arguments and
        results are kept.
    format
        The format of the files in a folder or an archive.
    scene, panel, flat_pairs, db, values, motion, **settings
        As in `save`, of all designs.
    progress
        Called with the numbers of designs that are done and of all, and a note.

    Returns
    -------
    SavedDesigns
        What was written, kept and left out.

    Examples
    --------
    >>> from hcsearch import enumerate_into, save_designs
    >>> _ = enumerate_into("designs.sqlite", grid="hex", n=8, until="twist")
    >>> save_designs("untwisted", "sheets.zip", format="svg", db="designs.sqlite").written
    1
    """
    check_kinds(save_designs, locals())
    kind, export_format = bulk_kind_of(str(path), format)
    export_settings = checked_export_settings(export_format, settings)
    export_format.check_installed()
    check_export_motion(export_format, motion, export_settings.state)
    check_export_loads(export_format, values, motion, export_settings.state)
    with reading_database(db) as database:
        # without any verdict, the columns that depend on a scene are unknown in all scenes
        is_judged = bool(store.scene_names(database))
        scene_name = scene_asked_for(database, scene, panel, query=query) if is_judged else DEFAULT_SCENE_NAME
        ids = designs_of_query(database, query, scene_name)
        if not ids:
            raise QueryError(f"no design of {database.location} satisfies {query!r}: see hcsearch query")
        if scene is None and panel is None and scene_name != DEFAULT_SCENE_NAME:
            scene = scene_name  # the only one that is judged, which a line has reported
        named = {"scene": scene, "panel": panel, "flat_pairs": flat_pairs, "values": values}
        request = BulkRequest(export_format, export_settings, motion, named)
        with open_bulk_target(str(path), kind) as target:
            saved = export_designs(database, ids, request, target, str(path), scene_name, progress)
    write_notice(saved.sentence)
    return saved
