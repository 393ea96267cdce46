"""Servers and roles that are set up otherwise: the same numbers and texts, or one line, and readers who only read."""

import re
from contextlib import contextmanager
from pathlib import Path

import pytest
from store_samples import circuits, record

from hcsearch.basics.errors import DatabaseError, HcsearchError
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import find_design, open_database, open_readonly, schema, select, select_sql
from tests import forking
from tests.judging import judge
from tests.postgresql import PASSWORD, USER
from tests.serve.asking import Asking

pytestmark = pytest.mark.extra

MANUAL = Path(__file__).parents[2] / "db/README.md"
MOVES = "hex:0234435011"
"""Has foldings at 1, which moves here, at 3 and at 4."""

QUERIES = (
    *("query --format csv", "query --format json -s -least_gap,circuit", "query untwisted -c id,array --format csv"),
    *("rank --format csv", "query --sql SELECT|*|FROM|motions", "query --format csv --sql SELECT|*|FROM|motions"),
    *("query --sql SELECT|arguments,target,until|FROM|runs", "show {id}", "show {id} --scene solar"),
    *("export {id}:1 --motion path --output path.csv", "export {id}:1 --output folding.fold"),
)


def fill(place):
    """Store designs with verdicts whose numbers need all their digits, and paths; the id of one that moves."""
    with open_database(place, create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "mobility"), database)
        judge(database, [(MOVES, 1, "movable", 1 / 3e3, 0.1 + 0.2)])
        judge(database, [(MOVES, 1, "locked", None, None)], "solar", key="p#0/2")
        with database.writing() as connection:
            for table in (schema.verdict, schema.motion):
                connection.execute(table.update().values(least_gap=-0.012176225131059655))
            connection.execute(schema.run.update().values(started="2026-01-01T00:00:00+00:00"))
        return find_design(database, MOVES)["id"]


def printed(place, number, folder):
    """What the commands print and write of a database, with its name left out."""
    folder.mkdir(exist_ok=True)
    texts = []
    for words in QUERIES:
        listed = [word.replace("|", " ").format(id=number) for word in words.split()]
        done = forking.run([*listed, "--db", place], cwd=folder)
        assert done.returncode == 0, (words, done.stderr)
        texts.append(re.sub(r"--db \S+", "", done.stdout + done.stderr))
    return texts + [file.read_text() for file in sorted(folder.iterdir())]


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """What is printed of a file, and the id of the design that moves."""
    folder = tmp_path_factory.mktemp("local")
    place = str(folder / "designs.sqlite")
    number = fill(place)
    return printed(place, number, folder / "files"), number


@pytest.fixture(scope="module")
def filled(server):
    """The same on the server."""
    name = server.create_database()
    fill(server.url(name))
    yield name
    server.drop_database(name)


@contextmanager
def role(server, name, statements):
    """A user of a database made by some statements; everything of it is taken back."""
    server.run(statements, name)
    try:
        yield f"postgresql+psycopg://guest@/{name}?host={server.folder}&port={server.port}"
    finally:
        server.run("DROP OWNED BY guest; DROP ROLE guest", name)


def grants():
    """The statements of the manual that make a role which only reads."""
    (statements,) = re.findall("`(CREATE ROLE guest LOGIN; GRANT [^`]*)`", MANUAL.read_text())
    return statements


