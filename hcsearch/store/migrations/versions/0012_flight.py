"""The figures of the stage `flight`.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0001"

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def upgrade() -> None:
    """Create the table `flight`."""
    op.create_table(
        "flight",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("torque_margin", REAL),
        sa.Column("torque_margin_hinge", TEXT),
        sa.Column("torque_margin_at", REAL),
        sa.Column("torque_margin_failed", REAL),
        sa.Column("deployed_hz", REAL),
        sa.Column("soft_modes", sa.Integer()),
        sa.Column("latch_torque", REAL),
        sa.Column("latch_impulse", REAL),
        sa.Column("clearance_ratio", REAL),
        sa.Column("self_stresses", sa.Integer()),
        sa.Column("flatness_mm_per_mrad", REAL),
        sa.Column("tilt", REAL),
        sa.Column("stowed_length", REAL),
        sa.Column("stowed_width", REAL),
        sa.Column("stowed_height", REAL),
        sa.Column("area_per_volume", REAL),
        sa.Column("mass", REAL),
        sa.Column("craft_clearance", REAL),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_flight")),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_flight_folding"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_flight_scene"), ondelete="CASCADE"),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
