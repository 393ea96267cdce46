"""A program one schema ahead, whose migration writes all designs and verdicts anew.

As a script it is its command line; the folder of its migrations is named first, and made where there is none.
"""

import shutil
import sys
from pathlib import Path

from hcsearch.store import database, migrate, schema

NEXT = f"{int(schema.SCHEMA_REVISION) + 1:04d}"
SCRIPT = f"versions/{NEXT}_more.py"
_MIGRATION = f"""
import sqlalchemy as sa
from alembic import op
revision = {NEXT!r}
down_revision = {schema.SCHEMA_REVISION!r}
def upgrade():
    recreate = "always" if op.get_bind().dialect.name == "sqlite" else "never"
    for name in ("design", "verdict"):
        with op.batch_alter_table(name, recreate=recreate) as table:
            table.add_column(sa.Column("colour", sa.Text()))
"""


def install(folder, change=setattr):
    """Make this program that one; change : sets an attribute, such as that of a monkeypatch."""
    if not folder.exists():
        shutil.copytree(migrate.MIGRATION_SCRIPTS, folder, ignore=shutil.ignore_patterns("__pycache__"))
        (folder / SCRIPT).write_text(_MIGRATION)
    change(migrate, "MIGRATION_SCRIPTS", folder)
    for module in (migrate, database):
        change(module, "SCHEMA_REVISION", NEXT)


def program_ahead(folder):
    """The words that begin a command of that program."""
    return sys.executable, __file__, str(folder)


if __name__ == "__main__":
    from hcsearch.cli import main

    install(Path(sys.argv.pop(1)))
    main()
