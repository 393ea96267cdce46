"""The tables. Values that follow from other columns (orbit size, booleans, the verdict on a twist) are in the views.

A change needs a new migration and a regenerated `db/schema.sql`; tests compare them. A change of the views needs the
same, with an empty migration.
"""

from __future__ import annotations

from pathlib import Path
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
from sqlalchemy.schema import SchemaItem
from sqlalchemy.types import REAL, TypeEngine

from hcsearch.basics.vocabulary import STATUSES
from hcsearch.store.columns import FUNNEL_COLUMNS, stored_quantities

MIGRATION_SCRIPTS = Path(__file__).with_name("migrations")
SCHEMA_REVISION = max(file.name[:4] for file in (MIGRATION_SCRIPTS / "versions").glob("[0-9]*.py"))
"""The newest migration. Revisions are numbers of four digits, so that older ones sort before newer ones. Numbers from
0002 to 0011 were used before the first release, by other schemas."""

VERSION_TABLE = "hcsearch_version"
APPLICATION_ID = 0x68635346  # "hcSF", in the header of an SQLite file

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
_KIND_TYPES: dict[str, TypeEngine[Any]] = {"integer": Integer(), "boolean": Integer(), "real": _REAL, "text": _TEXT}


def _table(name: str, *items: SchemaItem, rowid: bool = False) -> Table:
    """Return a table with some columns and constraints of its own, and a column and a check for each quantity.

    rowid : whether SQLite numbers its rows, beside the primary key.
    """
    own = {item.name: item for item in items if isinstance(item, Column)}
    stored = stored_quantities(name).values()
    made = {one.name: Column(one.name, _KIND_TYPES[one.kind], nullable=not one.required) for one in stored}
    columns = own | made | own  # keys come first
    checks = [CheckConstraint(one.condition, name=one.name) for one in stored if one.check]
    others = [item for item in items if not isinstance(item, Column)]
    return Table(name, metadata, *columns.values(), *others, *checks, sqlite_strict=True, sqlite_with_rowid=rowid)


def _one_status() -> CheckConstraint:
    """Return the constraint that a verdict is on a folding that can be judged."""
    return CheckConstraint(f"status IN ({', '.join(map(repr, STATUSES))})", name="status")


def _folding_key() -> tuple[Column[int], Column[int]]:
    """Return the key columns of a folding, which lead the key of each table on foldings."""
    return (
        Column("design_id", _ID, primary_key=True, autoincrement=False),
        Column("crease", Integer, primary_key=True, autoincrement=False),
    )


def _of_folding(crease: str) -> ForeignKeyConstraint:
    """Return the foreign key to a folding by `design_id` and the named crease column, with cascading deletion."""
    return ForeignKeyConstraint(["design_id", crease], ["folding.design_id", "folding.crease"], ondelete="CASCADE")


def _of_design() -> Column[int]:
    """Return the key column of a design in a table whose rows are deleted with it."""
    return Column("design_id", _ID, ForeignKey("design.id", ondelete="CASCADE"), primary_key=True, autoincrement=False)


def _in_scene() -> Column[str]:
    """Return the key column of a scene in a table whose rows are deleted with it."""
    return Column("scene", _TEXT, ForeignKey("scene.name", ondelete="CASCADE"), primary_key=True)


design = _table(
    "design",
    # Assigned by the writer, which holds the write lock and needs the ids to insert the foldings.
    Column("id", _ID, primary_key=True, autoincrement=False),
    # The best folding before any simulation, as is the status; verdicts in scenes are in `outcome`.
    Column("best_crease", Integer),
    # The notation of a circuit begins with its grid, so it is unique over all grids.
    UniqueConstraint("circuit"),
    CheckConstraint("n_foldings >= 0 AND n_untwisted >= 0 AND n_untwisted <= n_foldings", name="foldings"),
    # Ids grow, so rows are appended within one (grid, n), and the index slows inserts little.
    Index(None, "grid", "n"),
    rowid=True,
)

folding = _table(
    "folding",
    _of_design(),
    Column("crease", Integer, primary_key=True, autoincrement=False),
)

scene = _table(
    "scene",
    Column("name", _TEXT, primary_key=True),
    # All relevant values of the scene, as a TOML file.
    Column("scene_values", _TEXT, nullable=False),
)

# Keys begin with the design: the joins of the views and the deletion of a design need no other index.
outcome = _table(
    "outcome",
    Column("design_id", _ID, primary_key=True, autoincrement=False),
    _in_scene(),
    Column("best_crease", Integer, nullable=False),
    Column("status", _TEXT, nullable=False),
    # A verdict is deleted with the folding on which it rests.
    _of_folding("best_crease"),
    _one_status(),
)

verdict = _table(
    "verdict",
    *_folding_key(),
    _in_scene(),
    Column("status", _TEXT, nullable=False),
    _of_folding("crease"),
    _one_status(),
)

# One row per folding whose motion was planned in a scene.
motion = _table(
    "motion",
    *_folding_key(),
    _in_scene(),
    # Fold angles of the states (rad), doubles, little-endian, row by row, compressed by zlib; NULL without a path.
    Column("path", LargeBinary),
    _of_folding("crease"),
)

flight = _table("flight", *_folding_key(), _in_scene(), _of_folding("crease"))

score = _table("score", _of_design(), Column("scene", _TEXT, primary_key=True))

deployment = _table(
    "deployment",
    *_folding_key(),
    # `scene` was simulated: `base`, whose verdict it serves, or a variant of it with other springs or pairs.
    Column("base", _TEXT, primary_key=True),
    Column("scene", _TEXT, primary_key=True),
    _of_folding("crease"),
)

run = _table(
    "run",
    Column("id", Integer, primary_key=True),
    # Fixed circuits outgrow 32 bits long before the others do.
    *(Column(name, _ID) for name in FUNNEL_COLUMNS),
    rowid=True,
)

batch = _table(
    "batch",
    Column("grid", _TEXT, primary_key=True),
    Column("n", Integer, primary_key=True, autoincrement=False),
    *(Column(name, _TEXT, primary_key=True) for name in ("target", "keep", "scene", "prefix", "stage")),
    # Not part of the key: newer work replaces older work.
    Column("version", Integer, nullable=False),
    Column("passed", _ID, nullable=False),
    Column("n_fixed", _ID, nullable=False),
    Column("seconds", _REAL, nullable=False),
    Column("run_id", Integer, ForeignKey("run.id"), nullable=False),
)

# No reference to `design`: units can be searched for without a database of designs, and units of isosceles triangles
# belong to no design of a grid.
unit = _table(
    "unit",
    Column("id", _ID, primary_key=True, autoincrement=False),
    # Identifies the element and the placement of its copies; equal for repeated searches.
    Column("key", _TEXT, nullable=False),
    UniqueConstraint("key"),
    CheckConstraint("merged IN (0, 1) AND contact IN (0, 1)", name="flags"),
    Index(None, "grid", "n"),
    rowid=True,
)

# No reference to `design`: assemblies and panels of any size are tuned as well.
evaluation = _table(
    "evaluation",
    *(Column(name, _TEXT, primary_key=True) for name in ("subject", "setting", "springs")),
    # In metres; the view has millimetres.
    Column("gap", _REAL),
)
