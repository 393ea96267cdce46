"""Units: copies of an element laid together that move with one degree of freedom.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Create the table `unit`."""
    op.create_table(
        "unit",
        sa.Column("id", ID, autoincrement=False, nullable=False),
        sa.Column("grid", TEXT, nullable=False),
        sa.Column("n", sa.Integer(), nullable=False),
        sa.Column("circuit", TEXT, nullable=False),
        sa.Column("crease", sa.Integer(), nullable=False),
        sa.Column("alpha", REAL),
        sa.Column("shape", TEXT, nullable=False),
        sa.Column("merged", sa.Integer(), nullable=False),
        sa.Column("element_dof", sa.Integer()),
        sa.Column("copies", sa.Integer(), nullable=False),
        sa.Column("placements", TEXT, nullable=False),
        sa.Column("panels", sa.Integer(), nullable=False),
        sa.Column("hinges", sa.Integer(), nullable=False),
        sa.Column("directions", sa.Integer(), nullable=False),
        sa.Column("loops", sa.Integer(), nullable=False),
        sa.Column("kutzbach", sa.Integer(), nullable=False),
        sa.Column("dof", sa.Integer(), nullable=False),
        sa.Column("dof_folded", sa.Integer()),
        sa.Column("dof_flat", sa.Integer()),
        sa.Column("rank_gap", REAL, nullable=False),
        sa.Column("deployment_ratio", REAL, nullable=False),
        sa.Column("ways", sa.Integer(), nullable=False),
        sa.Column("path", TEXT, nullable=False),
        sa.Column("closure_error", REAL),
        sa.Column("contact", sa.Integer()),
        sa.Column("known", TEXT, nullable=False),
        sa.Column("key", TEXT, nullable=False),
        sa.CheckConstraint("copies > 1 AND panels > 0 AND hinges > 0", name=op.f("ck_unit_copies")),
        sa.CheckConstraint("merged IN (0, 1) AND contact IN (0, 1)", name=op.f("ck_unit_flags")),
        sa.CheckConstraint("alpha > 0 AND alpha < 90", name=op.f("ck_unit_alpha")),
        sa.CheckConstraint("path IN ('flat', 'stopped', 'stepwise', 'none', 'locked')", name=op.f("ck_unit_path")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_unit")),
        sa.UniqueConstraint("key", name=op.f("uq_unit_key")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_unit_grid_n"), "unit", ["grid", "n"], unique=False)
