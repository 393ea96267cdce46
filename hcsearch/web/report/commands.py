"""Options of the commands that pages name."""

from __future__ import annotations

import shlex

from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database
from hcsearch.system.machine import default_database


def database_option(database: Database | None) -> str:
    """The option that names a database file, where it is not the usual one; URLs of servers may hold passwords."""
    if database is None or database.path is None or database.location == default_database():
        return ""
    return f" --db {shlex.quote(database.location)}"


def scene_option(name: str, where: str) -> str:
    """The option that names a scene, where it is not the usual one, and the database that may hold it."""
    return "" if name == DEFAULT_SCENE_NAME else f" --scene {shlex.quote(name)}{where}"
