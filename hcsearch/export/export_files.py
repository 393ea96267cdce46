"""Exports: what a format takes of what is named, and the contents of its files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, get_args

from hcsearch.basics.errors import HcsearchError
from hcsearch.cases.case import Case
from hcsearch.cases.names import Place, design_named
from hcsearch.cases.replay_sources import ReplaySource, replay_case
from hcsearch.cases.resolve import resolve
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, split_crease
from hcsearch.export.exported import Exported
from hcsearch.export.formats import EXPORT_FORMATS, ExportFormat, FileContent
from hcsearch.export.settings import SETTING_NAMES, ExportSettings, ExportState


def checked_export_settings(wanted: ExportFormat, given: Mapping[str, Any]) -> ExportSettings:
    """Check the settings of an export; HcsearchError for those that the format does not heed."""
    for name in given:
        if name not in SETTING_NAMES:
            raise HcsearchError(f"exports have no setting {name!r}: they have {', '.join(sorted(SETTING_NAMES))}")
        if name not in wanted.takes:
            option = "--" + name.removesuffix("_mm").removesuffix("_s").replace("_", "-")
            others = ", ".join(other.name for other in EXPORT_FORMATS.values() if name in other.takes)
            raise HcsearchError(
                f"{wanted.name} takes no {option}: leave it out, or choose {others or 'another format'}"
            )
    return ExportSettings(**given)


def check_export_motion(wanted: ExportFormat, by: ReplaySource | None, state: ExportState) -> None:
    """Refuse a motion that does not exist, or that a format has no place for."""
    if by is not None and by not in get_args(ReplaySource):
        raise HcsearchError(f"there is no motion {by!r}: choose {' or '.join(get_args(ReplaySource))}")
    if by is not None and not (wanted.of == "motion" or wanted.frames or _is_share(wanted, state)):
        remedy = ", or give --state SHARE" if "state" in wanted.takes else ""
        raise HcsearchError(f"{wanted.name} holds no motion: leave out --motion{remedy}")


def exported_case(
    case: Case, wanted: ExportFormat, by: ReplaySource | None = None, state: ExportState = "flat"
) -> Exported:
    """Give a case as a format takes it, with its motion where the format or the state asks for one.

    by : where the motion comes from (`replay_case`). HcsearchError where there is no such motion, and for a share of a
    motion that does not end flat.
    """
    replay, sentence, share = None, case.sentence, _is_share(wanted, state)
    if wanted.of == "motion" or by is not None or share:
        replay, sentence = replay_case(case, by)
    if share and replay is not None and not replay.ends_flat:
        raise HcsearchError(
            f"the motion of {case.title} does not end flat ({replay.source}): write --state flat or folded"
        )
    faults = "" if replay is None else replay.faults
    sentence = "; ".join(filter(None, (sentence, faults and f"the motion: {faults}")))
    circuit = None if case.folding is None else case.folding.circuit
    return Exported(case.title, circuit, case, replay, sentence)


def _is_share(wanted: ExportFormat, state: ExportState) -> bool:
    """Whether a state is a share of the motion, which solids alone take."""
    return isinstance(state, float) and "state" in wanted.takes


def export_contents(exported: Exported, wanted: ExportFormat, settings: ExportSettings) -> dict[str, bytes]:
    """Make the contents of all files of an export, by what follows the stem of their names; the file itself first."""
    made = wanted.write(exported, settings)
    files: Mapping[str, FileContent] = made if isinstance(made, Mapping) else {wanted.endings[0]: made}
    return {ending: text.encode() if isinstance(text, str) else text for ending, text in files.items()}


def export_files(
    what: str | Folding | Circuit | Case,
    wanted: ExportFormat,
    settings: ExportSettings,
    motion: ReplaySource | None = None,
    db: Place | None = None,
    **named: Any,
) -> tuple[Exported, dict[str, bytes]]:
    """Make the files of an export, all of them or none, by what follows the stem of their names.

    named : scene, panel, flat_pairs and values, as of `resolve`.
    """
    wanted.check_installed()
    check_export_motion(wanted, motion, settings.state)
    circuit = _design(what, db) if wanted.of == "array" and motion is None else None
    if circuit is not None:
        exported = Exported(circuit.notation, circuit)
    else:
        case = resolve(what, db, path=motion == "path", **named)
        exported = exported_case(case, wanted, motion, settings.state)
    return exported, export_contents(exported, wanted, settings)


def _design(what: str | Folding | Circuit | Case, db: Place | None) -> Circuit | None:
    """The circuit of a design without a crease, whose array is exported whatever its foldings; None for all else."""
    if isinstance(what, Circuit):
        return what.canonical()
    if not isinstance(what, str) or what.endswith(".toml") or not (":" in what or what[:1].isdigit()):
        return None
    name, crease = split_crease(what)
    return design_named(name, db)[0] if crease is None else None
