"""The first schema: designs with their foldings, verdicts in scenes, runs and batches, units, evaluations.

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
        sa.PrimaryKeyConstraint("id", name=op.f("pk_design")),
        sa.UniqueConstraint("circuit", name=op.f("uq_design_circuit")),
        sa.CheckConstraint(
            "n_foldings >= 0 AND n_untwisted >= 0 AND n_untwisted <= n_foldings", name=op.f("ck_design_foldings")
        ),
        sa.CheckConstraint("min_twist >= 0", name=op.f("ck_design_min_twist")),
        sa.CheckConstraint(
            "status IN ('deploys', 'movable', 'undecided', 'locked', 'twisted', 'no_folding')",
            name=op.f("ck_design_status"),
        ),
        sa.CheckConstraint("symmetry > 0 AND array_symmetry >= symmetry", name=op.f("ck_design_symmetry")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_design_grid_n"), "design", ["grid", "n"], unique=False)


def create_evaluation() -> None:
    """Create the table `evaluation`."""
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
        sa.CheckConstraint(
            "outcome IN ('flat', 'moving', 'at rest', 'jammed', 'diverged', 'out of steps')",
            name=op.f("ck_evaluation_outcome"),
        ),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


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
        sa.Column("movable", ID),
        sa.Column("deploys", ID),
        sa.Column("stage_times", TEXT),
        sa.Column("batches_done", sa.Integer()),
        sa.Column("batches_reused", sa.Integer()),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_run")),
        sqlite_strict=True,
    )


def create_scene() -> None:
    """Create the table `scene`."""
    op.create_table(
        "scene",
        sa.Column("name", TEXT, nullable=False),
        sa.Column("scene_values", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_scene")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_unit() -> None:
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
        sa.PrimaryKeyConstraint("id", name=op.f("pk_unit")),
        sa.UniqueConstraint("key", name=op.f("uq_unit_key")),
        sa.CheckConstraint("alpha > 0 AND alpha < 90", name=op.f("ck_unit_alpha")),
        sa.CheckConstraint("copies > 1 AND panels > 0 AND hinges > 0", name=op.f("ck_unit_copies")),
        sa.CheckConstraint("merged IN (0, 1) AND contact IN (0, 1)", name=op.f("ck_unit_flags")),
        sa.CheckConstraint("path IN ('flat', 'stopped', 'stepwise', 'none', 'locked')", name=op.f("ck_unit_path")),
        sqlite_strict=True,
    )
    op.create_index(op.f("ix_unit_grid_n"), "unit", ["grid", "n"], unique=False)


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
        sa.PrimaryKeyConstraint("grid", "n", "target", "keep", "scene", "prefix", "stage", name=op.f("pk_batch")),
        sa.ForeignKeyConstraint(["run_id"], ["run.id"], name=op.f("fk_batch_run")),
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
        sa.PrimaryKeyConstraint("design_id", "crease", name=op.f("pk_folding")),
        sa.ForeignKeyConstraint(["design_id"], ["design.id"], name=op.f("fk_folding_design"), ondelete="CASCADE"),
        sa.CheckConstraint("crease >= 0 AND opposite > crease", name=op.f("ck_folding_crease")),
        sa.CheckConstraint(
            "status IN ('deploys', 'movable', 'undecided', 'locked', 'twisted')", name=op.f("ck_folding_status")
        ),
        sa.CheckConstraint("twist >= 0", name=op.f("ck_folding_twist")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_score() -> None:
    """Create the table `score`."""
    op.create_table(
        "score",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("score", REAL, nullable=False),
        sa.PrimaryKeyConstraint("design_id", "scene", name=op.f("pk_score")),
        sa.ForeignKeyConstraint(["design_id"], ["design.id"], name=op.f("fk_score_design"), ondelete="CASCADE"),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_deployment() -> None:
    """Create the table `deployment`."""
    op.create_table(
        "deployment",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("base", TEXT, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("pairs", TEXT, nullable=False),
        sa.Column("springs", TEXT, nullable=False),
        sa.Column("scene_values", TEXT, nullable=False),
        sa.Column("formulation", TEXT, nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.Column("reason", TEXT, nullable=False),
        sa.Column("clearance", REAL),
        sa.Column("first_contact", REAL),
        sa.Column("deploy_time", REAL),
        sa.Column("energy_error", REAL),
        sa.Column("closure_error", REAL),
        sa.Column("needed_margin", REAL),
        sa.Column("least_gap", REAL),
        sa.Column("as_crease", sa.Integer()),
        sa.PrimaryKeyConstraint("design_id", "crease", "base", "scene", name=op.f("pk_deployment")),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_deployment_folding"),
            ondelete="CASCADE",
        ),
        sa.CheckConstraint("pairs IN ('rigid', 'hinged', 'merged')", name=op.f("ck_deployment_pairs")),
        sa.CheckConstraint("status IN ('deploys', 'undecided', 'collides')", name=op.f("ck_deployment_status")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_motion() -> None:
    """Create the table `motion`."""
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
        sa.Column("as_crease", sa.Integer()),
        sa.Column("efforts", sa.Integer()),
        sa.Column("lock_pairs", TEXT),
        sa.Column("lock_end", TEXT),
        sa.Column("lock_cubes", sa.Integer()),
        sa.Column("lock_faces", sa.Integer()),
        sa.Column("critical_margin", REAL),
        sa.Column("unmet_margin", REAL),
        sa.Column("lock_margin", REAL),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_motion")),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_motion_folding"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_motion_scene"), ondelete="CASCADE"),
        sa.CheckConstraint("flat_pairs IN ('rigid', 'hinged', 'merged')", name=op.f("ck_motion_flat_pairs")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_outcome() -> None:
    """Create the table `outcome`."""
    op.create_table(
        "outcome",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("best_crease", sa.Integer(), nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("design_id", "scene", name=op.f("pk_outcome")),
        sa.ForeignKeyConstraint(
            ["design_id", "best_crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_outcome_folding"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_outcome_scene"), ondelete="CASCADE"),
        sa.CheckConstraint("status IN ('deploys', 'movable', 'undecided', 'locked')", name=op.f("ck_outcome_status")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def create_verdict() -> None:
    """Create the table `verdict`."""
    op.create_table(
        "verdict",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("scene", TEXT, nullable=False),
        sa.Column("status", TEXT, nullable=False),
        sa.Column("min_clearance", REAL),
        sa.Column("deploy_time", REAL),
        sa.Column("needed_margin", REAL),
        sa.Column("least_gap", REAL),
        sa.PrimaryKeyConstraint("design_id", "crease", "scene", name=op.f("pk_verdict")),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_verdict_folding"),
            ondelete="CASCADE",
        ),
        sa.ForeignKeyConstraint(["scene"], ["scene.name"], name=op.f("fk_verdict_scene"), ondelete="CASCADE"),
        sa.CheckConstraint("status IN ('deploys', 'movable', 'undecided', 'locked')", name=op.f("ck_verdict_status")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )


def upgrade() -> None:
    """Create the tables."""
    create_design()
    create_evaluation()
    create_run()
    create_scene()
    create_unit()
    create_batch()
    create_folding()
    create_score()
    create_deployment()
    create_motion()
    create_outcome()
    create_verdict()
