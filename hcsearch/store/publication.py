"""Copies of a database for publication: the same results give the same bytes, whatever runs computed them.

Designs are numbered by grid, number of panels and circuit. Runs and their batches are left out, as they hold times.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Sequence
from contextlib import closing
from importlib.metadata import version
from pathlib import Path

from sqlalchemy import Table

from hcsearch.store.database import LOCK_TIMEOUT, open_database
from hcsearch.store.failures import explaining_failures
from hcsearch.store.schema import deployment, design, flight, folding, motion, outcome, scene, verdict
from hcsearch.store.sqlite import connect_file

_OF_DESIGNS = (folding, outcome, verdict, motion, flight, deployment)
"""Tables whose keys begin with the id of a design."""


def file_library_versions() -> dict[str, str]:
    """Return the versions of the libraries that write databases and Parquet files."""
    return {"pyarrow": version("pyarrow"), "sqlite": sqlite3.sqlite_version}


def publish_database(source: Path, target: Path, sizes: Sequence[tuple[str, int]]) -> None:
    """Copy the results on all designs of some sizes to a new database of this program.

    source : a database file that no other program writes. target : a path where no file is; a file beside it is used
    meanwhile. sizes : grid and number of panels.
    """
    draft = target.with_name(f"{target.name}.draft")
    draft.unlink(missing_ok=True)
    open_database(draft, create=True).close()
    with explaining_failures(str(source), source), closing(connect_file(draft, "rw", LOCK_TIMEOUT)) as connection:
        connection.execute("PRAGMA journal_mode=DELETE")
        connection.execute("ATTACH ? AS source", (str(source.absolute()),))
        connection.execute("BEGIN")
        _number_designs(connection, sizes)
        _copy_results(connection)
        connection.execute("COMMIT")
        # pages of the copy are in the order of its rows, and none is free
        connection.execute("VACUUM main INTO ?", (str(target.absolute()),))
    draft.unlink()


def _number_designs(connection: sqlite3.Connection, sizes: Sequence[tuple[str, int]]) -> None:
    connection.execute("CREATE TEMP TABLE size (grid TEXT, n INTEGER, PRIMARY KEY (grid, n))")
    connection.executemany("INSERT INTO size VALUES (?, ?)", sizes)
    connection.execute("CREATE TEMP TABLE numbered (id INTEGER PRIMARY KEY, source_id INTEGER UNIQUE)")
    connection.execute(
        "INSERT INTO numbered (source_id) SELECT d.id FROM source.design AS d JOIN size USING (grid, n) "
        "ORDER BY d.grid, d.n, d.circuit"
    )


def _copy_results(connection: sqlite3.Connection) -> None:
    connection.execute(f"INSERT INTO main.scene SELECT {_names(scene)} FROM source.scene ORDER BY name")
    _copy_table(connection, design, "id")
    for table in _OF_DESIGNS:
        _copy_table(connection, table, "design_id")


def _copy_table(connection: sqlite3.Connection, table: Table, key: str) -> None:
    """Copy the rows of numbered designs, in the order of the primary key; key : the column with the id of a design."""
    others = [column.name for column in table.columns if column.name != key]
    order = [f't."{column.name}"' for column in table.primary_key.columns if column.name != key]
    values = ", ".join(f't."{name}"' for name in others)
    connection.execute(
        f'INSERT INTO main."{table.name}" ("{key}", {", ".join(map(_quoted, others))}) SELECT numbered.id, {values} '
        f'FROM numbered JOIN source."{table.name}" AS t ON t."{key}" = numbered.source_id '
        f"ORDER BY {', '.join(['numbered.id', *order])}"
    )


def _names(table: Table) -> str:
    return ", ".join(_quoted(column.name) for column in table.columns)


def _quoted(name: str) -> str:
    return f'"{name}"'