def test_the_role_of_the_manual_can_query_rank_show_report_and_export(server, filled, local, tmp_path):
    with role(server, filled, grants()) as guest:
        assert printed(guest, local[1], tmp_path / "files") == local[0]
        words = ["report", "untwisted", "--db", guest, "--output", "page.html"]
        done = forking.run(words, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (0, "page.html\n")


def test_the_role_of_the_manual_serves_all_pages_and_writes_nothing(server, filled, local):
    from hcsearch.web.serve.application import Application

    with role(server, filled, grants()) as guest:
        with open_readonly(guest) as database:
            application = Application(database, guest)
            below = (f"/designs/{local[1]}", f"/designs/{local[1]}/foldings/1/motion.json")
            for address in ("/designs", "/foldings", "/motions", "/deployments", "/runs", "/designs.csv", *below):
                assert Asking(application)(address).status == 200, address
            application.close()
        with open_database(guest, create=False) as database, pytest.raises(DatabaseError, match="permission denied"):
            record(database, circuits(1, 3))


SETTINGS = [
    *("extra_float_digits = 0", "extra_float_digits = -10", "bytea_output = escape", "client_encoding = LATIN1"),
    *("DateStyle = German", "IntervalStyle = iso_8601", "TimeZone = 'Asia/Kathmandu'", "lc_numeric = 'C'"),
    *("standard_conforming_strings = off", "backslash_quote = on", "default_transaction_read_only = on"),
    *("default_transaction_isolation = serializable", "default_transaction_deferrable = on", "enable_sort = off"),
    *(
        "client_min_messages = debug1",
        "row_security = off",
        "search_path = '$user', public",
        "transform_null_equals = on",
    ),
]


@pytest.fixture
def set_otherwise(server, filled):
    """A function that gives the user of the tests settings of their own in the database."""

    def change(setting):
        server.run(f"ALTER ROLE {USER} IN DATABASE {filled} SET {setting}")

    yield change
    server.run(f"ALTER ROLE {USER} IN DATABASE {filled} RESET ALL")


def test_numbers_and_texts_do_not_depend_on_the_settings_of_a_role(server, filled, local, set_otherwise, tmp_path):
    for setting in SETTINGS:
        set_otherwise(setting)
    assert printed(server.url(filled), local[1], tmp_path / "files") == local[0]


@pytest.mark.parametrize("setting", SETTINGS)
def test_no_setting_alone_changes_what_is_read(server, filled, set_otherwise, setting):
    names = "circuit,least_gap,needed_margin,min_clearance,deploy_time"
    with open_readonly(server.url(filled)) as database:
        before = select(database, "untwisted", columns=names), find_design(database, MOVES)
    set_otherwise(setting)
    with open_readonly(server.url(filled)) as database:
        assert (select(database, "untwisted", columns=names), find_design(database, MOVES)) == before
        assert select_sql(database, "SELECT 0.1::float8 + 0.2::float8").rows == ((0.1 + 0.2,),)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("default_transaction_read_only = on", "only reads"),
        ("statement_timeout = 1", "has stopped the statement"),
        ("search_path = nowhere", "has no schema to use"),
    ],
)
def test_settings_with_which_nothing_can_be_written_are_one_line(server, name, url, setting, message):
    server.run(f"ALTER DATABASE {name} SET {setting}")
    done = forking.run(["enumerate", "--grid", "hex", "--n", "10", "--until", "mobility", "--jobs", "1", "--db", url])
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert message in done.stderr
    assert PASSWORD not in done.stderr


def without_encoding(server):
    """The name of a new database whose texts are bytes."""
    name = server.create_database() + "ascii"
    server.run(f"CREATE DATABASE {name} ENCODING 'SQL_ASCII' LOCALE 'C' TEMPLATE template0")
    return name


def test_a_database_without_an_encoding_holds_what_a_file_holds(server, local, tmp_path):
    name = without_encoding(server)
    assert fill(server.url(name)) == local[1]
    assert printed(server.url(name), local[1], tmp_path / "files") == local[0]
    with open_database(server.url(name), create=False) as database:
        record(database, ["hex:é"])
        assert select(database, columns="circuit", sort="-id", limit=1).rows == (("hex:é",),)
    server.drop_database(name)


def test_bytes_that_are_no_text_in_such_a_database_are_one_line(server, local):
    name = without_encoding(server)
    fill(server.url(name))
    server.run("UPDATE design SET \"array\" = 'x' || chr(255)", name)
    with open_readonly(server.url(name)) as database:
        with pytest.raises(HcsearchError, match="holds what is no text") as caught:
            select(database)
        assert "\n" not in str(caught.value)
        assert select(database, columns="id", limit=1).rows == ((1,),)
    server.drop_database(name)
