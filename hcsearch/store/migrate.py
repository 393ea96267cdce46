"""Creating and upgrading the schema, in a transaction of the caller. Alembic is imported only when there is work."""

from __future__ import annotations

import re
import threading
from pathlib import Path

from sqlalchemy import Connection, inspect, text

from hcsearch.basics.errors import DatabaseError
from hcsearch.store.columns import VIEWS
from hcsearch.store.schema import APPLICATION_ID, SCHEMA_REVISION, VERSION_TABLE
from hcsearch.store.views import create_view

_ALEMBIC = threading.Lock()
"""Held while Alembic works: what it migrates is a global of its module."""

MIGRATION_SCRIPTS = Path(__file__).with_name("migrations")


def current_revision(connection: Connection) -> str | None:
    """Return the revision of the schema behind a connection; None where there is none of ours."""
    if not inspect(connection).has_table(VERSION_TABLE):
        return None
    revision = connection.scalar(text(f"SELECT max(version_num) FROM {VERSION_TABLE}"))
    return None if revision is None else str(revision)


def check_revision(location: str, revision: str, *, upgradable: bool) -> None:
    """Refuse a schema that this program cannot use: newer, older where it may not be upgraded, or none.

    Before the first release numbers ran up to 0011, and such a database cannot be told from a newer one.
    """
    if not re.fullmatch("(?!0000)[0-9]{4}", revision):
        raise DatabaseError(f"database {location} is damaged, its schema has no number: restore a copy")
    if revision > SCHEMA_REVISION:
        raise DatabaseError(
            f"database {location} was made by a newer hcsearch (schema {revision}, this one knows {SCHEMA_REVISION}), "
            "or by one before the first release: install the newer one, or "
            "run `hcsearch enumerate` anew on another database"
        )
    if revision < SCHEMA_REVISION and not upgradable:
        raise DatabaseError(
            f"database {location} has the older schema {revision} and is opened read-only: "
            "upgrade it first by running `hcsearch enumerate` on it"
        )


def upgrade_schema(connection: Connection, location: str) -> None:
    """Bring the database behind a connection to the newest revision; the caller holds the write lock."""
    revision = current_revision(connection)
    if revision is None:
        refuse_foreign_database(connection, location)
    if revision is not None:
        check_revision(location, revision, upgradable=True)
    if revision == SCHEMA_REVISION:
        return  # another process was faster
    # Views hold no data and stand in the way of altering tables: dropped, and made anew as this program knows them.
    for view in VIEWS:
        connection.execute(text(f"DROP VIEW IF EXISTS {view}"))
    _run_migrations(connection)
    for view in VIEWS:
        connection.execute(text(create_view(view)))
    if connection.dialect.name == "sqlite":
        # Part of the transaction: a file either is ours and complete, or empty.
        connection.exec_driver_sql(f"PRAGMA application_id={APPLICATION_ID}")
        if connection.exec_driver_sql("PRAGMA foreign_key_check").first():
            raise DatabaseError(f"database {location} cannot be upgraded, rows refer to missing ones: restore a copy")


def refuse_foreign_database(connection: Connection, location: str) -> None:
    """Refuse a database without a revision of ours, unless it is empty."""
    if inspect(connection).get_table_names():
        raise foreign_database_error(location)


def foreign_database_error(location: str) -> DatabaseError:
    """Return the refusal of a database that holds something else."""
    return DatabaseError(f"database {location} holds tables of another program: name another database")


def _run_migrations(connection: Connection) -> None:
    from alembic import command  # noqa: PLC0415 - 0.1 s that only a new or an old database costs
    from alembic.config import Config  # noqa: PLC0415 - only where there is work

    config = Config(attributes={"connection": connection})
    config.set_main_option("script_location", str(MIGRATION_SCRIPTS).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    with _ALEMBIC:
        command.upgrade(config, "head")
