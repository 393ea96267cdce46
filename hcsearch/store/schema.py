"""The tables. Values that follow from other columns (orbit size, booleans, the verdict on a twist) are in the views.

A change needs a new migration, a higher revision and a regenerated `db/schema.sql`; tests compare all three. A change
of the views needs the same, with an empty migration.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sqlalchemy import (
    BigInteger,
    CheckConstraint,
    Column,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.types import REAL, TypeEngine

from hcsearch.basics.vocabulary import DESIGN_STATUSES, ENDINGS, FOLDING_STATUSES, STATUSES, UNIT_PATHS, VERDICTS, WAYS
from hcsearch.store.columns import FLIGHT_QUANTITIES

SCHEMA_REVISION = "0014"
"""The newest migration. Revisions are numbers of four digits, so that older ones sort before newer ones. Numbers from
0002 to 0011 were used before the first release, by other schemas."""

VERSION_TABLE = "hcsearch_version"
APPLICATION_ID = 0x68635346  # "hcSF", in the header of an SQLite file

FUNNEL_COLUMNS = ("fixed_circuits", "circuits", "arrays", "two_stack", "untwisted", "movable", "deploys")

# Names let later migrations change constraints.
metadata = MetaData(
    naming_convention={
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "fk": "fk_%(table_name)s_%(referred_table_name)s",
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    }
)

# INTEGER on SQLite: only this spelling makes an id the row number. STRICT tables have REAL, but not DOUBLE.
_ID = BigInteger().with_variant(Integer, "sqlite")
# Compared by bytes on servers, as SQLite does: notations sort alike everywhere, and faster than by a language.
_TEXT = Text().with_variant(Text(collation="C"), "postgresql")
_REAL: TypeEngine[float] = Double().with_variant(REAL, "sqlite")
_KIND_TYPES: dict[str, TypeEngine[Any]] = {"integer": Integer(), "real": _REAL, "text": _TEXT}


def _one_of(name: str, words: Iterable[str]) -> CheckConstraint:
    """Return the constraint that a column holds one of some words or NULL."""
    return CheckConstraint(f"{name} IN ({', '.join(map(repr, words))})", name=name)


def _folding_key() -> tuple[Column[int], Column[int]]:
    """Return the key columns of a folding, which lead the key of each table on foldings."""
    return (
        Column("design_id", _ID, primary_key=True, autoincrement=False),
        Column("crease", Integer, primary_key=True, autoincrement=False),
    )


def _of_folding(crease: str) -> ForeignKeyConstraint:
    """Return the foreign key to a folding by `design_id` and the named crease column, with cascading deletion."""
    return ForeignKeyConstraint(["design_id", crease], ["folding.design_id", "folding.crease"], ondelete="CASCADE")


design = Table(
    "design",
    metadata,
    # Assigned by the writer, which holds the write lock and needs the ids to insert the foldings.
    Column("id", _ID, primary_key=True, autoincrement=False),
    Column("grid", _TEXT, nullable=False),
    Column("n", Integer, nullable=False),
    Column("circuit", _TEXT, nullable=False),
    Column("array", _TEXT, nullable=False),
    Column("array_symmetry", Integer, nullable=False),
    Column("symmetry", Integer, nullable=False),
    Column("n_fixed", Integer, nullable=False),
    Column("n_foldings", Integer),
    Column("n_untwisted", Integer),
    Column("min_twist", Integer),
    Column("best_crease", Integer),
    # The status before any simulation; verdicts in scenes are in `outcome`.
    Column("status", _TEXT),
    # The notation of a circuit begins with its grid, so it is unique over all grids.
    UniqueConstraint("circuit"),
    CheckConstraint("symmetry > 0 AND array_symmetry >= symmetry", name="symmetry"),
    CheckConstraint("n_foldings >= 0 AND n_untwisted >= 0 AND n_untwisted <= n_foldings", name="foldings"),
    CheckConstraint("min_twist >= 0", name="min_twist"),
    _one_of("status", DESIGN_STATUSES),
    # Ids grow, so rows are appended within one (grid, n), and the index slows inserts little.
    Index(None, "grid", "n"),
    sqlite_strict=True,
)

folding = Table(
    "folding",
    metadata,
    Column("design_id", _ID, ForeignKey("design.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("crease", Integer, primary_key=True, autoincrement=False),
    Column("opposite", Integer, nullable=False),
    Column("twist", Integer),
    Column("kutzbach", Integer),
    Column("dof", Integer),
    Column("dof_folded", Integer),
    Column("dof_flat", Integer),
    Column("merged_panels", Integer),
    Column("kutzbach_merged", Integer),
    Column("dof_merged", Integer),
    Column("status", _TEXT),
    CheckConstraint("crease >= 0 AND opposite > crease", name="crease"),
    CheckConstraint("twist >= 0", name="twist"),
    _one_of("status", FOLDING_STATUSES),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

scene = Table(
    "scene",
    metadata,
    Column("name", _TEXT, primary_key=True),
    # All relevant values of the scene, as a TOML file.
    Column("scene_values", _TEXT, nullable=False),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

# Keys begin with the design: the joins of the views and the deletion of a design need no other index.
outcome = Table(
    "outcome",
    metadata,
    Column("design_id", _ID, primary_key=True, autoincrement=False),
    Column("scene", _TEXT, ForeignKey("scene.name", ondelete="CASCADE"), primary_key=True),
    Column("best_crease", Integer, nullable=False),
    Column("status", _TEXT, nullable=False),
    # A verdict is deleted with the folding on which it rests.
    _of_folding("best_crease"),
    _one_of("status", STATUSES),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

verdict = Table(
    "verdict",
    metadata,
    *_folding_key(),
    Column("scene", _TEXT, ForeignKey("scene.name", ondelete="CASCADE"), primary_key=True),
    Column("status", _TEXT, nullable=False),
    Column("min_clearance", _REAL),
    Column("deploy_time", _REAL),
    # Of the motion behind the status: the deployment for `deploys`, the path for `movable`.
    Column("needed_margin", _REAL),
    Column("least_gap", _REAL),
    _of_folding("crease"),
    _one_of("status", STATUSES),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

# One row per folding whose motion was planned in a scene. Lengths in millimetres, as in the views.
motion = Table(
    "motion",
    metadata,
    *_folding_key(),
    Column("scene", _TEXT, ForeignKey("scene.name", ondelete="CASCADE"), primary_key=True),
    Column("flat_pairs", _TEXT),
    Column("needed_margin", _REAL),
    Column("least_gap", _REAL),
    Column("slack", _REAL),
    Column("states", Integer, nullable=False),
    Column("reason", _TEXT, nullable=False),
    # Fold angles of the states (rad), doubles, little-endian, row by row, compressed by zlib; NULL without a path.
    Column("path", LargeBinary),
    # The congruent folding whose motion this is; NULL if this folding was planned itself.
    Column("as_crease", Integer),
    # Effort of the search; the widest lock between the ends; play with a path, and play without one.
    Column("efforts", Integer),
    Column("lock_pairs", _TEXT),
    Column("lock_end", _TEXT),
    Column("lock_cubes", Integer),
    Column("lock_faces", Integer),
    Column("critical_margin", _REAL),
    Column("unmet_margin", _REAL),
    Column("lock_margin", _REAL),
    _of_folding("crease"),
    _one_of("flat_pairs", WAYS),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

# The figures of the stage `flight`, in the units of the views; NULL where one is not known.
flight = Table(
    "flight",
    metadata,
    *_folding_key(),
    Column("scene", _TEXT, ForeignKey("scene.name", ondelete="CASCADE"), primary_key=True),
    *(Column(quantity.name, _KIND_TYPES[quantity.kind]) for quantity in FLIGHT_QUANTITIES),
    _of_folding("crease"),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

score = Table(
    "score",
    metadata,
    Column("design_id", _ID, ForeignKey("design.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("scene", _TEXT, primary_key=True),
    Column("score", _REAL, nullable=False),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

deployment = Table(
    "deployment",
    metadata,
    *_folding_key(),
    # `scene` was simulated: `base`, whose verdict it serves, or a variant of it with other springs or pairs.
    Column("base", _TEXT, primary_key=True),
    Column("scene", _TEXT, primary_key=True),
    Column("pairs", _TEXT, nullable=False),
    Column("springs", _TEXT, nullable=False),
    Column("scene_values", _TEXT, nullable=False),
    Column("formulation", _TEXT, nullable=False),
    Column("status", _TEXT, nullable=False),
    Column("reason", _TEXT, nullable=False),
    Column("clearance", _REAL),
    Column("first_contact", _REAL),
    Column("deploy_time", _REAL),
    Column("energy_error", _REAL),
    Column("closure_error", _REAL),
    Column("needed_margin", _REAL),
    Column("least_gap", _REAL),
    # The congruent folding that was simulated instead, or NULL.
    Column("as_crease", Integer),
    # Added by a migration, so NULL in rows of before; names of omissions are joined by commas.
    Column("method", _TEXT),
    Column("error_angle", _REAL),
    Column("error_time", _REAL),
    Column("omitted", _TEXT),
    Column("time_saved", _REAL),
    _of_folding("crease"),
    _one_of("pairs", WAYS),
    _one_of("status", VERDICTS),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

run = Table(
    "run",
    metadata,
    Column("id", Integer, primary_key=True),
    Column("started", _TEXT, nullable=False),
    Column("finished", _TEXT),
    Column("grid", _TEXT, nullable=False),
    Column("n", Integer, nullable=False),
    Column("target", _TEXT, nullable=False),
    Column("keep", _TEXT, nullable=False),
    Column("until", _TEXT, nullable=False),
    Column("panel", _TEXT),
    Column("arguments", _TEXT, nullable=False),
    Column("versions", _TEXT, nullable=False),
    # Fixed circuits outgrow 32 bits long before the others do.
    *(Column(name, _ID) for name in FUNNEL_COLUMNS),
    Column("stage_times", _TEXT),
    Column("batches_done", Integer),
    Column("batches_reused", Integer),
    sqlite_strict=True,
)

batch = Table(
    "batch",
    metadata,
    Column("grid", _TEXT, primary_key=True),
    Column("n", Integer, primary_key=True, autoincrement=False),
    Column("target", _TEXT, primary_key=True),
    Column("keep", _TEXT, primary_key=True),
    Column("scene", _TEXT, primary_key=True),
    Column("prefix", _TEXT, primary_key=True),
    Column("stage", _TEXT, primary_key=True),
    # Not part of the key: newer work replaces older work.
    Column("version", Integer, nullable=False),
    Column("passed", _ID, nullable=False),
    Column("n_fixed", _ID, nullable=False),
    Column("seconds", _REAL, nullable=False),
    Column("run_id", Integer, ForeignKey("run.id"), nullable=False),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)

# No reference to `design`: units can be searched for without a database of designs, and those of isosceles triangles
# belong to no design of a grid.
unit = Table(
    "unit",
    metadata,
    Column("id", _ID, primary_key=True, autoincrement=False),
    Column("grid", _TEXT, nullable=False),
    Column("n", Integer, nullable=False),
    Column("circuit", _TEXT, nullable=False),
    Column("crease", Integer, nullable=False),
    Column("alpha", _REAL),
    Column("shape", _TEXT, nullable=False),
    Column("merged", Integer, nullable=False),
    Column("element_dof", Integer),
    Column("copies", Integer, nullable=False),
    Column("placements", _TEXT, nullable=False),
    Column("panels", Integer, nullable=False),
    Column("hinges", Integer, nullable=False),
    Column("directions", Integer, nullable=False),
    Column("loops", Integer, nullable=False),
    Column("kutzbach", Integer, nullable=False),
    Column("dof", Integer, nullable=False),
    Column("dof_folded", Integer),
    Column("dof_flat", Integer),
    Column("rank_gap", _REAL, nullable=False),
    Column("deployment_ratio", _REAL, nullable=False),
    Column("ways", Integer, nullable=False),
    Column("path", _TEXT, nullable=False),
    Column("closure_error", _REAL),
    Column("contact", Integer),
    Column("known", _TEXT, nullable=False),
    # Identifies the element and the placement of its copies; equal for repeated searches.
    Column("key", _TEXT, nullable=False),
    UniqueConstraint("key"),
    CheckConstraint("copies > 1 AND panels > 0 AND hinges > 0", name="copies"),
    CheckConstraint("merged IN (0, 1) AND contact IN (0, 1)", name="flags"),
    CheckConstraint("alpha > 0 AND alpha < 90", name="alpha"),
    _one_of("path", UNIT_PATHS),
    Index(None, "grid", "n"),
    sqlite_strict=True,
)

# No reference to `design`: assemblies and panels of any size are tuned as well.
evaluation = Table(
    "evaluation",
    metadata,
    Column("subject", _TEXT, primary_key=True),
    Column("setting", _TEXT, primary_key=True),
    Column("springs", _TEXT, primary_key=True),
    Column("outcome", _TEXT, nullable=False),
    # NULL if undecided or overflowed.
    Column("clear", Integer),
    Column("end_time", _REAL, nullable=False),
    Column("collision_time", _REAL),
    Column("first_panel", Integer),
    Column("second_panel", Integer),
    Column("gap", _REAL),
    Column("speed", _REAL),
    Column("remaining", _REAL),
    Column("end_remaining", _REAL),
    Column("widest", _REAL),
    Column("drift", _REAL),
    Column("opening", _REAL),
    Column("steps", Integer, nullable=False),
    Column("evaluations", Integer, nullable=False),
    Column("looks", Integer, nullable=False),
    CheckConstraint("clear IN (0, 1)", name="clear"),
    _one_of("outcome", ENDINGS),
    sqlite_strict=True,
    sqlite_with_rowid=False,
)
