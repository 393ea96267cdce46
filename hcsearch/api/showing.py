"""Show a design: its circuit, its foldings, and the results on them in a database; or an assembly, or a pattern."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError, OutputError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, no_folding_reason, split_crease
from hcsearch.designs.panel_sizes import PanelSize, default_panel
from hcsearch.designs.twisting import twist
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.description import AssemblyFacts, describe_assembly
from hcsearch.library.assemblies.fact_texts import fact_rows, published_rows
from hcsearch.scenes import Scene, panel_of
from hcsearch.subjects.case import NamedAssembly
from hcsearch.subjects.mechanisms import freedoms_of, lock_sentences
from hcsearch.subjects.names import parameters_of
from hcsearch.subjects.pattern_files import (
    DrawnDesign,
    DrawnPattern,
    is_pattern_file,
    read_pattern_file,
    refuse_other_file,
)
from hcsearch.system.outputs import check_output
from hcsearch.system.terminal import write_notice

if TYPE_CHECKING:
    from hcsearch.search.own_patterns.checked_patterns import CheckedPattern
    from hcsearch.subjects.case import Case
    from hcsearch.subjects.databases import Place
    from hcsearch.subjects.stored_designs import StoredDesign


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


@dataclass(frozen=True)
class ShownAssembly:
    """An assembly of the thesis; facts : its properties, as of `describe`."""

    name: str
    facts: AssemblyFacts

    def rows(self) -> Iterator[tuple[str, str]]:
        """The name and the value of each property, then the values that the thesis states."""
        yield from fact_rows(self.facts)
        for label, text, verdict in published_rows(self.facts):
            yield "the thesis", f"{label} {text}: {verdict}"


def show(
    design: str | Circuit | Folding | Case,
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
) -> ShownDesign | ShownAssembly | CheckedPattern:
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
    ShownDesign, ShownAssembly or CheckedPattern
        The design, and its foldings with their results; the properties of an assembly; of a file that draws no design
        of a grid, the degrees of freedom and the locks.

    Examples
    --------
    >>> from hcsearch import show
    >>> [folding.crease for folding in show("hex:0234550132").foldings]
    [3, 4]
    """
    check_kinds(show, locals())
    if isinstance(design, str) and (design in ASSEMBLIES or design.endswith(".toml")):
        if design in ASSEMBLIES and (scene or panel):
            raise HcsearchError("the properties of an assembly depend on no scene: add --html, or leave the scene out")
        design = _resolved(design, db, scene, panel)
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
        size = panel_of(_scene_of_circuit(circuit, db, scene, panel), circuit.grid.name)
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
        As in `show`, but not a case.
    path
        The file to write, by default reports/design-DESIGN.html, reports/assembly-NAME.html,
        reports/pattern-FILE.html or, of a file `NAME.toml`, reports/case-FILE.html.

    Returns
    -------
    Path
        The page.
    """
    check_kinds(show_page, locals())
    options = [("--scene", scene), ("--panel", panel)]
    option = "".join(f" {key} {shlex.quote(value)}" for key, value in options if value)
    if isinstance(design, str) and (kind := _kind_of_case(design)):
        place = Path(path or f"reports/{kind}-{Path(design).name}.html")
        check_output(str(place))
        _refuse_source(place, design)
        return _case_page(_resolved(design, db, scene, panel), place, db, f"{shlex.quote(design)}{option}")
    name, crease = _split(design)
    given = name if crease is None else f"{name}:{crease}"
    place = Path(path or f"reports/design-{given.replace(':', '-')}.html")
    if ":" in name:
        return _circuit_page(name, crease, place, db, scene=scene, panel=panel, option=option)
    from hcsearch.subjects.databases import database_location  # noqa: PLC0415 - texts do without pages and their engine
    from hcsearch.subjects.stored_designs import stored_circuit_in_scene  # noqa: PLC0415
    from hcsearch.web.report.page_files import write_design  # noqa: PLC0415

    number, circuit, scene_name = stored_circuit_in_scene(name, db, scene=scene, panel=panel)
    check_output(str(place))
    chosen = _chosen(circuit, crease)
    return write_design(circuit, chosen, place, db=database_location(db), number=number, scene=scene_name)


def _circuit_page(
    name: str, crease: int | None, place: Path, db: Place | None, *, scene: str | None, panel: str | None, option: str
) -> Path:
    """Write the page of a circuit, whose foldings are planned and simulated; option : of commands, for the scene."""
    from hcsearch.web.report.design_data import ComputedFolding  # noqa: PLC0415 - texts do without pages
    from hcsearch.web.report.page_files import write_computed_design  # noqa: PLC0415

    circuit = Circuit.from_notation(name).canonical()
    chosen, values = _chosen(circuit, crease), _scene_of_circuit(circuit, db, scene, panel)
    check_output(str(place))
    cases = [_resolved(folding.notation, db, scene, panel) for folding in chosen]
    computed = [ComputedFolding(case, f"{case.name}{option}") for case in cases]
    return write_computed_design(circuit, computed, values, place)


def _kind_of_case(name: str) -> str:
    """The kind of what a name denotes with one page for one case; empty for a design."""
    if name in ASSEMBLIES:
        return "assembly"
    return "pattern" if is_pattern_file(name) else "case" if name.endswith(".toml") else ""


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
    write_notice(f"{path} {drawn.no_design}")
    return pattern_mobility(path, drawn.packed, Scene())


def _refuse_source(place: Path, source: str) -> None:
    """Refuse to write a page to the file that it shows."""
    if place.exists() and Path(source).exists() and place.samefile(source):
        raise OutputError(f"{place} is the file that is shown: write the page to another one")


def _case_page(case: Case, place: Path, db: Place | None, subject: str) -> Path:
    """Write the page of a case; subject : how commands name it, with its options."""
    from hcsearch.subjects.databases import database_location  # noqa: PLC0415 - texts do without pages and their engine
    from hcsearch.web.report.assembly_page import write_assembly  # noqa: PLC0415
    from hcsearch.web.report.design_data import ComputedFolding  # noqa: PLC0415
    from hcsearch.web.report.page_files import write_computed_design, write_design  # noqa: PLC0415
    from hcsearch.web.report.pattern_page import write_pattern  # noqa: PLC0415

    if case.folding is None:
        if not isinstance(case.what, DrawnPattern):
            return write_assembly(case, place, subject)
        _refuse_source(place, case.what.path)
        return write_pattern(case, place, subject)
    stored, circuit = case.stored, case.folding.circuit
    if stored is None or stored.verdict is None or case.drive is not None or case.formulation is not None:
        return write_computed_design(circuit, [ComputedFolding(case, subject)], case.scene, place)
    number, scene = stored.number, stored.scene
    return write_design(circuit, [case.folding], place, db=database_location(db), number=number, scene=scene)


def _of_case(case: Case) -> ShownDesign | ShownAssembly | CheckedPattern:
    """The folding of a case, with its panels and the results in its scene, or its assembly or pattern."""
    if isinstance(case.what, NamedAssembly):
        assembly = ASSEMBLIES[case.what.name]
        return ShownAssembly(assembly.name, describe_assembly(assembly, parameters_of(assembly, case.what.parameters)))
    if isinstance(case.what, DrawnPattern):
        from hcsearch.search.own_patterns.checked_patterns import pattern_mobility  # noqa: PLC0415 - few are patterns

        return pattern_mobility(case.title, case.what.packed, case.scene)
    if case.folding is None:
        raise HcsearchError(f"{case.title} is no design: name a circuit such as hex:0234550132, or an assembly")
    folding, stored = Folding.from_notation(case.folding.notation), None
    if case.stored is not None and case.stored.verdict is not None:
        stored = _stored(str(case.stored.number), case.stored.location, case.stored.scene, None)
    return ShownDesign(folding.circuit, [folding], case.panel, stored)


def _resolved(name: str, db: Place | None, scene: str | None, panel: str | None) -> Case:
    from hcsearch.subjects.resolve import resolve  # noqa: PLC0415 - a circuit alone needs no database

    return resolve(name, db, scene=scene, panel=panel)


def _scene_of_circuit(circuit: Circuit, db: Place | None, scene: str | None, panel: str | None) -> Scene:
    from hcsearch.subjects.resolve import resolve_scene  # noqa: PLC0415 - a circuit alone needs no database

    return resolve_scene(circuit.grid.name, db, scene=scene, panel=panel)


def _split(design: str | Circuit | Folding) -> tuple[str, int | None]:
    """The name of a design, and the crease of the folding that is named."""
    if isinstance(design, Circuit):
        return design.notation, None
    name = design if isinstance(design, str) else design.notation
    refuse_other_file(name)
    if not name[:1].isdigit() and ":" not in name:
        raise HcsearchError(
            f"{name!r} is no design: give an id, the notation of a circuit such as hex:0234550132, a file .toml, "
            ".fold, .cp, .opx, .svg, .urdf or .xml, or the name of an assembly (`hcsearch assembly list`)"
        )
    return split_crease(name)


def _stored(name: str, db: Place | None, scene: str | None, panel: str | None) -> StoredDesign:
    from hcsearch.subjects.stored_designs import stored_design  # noqa: PLC0415 - a circuit alone needs no database

    return stored_design(name, db, scene=scene, panel=panel)


def _chosen(circuit: Circuit, crease: int | None) -> list[Folding]:
    return foldings(circuit) if crease is None else [folding_of(circuit, crease)]
