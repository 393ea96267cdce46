"""Databases that another program has written nonsense into: one line on a page, and nothing on the terminal."""

import html
import logging
import math
import re
import shutil
import sqlite3
import zlib
from contextlib import closing, contextmanager

import numpy as np
import pytest

from hcsearch.basics.errors import DatabaseError
from hcsearch.store import open_readonly
from tests.serve.asking import Asking

pytestmark = pytest.mark.extra

BELOW = ("", "/export.g6", "/foldings/1/export.fold", "/foldings/1/motion.json")
"""Addresses of a design."""


class Direct:
    """Computes where it is asked, as a process of its own takes long to start, and fails out of sight."""

    def __call__(self, key, call, *arguments):
        return call(*arguments)

    def close(self):
        """Nothing has begun."""


@contextmanager
def damaged(database_file, folder, statement, *values):
    """An application on a copy of the database after a statement."""
    from hcsearch.web.serve.application import Application

    path = folder / "designs.sqlite"
    shutil.copy(database_file, path)
    with closing(sqlite3.connect(path)) as link:
        link.execute(statement, values)
        link.commit()
    with open_readonly(str(path)) as database:
        application = Application(database, str(path))
        application.computing = Direct()
        yield Asking(application)
        application.close()


def reason(answer):
    """The one sentence of a page of an error."""
    return html.unescape(" ".join(re.findall("<p[^>]*>(.*?)</p>", answer.text, re.DOTALL)))


@pytest.mark.parametrize("arguments", ["[1, 2]", "7", "null", '"scene"', "{", "", "[" * 100_000])
def test_arguments_of_a_run_that_are_no_object(database_file, tmp_path, capsys, arguments):
    with damaged(database_file, tmp_path, "UPDATE run SET arguments = ?", arguments) as asking:
        answer = asking("/designs")
        assert answer.status == 500
        assert "is damaged, the arguments of run 1 are no object in JSON: restore a copy" in reason(answer)
        assert asking("/runs").status == asking("/designs?as=table").status == 200
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("panel", ["9" * 400 + "x1x1", "1.2.3x4", "٣x٣x٣", "<b>", "x"])
def test_a_size_of_panels_that_is_none_is_left_out(database_file, tmp_path, panel):
    with damaged(database_file, tmp_path, "UPDATE run SET panel = ?", panel) as asking:
        assert asking("/designs").status == 200


@pytest.mark.parametrize("circuit", ["hex:zzz", "hex:0000", "kagome:012", "", "a\0<script>", "hex:" + "0" * 50_000])
def test_a_circuit_that_is_none(database_file, tmp_path, number, capsys, circuit):
    with damaged(database_file, tmp_path, f"UPDATE design SET circuit = ? WHERE id = {number}", circuit) as asking:
        for below in BELOW:
            answer = asking(f"/designs/{number}{below}")
            assert answer.status == 500
            why = "has more than its 10 panels" if len(circuit) > 100 else "cannot be read"
            assert f"is damaged, the circuit of design {number} {why}: restore a copy" in reason(answer)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("value", [math.inf, -math.inf])
@pytest.mark.parametrize(
    ("table", "column", "lists", "below"),
    [
        ("motion", "needed_margin", ["/designs", "/motions", "/motions.json"], ["", "/foldings/1/motion.json"]),
        ("motion", "least_gap", ["/designs", "/motions", "/motions.csv"], [""]),
        ("verdict", "needed_margin", ["/designs", "/designs.csv", "/foldings?as=table"], [""]),
        ("verdict", "min_clearance", ["/designs?as=table", "/designs.json?limit=100", "/foldings.json"], [""]),
        ("verdict", "deploy_time", ["/designs.json?sort=-deploy_time&limit=1"], [""]),
    ],
)
def test_numbers_that_are_infinite(database_file, tmp_path, number, capsys, table, column, lists, below, value):
    with damaged(database_file, tmp_path, f"UPDATE {table} SET {column} = ?", value) as asking:
        for address in (*lists, *(f"/designs/{number}{end}" for end in below)):
            answer = asking(address)
            assert (answer.status, f"is damaged, column {column} holds what is no" in reason(answer)) == (500, True)
        assert asking("/runs").status == asking(f"/designs/{number}/foldings/1/export.fold").status == 200
    assert capsys.readouterr().err == ""


def packed(values):
    return zlib.compress(np.asarray(values, "<f8").tobytes())


@pytest.mark.parametrize(
    ("path", "states", "message"),
    [
        (packed(np.full((2, 8), math.inf)), 2, "not all of its numbers are fold angles"),
        (packed(np.full((2, 8), -1e300)), 2, "not all of its numbers are fold angles"),
        (packed(np.zeros((2, 8))), 10**18, "16 fold angles are not those of 1000000000000000000 states"),
        (packed(np.zeros((2, 8))), -2, "16 fold angles are not those of -2 states"),
        (packed([]), 0, "0 fold angles are not those of 0 states"),
        (zlib.compress(bytes(9 << 20)), 2, "takes more than 8 MB"),
        (packed(np.zeros((2, 8)))[:-3], 2, "it is cut short"),
        (b"no path", 2, "incorrect header"),
        (b"", 2, "it is cut short"),
    ],
)
def test_paths_that_are_none(database_file, tmp_path, number, capsys, path, states, message):
    change = "UPDATE motion SET path = ?, states = ? WHERE path IS NOT NULL"
    with damaged(database_file, tmp_path, change, path, states) as asking:
        for below in ("", "/foldings/1/motion.json"):
            answer = asking(f"/designs/{number}{below}")
            assert (answer.status, "is damaged: a path cannot be read" in reason(answer)) == (500, True)
            assert message in reason(answer)
        assert asking("/designs").status == asking("/motions").status == 200
    assert capsys.readouterr().err == ""


