"""The store on a PostgreSQL server beside one in a file, and what a server alone has: roles, connections, other SQL."""

import gc
import random
import re
import signal
import subprocess
import sys
import threading
import time

import pytest
import sqlalchemy
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from store_samples import begin, circuits, everything, record
from test_store_verdicts import COLLIDES, CUT, DEPLOYS, FLAT, LOCKED, MOVES, PATH, list_designs, row_of, trial
from test_store_writing import insert_and

from hcsearch.basics.errors import DatabaseError, HcsearchError, QueryError
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.search.enumeration import ArraySearch, PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.search.ranking import rank_designs, save_ranks
from hcsearch.store import (
    open_database,
    open_readonly,
    record_scene,
    schema,
    select,
    select_sql,
    stream,
)
from hcsearch.store.columns import VIEWS, column_names
from tests import forking, next_schema
from tests.judging import judge
from tests.postgresql import PASSWORD

pytestmark = pytest.mark.extra


def refusal(opener, *args, **options):
    """The message of a refusal: one line, a remedy after a colon, no password."""
    with pytest.raises(DatabaseError) as caught:
        opener(*args, **options)
    message = str(caught.value)
    assert re.fullmatch(r".+: .+", message)
    assert "not:" not in message
    assert "not%3A" not in message
    return message


def command(*words, code=0):
    """The standard output and the standard error of a command of hcsearch, which never name the password."""
    done = forking.run(words)
    assert done.returncode == code, done.stderr
    assert not re.search("not:|not%3A|Traceback", done.stderr)
    return done.stdout, done.stderr


@pytest.fixture
def both(url, path):
    """The same kind of database twice: on the server, and in a file."""
    with open_database(url, create=True) as remote, open_database(str(path), create=True) as local:
        yield remote, local


@pytest.mark.parametrize(("grid", "n"), [("hex", 10), ("square", 12), ("triangle", 14)])
def test_the_pipeline_stores_the_same_rows(both, grid, n):
    for database in both:
        run_into(Plan(PolygonSearch(GRIDS[grid], n), "circuits"), database)
        summary = run_into(Plan(PolygonSearch(GRIDS[grid], n), "twist"), database)
        again = run_into(Plan(PolygonSearch(GRIDS[grid], n), "twist"), database)
        assert (again.funnel, again.batches_done) == (summary.funnel, 0)
    stored = [everything(database) for database in both]
    assert stored[0] == stored[1]
    assert len(stored[0]["run"]) == 3
    assert stored[0]["design"]


def test_an_array_before_all_arrays(both):
    for database in both:
        run_into(Plan(ArraySearch(parse_array(GRIDS["hex"], "3-4-3")), "twist"), database)
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), database)
    assert everything(both[0]) == everything(both[1])


@pytest.mark.parametrize("seed", range(3))
def test_any_sequence_of_batches_gives_the_same_ids(both, seed):
    """Batches that overlap, repeat circuits, come twice, bring other stages or other foldings."""
    chance = random.Random(seed)
    names = circuits(1, 40)
    for number in range(12):
        batch = chance.choices(names, k=chance.randint(1, 15))
        until = chance.choice(["circuits", "foldings", "twist"])
        creases = chance.choice([[[1, 4]], [[0, 3]]])
        for database in both * chance.randint(1, 2):
            record(database, batch, prefix=str(number), until=until, creases=creases, twists=[[0, 1]])
    stored = [{k: v for k, v in everything(database).items() if k in ("design", "folding")} for database in both]
    assert stored[0] == stored[1]


def test_ranks_and_scores(both):
    """Criteria of every kind and NULLs; the scores come back to the last bit, and some are taken away again."""
    ranked = []
    for database in both:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "mobility"), database)
        places = dict(select(database, "untwisted", columns="design_id,crease", view="foldings").rows)
        named = dict(select(database, columns="id,circuit").rows)
        judge(database, [(named[k], places[k], "deploys", k % 3 / 7.0, 0.1 + k % 4) for k in places if k % 2 == 0])
        judge(database, [(named[k], places[k], "deploys", k / 7.0, 0.1) for k in places], "solar")
        save_ranks(database, rank_designs(database, "n=10", {"dof": 0.3}))
        save_ranks(database, rank_designs(database, scene="solar"), "solar")
        judge(database, [(named[k], places[k], "locked", None, None) for k in places if k % 5 == 0])
        ranked.append((rank_designs(database), rank_designs(database, scene="solar")))
        save_ranks(database, ranked[-1][0])
    assert ranked[0] == ranked[1]
    assert all(one.result.rows for one in ranked[0])
    stored = [everything(database) for database in both]
    for table in ("design", "outcome", "verdict", "motion", "score"):
        assert stored[0][table] == stored[1][table]
        assert stored[0][table]


