"""Files for other programs."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.cases.case import Case
from hcsearch.cases.names import design_named
from hcsearch.cases.places import Place
from hcsearch.cases.resolve import resolve
from hcsearch.circuit import Circuit
from hcsearch.export.exported import Exported
from hcsearch.export.formats import Format, format_of
from hcsearch.export.settings import Settings
from hcsearch.export.writing import check_motion, contents, exported_case, settings_of
from hcsearch.folding import Folding, split_crease
from hcsearch.replays.sources import By
from hcsearch.scenes import Scene
from hcsearch.system.notices import say
from hcsearch.system.outputs import check_output, replacing
from hcsearch.vocabulary import Way


def save(
    what: str | Folding | Circuit | Case,
    path: str | Path,
    scene: Scene | str | None = None,
    *,
    format: str | None = None,  # noqa: A002 - as the command's option
    motion: By | None = None,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    values: dict[str, Any] | None = None,
    **settings: Any,
) -> list[Path]:
    """Write a folding or an assembly to a file for another program, as `hcsearch export` does; return the paths.

    what, scene, panel, flat_pairs, db : as in `deploy`; a Linkage cannot be exported.
    path : the file; its ending sets the format. format : the format, if the ending does not tell it.
    motion : the motion to export, `path` or `springs`. values : other values of the scene, as in `deploy`.
    settings : options of the format, such as `state="folded"` or `kerf_mm=0.2`; names of lengths end in `_mm`.

    >>> from hcsearch import Folding, save
    >>> [path.name for path in save(Folding.from_notation("hex:0234550132:4"), "sheet.svg", kerf_mm=0.2)]
    ['sheet.svg']
    """
    check_kinds(save, locals())
    wanted = format_of(str(path), format)
    chosen = replace(settings_of(wanted, settings), stem=Path(path).stem)
    check_output(path)
    named = {"scene": scene, "panel": panel, "flat_pairs": flat_pairs, "values": values}
    exported, files = export_files(what, wanted, chosen, motion, db, **named)
    paths = [Path(path), *(Path(path).with_suffix(ending) for ending in list(files)[1:])]
    with ExitStack() as stack:
        for place, content in zip(paths, files.values(), strict=True):
            stack.enter_context(replacing(place)).write_bytes(content)
    say(exported.sentence)
    return paths


def export_files(
    what: str | Folding | Circuit | Case,
    wanted: Format,
    settings: Settings,
    motion: By | None = None,
    db: Place | None = None,
    **named: Any,
) -> tuple[Exported, dict[str, bytes]]:
    """Make the files of an export, all of them or none, by what follows the stem of their names.

    named : scene, panel, flat_pairs and values, as of `resolve`.
    """
    wanted.check_installed()
    check_motion(wanted, motion, settings.state)
    circuit = _design(what, db) if wanted.of == "array" and motion is None else None
    if circuit is not None:
        exported = Exported(circuit.notation, circuit)
    else:
        case = resolve(what, db, path=motion == "path", **named)
        exported = exported_case(case, wanted, motion, settings.state)
    return exported, contents(exported, wanted, settings)


def _design(what: str | Folding | Circuit | Case, db: Place | None) -> Circuit | None:
    """The circuit of a design without a crease, whose array is exported whatever its foldings; None for all else."""
    if isinstance(what, Circuit):
        return what.canonical()
    if not isinstance(what, str) or what.endswith(".toml") or not (":" in what or what[:1].isdigit()):
        return None
    name, crease = split_crease(what)
    return design_named(name, db)[0] if crease is None else None
