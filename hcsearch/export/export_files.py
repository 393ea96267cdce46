"""Exports: from a named design, folding or case to the contents of the files of a format."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.basics.vocabulary import ReplaySource
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.export.exported import Exported
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat, FileContent
from hcsearch.export.settings import SETTING_NAMES, ExportSettings, ExportState
from hcsearch.subjects.asked import Extent
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.replay import Replay
from hcsearch.subjects.resolve import resolve
from hcsearch.system.work_steps import work_step

_LOADS = ("held", "seconds", "gravity", "friction")
"""Values of a scene on which only motions and models for simulators depend, and for which `export` has an option."""


def checked_export_settings(export_format: ExportFormat, values: Mapping[str, Any]) -> ExportSettings:
    """Check the settings of an export; HcsearchError for settings that the format does not support."""
    for name in values:
        if name not in SETTING_NAMES:
            raise HcsearchError(f"exports have no setting {name!r}: they have {', '.join(sorted(SETTING_NAMES))}")
        if name not in export_format.setting_names:
            option = "--" + name.removesuffix("_mm").removesuffix("_s").replace("_", "-")
            supporting = ", ".join(other.name for other in EXPORT_FORMATS.values() if name in other.setting_names)
            raise HcsearchError(
                f"{export_format.name} takes no {option}: leave it out, or choose {supporting or 'another format'}"
            )
    return ExportSettings(**values)


def check_export_motion(export_format: ExportFormat, by: ReplaySource | None, state: ExportState) -> None:
    """Refuse an unknown motion, and a motion for a format that holds none; HcsearchError."""
    if by is not None and by not in get_args(ReplaySource):
        raise HcsearchError(f"there is no motion {by!r}: choose {' or '.join(get_args(ReplaySource))}")
    if by is not None and not (
        export_format.subject == "motion" or export_format.frames or _is_share(export_format, state)
    ):
        remedy = ", or give --state SHARE" if "state" in export_format.setting_names else ""
        raise HcsearchError(f"{export_format.name} holds no motion: leave out --motion{remedy}")


def check_export_loads(
    export_format: ExportFormat, values: Mapping[str, object] | None, by: ReplaySource | None, state: ExportState
) -> None:
    """Refuse loads and supports for a file that holds neither them nor a motion; HcsearchError.

    values : of the scene by name, as of `resolve`; others than these are taken by all formats.
    """
    moves = export_format.subject == "motion" or by is not None or _is_share(export_format, state)
    names = [name for name in _LOADS if (values or {}).get(name) is not None]
    if names and not (moves or export_format.simulated):
        simulated = ", ".join(other.name for other in EXPORT_FORMATS.values() if other.simulated)
        remedy = " or --motion springs" if export_format.frames else ""
        raise HcsearchError(f"{export_format.name} takes no --{names[0]}: leave it out, or choose {simulated}{remedy}")


def exported_case(
    case: Case, export_format: ExportFormat, by: ReplaySource | None = None, state: ExportState = "flat"
) -> Exported:
    """Prepare a case for export, with its motion where the format or the state needs one.

    by : source of the motion (`Case.replay`). HcsearchError where there is no such motion, and for solids at a share of
    a motion that does not end flat.
    """
    replay, sentence, share = None, case.sentence, _is_share(export_format, state)
    if export_format.subject == "motion" or by is not None or share:
        replay, sentence = case.replay(by)
    # a picture tells that its motion does not end flat
    if share and replay is not None and not replay.ends_flat and not export_format.frames:
        raise HcsearchError(
            f"the motion of {case.title} does not end flat ({replay.source}): write --state flat or folded"
        )
    faults = "" if replay is None else replay.faults
    sentence = "; ".join(filter(None, (sentence, faults and f"the motion: {faults}")))
    return Exported(case.title, case, replay, sentence)


def _is_share(export_format: ExportFormat, state: ExportState) -> bool:
    """Whether a state is a share of the motion, in a format that supports states (solids)."""
    return isinstance(state, float) and "state" in export_format.setting_names


@work_step("writing the file")
def export_contents(exported: Exported, export_format: ExportFormat, settings: ExportSettings) -> dict[str, bytes]:
    """Return the contents of all files of an export, by what follows the stem of their names; the main file first."""
    written = export_format.write(exported, settings)
    files: Mapping[str, FileContent] = written if isinstance(written, Mapping) else {export_format.endings[0]: written}
    return {ending: text.encode() if isinstance(text, str) else text for ending, text in files.items()}


def export_files(
    what: str | Folding | Circuit | Case,
    export_format: ExportFormat,
    settings: ExportSettings,
    motion: ReplaySource | None = None,
    db: Place | None = None,
    **named: Any,
) -> tuple[Exported, dict[str, bytes]]:
    """Return the contents of all files of an export, by what follows the stem of their names.

    named : scene, panel, flat_pairs and values, as of `resolve`.
    """
    export_format.check_installed()
    check_export_motion(export_format, motion, settings.state)
    case = export_subject(what, export_format, motion, db, **named)
    exported = exported_case(case, export_format, motion, settings.state)
    return exported, export_contents(exported, export_format, settings)


def export_subject(
    what: str | Folding | Circuit | Case,
    export_format: ExportFormat,
    motion: ReplaySource | None = None,
    db: Place | None = None,
    **named: Any,
) -> Case:
    """Resolve what is exported: the whole design in a format of the array, else a case; named : as above."""
    extent: Extent = "array" if export_format.subject == "array" and motion is None else "folding"
    return resolve(what, db, path=motion == "path", extent=extent, **named)


def replay_export_format(path: str, name: str | None = None) -> ExportFormat:
    """Return the format of a file that holds a motion, of a given name or by its ending; OutputError for others.

    The ending `.svg` stands for the moving picture, as a sheet does not move.
    """
    suffix = Path(path).suffix.lower()
    formats = [form for form in EXPORT_FORMATS.values() if form.frames or form.subject == "motion"]
    fitting = [form for form in formats if suffix in form.endings and name in (None, form.name)]
    if not fitting:
        endings = ", ".join(form.endings[0] for form in formats)
        raise OutputError(f"{path} is no name for a file of a motion{f' as {name}' if name else ''}: write {endings}")
    return fitting[0]


def replay_contents(replay: Replay, path: str, name: str | None = None) -> dict[str, bytes]:
    """Return the contents of all files of an export of a replay, by what follows the stem of their names.

    path : the file, and name : of the format, if its ending does not determine it.
    """
    export_format = replay_export_format(path, name)
    export_format.check_installed()
    settings = ExportSettings(ending=Path(path).suffix.lower())
    return export_contents(Exported(replay.title, replay=replay), export_format, settings)
