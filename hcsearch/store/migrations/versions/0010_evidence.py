"""Evidence of the search for motions: efforts, kinematic locks, critical margins; what stands behind a status.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"

TEXT: sa.types.TypeEngine[str] = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Add the columns; motions that are stored get theirs as they are searched for anew."""
    whole = sa.Integer()
    columns: dict[str, sa.types.TypeEngine[Any]] = {"efforts": whole, "lock_pairs": TEXT, "lock_end": TEXT}
    columns |= {"lock_cubes": whole, "lock_faces": whole, "critical_margin": REAL, "unmet_margin": REAL}
    for name, kind in columns.items():
        op.add_column("motion", sa.Column(name, kind))
