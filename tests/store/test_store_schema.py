import importlib.resources
import re
import sqlite3
from functools import partial
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import create_mock_engine, inspect
from sqlalchemy.schema import CreateTable
from store_samples import record

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import migrate, open_database, open_readonly, schema, select, select_sql
from hcsearch.store.columns import VIEWS, column_names
from hcsearch.store.generated import schema_sql
from hcsearch.store.views import create_view, select_view_in
from tests import next_schema

ROOT = Path(__file__).parents[2]


@pytest.fixture
def place(path):
    """These tests read what SQLite alone has; `test_store_postgresql.py` has those of a server."""
    return str(path)


def stored_sql(database, kind):
    with database.reading() as connection:
        rows = connection.exec_driver_sql("SELECT name, sql FROM sqlite_schema WHERE type = ?", (kind,)).all()
    return dict(tuple(row) for row in rows)


def parts(sql):
    """Columns, constraints and options of a CREATE TABLE, whatever their order."""
    lines = [line.strip().rstrip(",") for line in sql.strip().splitlines()]
    # a column that a migration added stands in a line with another one; commas within brackets are of one part
    return sorted(part for line in lines for part in re.split(r", (?![^()]*\))", line))


def test_migrated_schema_equals_the_models(database):
    with database.reading() as connection:
        context = MigrationContext.configure(connection, opts={"version_table": schema.VERSION_TABLE})
        assert compare_metadata(context, schema.metadata) == []
        tables = set(inspect(connection).get_table_names())
        created = {
            name: parts(str(CreateTable(table).compile(connection.engine)))
            for name, table in schema.metadata.tables.items()
        }
    assert tables == {*schema.metadata.tables, schema.VERSION_TABLE}
    # compare_metadata overlooks CHECK, STRICT and WITHOUT ROWID.
    stored = {name: parts(sql) for name, sql in stored_sql(database, "table").items() if name != schema.VERSION_TABLE}
    assert stored == created
    assert all("STRICT" in lines for lines in created.values())


def test_migrated_views_equal_their_source(database):
    assert stored_sql(database, "view") == {view: create_view(view) for view in VIEWS}


FLIGHT = (
    "torque_margin torque_margin_hinge torque_margin_at torque_margin_failed deployed_hz soft_modes latch_torque"
    " latch_impulse clearance_ratio self_stresses flatness_mm_per_mrad tilt stowed_length stowed_width stowed_height"
    " area_per_volume mass craft_clearance"
)


def test_views_have_the_promised_columns(database):
    for view in VIEWS:
        assert select(database, view=view).columns == column_names(view)
    assert " ".join(column_names("designs")) == (
        "id grid n array circuit array_symmetry symmetry orbit_size n_fixed n_foldings two_stack n_untwisted untwisted"
        " min_twist kutzbach dof merged_panels kutzbach_merged dof_merged deployable flat_pairs known"
        " critical_margin unmet_margin needed_margin least_gap min_clearance deploy_time error_angle error_time status"
        f" score deployment_ratio hinges {FLIGHT}"
    )
    assert " ".join(column_names("foldings")) == (
        "design_id crease opposite twist untwisted kutzbach dof dof_folded dof_flat merged_panels kutzbach_merged"
        " dof_merged status deployable flat_pairs known critical_margin unmet_margin needed_margin least_gap"
        f" min_clearance deploy_time error_angle error_time {FLIGHT}"
    )
    assert " ".join(column_names("motions")) == (
        "design_id crease scene flat_pairs needed_margin least_gap slack states reason as_crease efforts"
        " lock_pairs lock_end lock_cubes lock_faces critical_margin unmet_margin lock_margin"
    )
    assert " ".join(column_names("runs")).count(" two_stack untwisted movable deploys ") == 1


def test_schema_file_is_the_generated_one():
    assert (ROOT / "db" / "schema.sql").read_text() == schema_sql(), "run: make db"


def test_schema_file_makes_a_database_by_hand(path):
    connection = sqlite3.connect(path)
    connection.executescript(schema_sql())
    connection.close()
    with open_database(str(path), create=False) as database:
        record(database, ["hex:1"])
        assert len(select(database).rows) == 1


def test_newest_migration_is_the_known_revision():
    config = Config()
    config.set_main_option("script_location", str(migrate.MIGRATION_SCRIPTS))
    config.set_main_option("path_separator", "os")
    scripts = ScriptDirectory.from_config(config)
    assert scripts.get_heads() == [schema.SCHEMA_REVISION]
    assert all(re.fullmatch(r"\d{4}", script.revision) for script in scripts.walk_revisions())


def test_migrations_are_packaged():
    files = {file.name for file in (importlib.resources.files("hcsearch.store") / "migrations").iterdir()}
    assert {"env.py", "__init__.py", "script.py.mako", "versions"} <= files


@pytest.fixture
def next_version(tmp_path, monkeypatch):
    """Makes this program one that knows one more migration."""
    return partial(next_schema.install, tmp_path / "100% migrations", monkeypatch.setattr)


