"""Motions: proved paths of foldings in a scene, the status `movable`, and no `collides` for a folding.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

from collections.abc import Callable

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")
VERDICTS = "IN ('deploys', 'movable', 'undecided', 'locked')"


def upgrade() -> None:
    """Create the table, and write verdicts anew: SQLite cannot change what a column is checked for."""
    _rewrite("outcome", _create_outcome)
    _rewrite("verdict", _create_verdict)
    _create_motion()
    op.add_column("run", sa.Column("movable", ID))


def _rewrite(name: str, create: Callable[[], sa.Table]) -> None:
    connection = op.get_bind()
    rows = [dict(row) for row in connection.execute(sa.text(f"SELECT * FROM {name}")).mappings()]
    op.drop_table(name)
    table = create()
    for row in rows:
        row["status"] = "undecided" if row["status"] == "collides" else row["status"]
    if rows:
        connection.execute(table.insert(), rows)


def _create_outcome() -> sa.Table:
    return op.create_table(
        "outcome",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("best_crease", sa.Integer(), nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("design_id", "scene", name=op.f("pk_outcome")),
        sa.CheckConstraint(f"status {VERDICTS}", name=op.f("ck_outcome_status")),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_outcome_scene"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["design_id", "best_crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_outcome_folding"),
            ondelete="CASCADE",
        ),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def _create_verdict() -> sa.Table:
    return op.create_table(
        "verdict",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.Column("min_clearance", REAL),
        sa.Column("deploy_time", REAL),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_verdict")),
        sa.CheckConstraint(f"status {VERDICTS}", name=op.f("ck_verdict_status")),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_verdict_scene"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_verdict_folding"),
            ondelete="CASCADE",
        ),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def _create_motion() -> None:
    op.create_table(
        "motion",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("flat_pairs", TEXT),
        sa.Column("needed_margin", REAL),
        sa.Column("least_gap", REAL),
        sa.Column("slack", REAL),
        sa.Column("states", sa.Integer(), nullable=False),
        sa.Column("reason", TEXT, nullable=False),
        sa.Column("path", sa.LargeBinary()),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_motion")),
        sa.CheckConstraint("flat_pairs IN ('rigid', 'hinged', 'merged')", name=op.f("ck_motion_flat_pairs")),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_motion_scene"), ondelete="CASCADE"),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_motion_folding"),
            ondelete="CASCADE",
        ),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
