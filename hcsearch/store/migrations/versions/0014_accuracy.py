"""Deployments have their method, the errors of angles and time, and what was left out.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"

TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Add the columns; they are NULL in rows of before."""
    for name, kind in (
        ("method", TEXT),
        ("error_angle", REAL),
        ("error_time", REAL),
        ("omitted", TEXT),
        ("time_saved", REAL),
    ):
        op.add_column("deployment", sa.Column(name, kind))
