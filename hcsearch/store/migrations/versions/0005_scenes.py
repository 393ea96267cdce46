"""Scenes: verdicts, scores and deployments of a design are those in a scene, and a database holds many.

A migration is frozen: it spells out its DDL and imports nothing of hcsearch.
"""

import json
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"

ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
TEXT = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
REAL: sa.types.TypeEngine[float] = sa.Double().with_variant(sa.REAL(), "sqlite")
VERDICTS = "IN ('deploys', 'undecided', 'collides', 'locked')"
ON_TOP = ("panel_mm", "margin_mm", "flat_pairs", "merge")


def upgrade() -> None:
    """Create the tables, move what was of the scene `default` there, and write deployments as they are read now."""
    _create()
    connection = op.get_bind()
    for statement in _MOVES:
        connection.execute(sa.text(statement))
    _convert_deployments(connection)
    op.drop_column("design", "score")
    op.drop_column("folding", "min_clearance")
    op.drop_column("folding", "deploy_time")


def _create() -> None:
    op.create_table(
        "scene",
        sa.Column("name", TEXT, nullable=False),
        sa.Column("scene_values", TEXT, nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_scene")),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
    op.create_table(
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
    op.create_table(
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


# Batches of the stage go: it works in smaller pieces now, and does them anew.
_MOVES = (
    "INSERT INTO scene SELECT 'default', '' WHERE EXISTS (SELECT 1 FROM deployment)",
    """INSERT INTO outcome SELECT d.id, 'default', b.crease, d.status
    FROM design AS d JOIN folding AS b ON b.design_id = d.id AND b.crease = coalesce(
        (SELECT e.crease FROM folding AS e WHERE e.design_id = d.id AND e.twist = 0 AND e.status = d.status
         ORDER BY e.dof IS NULL, e.dof, e.crease LIMIT 1), d.best_crease)
    WHERE d.status IN ('deploys', 'undecided', 'collides', 'locked')
    AND EXISTS (SELECT 1 FROM deployment AS p WHERE p.design_id = d.id)""",
    """INSERT INTO verdict SELECT f.design_id, f.crease, 'default', f.status, f.min_clearance, f.deploy_time
    FROM folding AS f WHERE f.twist = 0 AND f.status IN ('deploys', 'undecided', 'collides', 'locked')
    AND EXISTS (SELECT 1 FROM outcome AS o WHERE o.design_id = f.design_id)""",
    "INSERT INTO score SELECT id, 'default', score FROM design WHERE score IS NOT NULL",
    "UPDATE design SET status = 'undecided' WHERE status IN ('deploys', 'collides')",
    "UPDATE folding SET status = 'undecided' WHERE status IN ('deploys', 'collides')",
    "DELETE FROM batch WHERE stage = 'deployment'",
)


def _convert_deployments(connection: sa.Connection) -> None:
    """Write `deployment` anew: SQLite cannot give a table another key."""
    wanted = "SELECT p.*, d.circuit FROM deployment AS p JOIN design AS d ON d.id = p.design_id"
    rows = [dict(row) for row in connection.execute(sa.text(wanted)).mappings()]
    op.drop_table("deployment")
    table = op.create_table(
        "deployment",
        sa.Column("design_id", ID, autoincrement=False, nullable=False),
        sa.Column("crease", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("base", TEXT, nullable=False),
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
        sa.PrimaryKeyConstraint("design_id", "crease", "base", "scene", name=op.f("pk_deployment")),
        sa.CheckConstraint(f"status {VERDICTS}", name=op.f("ck_deployment_status")),
        sa.ForeignKeyConstraint(
            ["design_id", "crease"],
            ["folding.design_id", "folding.crease"],
            name=op.f("fk_deployment_folding"),
            ondelete="CASCADE",
        ),
        sqlite_strict=True,
        sqlite_with_rowid=False,
    )
    for row in rows:
        row["base"] = "default"
        design = f"{row.pop('circuit')}:{row['crease']}"
        row["scene_values"] = _toml(design, row["scene"], row["formulation"], row["scene_values"])
    if rows:
        connection.execute(table.insert(), rows)


def _toml(design: str, name: str, formulation: str, values: str) -> str:
    """The values of a scene as `hcsearch deploy` reads them."""
    try:
        found: dict[str, Any] = json.loads(values)
    except json.JSONDecodeError:
        found = {}
    lines = [f"design = {json.dumps(design)}", f"name = {json.dumps(name)}", f"formulation = {json.dumps(formulation)}"]
    lines += [f"{key} = {json.dumps(found[key])}" for key in ON_TOP if key in found]
    springs = found.pop("springs", {})
    own = [f"{key} = {json.dumps(value)}" for key, value in found.items() if key not in ON_TOP]
    if springs:
        laws = ", ".join(f"{hinge} = {json.dumps(law)}" for hinge, law in springs.items())
        own.append(f"springs = {{ {laws} }}")
    lines += ["", "[scene]", *own] if own else []
    return "".join(f"{line}\n" for line in lines)
