"""Databases that another program wrote into: what no column of ours holds is refused in one line, or does no harm."""

import shutil
import sqlite3
from contextlib import closing

import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch.errors import HcsearchError
from tests.faults.fault_tools import seeded

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
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA writable_schema = 1")
        strict = "replace(replace(sql, ',\n STRICT', ''), 'STRICT', '')"
        connection.execute(f"UPDATE sqlite_schema SET sql = {strict} WHERE type = 'table'")
        connection.commit()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA ignore_check_constraints = 1")
        connection.execute(f'UPDATE OR IGNORE "{table}" SET "{column}" = ?', (value,))
        connection.commit()
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
