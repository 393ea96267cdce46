"""Show a design: its circuit, its foldings, and the results on them in a database."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.basics.vocabulary import play_sentence
from hcsearch.cases.databases import Place, database_location, reading_database
from hcsearch.cases.mechanisms import freedoms_of, lock_sentences
from hcsearch.cases.names import deployment_scene_name, stored_circuit, way_option_text
from hcsearch.cases.resolve import resolve_scene
from hcsearch.cases.stored_scenes import scene_asked_for, stored_scene
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, folding_of, foldings, no_folding_reason, split_crease
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.designs.twisting import twist
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.scenes import DEFAULT_SCENE_NAME, panel_of
from hcsearch.store import Database, StoredVerdict, best_creases, find_circuit, find_design, find_verdict
from hcsearch.store.columns import Quantity
from hcsearch.store.conditions import find_quantity
from hcsearch.store.location import parse_location
from hcsearch.system.machine import default_database
from hcsearch.system.outputs import check_output

_SHOWN = ("deployable", "needed_margin", "least_gap", "deploy_time", "min_clearance", "score")
"""Columns of `designs` on the best motion of a design."""


@dataclass(frozen=True)
class ShownDesign:
    """A design and its foldings.

    circuit : in canonical order. foldings : all, or the one that is named. panel : size of its panels, m.
    number : its id in a database; None of a circuit without one, and then nothing of the rest is known.
    scene : whose verdicts these are. row : of the view `designs`, with the rows of its paths and deployments.
    best : crease of its best folding. verdicts : by crease and scene. location_option : names the database.
    """

    circuit: Circuit
    foldings: Sequence[Folding]
    panel: PanelSize
    number: int | None = None
    scene: str = DEFAULT_SCENE_NAME
    row: Mapping[str, Any] = field(default_factory=dict)
    best: int | None = None
    verdicts: Mapping[tuple[int, str], StoredVerdict | None] = field(default_factory=dict)
    location_option: str = ""

    @property
    def no_folding_reason(self) -> str:
        """The reason that a circuit has no folding."""
        return no_folding_reason(self.circuit.n)

    @property
    def joining(self) -> str | None:
        """The joining of flat pairs in the motion that gave the design its status, of which its numbers are."""
        row = self.row
        if row["status"] == "movable":
            return f"{row['flat_pairs']}, in the proved path of folding {self.best}"
        best = (one for one in row["deployments"] if (one["crease"], one["base"]) == (self.best, self.scene))
        deploys = next((one for one in best if one["status"] == "deploys"), None)
        return None if deploys is None else f"{deploys['pairs']}, in the deployment of folding {self.best}"

    def linking_number(self, folding: Folding) -> int:
        """The twist of a folding."""
        return twist(folding)

    @property
    def quantities(self) -> list[tuple[Quantity, Any]]:
        """The columns of `designs` on its best motion that have a value."""
        return [(find_quantity("designs", name), self.row[name]) for name in _SHOWN if self.row.get(name) is not None]

    def sentences(self, folding: Folding) -> Iterator[list[str]]:
        """Sentences on the mechanism of a folding and its stored motions, each with its details and commands."""
        if twist(folding) == 0:
            yield from ([freedoms.sentence] for freedoms in freedoms_of(folding, self.panel))
            yield from lock_sentences(folding, self.panel)
        if self.number is None:
            return
        deployments = [tried for tried in self.row["deployments"] if tried["crease"] == folding.crease]
        deployed = {tried["base"]: tried["pairs"] for tried in deployments if tried["status"] == "deploys"}
        for path in self.row["motions"]:
            if path["crease"] == folding.crease:
                yield self._path(path, deployed.get(path["scene"], path["flat_pairs"]))
        yield from (self._deployment(tried, folding) for tried in deployments)

    def _path(self, path: Mapping[str, Any], deployed_pairs: str) -> list[str]:
        scene, pairs = path["scene"], path["flat_pairs"]
        if pairs is None:
            return [f"{scene}: {path['reason']}"]
        play = f"{path['needed_margin']:.4g} mm of play on every face"
        options = "" if scene == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(scene)}"
        options += self.location_option + (way_option_text(pairs) if deployed_pairs != pairs else "")
        command = f"hcsearch drive {self.number}:{path['crease']}{options}"
        return [f"path, {scene}: proved, flat pairs {pairs}, with {play}", command]

    def _deployment(self, tried: Mapping[str, Any], folding: Folding) -> list[str]:
        scene = deployment_scene_name(tried, self.verdicts[folding.crease, tried["base"]])
        return [
            f"deployment, {tried['scene']}: {tried['status']}, {tried['reason']}",
            *filter(None, [play_sentence(tried["needed_margin"])]),
            f"hcsearch deploy {folding.notation} --scene {shlex.quote(scene)}{self.location_option}",
        ]


def _location_option(location: str) -> str:
    """Return the option that names a database, empty for the default one."""
    # as messages show it: a terminal may lack marks of a path, and a URL may hold a password
    return "" if location == default_database() else f" --db {shlex.quote(parse_location(location).text)}"


def show(
    design: str | Circuit | Folding, *, db: Place | None = None, scene: str | None = None, panel: str | None = None
) -> ShownDesign:
    """Look up a design and its foldings, as `hcsearch show` prints them.

    design : its id in the database, the notation of its circuit, which needs no database, or DESIGN:CREASE for one of
    its foldings. db, scene, panel : as in `deploy`. Where a scene or panels are given, the paths and deployments are
    those in this scene; else in all.

    >>> from hcsearch import show
    >>> [folding.crease for folding in show("hex:0234550132").foldings]
    [3, 4]
    """
    check_kinds(show, locals())
    name, crease = _split(design)
    if ":" in name:
        circuit = Circuit.from_notation(name).canonical()
        grid = circuit.grid.name
        size = panel_of(resolve_scene(grid, db, scene=scene, panel=panel), grid)
        return ShownDesign(circuit, _chosen(circuit, crease), size)
    with reading_database(db) as database:
        number, circuit = _stored(database, name)
        asked = scene_asked_for(database, scene, panel, grid=circuit.grid.name)
        row = find_design(database, str(number), asked)
        best = best_creases(database, [number], asked).get(number)
        rows = [*row["motions"], *row["deployments"]]
        places = {(one["crease"], one.get("base", one["scene"])) for one in rows}
        verdicts = {place: find_verdict(database, number, *place) for place in places}
        size = panel_of(stored_scene(database, asked), circuit.grid.name)
    if scene or panel:
        row["motions"] = [one for one in row["motions"] if one["scene"] == asked]
        row["deployments"] = [one for one in row["deployments"] if one["base"] == asked]
    place = _location_option(database_location(db))
    return ShownDesign(circuit, _chosen(circuit, crease), size, number, asked, row, best, verdicts, place)


def show_page(
    design: str | Circuit | Folding,
    path: str | Path | None = None,
    *,
    db: Place | None = None,
    scene: str | None = None,
    panel: str | None = None,
) -> Path:
    """Write the HTML page of a design, as `hcsearch show --html` does; return its path.

    design, db, scene, panel : as in `show`; a circuit is shown in the scene `default`. path : of the file, by default
    reports/design-DESIGN.html.
    """
    from hcsearch.web.report.page_files import write_design  # noqa: PLC0415 - the engine, which texts do without

    check_kinds(show_page, locals())
    name, crease = _split(design)
    given = name if crease is None else f"{name}:{crease}"
    place = Path(path or f"reports/design-{given.replace(':', '-')}.html")
    number, asked = None, DEFAULT_SCENE_NAME
    if ":" in name:
        circuit = Circuit.from_notation(name).canonical()
        if scene or panel:
            raise HcsearchError("a circuit is shown in the scene default: name the design by its id in a database")
    else:
        with reading_database(db) as database:
            number, circuit = _stored(database, name)
            asked = scene_asked_for(database, scene, panel, grid=circuit.grid.name)
    check_output(str(place))
    return write_design(circuit, _chosen(circuit, crease), place, db=database_location(db), number=number, scene=asked)


def _split(design: str | Circuit | Folding) -> tuple[str, int | None]:
    """The name of a design, and the crease of the folding that is named."""
    if isinstance(design, Circuit):
        return design.notation, None
    name = design if isinstance(design, str) else design.notation
    if not name[:1].isdigit() and ":" not in name:
        if name in ASSEMBLIES:
            raise HcsearchError(f"{name} is an assembly: see hcsearch assembly {name}")
        raise HcsearchError(f"{name!r} is no design: give an id, or the notation of a circuit such as hex:0234550132")
    return split_crease(name)


def _stored(database: Database, name: str) -> tuple[int, Circuit]:
    number, notation = find_circuit(database, name)
    return number, stored_circuit(database, number, notation)


def _chosen(circuit: Circuit, crease: int | None) -> list[Folding]:
    return foldings(circuit) if crease is None else [folding_of(circuit, crease)]
