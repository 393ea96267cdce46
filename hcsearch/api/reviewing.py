"""Compare a folding or a pattern with the rules of a standard: its flight sheet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.vocabulary import Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.scenes import Scene
from hcsearch.springs.flight.flight_sheet import FlightSheet, sheet_text
from hcsearch.springs.flight.review import review
from hcsearch.springs.flight.rules import read_rules
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import resolve
from hcsearch.system.outputs import check_output, write_output

SHEET_SUFFIXES = {".md": "markdown", ".tex": "latex", ".txt": "text", ".html": "html"}
"""Formats of files by their suffix."""


def sheet(
    what: str | Folding | Circuit | Case,
    scene: Scene | str | None = None,
    *,
    rules: str = "ecss",
    measured: bool = False,
    panel: str | None = None,
    flat_pairs: Way | None = None,
    db: Place | None = None,
    **values: Any,
) -> FlightSheet:
    """Compare a folding, or a pattern of a file, in a scene with the rules of a standard, as `hcsearch sheet` does.

    Parameters
    ----------
    what, scene, panel, flat_pairs, db, **values
        As in `deploy`, but not a Linkage or an assembly.
    rules
        `ecss`, `aiaa`, or a file `NAME.toml` (docs/reference/rules.md).
    measured
        Whether friction and harness are measured.

    Returns
    -------
    FlightSheet
        The rules with their figures and margins.

    Raises
    ------
    HcsearchError
        Where neither springs nor a proved path open it.
    """
    check_kinds(sheet, locals())
    standard = read_rules(rules)
    case = resolve(what, db, scene=scene, panel=panel, flat_pairs=flat_pairs, values=values, path=True)
    moved = case.travel()
    return review(moved.travel, standard, kind=case.kind, title=case.title, source=moved.source, measured=measured)


def check_sheet_file(path: str | Path) -> None:
    """Check that a sheet can be written to a file; OutputError for other suffixes than those of `SHEET_SUFFIXES`."""
    check_output(path, tuple(SHEET_SUFFIXES))


def save_sheet(reviewed: FlightSheet, path: str | Path) -> None:
    """Write a flight sheet to a file of a format of `SHEET_SUFFIXES`; OutputError for other suffixes."""
    check_sheet_file(path)
    write_output(path, sheet_in(reviewed, SHEET_SUFFIXES[Path(path).suffix.lower()]))


def sheet_in(reviewed: FlightSheet, style: str) -> str:
    """Return a flight sheet in a format: text, markdown, latex or html."""
    if style != "html":
        return sheet_text(reviewed, style)
    from hcsearch.web.report.sheet_page import render_sheet  # noqa: PLC0415 - loads templates

    return render_sheet(reviewed)