def test_verdicts_are_stored_made_anew_and_deleted_alike(both):
    """In two scenes, with their deployments, whole or not at all, and gone with their designs."""
    states = []
    for database in both:
        list_designs(database)
        judge(database, [FLAT], trials=[COLLIDES, DEPLOYS])
        judge(database, [MOVES], "solar", [trial("solar", "collides")])
        judge(database, [CUT], "dim")
        judge(database, [LOCKED], "dark")
        states.append([everything(database)])
        judge(database, [MOVES], trials=[COLLIDES])
        states[-1].append(everything(database))
        with pytest.raises(HcsearchError, match="another scene 'solar'"):
            record_scene(database, "solar", "density = 600.0\n")
        for wrong in (("hex:z", 3, "movable", None, None), ("hex:c", 2, "movable", None, None)):
            # in a piece of its own run, which stays
            with pytest.raises(Exception, match=r"lacks 1 designs|cannot store|foreign key|FOREIGN KEY"):
                judge(database, [FLAT, wrong])
        assert {**everything(database), "run": states[-1][1]["run"]} == states[-1][1]
        states[-1].append([row_of(database, scene) for scene in ("default", "solar", "dim", "dark")])
        with database.writing() as connection:
            connection.execute(schema.design.delete().where(schema.design.c.circuit == "hex:c"))
        states[-1].append(everything(database))
    assert states[0] == states[1]
    before, after, shown, left = states[0]
    assert before != after
    assert shown[:2] == [["movable", 1, None, None, *PATH]] * 2
    assert [row[:2] + row[4:] for row in shown[2:]] == [[*CUT[2:4], *[None] * 3], ["locked", 0, *[None] * 3]]
    assert [len(state["motion"]) for state in (before, after)] == [3, 3]
    assert [left[name] for name in ("outcome", "verdict", "motion", "deployment")] == [[], [], [], []]
    assert left["scene"] == after["scene"]


def test_schema_is_the_one_of_the_models(url):
    with open_database(url, create=True) as database, database.reading() as connection:
        migrated = MigrationContext.configure(connection, opts={"version_table": schema.VERSION_TABLE})
        assert compare_metadata(migrated, schema.metadata) == []
        inspector = sqlalchemy.inspect(connection)
        assert set(inspector.get_table_names()) == {*schema.metadata.tables, schema.VERSION_TABLE}
        assert set(inspector.get_view_names()) == set(VIEWS)
        checks = "SELECT conname FROM pg_constraint WHERE contype = 'c'"
        named = {c.name for table in schema.metadata.tables.values() for c in table.constraints if "ck_" in str(c.name)}
        assert named <= set(connection.exec_driver_sql(checks).scalars())
    with open_readonly(url) as reader:
        for view in VIEWS:
            assert select(reader, view=view).columns == column_names(view)


def test_creating_opening_and_refusing(server, name, url):
    assert "make one with `hcsearch enumerate`" in refusal(open_readonly, url)
    assert "make one with `hcsearch enumerate`" in refusal(open_database, url, create=False)
    open_database(url, create=True).close()
    open_database(server.socket_url(name), create=False).close()
    open_readonly(server.socket_url(name) + f"&password={PASSWORD}").close()
    server.run(f"UPDATE {schema.VERSION_TABLE} SET version_num = '9999'", name)
    assert "newer hcsearch (schema 9999" in refusal(open_readonly, url)
    assert "newer hcsearch (schema 9999" in refusal(open_database, url, create=True)


def test_old_schema_is_upgraded_on_open(url, monkeypatch, tmp_path):
    with open_database(url, create=True) as database:
        record(database, circuits(1, 3))
        before = everything(database)
    next_schema.install(tmp_path / "migrations", monkeypatch.setattr)
    assert f"older schema {schema.SCHEMA_REVISION}" in refusal(open_readonly, url)
    with open_database(url, create=False) as database:
        assert everything(database) == before
    with open_readonly(url) as reader:
        assert select_sql(reader, "SELECT count(*), count(colour) FROM design").rows == ((3, 0),)


