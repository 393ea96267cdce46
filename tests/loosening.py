"""Databases of which tables take any value, as another program may leave them."""

import re
import sqlite3
from contextlib import closing, contextmanager


@contextmanager
def loosened(path):
    """A connection to a database file of which no table is STRICT any more, and no constraint is checked."""
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA writable_schema = 1")
        tables = connection.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'table'").fetchall()
        for name, sql in tables:
            loose = re.sub(r",?\s*STRICT\b", "", sql)
            connection.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (loose, name))
        connection.commit()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA ignore_check_constraints = 1")
        yield connection
        connection.commit()
