"""What a request may have computed, in a process of its own: the page of a design, and files of exports.

Nothing is simulated or planned in the process that answers lists, so that these are answered all the time.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from hcsearch.basics.errors import HcsearchError
from hcsearch.export.formats import FORMATS, Format
from hcsearch.store import open_readonly
from hcsearch.web.serve.addresses import Asked, address_of, design_address


@dataclass(frozen=True)
class Made:
    """A file: its name, and what is in it."""

    name: str
    content: bytes


def design_page(db: str, notation: str, number: int, scene: str, named: str) -> str:
    """The page of a design of a database, with its foldings and their motions; named : its scene, in addresses."""
    from hcsearch.designs.circuit import Circuit  # noqa: PLC0415 - the engine
    from hcsearch.designs.folding import foldings  # noqa: PLC0415 - the engine
    from hcsearch.web.report.design_fetching import design_data  # noqa: PLC0415 - the engine
    from hcsearch.web.report.design_page import render_design  # noqa: PLC0415 - the engine

    circuit = Circuit.from_notation(notation)
    with open_readonly(db) as database:
        data = design_data(circuit, foldings(circuit), db, database, number, scene)
    row = Asked("designs", query=f"id={number}", scene=named, usual="")
    links = [("all designs", address_of(replace(row, query=""))), ("its row as JSON", address_of(row, ".json"))]
    links += [(f"{form.name} of its array", _export_address(number, form, named)) for form in _formats("array")]
    exports = {
        shown.folding.crease: [
            (form.name, _export_address(number, form, named, shown.folding.crease))
            for form in _formats("pattern", *(() if shown.twist else ("motion",)))
        ]
        for shown in data.foldings
    }
    return render_design(replace(data, links=links, exports=exports))


def motion(db: str, notation: str, number: int, crease: int, scene: str) -> str:
    """The stored path of a folding in a scene, as the player takes it."""
    from hcsearch.cases.replays.sources import stored_replays  # noqa: PLC0415 - the engine
    from hcsearch.designs.circuit import Circuit  # noqa: PLC0415 - the engine
    from hcsearch.web.player import motion_json  # noqa: PLC0415 - the engine

    with open_readonly(db) as database:
        replays = stored_replays(database, {number: Circuit.from_notation(notation)}, scene)
        for path, replay in replays:
            if path.crease == crease:
                return motion_json(replay)
    raise HcsearchError(f"the path of folding {crease} is no longer in the database: open the list again")


def _formats(*of: str) -> list[Format]:
    """The formats of some kinds that are installed."""
    installed = []
    for form in FORMATS.values():
        with suppress(HcsearchError):
            if form.of in of:
                form.check_installed()
                installed.append(form)
    return installed


def _export_address(number: int, form: Format, named: str, crease: int | None = None) -> str:
    below = "" if crease is None else f"/foldings/{crease}"
    chosen = {"format": form.name} if form.by_name else {}
    return design_address(number, named, f"{below}/export{form.endings[0]}", **chosen)


def export_file(
    db: str, subject: str, stem: str, name: str, scene: str, motion: Any, settings: Mapping[str, Any]
) -> Made:
    """An export of a design or folding of the database; of several files, an archive. stem : of its name."""
    from hcsearch.export.writing import export_files, settings_of  # noqa: PLC0415 - the engine

    wanted = FORMATS[name]
    chosen = replace(settings_of(wanted, settings), stem=stem)
    _, files = export_files(subject, wanted, chosen, motion, db, scene=scene)
    ending = wanted.endings[0]
    if len(files) == 1:
        return Made(stem + ending, files[ending])
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for own, content in files.items():
            packed.writestr(zipfile.ZipInfo(stem + own), content)
    return Made(f"{stem}{ending}.zip", archive.getvalue())
