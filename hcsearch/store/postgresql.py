"""Connections to PostgreSQL servers through psycopg: one writer at a time, and bulk transfer of rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import URL, Connection, Engine, TableClause, create_engine, event
from sqlalchemy import Table as SchemaTable
from sqlalchemy import column as column_named
from sqlalchemy import table as table_named
from sqlalchemy.exc import DBAPIError

from hcsearch.store.schema import APPLICATION_ID

_SETTINGS = "; ".join(
    f"SET LOCAL {name} = {value}"
    for name, value in (("extra_float_digits", 1), ("bytea_output", "hex"), ("standard_conforming_strings", "on"))
)
"""Settings that a role or a database may override, so that numbers lose digits or texts and paths differ."""

CONNECT_TIMEOUT = 10
"""Longest wait for the first answer of a server, in seconds, unless the URL sets it."""


def server_engine(url: URL, timeout: float, *, readonly: bool) -> Engine:
    """Return an engine on a server; ImportError without psycopg.

    timeout : longest wait for a lock, in seconds; readonly : the server refuses every change in its transactions.
    """
    wait = {} if "connect_timeout" in url.query else {"connect_timeout": CONNECT_TIMEOUT}
    # a database without an encoding would return bytes for texts
    encoding = {} if "client_encoding" in url.query else {"client_encoding": "utf8"}
    options = {"fallback_application_name": "hcsearch", **wait, **encoding}
    # a connection per thread: no thread waits for another
    engine = create_engine(url, connect_args=options, max_overflow=-1)

    def begin(connection: Connection) -> None:
        statements = f"SET LOCAL lock_timeout = {max(1, round(timeout * 1000))}; {_SETTINGS}"
        if connection.get_execution_options().get("hcsearch_begin") == "IMMEDIATE":
            # As in SQLite, one transaction writes at a time, so that two neither deadlock nor assign the same id.
            statements += f"; SELECT pg_advisory_xact_lock({APPLICATION_ID})"
        connection.exec_driver_sql(statements)

    event.listen(engine, "begin", begin)
    return engine.execution_options(postgresql_readonly=True) if readonly else engine


def stage_rows(connection: Connection, table: SchemaTable, columns: Mapping[str, Sequence[Any]]) -> TableClause:
    """Copy rows, given as columns of equal length, into a temporary table of this transaction, and return it."""
    import psycopg  # noqa: PLC0415 - an extra

    name, listed = f"new_{table.name}", ", ".join(f'"{column}"' for column in columns)
    connection.exec_driver_sql(
        f"CREATE TEMPORARY TABLE IF NOT EXISTS {name} (LIKE {table.name}) ON COMMIT DELETE ROWS; DELETE FROM {name}"
    )
    copying = f"COPY {name} ({listed}) FROM STDIN"
    driver: Any = connection.connection.driver_connection
    try:
        with driver.cursor() as cursor, cursor.copy(copying) as copy:
            for row in zip(*columns.values(), strict=True):
                copy.write_row(row)
    except psycopg.Error as error:  # so that it fails like statements of SQLAlchemy
        raise DBAPIError(copying, None, error) from error
    return table_named(name, *map(column_named, columns))
