"""Designs in a database, with the results on their foldings in a scene."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from hcsearch import store
from hcsearch.basics.vocabulary import percent, play_sentence
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.panel_sizes import PanelSize
from hcsearch.scenes import DEFAULT_SCENE_NAME, panel_of
from hcsearch.store.conditions import find_quantity
from hcsearch.store.location import parse_location
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.databases import Place, database_location, reading_database
from hcsearch.subjects.names import deployment_scene_name, stored_circuit, way_option_text
from hcsearch.subjects.stored_scenes import scene_asked_for, stored_scene
from hcsearch.system.machine import default_database

_MOTION_COLUMNS = ("deployable", "needed_margin", "least_gap", "deploy_time", "min_clearance", "score")
"""Columns of `designs` on the best motion of a design."""


@dataclass(frozen=True)
class StoredDesign:
    """A design in a database.

    number : its id. circuit : in canonical order. panel : size of its panels, m.
    scene : whose verdicts these are. row : of the view `designs`, with the rows of its paths and deployments.
    best : crease of its best folding. verdicts : by crease and scene. location_option : names the database.
    """

    number: int
    circuit: Circuit
    panel: PanelSize
    scene: str
    row: Mapping[str, Any]
    best: int | None
    verdicts: Mapping[tuple[int, str], store.StoredVerdict | None]
    location_option: str

    @property
    def joining(self) -> str | None:
        """The joining of flat pairs in the motion that gave the design its status, of which its numbers are."""
        row = self.row
        if row["status"] == "movable":
            return f"{row['flat_pairs']}, in the proved path of folding {self.best}"
        best = (one for one in row["deployments"] if (one["crease"], one["base"]) == (self.best, self.scene))
        deploys = next((one for one in best if one["status"] == "deploys"), None)
        return None if deploys is None else f"{deploys['pairs']}, in the deployment of folding {self.best}"

    @property
    def quantities(self) -> list[tuple[Quantity, Any]]:
        """The columns of `designs` on its best motion that have a value."""
        return [
            (find_quantity("designs", name), self.row[name])
            for name in _MOTION_COLUMNS
            if self.row.get(name) is not None
        ]

    def motions(self, folding: Folding) -> Iterator[list[str]]:
        """Sentences on the stored paths and deployments of a folding, each with its details and a command."""
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
            *filter(None, [play_sentence(tried["needed_margin"]), accuracy_of_row(tried)]),
            f"hcsearch deploy {folding.notation} --scene {shlex.quote(scene)}{self.location_option}",
        ]


def accuracy_of_row(tried: Mapping[str, Any]) -> str:
    """Return a sentence on the method, errors and omissions of a stored deployment; empty for one of before these."""
    if tried["method"] is None:
        return ""
    names = {"fold angles": ("error_angle", "rad"), "time to flat": ("error_time", "s")}
    known = [(words, tried[column], unit) for words, (column, unit) in names.items() if tried[column] is not None]
    errors = [f"{words} +- {error:.0e} {unit}" for words, error, unit in known]
    left_out = f"left out: {tried['omitted']}, {percent(tried['time_saved'])} of the work" if tried["omitted"] else ""
    return "; ".join(filter(None, [f"by {tried['method']}", ", ".join(errors), left_out]))


def stored_design(name: str, db: Place | None, *, scene: str | None, panel: str | None) -> StoredDesign:
    """Read a design by its id, with its paths and deployments in a scene, or in all scenes if none is named."""
    with reading_database(db) as database:
        number, circuit, scene_name = stored_circuit_in_scene(name, database, scene=scene, panel=panel)
        row = store.find_design(database, str(number), scene_name)
        best = store.best_creases(database, [number], scene_name).get(number)
        rows = [*row["motions"], *row["deployments"]]
        places = {(one["crease"], one.get("base", one["scene"])) for one in rows}
        verdicts = {place: store.find_verdict(database, number, *place) for place in places}
        size = panel_of(stored_scene(database, scene_name), circuit.grid.name)
    if scene or panel:
        row["motions"] = [path for path in row["motions"] if path["scene"] == scene_name]
        row["deployments"] = [tried for tried in row["deployments"] if tried["base"] == scene_name]
    option = _location_option(database_location(db))
    return StoredDesign(number, circuit, size, scene_name, row, best, verdicts, option)


def stored_circuit_in_scene(
    name: str, db: Place | None, *, scene: str | None, panel: str | None
) -> tuple[int, Circuit, str]:
    """Return the id of a design, its circuit, and the name of the stored scene that is denoted by options."""
    with reading_database(db) as database:
        number, notation = store.find_circuit(database, name)
        circuit = stored_circuit(database, number, notation)
        return number, circuit, scene_asked_for(database, scene, panel, grid=circuit.grid.name)


def _location_option(location: str) -> str:
    """Return the option that names a database, empty for the default one."""
    # as messages show it: a terminal may lack marks of a path, and a URL may hold a password
    return "" if location == default_database() else f" --db {shlex.quote(parse_location(location).text)}"
