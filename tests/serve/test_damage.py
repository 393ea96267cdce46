"""Databases that another program has written nonsense into: one line on a page, and nothing on the terminal."""

import html
import re
import shutil
import sqlite3
from contextlib import closing, contextmanager

import pytest

from hcsearch.store import open_readonly
from tests.serve.asking import Asking

pytestmark = pytest.mark.extra


@contextmanager
def damaged(database_file, folder, statement, *values):
    """An application on a copy of the database after a statement."""
    from hcsearch.serve import Application

    path = folder / "designs.sqlite"
    shutil.copy(database_file, path)
    with closing(sqlite3.connect(path)) as link:
        link.execute(statement, values)
        link.commit()
    with open_readonly(str(path)) as database:
        application = Application(database, str(path))
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
        for below in ("", "/export.g6", "/foldings/1/export.fold", "/foldings/1/motion.json"):
            answer = asking(f"/designs/{number}{below}")
            assert answer.status == 500
            assert f"is damaged, the circuit of design {number} cannot be read: restore a copy" in reason(answer)
    assert capsys.readouterr().err == ""