def test_a_path_that_expands_to_fill_memory_is_read_no_further_than_a_path_is_long(database_file, tmp_path):
    import tracemalloc

    packing = zlib.compressobj()
    bomb = b"".join(packing.compress(bytes(1 << 24)) for _ in range(16)) + packing.flush()
    with damaged(database_file, tmp_path, "UPDATE motion SET path = ? WHERE path IS NOT NULL", bomb) as asking:
        from hcsearch.store.judgements import MAX_PATH_BYTES, find_paths

        tracemalloc.start()
        try:
            with pytest.raises(DatabaseError, match="takes more than"):
                find_paths(asking.application.database, range(1, 200))
            assert tracemalloc.get_traced_memory()[1] < 3 * MAX_PATH_BYTES
        finally:
            tracemalloc.stop()


def test_a_path_of_a_folding_that_the_design_does_not_have(database_file, tmp_path, number, capsys):
    with damaged(database_file, tmp_path, "UPDATE motion SET crease = 77") as asking:
        answer = asking(f"/designs/{number}")
        assert (answer.status, "is damaged: its path of folding 77 of" in reason(answer)) == (500, True)
        assert asking(f"/designs/{number}/foldings/1/motion.json").status == 404
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("column", ["n", "symmetry", "n_fixed"])
def test_numbers_beyond_all_sizes_are_shown(database_file, tmp_path, number, capsys, column):
    change = f"UPDATE design SET {column} = {10**18}, array_symmetry = {10**18}"
    with damaged(database_file, tmp_path, change) as asking:
        for address in ("/designs", "/designs?as=table", "/designs.json", f"/designs/{number}"):
            assert asking(address).status == 200, address
        assert str(10**18) in asking("/designs.csv").text
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("table", "column", "address"),
    [
        ("design", "array", "/designs"),
        ("design", "array", "/designs.csv"),
        ("design", "grid", "/designs.json?limit=3"),
        ("motion", "reason", "/motions"),
        ("motion", "reason", "/motions.csv"),
        ("run", "arguments", "/runs?as=table"),
        ("motion", "reason", "/designs"),
    ],
)
def test_bytes_that_are_no_text(database_file, tmp_path, capsys, table, column, address):
    with damaged(database_file, tmp_path, f"UPDATE {table} SET {column} = CAST(x'ff6162' AS TEXT)") as asking:
        answer = asking(address)
        assert answer.status == 500
        assert f"is damaged (Could not decode to UTF-8 column '{column}'" in reason(answer)
        assert asking("/deployments").status == 200
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("values", ["[[[", "panel = 7", "a = " + "[" * 100_000, "density = inf"])
def test_a_scene_that_is_none(database_file, tmp_path, number, capsys, values):
    with damaged(database_file, tmp_path, "UPDATE scene SET scene_values = ? WHERE name = 'solar'", values) as asking:
        answer = asking(f"/designs/{number}?scene=solar")
        assert (answer.status, "is damaged, " in reason(answer)) == (500, True)
        assert asking(f"/designs/{number}").status == asking("/designs?scene=solar").status == 200
    assert capsys.readouterr().err == ""


def test_a_file_of_rows_ends_at_a_damaged_one_and_gives_its_room_back(database_file, tmp_path, monkeypatch):
    monkeypatch.setattr("hcsearch.store.rows.FETCH_CHUNK_ROWS", 20)
    change = "UPDATE design SET array = CAST(x'ff' AS TEXT) WHERE id > 100"
    with damaged(database_file, tmp_path, change) as asking:
        for _ in range(4):  # one more than there is room for
            with pytest.raises(DatabaseError, match="is damaged"):
                asking("/designs.csv")
        assert asking("/designs.csv?q=id<100").status == 200


def test_the_terminal_says_in_one_line_why_an_answer_was_cut_off(caplog):
    from hcsearch.web.serve.server import shorten_log_record

    logger = logging.getLogger("waitress")
    logger.addFilter(shorten_log_record)
    try:
        for error in (DatabaseError("database x is damaged"), ZeroDivisionError("a fault")):
            try:
                raise error
            except ArithmeticError:
                logger.exception("Exception while serving /designs.csv")
            except DatabaseError:
                logger.exception("Exception while serving /designs.csv")
    finally:
        logger.removeFilter(shorten_log_record)
    cut, fault = caplog.records
    assert (cut.getMessage(), cut.exc_info) == (
        "hcsearch: Exception while serving /designs.csv: database x is damaged",
        None,
    )
    assert fault.exc_info[0] is ZeroDivisionError