def test_database_of_another_program(server, name, url):
    server.run("CREATE TABLE designs (id int)", name)
    for attempt in (open_readonly, lambda url: open_database(url, create=True)):
        assert "tables of another program: name another database" in refusal(attempt, url)
    assert server.run("SELECT count(*) FROM pg_tables WHERE schemaname = 'public'", name) == [(1,)]


def test_servers_that_cannot_be_used(server, name, url):
    for place, part in (
        (server.url("nope"), 'database "nope" does not exist): check that the server runs, has this database'),
        (server.url(name, password="not:right"), "password authentication failed"),
        (server.url(name, user="nobody"), "takes the user and password"),
        (server.url(name, port=1), "check that the server runs"),
        (url + "?nonsense=1", "option that cannot be used"),
        (url + "?connect_timeout=soon", "option that cannot be used"),
        (url + "?sslmode=require", "SSL"),
    ):
        assert part in refusal(open_readonly, place)
        assert part in refusal(open_database, place, create=True)


def test_a_user_without_rights(server, name, url):
    server.run("CREATE ROLE guest LOGIN PASSWORD 'not:guessed'; REVOKE CREATE ON SCHEMA public FROM PUBLIC", name)
    try:
        guest = server.url(name, user="guest", password="not:guessed")
        assert "refuses the user (permission denied" in refusal(open_database, guest, create=True)
        open_database(url, create=True).close()
        with pytest.raises(DatabaseError, match=r"refuses the user .*: grant"), open_readonly(guest) as reader:
            select(reader)
        server.run(f"GRANT SELECT ON {schema.VERSION_TABLE}, designs TO guest", name)
        with (
            pytest.raises(DatabaseError, match=r"permission denied for table scene\): grant"),
            open_readonly(guest) as reader,
        ):
            select(reader)
        server.run("GRANT SELECT ON scene TO guest", name)
        with open_readonly(guest) as reader:
            assert select(reader).rows == ()
    finally:
        server.run("DROP OWNED BY guest; DROP ROLE guest", name)


ATTACKS = [
    *("DELETE FROM design", "UPDATE design SET n = 1", "TRUNCATE design CASCADE", "DROP VIEW designs", "VACUUM"),
    *("CREATE TABLE other (x int)", "CREATE TEMP TABLE other (x int)", "SELECT 1 INTO other", "DO $$BEGIN END$$"),
    *("SET TRANSACTION READ WRITE", "RESET ALL", "COMMIT", "BEGIN", "SELECT 1; DELETE FROM design", "COMMIT; SELECT 1"),
    *("COPY design TO '/tmp/hcsearch-attack'", "COPY design TO PROGRAM 'cat'", "EXPLAIN ANALYZE DELETE FROM design"),
    *("WITH x AS (DELETE FROM design RETURNING id) SELECT * FROM x", "SELECT nextval('run_id_seq')", "CALL x()"),
    *("SELECT * FROM design FOR UPDATE", "INSERT INTO run (id) VALUES (7) RETURNING id"),
    *("SELECT query_to_xml('DELETE FROM design', true, false, '')", "LOCK TABLE design", "NOTIFY x"),
    *("", "-- nothing", "SELECT nope", "SELECT 'a\0b'", "SELECT $1", "SELECT '\udcff'", "SELECT 1/0", "nonsense"),
]


def test_sql_cannot_write_and_mistakes_are_one_line(url):
    with open_database(url, create=True) as database:
        record(database, circuits(1, 30))
        before = everything(database)
        with open_readonly(url) as reader:
            for sql in ATTACKS:
                with pytest.raises(QueryError) as caught:
                    select_sql(reader, sql)
                assert "\n" not in str(caught.value)
                assert "SELECT" in str(caught.value)
                # The connection goes on to serve.
                assert select_sql(reader, "SELECT count(*) FROM designs; ").rows == ((30,),)
            with pytest.raises(DatabaseError, match="read-only"):
                begin(reader)
            with reader.reading() as connection, pytest.raises(sqlalchemy.exc.DBAPIError, match="read-only"):
                connection.exec_driver_sql("DELETE FROM design")
            # What a read-only transaction lets pass (before PostgreSQL 16) is rolled back.
            select_sql(reader, "SELECT lo_create(7)")
            assert select_sql(reader, "SELECT count(*) FROM pg_largeobject_metadata").rows == ((0,),)
        assert everything(database) == before


