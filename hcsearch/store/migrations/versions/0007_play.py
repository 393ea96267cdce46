"""Play: needed margins and least gaps of deployments, and those of the motion that gives a folding its status.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"

REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Add the columns; what is movable has those of its path, what deploys gets its own as it is judged anew."""
    for table in ("deployment", "verdict"):
        for name in ("needed_margin", "least_gap"):
            op.add_column(table, sa.Column(name, REAL))
    # less than a nanometre is rounding
    op.execute("UPDATE motion SET least_gap = 0 WHERE abs(least_gap) < 1e-6")
    for name in ("needed_margin", "least_gap"):
        path = "m.design_id = verdict.design_id AND m.crease = verdict.crease AND m.scene = verdict.scene"
        op.execute(
            f"UPDATE verdict SET {name} = (SELECT m.{name} FROM motion AS m WHERE {path}) WHERE status = 'movable'"
        )
