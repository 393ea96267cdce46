"""Designs, scenes of deployments and parameters of assemblies as users name them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings, no_folding_reason
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.library.assemblies.named_assembly import Assembly, Parameters
from hcsearch.scenes.scene import joined_name, warn_of_panel_size
from hcsearch.store.columns import column_names
from hcsearch.subjects.databases import Place, reading_database
from hcsearch.subjects.pattern_files import is_pattern_file, refuse_other_file

if TYPE_CHECKING:
    from hcsearch.designs.panel_sizes import PanelSize


def is_id(name: str) -> bool:
    """Whether a name is the id of a design in a database."""
    return name.isascii() and name.isdigit()


_NAME = re.compile(r"[0-9]+(:[0-9]+)?|[a-z0-9]+:[^\s=<>]*")
_OPERATOR = re.compile(r"[=<>]")
_CONDITION_MARK = re.compile(r"[\s=<>()]")


def is_query(text: str) -> bool:
    """Whether a text is a query for designs; else it is a name. HcsearchError for what is neither.

    A name is an id, a notation, an assembly or a file `.toml` or `.fold`. A query has an operator, a bracket or a
    space, or is the name of a column.
    """
    if not _OPERATOR.search(text):  # a query may name a file of cells
        refuse_other_file(text)
    if text in ASSEMBLIES or text.endswith(".toml") or is_pattern_file(text) or _NAME.fullmatch(text):
        return False
    if _CONDITION_MARK.search(text) or text in column_names("designs"):
        return True
    raise HcsearchError(
        f"there is no assembly {text!r}, and it is no query: name DESIGN:CREASE, an assembly that `hcsearch assembly "
        "list` prints or a file .toml or .fold, or write conditions as in 'n=12 untwisted'"
    )


def design_named(name: str, db: Place | None) -> tuple[Circuit, int | None]:
    """Return the circuit of a design, named by notation or by its id in a database, and this id; None without."""
    if ":" in name:
        return Circuit.from_notation(name).canonical(), None
    if name in ASSEMBLIES:
        raise HcsearchError(f"{name} is an assembly, no design of a database: see hcsearch assembly {name}")
    with reading_database(db) as database:
        number, notation = store.find_circuit(database, name)
        return stored_circuit(database, number, notation), number


def stored_circuit(database: store.Database, number: int, notation: str) -> Circuit:
    """The circuit of a design as a database has it; DatabaseError where the notation is none."""
    try:
        return Circuit.from_notation(notation)
    except HcsearchError as error:
        raise DatabaseError(
            f"database {database.location} is damaged, the circuit of design {number} cannot be read: restore a copy, "
            "or mend it with `sqlite3 FILE`"
        ) from error


def refuse_unknown(name: str) -> None:
    """Refuse a name that is neither an id nor a notation."""
    refuse_other_file(name)
    if not any(mark.isdigit() for mark in name) or not (name[0].isdigit() or ":" in name):
        raise HcsearchError(f"there is no assembly {name!r}: see hcsearch assembly list, or name DESIGN:CREASE")


def only_folding(circuit: Circuit, name: str | None = None) -> Folding:
    """The folding of a circuit that has one; HcsearchError, which calls it by a name, for none or several."""
    text, candidates = name or circuit.notation, foldings(circuit)
    if not candidates:
        why = f", as {no_folding_reason(circuit.n)}" if circuit.n % 2 else ""
        raise HcsearchError(f"{text} does not fold into two stacks{why}: choose among hcsearch query 'two_stack'")
    if len(candidates) > 1:
        creases = ", ".join(str(folding.crease) for folding in candidates)
        raise HcsearchError(
            f"{text} has {len(candidates)} foldings: name one as {text}:CREASE; its creases are {creases}"
        )
    return candidates[0]


LENGTH_PARAMETERS = ("base", "thickness", "side", "width")


def parameters_of(assembly: Assembly, given: Mapping[str, Any]) -> Parameters:
    """The default parameters of an assembly, with the given ones replaced: degrees, millimetres, columns x rows.

    HcsearchWarning for lengths that are probably not meant.
    """
    changes: dict[str, Any] = {}
    for name, value in given.items():
        if value is None:
            continue
        if name not in (*LENGTH_PARAMETERS, "alpha", "size"):
            raise HcsearchError(f"assemblies have no {name!r}: they have alpha, size, {', '.join(LENGTH_PARAMETERS)}")
        if name == "size":
            changes[name] = _size(str(value))
        else:
            changes[name] = math.radians(float(value)) if name == "alpha" else 1e-3 * float(value)
    for name in changes:
        if name not in assembly.parameter_names:
            option = "SIZE" if name == "size" else f"--{name}"
            raise HcsearchError(f"{assembly.name} does not depend on {option}: leave it out")
    parameters = replace(assembly.defaults, **changes)
    if changes.keys() & {*LENGTH_PARAMETERS}:
        warn_of_panel_size(_panel(assembly, parameters), None)
    return parameters


def _panel(assembly: Assembly, parameters: Parameters) -> PanelSize:
    """The sizes of an assembly's panels, of triangles the base on both sides."""
    side = parameters.base if "base" in assembly.parameter_names else parameters.side
    return (side, parameters.width if "width" in assembly.parameter_names else side, parameters.thickness)


def _size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"([0-9]{1,4})x([0-9]{1,4})", text)
    if match is None:
        raise HcsearchError(f"{text!r} is no size: write columns x rows, such as 3x2")
    return int(match[1]), int(match[2])


def deployment_scene_name(row: Mapping[str, Any], verdict: store.StoredVerdict | None) -> str:
    """Return the scene name with which `hcsearch deploy` repeats a deployment.

    verdict : on the folding in the served scene. If another variant gave it, the name includes the joining of flat
    pairs, since `hcsearch deploy` would otherwise use that of the verdict.
    """
    scene, pairs = str(row["scene"]), str(row["pairs"])
    if verdict is None or scene != row["base"]:
        return scene
    deploys, moves = verdict.status == "deploys", verdict.status == "movable" and verdict.path_flat_pairs is not None
    deployed = verdict.deployed_variant
    if deploys:
        is_other = deployed is not None and not deployed.as_written
    else:
        is_other = moves and verdict.path_flat_pairs != pairs
    return joined_name(scene, pairs) if is_other else scene


def way_option_text(way: str | None) -> str:
    """Return the option of `hcsearch drive` for a joining of flat pairs; empty for None."""
    return "" if way is None else f" --flat-pairs {way}"
