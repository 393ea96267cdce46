"""SQL of users cannot change anything, in this file or another."""

import pytest
from store_samples import begin, circuits, record

from hcsearch.basics.errors import QueryError
from hcsearch.store import find_design, open_database, open_readonly, select, select_sql

ATTACKS = [
    "ATTACH 'other.sqlite' AS other",
    "DETACH main",
    "PRAGMA writable_schema=1",
    "PRAGMA journal_mode=delete",
    "PRAGMA query_only=OFF",
    "PRAGMA user_version=7",
    "PRAGMA table_info(design)",
    "SELECT * FROM pragma_journal_mode('delete')",
    "SELECT load_extension('other.so')",
    "SELECT LOAD_EXTENSION('other.so', 'entry')",
    "DELETE FROM design",
    "UPDATE design SET n = 1",
    "INSERT INTO run (started) VALUES (1)",
    "INSERT INTO design (id) VALUES (99) RETURNING id",
    "REPLACE INTO design (id) VALUES (1)",
    "WITH x AS (SELECT 1) DELETE FROM design",
    "WITH x AS (SELECT 1) UPDATE design SET n = 1 RETURNING n",
    "EXPLAIN DELETE FROM design",
    "VACUUM",
    "VACUUM INTO 'other.sqlite'",
    "CREATE TABLE other (x)",
    "CREATE TEMP TABLE other (x)",
    "CREATE TEMP TRIGGER t AFTER INSERT ON run BEGIN DELETE FROM design; END",
    "CREATE VIRTUAL TABLE other USING fts5(x)",
    "DROP VIEW designs",
    "ALTER TABLE design ADD COLUMN x",
    "REINDEX",
    "ANALYZE",
    "BEGIN IMMEDIATE",
    "SAVEPOINT x",
    "/* SELECT */ DELETE FROM design",
]


@pytest.fixture
def reader(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 30))
    with open_readonly(str(path)) as opened:
        yield opened


@pytest.mark.parametrize("sql", ATTACKS)
def test_refused_as_read_only(reader, path, sql):
    before = path.read_bytes()
    # SQLite 3.53 takes the argument of pragma_journal_mode for the name of a database
    with pytest.raises(QueryError, match=r"read-only|unknown database 'delete'"):
        select_sql(reader, sql)
    assert path.read_bytes() == before
    assert {file.name.removesuffix("-wal").removesuffix("-shm") for file in path.parent.iterdir()} == {path.name}
    # The connection goes on to serve.
    assert select_sql(reader, "SELECT count(*) FROM designs").rows == ((30,),)


@pytest.mark.parametrize("sql", ["SELECT 1; DELETE FROM design", "SELECT 1; SELECT 2", "DELETE FROM design; SELECT 1"])
def test_two_statements_are_refused(reader, path, sql):
    before = path.read_bytes()
    with pytest.raises(QueryError, match=r"one statement|read-only"):
        select_sql(reader, sql)
    assert path.read_bytes() == before


@pytest.mark.parametrize("sql", ["DELETE FROM design", "CREATE TEMP TABLE other (x)"])
def test_nothing_is_even_tried_without_the_authorizer(path, reader, sql):
    """A second lock behind the first: the connection itself reads only."""
    with reader.reading() as connection:
        connection.connection.driver_connection.set_authorizer(None)
        with pytest.raises(Exception, match="readonly database"):
            connection.exec_driver_sql(sql)


MISTAKES = [
    *("", " ", "-- nothing", "SELECT", "SELECT ?", "SELECT :a", "SELECT '\udcff'", "SELECT 'a\0b'", "SELECT nope"),
    *("SELECT * FROM nope", "SELECT CAST(x'ff' AS TEXT)", "nonsense", "SELECT writefile('a', 'b')"),
]


@pytest.mark.parametrize("sql", MISTAKES)
def test_mistakes_are_explained_in_one_line(reader, sql):
    with pytest.raises(QueryError) as caught:
        select_sql(reader, sql)
    assert "\n" not in str(caught.value)
    assert "SELECT" in str(caught.value)


def test_any_reading_statement_works(reader):
    assert select_sql(reader, "SELECT 'a:b %s %(x)s' AS x, 1 AS y;").rows == (("a:b %s %(x)s", 1),)
    assert select_sql(reader, "VALUES (1), (2)").rows == ((1,), (2,))
    counting = (
        "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c WHERE x < 5) SELECT sum(x) AS total FROM c"
    )
    assert select_sql(reader, counting).rows == ((15,),)
    assert select_sql(reader, counting).columns == ("total",)
    sums = "SELECT grid, n, sum(n_fixed) FROM designs GROUP BY grid, n -- published"
    assert select_sql(reader, sums).rows == (("hex", 12, 200),)
    assert select_sql(reader, "SELECT name FROM sqlite_schema WHERE type = 'view' ORDER BY name").rows[0] == (
        "deployments",
    )
    assert "SCAN" in str(select_sql(reader, "EXPLAIN QUERY PLAN SELECT * FROM designs").rows)
    assert select_sql(reader, "SELECT * FROM designs WHERE 0").rows == ()


def test_sql_is_run_on_read_only_databases_alone(database):
    with pytest.raises(QueryError, match="open_readonly"):
        select_sql(database, "DELETE FROM design")


def test_reader_sees_what_is_written_meanwhile(path, reader):
    with open_database(str(path), create=False) as database:
        begin(database)
        assert len(select(reader, view="runs").rows) == 2
        with database.writing() as connection:
            connection.exec_driver_sql("DELETE FROM design")
            assert len(select(reader).rows) == 30  # not committed, and the reader does not wait


def test_find_design(reader):
    design = find_design(reader, "3")
    assert design["circuit"] == "hex:023757"
    assert [(folding["crease"], folding["twist"]) for folding in design["foldings"]] == [(0, 1), (3, 0)]
    assert find_design(reader, "hex:023757") == design
    assert find_design(reader, "0003") == design
    assert find_design(reader, "1")["foldings"] == []


@pytest.mark.parametrize(
    "text", ["31", "0", "-1", "", "hex:", "hex:023757 ", "9" * 18, "9" * 30, "٣", "1.0", "' OR 1=1", "\udcff"]
)
def test_unknown_design(reader, text):
    with pytest.raises(QueryError, match=r"no design .*give an id or a circuit"):
        find_design(reader, text)
