"""The first schema: designs, their foldings and deployments; the runs that found them and the batches they finished.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")


def create_design() -> None:
    """Create the table `design`."""
    op.create_table(
        "design",
        sa.Column("id", ID, autoincrement=False, nullable=False),
        sa.Column("grid", TEXT, nullable=False),
        sa.Column("n", sa.Integer(), nullable=False),
        sa.Column("circuit", TEXT, nullable=False),
        sa.Column("array", TEXT, nullable=False),
        sa.Column("array_symmetry", sa.Integer(), nullable=False),
        sa.Column("symmetry", sa.Integer(), nullable=False),
        sa.Column("n_fixed", sa.Integer(), nullable=False),
        sa.Column("n_foldings", sa.Integer()),
        sa.Column("n_untwisted", sa.Integer()),
        sa.Column("min_twist", sa.Integer()),
        sa.Column("best_crease", sa.Integer()),
        sa.Column("status", TEXT),
        sa.Column("score", REAL),
        sa.CheckConstraint(
            "status IN ('deploys', 'undecided', 'collides', 'locked', 'twisted', 'no_folding')",
            name=op.f("ck_design_status"),
        ),
        sa.CheckConstraint("min_twist >= 0", name=op.f("ck_design_min_twist")),
        sa.CheckConstraint(
            "n_foldings >= 0 AND n_untwisted >= 0 AND n_untwisted <= n_foldings", name=op.f("ck_design_foldings")
        ),
        sa.CheckConstraint("symmetry > 0 AND array_symmetry >= symmetry", name=op.f("ck_design_symmetry")),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_design")),
        sa.UniqueConstraint("circuit", name=op.f("uq_design_circuit")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_design_grid_n"), "design", ["grid", "n"], unique=False)


def create_run() -> None:
    """Create the table `run`."""
    op.create_table(
        "run",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("started", TEXT, nullable=False),
        sa.Column("finished", TEXT),
        sa.Column("grid", TEXT, nullable=False),
        sa.Column("n", sa.Integer(), nullable=False),
        sa.Column("target", TEXT, nullable=False),
        sa.Column("keep", TEXT, nullable=False),
        sa.Column("until", TEXT, nullable=False),
        sa.Column("panel", TEXT),
        sa.Column("arguments", TEXT, nullable=False),
        sa.Column("versions", TEXT, nullable=False),
        sa.Column("fixed_circuits", ID),
        sa.Column("circuits", ID),
        sa.Column("arrays", ID),
        sa.Column("two_stack", ID),
        sa.Column("untwisted", ID),
        sa.Column("deployable", ID),
        sa.Column("stage_times", TEXT),
        sa.Column("batches_done", sa.Integer()),
        sa.Column("batches_reused", sa.Integer()),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run")),
        sqlite_strict=True,
    )


def create_batch() -> None:
    """Create the table `batch`."""
    op.create_table(
        "batch",
        sa.Column("grid", TEXT, nullable=False),
        sa.Column("n", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("target", TEXT, nullable=False),
        sa.Column("keep", TEXT, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("prefix", TEXT, nullable=False),
        sa.Column("stage", TEXT, nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("passed", ID, nullable=False),
        sa.Column("n_fixed", ID, nullable=False),
        sa.Column("seconds", REAL, nullable=False),
        sa.Column("run_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["run_id"], ["run.id"], name=op.f("fk_batch_run")),
        sa.PrimaryKeyConstraint("grid", "n", "target", "keep", "scene", "prefix", "stage", name=op.f("pk_batch")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_folding() -> None:
    """Create the table `folding`."""
    op.create_table(
        "folding",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("opposite", sa.Integer(), nullable=False),
        sa.Column("twist", sa.Integer()),
        sa.Column("kutzbach", sa.Integer()),
        sa.Column("dof", sa.Integer()),
        sa.Column("dof_folded", sa.Integer()),
        sa.Column("dof_flat", sa.Integer()),
        sa.Column("merged_panels", sa.Integer()),
        sa.Column("kutzbach_merged", sa.Integer()),
        sa.Column("dof_merged", sa.Integer()),
        sa.Column("status", TEXT),
        sa.Column("min_clearance", REAL),
        sa.Column("deploy_time", REAL),
        sa.CheckConstraint(
            "status IN ('deploys', 'undecided', 'collides', 'locked', 'twisted')", name=op.f("ck_folding_status")
        ),
        sa.CheckConstraint("crease >= 0 AND opposite > crease", name=op.f("ck_folding_crease")),
        sa.CheckConstraint("twist >= 0", name=op.f("ck_folding_twist")),
        sa.ForeignKeyConstraint(["design_id"], ["design.id"], name=op.f("fk_folding_design"), ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("design_id", "crease", name=op.f("pk_folding")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_deployment() -> None:
    """Create the table `deployment`."""
    op.create_table(
        "deployment",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("scene_values", TEXT, nullable=False),
        sa.Column("formulation", TEXT, nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.Column("reason", TEXT, nullable=False),
        sa.Column("clearance", REAL),
        sa.Column("first_contact", REAL),
        sa.Column("deploy_time", REAL),
        sa.Column("energy_error", REAL),
        sa.Column("closure_error", REAL),
        sa.CheckConstraint(
            "status IN ('deploys', 'undecided', 'collides', 'locked')", name=op.f("ck_deployment_status")
        ),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_deployment_folding"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_deployment")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def upgrade() -> None:
    """Create the tables."""
    create_design()
    create_run()
    create_batch()
    create_folding()
    create_deployment()
