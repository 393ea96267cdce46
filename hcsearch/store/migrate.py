"""Creating and upgrading the schema in a transaction of the caller; Alembic is imported only if needed."""

from __future__ import annotations

import re
import threading

from sqlalchemy import Connection, inspect, text

from hcsearch.basics.errors import DatabaseError
from hcsearch.store.columns import VIEWS
from hcsearch.store.schema import APPLICATION_ID, MIGRATION_SCRIPTS, SCHEMA_REVISION, VERSION_TABLE
from hcsearch.store.views import create_view

_ALEMBIC = threading.Lock()
"""Held while Alembic works, since its migration context is a global variable."""


def current_revision(connection: Connection) -> str | None:
    """Return the schema revision of the database behind a connection; None if it is not of this program."""
    if not inspect(connection).has_table(VERSION_TABLE):
        return None
    revision = connection.scalar(text(f"SELECT max(version_num) FROM {VERSION_TABLE}"))
    return None if revision is None else str(revision)


def check_revision(location: str, revision: str, *, upgradable: bool) -> None:
    """Raise DatabaseError for a schema that is missing, newer, older and not upgradable, or from before a release."""
    if not re.fullmatch("(?!0000)[0-9]{4}", revision):
        raise DatabaseError(f"database {location} is damaged, its schema has no number: restore a copy")
    if revision > SCHEMA_REVISION or "0001" < revision < "0012":
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
    """Upgrade the database behind a connection to the newest revision; the caller holds the write lock."""
    revision = current_revision(connection)
    if revision is None:
        refuse_foreign_database(connection, location)
    if revision is not None:
        check_revision(location, revision, upgradable=True)
    if revision == SCHEMA_REVISION:
        return  # another process was faster
    # Views hold no data and hinder altering tables: they are dropped and created anew.
    for view in VIEWS:
        connection.execute(text(f"DROP VIEW IF EXISTS {view}"))
    _run_migrations(connection)
    for view in VIEWS:
        connection.execute(text(create_view(view)))
    if connection.dialect.name == "sqlite":
        # In the same transaction: a file is either complete and of this program, or empty.
        connection.exec_driver_sql(f"PRAGMA application_id={APPLICATION_ID}")
        if connection.exec_driver_sql("PRAGMA foreign_key_check").first():
            raise DatabaseError(f"database {location} cannot be upgraded, rows refer to missing ones: restore a copy")


def refuse_foreign_database(connection: Connection, location: str) -> None:
    """Raise DatabaseError for a database that is neither empty nor of this program."""
    if inspect(connection).get_table_names():
        raise foreign_database_error(location)


def foreign_database_error(location: str) -> DatabaseError:
    """Return the error for a database of another program."""
    return DatabaseError(f"database {location} holds tables of another program: name another database")


def _run_migrations(connection: Connection) -> None:
    from alembic import command  # noqa: PLC0415 - takes 0.1 s, needed only for new and old databases
    from alembic.config import Config  # noqa: PLC0415 - as above

    config = Config(attributes={"connection": connection})
    config.set_main_option("script_location", str(MIGRATION_SCRIPTS).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    with _ALEMBIC:
        command.upgrade(config, "head")
