"""Show a design: its circuit, its foldings, and the results on them in a database; or a pattern of a file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.cases.mechanisms import freedoms_of, lock_sentences
from hcsearch.cases.pattern_files import DrawnDesign, is_pattern_file, read_pattern_file
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, no_folding_reason, split_crease
from hcsearch.designs.panel_sizes import PanelSize, default_panel, panel_text
from hcsearch.designs.twisting import twist
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene, panel_of
from hcsearch.system.outputs import check_output

if TYPE_CHECKING:
    from hcsearch.cases.case import Case
    from hcsearch.cases.databases import Place
    from hcsearch.cases.stored_designs import StoredDesign
    from hcsearch.search.own_patterns.checked_patterns import CheckedPattern


@dataclass(frozen=True)
class ShownDesign:
    """A design and its foldings.

    circuit : in canonical order. foldings : all, or the one that is named. panel : size of its panels, m.
    stored : the results in a database; None of a circuit without one.
    """

    circuit: Circuit
    foldings: Sequence[Folding]
    panel: PanelSize
    stored: StoredDesign | None = None

    @property
    def no_folding_reason(self) -> str:
        """The reason that a circuit has no folding."""
        return no_folding_reason(self.circuit.n)

    def linking_number(self, folding: Folding) -> int:
        """The twist of a folding."""
        return twist(folding)

    def sentences(self, folding: Folding) -> Iterator[list[str]]:
        """Sentences on the mechanism of a folding and its stored motions, each with its details and commands."""
        if twist(folding) == 0:
            yield from ([freedoms.sentence] for freedoms in freedoms_of(folding, self.panel))
            yield from lock_sentences(folding, self.panel)
        if self.stored is not None:
            yield from self.stored.motions(folding)


def show(
    design: str | Circuit | Folding | Case,
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
) -> ShownDesign | CheckedPattern:
    """Look up a design and its foldings, or a pattern of a file, as `hcsearch show` prints them.

    Parameters
    ----------
    design
        Its id in the database, the notation of its circuit, which needs no database, DESIGN:CREASE for one of its
        foldings, a file `.fold`, `.urdf`, `.xml` or `.mjcf`, or a case, which is shown in its scene.
    db, scene, panel
        As in `deploy`. Where a scene or panels are given, the paths and deployments are those in this scene; else in
        all.

    Returns
    -------
    ShownDesign or CheckedPattern
        The design, and its foldings with their results; of a file that draws no design of a grid, the degrees of
        freedom and the locks.

    Examples
    --------
    >>> from hcsearch import show
    >>> [folding.crease for folding in show("hex:0234550132").foldings]
    [3, 4]
    """
    check_kinds(show, locals())
    if not isinstance(design, str | Circuit | Folding):
        return _of_case(design)
    if isinstance(design, str) and is_pattern_file(design):
        return _of_file(design, db, scene, panel)
    name, crease = _split(design)
    if ":" not in name:
        stored = _stored(name, db, scene, panel)
        return ShownDesign(stored.circuit, _chosen(stored.circuit, crease), stored.panel, stored)
    circuit = Circuit.from_notation(name).canonical()
    size = default_panel(circuit.grid.name)
    if scene or panel:
        from hcsearch.cases.resolve import resolve_scene  # noqa: PLC0415 - a circuit alone needs no database

        size = panel_of(resolve_scene(circuit.grid.name, db, scene=scene, panel=panel), circuit.grid.name)
    return ShownDesign(circuit, _chosen(circuit, crease), size)


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
        As in `show`, or the name of an assembly; a circuit is shown in the scene `default`.
    path
        The file to write, by default reports/design-DESIGN.html, reports/assembly-NAME.html or
        reports/pattern-FILE.html.

    Returns
    -------
    Path
        The page.
    """
    from hcsearch.cases.databases import database_location  # noqa: PLC0415 - texts do without pages and their engine
    from hcsearch.cases.stored_designs import stored_circuit_in_scene  # noqa: PLC0415
    from hcsearch.web.report.page_files import write_design  # noqa: PLC0415

    check_kinds(show_page, locals())
    if isinstance(design, str) and design in ASSEMBLIES:
        return _assembly_page(design, path, db, scene=scene, panel=panel)
    if isinstance(design, str) and is_pattern_file(design):
        return _file_page(design, path, db, scene=scene, panel=panel)
    name, crease = _split(design)
    given = name if crease is None else f"{name}:{crease}"
    place = Path(path or f"reports/design-{given.replace(':', '-')}.html")
    number, scene_name = None, DEFAULT_SCENE_NAME
    if ":" in name:
        circuit = Circuit.from_notation(name).canonical()
        if scene or panel:
            raise HcsearchError("a circuit is shown in the scene default: name the design by its id in a database")
    else:
        number, circuit, scene_name = stored_circuit_in_scene(name, db, scene=scene, panel=panel)
    check_output(str(place))
    location = database_location(db)
    return write_design(circuit, _chosen(circuit, crease), place, db=location, number=number, scene=scene_name)


