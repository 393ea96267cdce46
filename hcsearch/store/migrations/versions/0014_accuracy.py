"""Deployments have their accuracy, and evaluations may end as `branch-singular`.

A deployment has its method, the errors of angles and time, what was left out and what that saved. `branch-singular`
says that rounding decides how a motion goes on.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"

TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Add columns, NULL in older rows, and widen the check of `outcome`; in SQLite its rows go to a new table."""
    for column, kind in (
        ("method", TEXT),
        ("error_angle", REAL),
        ("error_time", REAL),
        ("omitted", TEXT),
        ("time_saved", REAL),
    ):
        op.add_column("deployment", sa.Column(column, kind))
    name = op.f("ck_evaluation_outcome")
    endings = "'flat', 'moving', 'at rest', 'stuck', 'jammed', 'diverged', 'out of steps', 'branch-singular'"
    outcomes = f"outcome IN ({endings})"
    if op.get_bind().dialect.name != "sqlite":
        op.drop_constraint(name, "evaluation", type_="check")
        op.create_check_constraint(name, "evaluation", outcomes)
        return
    op.rename_table("evaluation", "evaluation_before")
    op.create_table(
        "evaluation",
        sa.Column("subject", TEXT, nullable=False),
        sa.Column("setting", TEXT, nullable=False),
        sa.Column("springs", TEXT, nullable=False),
        sa.Column("outcome", TEXT, nullable=False),
        sa.Column("clear", sa.Integer()),
        sa.Column("end_time", REAL, nullable=False),
        sa.Column("collision_time", REAL),
        sa.Column("first_panel", sa.Integer()),
        sa.Column("second_panel", sa.Integer()),
        sa.Column("gap", REAL),
        sa.Column("speed", REAL),
        sa.Column("remaining", REAL),
        sa.Column("end_remaining", REAL),
        sa.Column("widest", REAL),
        sa.Column("drift", REAL),
        sa.Column("opening", REAL),
        sa.Column("steps", sa.Integer(), nullable=False),
        sa.Column("evaluations", sa.Integer(), nullable=False),
        sa.Column("looks", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("subject", "setting", "springs", name=op.f("pk_evaluation")),
        sa.CheckConstraint("clear IN (0, 1)", name=op.f("ck_evaluation_clear")),
        sa.CheckConstraint(outcomes, name=name),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
    op.execute("INSERT INTO evaluation SELECT * FROM evaluation_before")
    op.drop_table("evaluation_before")