def test_reading_waits_for_no_writer(url):
    with open_database(url, create=True) as database:
        record(database, circuits(1, 3))
        with database.writing() as connection:
            connection.exec_driver_sql("DELETE FROM design")
            with open_readonly(url, timeout=0.05) as reader:
                assert len(select(reader).rows) == 3
            open_database(url, create=True, timeout=0.05).close()


def test_locked_too_long(url):
    with open_database(url, create=True) as database, open_database(url, create=False, timeout=0.05) as second:
        with database.writing():
            assert "is locked by another program: wait" in refusal(begin, second)
        begin(second)


TERMINATE = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '{}'"


@pytest.fixture
def lost_cursors():
    """The driver warns of a cursor that was left open, on a connection that is gone: here, and not in a later test."""
    yield
    gc.collect()


@pytest.mark.usefixtures("lost_cursors")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(("opener", "call"), [(open_database, begin), (open_readonly, select)])
def test_a_lost_connection_is_one_line_and_the_next_call_works(server, name, url, opener, call):
    open_database(url, create=True).close()
    with opener(url, **({"create": False} if opener is open_database else {})) as database:
        call(database)
        server.run(TERMINATE.format(name))
        assert "see that the server runs, then give the same command again" in refusal(call, database)
        call(database)


@pytest.mark.usefixtures("lost_cursors")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_connection_lost_within_a_transaction_or_a_result(server, name, url):
    terminate = TERMINATE.format(name)
    with open_database(url, create=True) as database:
        record(database, circuits(1, 30))
        assert "lost its connection" in refusal(insert_and, database, circuits(31, 30), lambda: server.run(terminate))
        record(database, circuits(31, 30))
    with open_readonly(url) as reader:
        assert "lost its connection" in refusal(terminate_and_read, server, name, reader)
        assert len(select(reader).rows) == 60


def terminate_and_read(server, name, reader):
    with stream(reader) as rows:
        server.run(TERMINATE.format(name))
        list(rows.chunks)


def test_command_line_with_a_terminated_backend(server, name, url):
    with open_database(url, create=True) as database:
        record(database, circuits(1, 30))
    slow = "SELECT count(*) FROM generate_series(1, 1000000000)"
    killer = threading.Thread(target=terminate_when_busy, args=(server, name))
    killer.start()
    out, error = command("query", "--db", url, "--sql", slow, code=2)
    killer.join()
    assert out == ""
    assert error.startswith("hcsearch: database ")
    assert error.count("\n") == 1
    assert "has lost its connection" in error


def terminate_when_busy(server, name):
    wait_until_busy(server, name)
    server.run(TERMINATE.format(name))


def wait_until_busy(server, name):
    """Wait until a statement has run for a while."""
    deadline = time.monotonic() + 30
    busy = f"datname = '{name}' AND state = 'active' AND query_start < clock_timestamp() - interval '0.2 s'"
    while not server.run(f"SELECT 1 FROM pg_stat_activity WHERE {busy}"):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_interrupted_statement_stops_at_once(server, name, url):
    open_database(url, create=True).close()
    words = ["query", "--db", url, "--sql", "SELECT count(*) FROM generate_series(1, 1000000000)"]
    process = subprocess.Popen([sys.executable, "-m", "hcsearch", *words], stderr=subprocess.PIPE, text=True)
    wait_until_busy(server, name)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=5)
    assert process.returncode == 130
    assert "Traceback" not in error


def test_the_same_commands(server, name, url):
    out, error = command("enumerate", "--grid", "hex", "--n", "10", "--until", "mobility", "--db", url)
    assert "non-isomorphic circuits" in out
    assert error == ""
    out, _ = command("enumerate", "--grid", "hex", "--n", "10", "--until", "mobility", "--db", url)
    assert "0 done" in out
    out, _ = command("query", "untwisted", "--db", url, "-c", "id", "--format", "csv")
    assert len(out.splitlines()) == 26
    out, error = command("query", "grid=hexagon", "--db", url, code=2)
    assert "one of triangle, square, rectangle, hex" in error