def test_upgrade_keeps_rows_and_their_children(path, next_version):
    with open_database(str(path), create=True) as database:
        record(database, ["hex:1", "hex:2", "hex:3"])
    next_version()
    with pytest.raises(DatabaseError, match=f"older schema {schema.SCHEMA_REVISION}"):
        open_readonly(str(path))
    with open_database(str(path), create=False):
        pass
    with open_readonly(str(path)) as database:
        assert select_sql(database, "SELECT count(*), count(colour) FROM design").rows == ((3, 0),)
        assert select_sql(database, "SELECT count(*) FROM folding").rows == ((4,),)


def test_second_of_two_upgraders_finds_it_done(database, monkeypatch):
    monkeypatch.setattr(migrate, "_run_migrations", None)
    with database.writing() as connection:
        migrate.upgrade_schema(connection, "here")


def test_failed_upgrade_changes_nothing(path, next_version):
    with open_database(str(path), create=True) as database:
        record(database, ["hex:1", "hex:2", "hex:3"])
    before = path.read_bytes()
    next_version()
    file = migrate.MIGRATION_SCRIPTS / next_schema.SCRIPT
    file.write_text(file.read_text() + "    op.execute('SELECT 1 FROM nowhere')\n")
    with pytest.raises(DatabaseError, match="nowhere"):
        open_database(str(path), create=False)
    assert path.read_bytes() == before


def test_newer_schema_is_refused(path, next_version, monkeypatch):
    next_version()
    open_database(str(path), create=True).close()
    monkeypatch.undo()
    before = path.read_bytes()
    for attempt in (lambda: open_database(str(path), create=True), lambda: open_readonly(str(path))):
        with pytest.raises(DatabaseError, match=rf"newer hcsearch .schema {next_schema.NEXT}.*install"):
            attempt()
    assert path.read_bytes() == before


def plan(database, sql):
    with database.reading() as connection:
        return " / ".join(row[3] for row in connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {sql}"))


def test_join_is_left_out_where_it_is_not_needed(database):
    assert "LEFT" in plan(database, "SELECT id, dof FROM designs")
    assert "LEFT" not in plan(database, "SELECT id, n, untwisted FROM designs WHERE two_stack = 1 ORDER BY id")
    assert "LEFT" not in plan(database, "SELECT id, circuit FROM designs WHERE n = 12")
    for name in ("status", "dof", "min_clearance", "needed_margin", "flat_pairs", "least_gap", "score"):
        joined = plan(database, f"SELECT id, {name} FROM designs")
        assert joined.count("LEFT") == 1
        # by whole keys: nothing is searched for
        assert joined.count("SCAN") == 1
        assert joined.count("LEFT") + joined.count("SUBQUERY") == joined.count("USING PRIMARY KEY")
    solar = plan(database, f"SELECT id, status FROM ({select_view_in('designs', 'solar')}) AS designs WHERE n = 12")
    assert (solar.count("LEFT"), solar.count("SCAN")) == (1, 1)


def test_verdicts_of_a_design_are_deleted_by_their_keys(database):
    """A cascade that has no index reads the whole table for each design."""
    for name in ("outcome", "verdict", "score", "motion", "deployment"):
        assert "SCAN" not in plan(database, f"DELETE FROM {name} WHERE design_id = 7")


def test_grid_and_n_are_indexed(database):
    assert "ix_design_grid_n" in plan(
        database, "SELECT id FROM designs WHERE grid = 'hex' AND n = 12 AND untwisted = 1"
    )


def test_tables_are_valid_for_postgresql():
    statements = []
    engine = create_mock_engine("postgresql://", lambda sql, *_, **__: statements.append(str(sql.compile(engine))))
    schema.metadata.create_all(engine, checkfirst=False)
    text = "\n".join(statements)
    assert '"array" TEXT COLLATE "C" NOT NULL' in text
    assert "DOUBLE PRECISION" in text
    assert "STRICT" not in text


def test_constraints_hold(database):
    good = {
        "id": 1,
        "grid": "hex",
        "n": 6,
        "circuit": "c",
        "array": "a",
        "array_symmetry": 6,
        "symmetry": 2,
        "n_fixed": 6,
    }
    for bad in (
        {"symmetry": 0},
        {"n": "six"},
        {"status": "fine"},
        {"min_twist": -1},
        {"n_foldings": 1, "n_untwisted": 2},
    ):
        with pytest.raises(Exception, match=r"constraint failed|cannot store"), database.writing() as connection:
            connection.execute(schema.design.insert().values({**good, **bad}))
    with pytest.raises(Exception, match="FOREIGN KEY"), database.writing() as connection:
        connection.execute(schema.folding.insert().values(design_id=7, crease=0, opposite=3))
    with database.writing() as connection:
        connection.execute(schema.design.insert().values(good))
        connection.execute(schema.folding.insert().values(design_id=1, crease=0, opposite=3))
    with database.writing() as connection:
        connection.execute(schema.design.delete())
    assert select(database, view="foldings").rows == ()
