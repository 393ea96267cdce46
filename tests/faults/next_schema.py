"""The command line of a program one schema ahead; its migration, kept in the folder named first, copies all designs."""

import shutil
import sys
from pathlib import Path

from hcsearch.cli import main
from hcsearch.store import database, migrate

NEXT = f"{int(migrate.REVISION) + 1:04d}"
MIGRATION = f"""
import sqlalchemy as sa
from alembic import op
revision = {NEXT!r}
down_revision = {migrate.REVISION!r}
def upgrade():
    with op.batch_alter_table("design", recreate="always") as table:
        table.add_column(sa.Column("colour", sa.Text()))
"""

if __name__ == "__main__":
    scripts = Path(sys.argv.pop(1))
    if not scripts.exists():
        shutil.copytree(migrate.SCRIPTS, scripts, ignore=shutil.ignore_patterns("__pycache__"))
        (scripts / "versions" / f"{NEXT}_more.py").write_text(MIGRATION)
    migrate.SCRIPTS = scripts
    migrate.REVISION = database.REVISION = NEXT
    main()
