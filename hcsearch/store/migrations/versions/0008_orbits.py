"""Congruent foldings: whose motions and deployments rows have. What springs alone do is called `deploys` in runs, too.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Add the columns, and rename the one."""
    op.add_column("motion", sa.Column("as_crease", sa.Integer()))
    op.add_column("deployment", sa.Column("as_crease", sa.Integer()))
    op.execute("ALTER TABLE run RENAME COLUMN deployable TO deploys")
