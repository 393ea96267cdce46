"""Show a design, an assembly or a pattern, with the results on it in a database, as text or as a page."""

from __future__ import annotations

import shlex
from pathlib import Path

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import OutputError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.subjects.case import Case
from hcsearch.subjects.names import Place
from hcsearch.subjects.resolve import kind_of, resolve
from hcsearch.system.outputs import check_output, write_output


def show(
    design: str | Circuit | Folding | Case,
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
) -> Case:
    """Look up a design and its foldings, an assembly, or a pattern of a file, as `hcsearch show` prints them.

    Parameters
    ----------
    design
        Its id in the database, the notation of its circuit, which needs no database, DESIGN:CREASE for one of its
        foldings, the name of an assembly, a file `.fold`, `.cp`, `.opx`, `.svg`, `.urdf`, `.xml` or `.mjcf`, or a case
        or a file `NAME.toml` that names one of these, which is shown in its scene.
    db, scene, panel
        As in `deploy`. Where a scene or panels are given, the paths and deployments are those in this scene; else in
        all.

    Returns
    -------
    Case
        The design, with its `foldings` and what is `stored` of them, the assembly or the pattern, each with its
        `facts`.

    Examples
    --------
    >>> from hcsearch import show
    >>> [folding.crease for folding in show("hex:0234550132").foldings]
    [3, 4]
    """
    check_kinds(show, locals())
    return resolve(design, db, scene=scene, panel=panel, extent="results").shown()


def show_page(
    design: str | Circuit | Folding,
    path: str | Path | None = None,
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
) -> Path:
    """Write the HTML page of a design, an assembly or a pattern, as `hcsearch show --html` does; return its path.

    Parameters
    ----------
    design, db, scene, panel
        As in `show`, but not a case.
    path
        The file to write, by default reports/design-DESIGN.html, reports/assembly-NAME.html,
        reports/pattern-FILE.html or, of a file `NAME.toml`, reports/case-FILE.html.

    Returns
    -------
    Path
        The page.
    """
    from hcsearch.web.report.page_files import Pages  # noqa: PLC0415 - texts do without pages and their engine

    check_kinds(show_page, locals())
    kind, name = kind_of(design), str(design)
    options = [("--scene", scene), ("--panel", panel)]
    option = "".join(f" {key} {shlex.quote(value)}" for key, value in options if value)
    is_design = kind == "design"
    file_name = name.replace(":", "-") if is_design else Path(name).name
    place = Path(path or f"reports/{kind}-{file_name}.html")
    check_output(str(place))
    _refuse_source(place, name)
    case = resolve(design, db, scene=scene, panel=panel, extent="page")
    _refuse_source(place, case.source_file)
    write_output(place, case.page(Pages(option if is_design else "", "" if is_design else shlex.quote(name) + option)))
    return place


def _refuse_source(place: Path, source: str) -> None:
    """Refuse to write a page to the file that it shows."""
    if source and place.exists() and Path(source).exists() and place.samefile(source):
        raise OutputError(f"{place} is the file that is shown: write the page to another one")
