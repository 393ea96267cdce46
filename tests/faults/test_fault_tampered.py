"""Databases that another program wrote into: what no column of ours holds is refused in one line, or does no harm."""

import math
import shutil
import sqlite3
import zlib
from contextlib import closing

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.designs.records import Trial
from hcsearch.store import find_design, open_database
from tests.faults.fault_tools import seeded
from tests.judging import judge
from tests.loosening import loosened

ENUMERATE = "enumerate --grid hex --n 8 --until mobility --db"
COMMANDS = (
    "query",
    "query --format csv",
    "query n>4 -s -dof --format markdown",
    "query --sql SELECT|*|FROM|designs",
    "query --sql SELECT|*|FROM|runs",
    "show {id}",
    "report --output page.html",
    "rank",
    "rank --save",
)
HOSTILE = "x\x1b]0;owned\x07\x9b31m\nyy"
VALUES = (HOSTILE, b"\xff\x00", 1.5, -3, 10**18, None)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small database, its columns, and the id of a design that folds."""
    path = tmp_path_factory.mktemp("tampered") / "designs.sqlite"
    assert CliRunner().invoke(hcsearch, [*ENUMERATE.split(), str(path)]).exit_code == 0
    with closing(sqlite3.connect(path)) as connection:
        values = connection.execute(
            "SELECT t.name, c.name, c.type FROM sqlite_schema AS t, pragma_table_info(t.name) AS c"
            " WHERE t.type = 'table' AND t.name NOT LIKE 'sqlite%'"
        ).fetchall()
        folding = connection.execute("SELECT design_id FROM folding WHERE twist = 0").fetchone()[0]
    return path, values, folding


def tampered(made, folder, table, column, value):
    """A copy with one column overwritten in all rows; tables that are STRICT no more let that be."""
    path = folder / "designs.sqlite"
    shutil.copy(made[0], path)
    with loosened(path) as connection:
        connection.execute(f'UPDATE OR IGNORE "{table}" SET "{column}" = ?', (value,))
    return path


def survive(made, folder, *change):
    """Run all commands on such a copy; whether one has refused it."""
    refused = False
    for words in (*COMMANDS, ENUMERATE.removesuffix(" --db")):
        path = tampered(made, folder, *change)
        listed = [word.replace("|", " ").format(id=made[2]) for word in words.split()]
        done = CliRunner().invoke(hcsearch, [*listed, "--db", str(path)])
        if done.exception is not None:
            assert isinstance(done.exception, HcsearchError), (change, words, done.exception)
            assert "\n" not in str(done.exception)
            refused = True
        if "csv" not in words:
            assert not set(done.output + str(done.exception)) & set("\x1b\x07\x9b"), (change, words)
    return refused


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("table", "column"),
    [("design", "n_foldings"), ("folding", "crease"), ("batch", "passed"), ("hcsearch_version", "version_num")],
)
def test_text_where_numbers_belong_is_refused(made, folder, tally, table, column):
    assert survive(made, folder, table, column, HOSTILE)
    tally("tampered database", 1, 0, 0)


def test_bytes_for_the_number_of_the_schema_are_refused(made, folder, tally):
    assert survive(made, folder, "hcsearch_version", "version_num", b"\xff\x00")
    tally("tampered database", 1, 0, 0)


def test_tables_show_no_control_characters_and_csv_keeps_them(made, folder):
    path = tampered(made, folder, "design", "array", HOSTILE)
    table = CliRunner().invoke(hcsearch, ["query", "--db", str(path), "-c", "array"])
    assert "x\\x1b]0;owned\\x07\\x9b31m yy" in table.output
    text = CliRunner().invoke(hcsearch, ["query", "--db", str(path), "-c", "array", "--format", "csv"])
    assert HOSTILE in text.output


@pytest.mark.parametrize("how_many", [6, pytest.param(80, marks=pytest.mark.slow)])
def test_no_value_of_a_column_is_a_traceback(made, folder, tally, how_many):
    # a number that stands for the row holds nothing but integers, whatever the schema says
    changes = [(table, column, value) for table, column, _ in made[1] if column != "id" for value in VALUES]
    for change in seeded("tampered").sample(changes, how_many):
        survive(made, folder, *change)
        tally("tampered database", 1, 0, 0)


@pytest.mark.parametrize("table", ["run", "design"])
def test_a_number_after_which_none_is_left_is_damage(made, folder, table):
    path = folder / "designs.sqlite"
    shutil.copy(made[0], path)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(f"UPDATE {table} SET id = {2**63 - 1} WHERE id = 1")
        connection.commit()
    done = CliRunner().invoke(hcsearch, [*ENUMERATE.replace("8", "10").split(), str(path)])
    assert isinstance(done.exception, HcsearchError)
    assert f"is damaged, column id of {table} holds" in str(done.exception)


MOVES = "hex:0234435011"
"""Has foldings at 1, 3 and 4; that at 1 moves in what follows."""
RING = f"square:{4999 * chr(48)}1{4999 * chr(50)}3"
"""A circuit of 10,000 panels."""
ASKED = {
    "query": "query -c id,circuit,array,needed_margin,min_clearance",
    "csv": "query --format csv",
    "best": "query n=10 -s -needed_margin --limit 1 --format json -c needed_margin",
    "runs": "query --sql SELECT|*|FROM|runs",
    "motions": "query --sql SELECT|*|FROM|motions",
    "rank": "rank",
    "save": "rank --save",
    "show": "show {id}",
    "page": "show {id} --html --output page.html",
    "report": "report --output page.html",
    "motion": "export {id}:1 --motion path --output path.csv",
    "folding": "export {id}:1 --output folding.fold",
    "other": "show {id}:1 --scene solar",
}


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """A database with verdicts in two scenes, paths and deployments that nobody computed; the id of what moves."""
    path = tmp_path_factory.mktemp("judged") / "designs.sqlite"
    enumerate_ = ENUMERATE.replace("8", "10").split()
    assert CliRunner().invoke(hcsearch, [*enumerate_, str(path)]).exit_code == 0
    result = "constrained", "collides", "so it was", None, 0.25, None, 1e-7, 2e-9
    tried = Trial(0, "default", "{}", *result, "dormand-prince", ("base",), 0.4)
    with open_database(str(path), create=False) as database:
        judge(database, [(MOVES, 1, "movable", 0.5, 0.2)], trials=[tried])
        judge(database, [(MOVES, 1, "locked", None, None)], "solar", key="p#0/2")
        return path, find_design(database, MOVES)["id"]


def packed(*states):
    return zlib.compress(np.asarray(states, "<f8").tobytes())


NO_TEXT = "CAST(x'ff6162' AS TEXT)"
READS_MOTION, READS_DESIGN = {"show", "page", "report", "other"}, {"show", "page", "motion", "folding", "other"}
PATH, ARGUMENTS = "UPDATE motion SET path = ?, states = ?", "UPDATE run SET arguments = ?"
DAMAGE = [
    ("UPDATE motion SET needed_margin = ?", [math.inf], "column needed_margin holds what is no real", READS_MOTION),
    ("UPDATE motion SET least_gap = ?", [-math.inf], "column least_gap holds what is no real", READS_MOTION),
    (
        "UPDATE verdict SET needed_margin = ?",
        [math.inf],
        "column needed_margin holds",
        {"best", "query", "rank"},
    ),
    ("UPDATE verdict SET min_clearance = ?", [math.inf], "column min_clearance holds", {"show", "report", "query"}),
    ("UPDATE deployment SET clearance = ?", [math.inf], "column clearance holds what is no real", {"show", "report"}),
    (PATH, [packed([math.inf] * 8, [0.0] * 8), 2], "not all of its numbers are fold angles", {"page", "report"}),
    (PATH, [packed([1e300] * 8, [0.0] * 8), 2], "not all of its numbers are fold angles", {"page", "report"}),
    (PATH, [packed([3.0] * 8, [0.0] * 8), 10**18], "are not those of 1000000000000000000 states", {"page", "report"}),
    (PATH, [packed([3.0] * 8, [0.0] * 8), -1], "are not those of -1 states", {"page", "report"}),
    (PATH, [zlib.compress(bytes(1 << 27)), 2], "takes more than 8 MB", {"page", "report"}),
    (PATH, [packed([3.0] * 7, [0.0] * 7), 2], "has 7 hinges, as no linkage of it", {"page", "report"}),
    ("UPDATE motion SET crease = 77", [], "its path of folding 77 of hex:0234435011", {"page", "report"}),
    (ARGUMENTS, ["[1, 2]"], "the arguments of run 1 are no object in JSON", {"report"}),
    (ARGUMENTS, ["[" * 100_000], "the arguments of run 1 are no object in JSON", {"report"}),
    ("UPDATE design SET circuit = 'kagome:01' WHERE circuit = ?", [MOVES], "the circuit of design", READS_DESIGN),
    ("UPDATE design SET circuit = '' WHERE circuit = ?", [MOVES], "the circuit of design", READS_DESIGN),
    ("UPDATE design SET circuit = ? WHERE circuit = ?", [RING, MOVES], "is damaged", READS_DESIGN | READS_MOTION),
    ("UPDATE design SET n_fixed = ?", [2**62], "is damaged (integer overflow)", {"report"}),
    ("UPDATE scene SET scene_values = ?", ["a = " + "[" * 100_000], "the scene 'solar' cannot be read", {"other"}),
    (f"UPDATE design SET array = {NO_TEXT}", [], "UTF-8 column 'array'", {"query", "csv", "show", "report"}),
    (f"UPDATE design SET circuit = {NO_TEXT} WHERE id = 1", [], "UTF-8 column 'circuit'", {"query", "rank", "report"}),
    (f"UPDATE motion SET reason = {NO_TEXT}", [], "UTF-8 column 'reason'", {"show", "report"}),
    (f"UPDATE scene SET name = {NO_TEXT} WHERE name = 'solar'", [], "UTF-8 column 'name'", {"query", "rank", "show"}),
    (f"UPDATE run SET panel = {NO_TEXT}", [], "UTF-8 column 'panel'", {"report"}),
]
HARMLESS = [
    ("UPDATE design SET n = ?", [10**18]),
    ("UPDATE design SET symmetry = ?1, array_symmetry = ?1", [10**18]),
    ("UPDATE folding SET dof = ?1, kutzbach = ?1, dof_folded = ?1, merged_panels = ?1", [10**18]),
    ("UPDATE outcome SET best_crease = ?", [10**18]),
    ("UPDATE motion SET as_crease = ?", [10**18]),
    ("UPDATE run SET n = ?1, panel = 'infxnanx1', versions = '[', stage_times = '7'", [10**18]),
    ("UPDATE deployment SET scene_values = ?", ["a = " + "[" * 100_000]),
]


def asked_of(judged, folder, statement, values):
    """The refusals of all commands on a copy of the database after a statement, by the name of the command."""
    refusals = {}
    for name, words in ASKED.items():
        path = folder / "designs.sqlite"
        shutil.copy(judged[0], path)
        with closing(sqlite3.connect(path)) as connection:
            connection.execute("PRAGMA ignore_check_constraints = 1")
            connection.execute(statement, values)
            connection.commit()
        listed = [word.replace("|", " ").format(id=judged[1]) for word in words.split()]
        done = CliRunner().invoke(hcsearch, [*listed, "--db", str(path)])
        if done.exception is not None:
            assert isinstance(done.exception, HcsearchError), (statement, words, done.exception)
            refusals[name] = str(done.exception)
    return refusals


@pytest.mark.parametrize(("statement", "values", "message", "refused"), DAMAGE)
def test_a_damaged_row_is_one_line_that_says_so(judged, folder, tally, statement, values, message, refused):
    refusals = asked_of(judged, folder, statement, values)
    assert refusals.keys() >= refused
    for name, text in refusals.items():
        own = "the SQL cannot be run (Could not decode" if name in ("runs", "motions") else "is damaged"
        assert (own in text, message in text, "\n" in text) == (True, True, False), text
    tally("tampered database", 1, 0, 0)


@pytest.mark.parametrize(("statement", "values"), HARMLESS)
def test_numbers_beyond_all_sizes_and_texts_that_nobody_reads_do_no_harm(judged, folder, tally, statement, values):
    assert asked_of(judged, folder, statement, values) == {}
    tally("tampered database", 1, 0, 0)


def test_sql_of_ones_own_that_makes_bytes_into_text_or_adds_too_much_is_not_called_damage(judged):
    for sql, words in (
        ("SELECT CAST(x'ff' AS TEXT)", "Could not decode"),
        ("SELECT sum(x) FROM (SELECT 9223372036854775807 AS x UNION ALL SELECT 1)", "integer overflow"),
    ):
        done = CliRunner().invoke(hcsearch, ["query", "--sql", sql, "--db", str(judged[0])])
        assert f"the SQL cannot be run ({words}" in str(done.exception)
