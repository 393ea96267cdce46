"""Margins up to which foldings are locked by collision.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"

REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Add the column; locks that are stored hold at every margin."""
    op.add_column("motion", sa.Column("lock_margin", REAL))
