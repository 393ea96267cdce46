"""How users name designs, sizes and databases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any, TypeAlias

from hcsearch import store
from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings, no_folding_reason
from hcsearch.scenes.scene import joined_name
from hcsearch.store.location import refuse_missing_file
from hcsearch.subjects.pattern_files import refuse_other_file
from hcsearch.system.machine import default_database


def is_id(name: str) -> bool:
    """Whether a name is the id of a design in a database."""
    return name.isascii() and name.isdigit()


def circuit_with_id(number: int, database: store.Database) -> Circuit:
    """Return the circuit of a stored design; QueryError for an unknown id."""
    return stored_circuit(database, *store.find_circuit(database, str(number)))


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
    if not name[:1].isdigit() and ":" not in name:
        raise HcsearchError(
            f"there is no assembly {name!r}: see hcsearch assembly list, or name DESIGN:CREASE; or name a file .fold, "
            "or a notation such as hex:0234435011"
        )


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


Place: TypeAlias = "str | Path | store.Database"


def database_location(db: Place | None) -> str:
    """Return the location of a database: the one that is named, else HCSEARCH_DB, else hcsearch.sqlite."""
    if db is None or isinstance(db, str | Path):
        return default_database() if db is None else str(db)
    return db.location


def reading_database(db: Place | None) -> AbstractContextManager[store.Database]:
    """Open a database to read."""
    if db is None or isinstance(db, str | Path):
        location = database_location(db)
        refuse_missing_file(location)
        return store.open_readonly(location)
    return nullcontext(db)


def writing_database(db: Place | None, *, create: bool) -> AbstractContextManager[store.Database]:
    """Open a database to write."""
    if db is None or isinstance(db, str | Path):
        return store.open_database(database_location(db), create=create)
    return nullcontext(db)


@contextmanager
def database_snapshot(db: Place | None) -> Iterator[tuple[store.Database | None, DatabaseError | None]]:
    """Open a database to read all in one transaction; give the error in its place where that cannot be done."""
    try:
        opened = reading_database(db)
    except DatabaseError as error:
        yield None, error
        return
    with opened as database, database.snapshot() as held:
        yield held, None