def _assembly_page(
    name: str, path: str | Path | None, db: Place | None, *, scene: str | None, panel: str | None
) -> Path:
    """Write the page of an assembly."""
    from hcsearch.cases.resolve import resolve  # noqa: PLC0415 - texts do without pages and their engine
    from hcsearch.web.report.assembly_page import write_assembly  # noqa: PLC0415

    place = Path(path or f"reports/assembly-{name}.html")
    check_output(str(place))
    case = resolve(name, db, scene=scene, panel=panel)
    return write_assembly(name, case, place, "" if scene is None else f" --scene {shlex.quote(scene)}")


def _of_file(path: str, db: Place | None, scene: str | None, panel: str | None) -> ShownDesign | CheckedPattern:
    """The design that a file draws, with the foldings of its assignment, or its pattern."""
    from hcsearch.search.own_patterns.checked_patterns import pattern_mobility  # noqa: PLC0415 - few names are files

    drawn = read_pattern_file(path, panel)
    if isinstance(drawn, DrawnDesign):
        shown = show(drawn.design.circuit, db=db, scene=scene, panel=drawn.panel)
        assert isinstance(shown, ShownDesign)
        return replace(shown, foldings=drawn.design.foldings)
    if scene is not None:
        raise HcsearchError("the properties of a pattern depend on no scene: ask for a page, or leave the scene out")
    return pattern_mobility(path, drawn.packed, Scene())


def _file_page(name: str, path: str | Path | None, db: Place | None, *, scene: str | None, panel: str | None) -> Path:
    """Write the page of the folding or the pattern that a file draws."""
    from hcsearch.cases.resolve import resolve  # noqa: PLC0415 - texts do without pages and their engine
    from hcsearch.web.report.pattern_page import write_pattern  # noqa: PLC0415

    place = Path(path or f"reports/pattern-{Path(name).name}.html")
    check_output(str(place))
    if place.exists() and place.samefile(name):
        raise OutputError(f"{place} is the file with the pattern: write the page to another one")
    case = resolve(name, db, scene=scene, panel=panel)
    if case.folding is not None:
        if case.panel != default_panel(case.folding.circuit.grid.name):
            raise HcsearchError(
                f"{name} draws {case.folding.notation} with panels of {panel_text(case.panel)} mm, and the page of a "
                "folding that no database holds shows default panels: enumerate it in a scene with these panels and "
                "name its id, or see hcsearch check"
            )
        return show_page(case.folding, place, db=db, scene=scene, panel=panel)
    options = [("--scene", scene), ("--panel", panel)]
    return write_pattern(case, place, "".join(f" {key} {shlex.quote(value)}" for key, value in options if value))


def _of_case(case: Case) -> ShownDesign:
    """The folding of a case, with its panels and the results in its scene."""
    if case.folding is None:
        raise HcsearchError(
            f"{case.title} is no design: see hcsearch assembly, or name a circuit such as hex:0234550132"
        )
    folding, stored = Folding.from_notation(case.folding.notation), None
    if case.stored is not None:
        scene = None if case.stored.verdict is None else case.stored.scene
        stored = _stored(str(case.stored.number), case.stored.location, scene, None)
    return ShownDesign(folding.circuit, [folding], case.panel, stored)


def _split(design: str | Circuit | Folding) -> tuple[str, int | None]:
    """The name of a design, and the crease of the folding that is named."""
    if isinstance(design, Circuit):
        return design.notation, None
    name = design if isinstance(design, str) else design.notation
    if not name[:1].isdigit() and ":" not in name:
        if name in ASSEMBLIES:
            raise HcsearchError(f"{name} is an assembly: see hcsearch assembly {name}")
        raise HcsearchError(
            f"{name!r} is no design: give an id, the notation of a circuit such as hex:0234550132, a file .fold, .urdf "
            "or .xml, or the name of an assembly (`hcsearch assembly list`)"
        )
    return split_crease(name)


def _stored(name: str, db: Place | None, scene: str | None, panel: str | None) -> StoredDesign:
    from hcsearch.cases.stored_designs import stored_design  # noqa: PLC0415 - a circuit alone needs no database

    return stored_design(name, db, scene=scene, panel=panel)


def _chosen(circuit: Circuit, crease: int | None) -> list[Folding]:
    return foldings(circuit) if crease is None else [folding_of(circuit, crease)]
