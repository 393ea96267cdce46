"""Designs in a database, with the results on their foldings in a scene; designs and foldings in words."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hcsearch import store
from hcsearch.basics.vocabulary import percent, play_sentence
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding
from hcsearch.designs.twisting import twist
from hcsearch.scenes import DEFAULT_SCENE_NAME, Scene
from hcsearch.store.conditions import find_quantity
from hcsearch.store.quantity import Quantity
from hcsearch.subjects.names import Place, deployment_scene_name, reading_database, way_option_text
from hcsearch.subjects.stored_scenes import stored_scene
from hcsearch.system.machine import default_database
from hcsearch.system.terminal import short_number

_MOTION_COLUMNS = ("deployable", "needed_margin", "least_gap", "deploy_time", "min_clearance", "score")
"""Columns of `designs` on the best motion of a design."""


@dataclass(frozen=True)
class StoredDesign:
    """A design in a database.

    number : its id. values : the scene, and scene : its name, whose verdicts these are.
    row : of the view `designs`, with the rows of its paths and deployments.
    best : crease of its best folding. verdicts : by crease and scene. location : of the database, for messages.
    paths : with their states, if these were read.
    """

    number: int
    values: Scene
    scene: str
    row: Mapping[str, Any]
    best: int | None
    verdicts: Mapping[tuple[int, str], store.StoredVerdict | None]
    location: str
    paths: Sequence[store.StoredPath] = ()

    @property
    def location_option(self) -> str:
        """The option that names the database, empty for the default one."""
        return "" if self.location == default_database() else f" --db {shlex.quote(self.location)}"

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

    def folding_row(self, crease: int) -> Mapping[str, Any]:
        """The row of the view `foldings` on a folding; empty where it has none."""
        return next((row for row in self.row["foldings"] if row["crease"] == crease), {})

    def deployments_of(self, crease: int) -> list[Mapping[str, Any]]:
        """The deployments of a folding for the scene: first in the scene itself, then with other springs."""
        rows = [row for row in self.row["deployments"] if (row["crease"], row["base"]) == (crease, self.scene)]
        return sorted(rows, key=lambda row: row["scene"] != self.scene)

    def motion_sentence(self, crease: int) -> str | None:
        """The sentence on the planned motion of a folding in the scene; None without one."""
        rows = (row for row in self.row["motions"] if (row["crease"], row["scene"]) == (crease, self.scene))
        return next((str(row["reason"]) for row in rows), None)

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


def stored_design(number: int, db: Place, scene: str) -> StoredDesign:
    """Read a design by its id, with its paths and deployments in a scene."""
    with reading_database(db) as database:
        return stored_design_in(database, number, scene, alone=True, paths=True)


def stored_design_in(database: store.Database, number: int, scene: str, *, alone: bool, paths: bool) -> StoredDesign:
    """Read a design by its id, with its motions and deployments in a scene, or in all scenes unless `alone`.

    paths : whether the states of its stored paths are read, too.
    """
    row = store.find_design(database, str(number), scene)
    if alone:
        row["motions"] = [path for path in row["motions"] if path["scene"] == scene]
        row["deployments"] = [tried for tried in row["deployments"] if tried["base"] == scene]
    rows = [*row["motions"], *row["deployments"]]
    places = {(one["crease"], one.get("base", one["scene"])) for one in rows}
    return StoredDesign(
        number,
        stored_scene(database, scene),
        scene,
        row,
        store.best_creases(database, [number], scene).get(number),
        {place: store.find_verdict(database, number, *place) for place in places},
        database.location,
        store.find_paths(database, [number], scene) if paths else (),
    )


def design_facts(circuit: Circuit, stored: StoredDesign | None) -> dict[str, Any]:
    """Return the properties of a circuit, and the results on its design in a database."""
    array = circuit.array
    facts: dict[str, Any] = {
        "circuit": circuit.notation,
        "array": array.canonical().notation,
        "panels": circuit.n,
        "slits": len(array.edges()) - circuit.n,
        "symmetry": circuit.symmetry,
        "array symmetry": array.symmetry,
        "orbit size": circuit.orbit_size,
        "fixed copies": circuit.n_fixed,
    }
    if stored is not None:
        facts |= {"id": stored.number, "scene": stored.scene, "status": stored.row["status"] or "not judged"}
        facts |= {} if stored.joining is None else {"flat pairs": stored.joining}
        facts |= {quantity.name.replace("_", " "): _with_unit(quantity, value) for quantity, value in stored.quantities}
        if stored.row["needed_margin"] is not None:
            facts["play"] = play_sentence(stored.row["needed_margin"])
    return facts


def _with_unit(quantity: Quantity, value: object) -> str:
    if quantity.kind == "boolean":
        return "yes" if value else "no"
    text = short_number(value, 6) if isinstance(value, float) else str(value)
    return f"{text} {quantity.unit}".rstrip()


def folding_lines(folding: Folding) -> Iterator[str]:
    """Yield the flat creases, the stacks and the hinges of a folding."""
    n = folding.circuit.n
    yield f"\nfolding {folding.crease}: flat creases {folding.crease} and {folding.opposite}, twist {twist(folding)}"
    for label, stack in zip(("first", "second"), folding.stacks, strict=True):
        yield f"  {label} stack, lowest panel first: {' '.join(map(str, stack))}"
    for kind in ("valley", "mountain"):
        creases = [str(k) for k, assigned in enumerate(folding.assignment) if assigned == kind]
        face = "top" if kind == "valley" else "bottom"
        yield f"  {kind} creases, hinges on the {face} face: {' '.join(creases)}"
    flats = ", ".join(f"{k % n} ({folding.hinge_faces[k % n]})" for k in (folding.crease, folding.opposite))
    yield f"  flat creases (the face of a hinge, if there is one): {flats}"
