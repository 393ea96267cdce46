"""Databases, designs and foldings as users name them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path

from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.folding import Folding, foldings, no_folding_reason
from hcsearch.library.assemblies import ASSEMBLIES
from hcsearch.store import Database, find_circuit, open_database, open_readonly
from hcsearch.system.machine import default_database

Place = str | Path | Database


def database_location(db: Place | None) -> str:
    """Return the location of a database: the one that is named, else HCSEARCH_DB, else hcsearch.sqlite."""
    if isinstance(db, Database):
        return db.location
    return default_database() if db is None else str(db)


def reading_database(db: Place | None) -> AbstractContextManager[Database]:
    """Open a database to read."""
    return nullcontext(db) if isinstance(db, Database) else open_readonly(database_location(db))


def writing_database(db: Place | None, *, create: bool) -> AbstractContextManager[Database]:
    """Open a database to write."""
    return nullcontext(db) if isinstance(db, Database) else open_database(database_location(db), create=create)


@contextmanager
def database_snapshot(db: Place | None) -> Iterator[tuple[Database | None, DatabaseError | None]]:
    """Open a database to read all in one transaction; give the error in its place where that cannot be done."""
    try:
        opened = reading_database(db)
    except DatabaseError as error:
        yield None, error
        return
    with opened as database, database.snapshot() as held:
        yield held, None


def is_id(name: str) -> bool:
    """Whether a name is the id of a design in a database."""
    return name.isascii() and name.isdigit()


def design_named(name: str, db: Place | None) -> tuple[Circuit, int | None]:
    """Return the circuit of a design, named by notation or by its id in a database, and this id; None without."""
    if ":" in name:
        return Circuit.from_notation(name).canonical(), None
    if name in ASSEMBLIES:
        raise HcsearchError(f"{name} is an assembly, no design of a database: see hcsearch assembly {name}")
    with reading_database(db) as database:
        number, notation = find_circuit(database, name)
        return stored_circuit(database, number, notation), number


def stored_circuit(database: Database, number: int, notation: str) -> Circuit:
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
