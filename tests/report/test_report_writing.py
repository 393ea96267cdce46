from dataclasses import asdict

import pytest

from hcsearch.errors import OutputError, QueryError
from hcsearch.report import write_report
from hcsearch.report.fetching import fetch
from hcsearch.store import open_readonly


@pytest.fixture
def database(database_file):
    with open_readonly(str(database_file)) as opened:
        yield opened


def counts(data):
    return {stage.label: stage.count for stage in data.funnel}


def test_the_funnel_counts_what_the_query_selects(database):
    assert counts(fetch(database, "grid=hex n=8", limit=None)) == {
        "fixed circuits": 123,
        "arrays": 14,
        "non-isomorphic circuits": 16,
        "two-stack": 2,
        "untwisted": 1,
        "deployable": None,
    }
    untwisted = fetch(database, "grid=hex n=8 untwisted", limit=None)
    assert [stage.count for stage in untwisted.funnel][1:] == [1, 1, 1, 1, None]


def test_stages_that_have_not_run_are_not_known(database):
    data = fetch(database, "grid=hex n=10", limit=5)
    assert list(counts(data).values())[2:] == [120, None, None, None]
    assert data.census == [(None, None, 120)]
    assert (len(data.designs), data.total) == (5, 120)


def test_twisted_designs_alone_are_known_not_to_deploy(database):
    assert counts(fetch(database, "grid=hex n=8 untwisted=0", limit=None))["deployable"] == 0


def test_the_best_designs_come_first_with_their_foldings(database):
    data = fetch(database, "grid=hex n=8", limit=3)
    assert [(d["untwisted"], d["two_stack"]) for d in data.designs] == [(1, 1), (0, 1), (0, 0)]
    assert sorted(data.foldings) == sorted(d["id"] for d in data.designs if d["two_stack"])
    assert all(len(data.foldings[d["id"]]) == d["n_foldings"] for d in data.designs[:2])


def test_the_page_says_what_was_searched_and_what_was_left_out(database):
    data = fetch(database, "grid=rectangle", limit=None)
    meta = dict(data.meta)
    assert (meta["grid"], meta["n"], meta["array"], meta["kept"]) == (
        "rectangle",
        "16",
        "rectangle:f.f.f.f",
        "untwisted",
    )
    assert data.title == "Designs of array rectangle:f.f.f.f"
    assert data.size == (60, 30)
    assert "kept only untwisted designs" in data.notes[0]
    assert not fetch(database, "grid=hex n=8", limit=None).notes


def test_a_query_without_designs_is_a_result(database, tmp_path):
    data = fetch(database, "n=99", limit=None)
    assert set(counts(data).values()) == {0}
    assert "No designs" in write_report(database, "n=99", tmp_path / "none.html").read_text()


def test_values_of_a_query_are_data(database):
    data = fetch(database, "circuit=x'OR'1'='1", limit=None)
    assert data.total == 0
    with pytest.raises(QueryError, match="nosuch"):
        fetch(database, "nosuch=1", limit=None)


def test_a_report_is_written(database, tmp_path):
    path = write_report(database, "grid=hex n=8", tmp_path / "report.html", limit=10, title="Eight <hexagons>")
    text = path.read_text(encoding="utf-8")
    assert text.count('<li class="card') == 10
    assert "first 10 of 16 designs" in text
    assert "<h1>Eight &lt;hexagons&gt;</h1>" in text


def test_bytes_of_a_command_line_that_are_no_text_are_no_crash(database, tmp_path):
    write_report(database, "circuit=\udcff", tmp_path / "report.html")


@pytest.mark.parametrize("where", ["file/report.html", "", "bad\0name"])
def test_a_path_that_cannot_be_written_is_one_clear_line(database, tmp_path, where):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"cannot write|there is no folder|is a folder") as caught:
        write_report(database, "grid=hex n=8", tmp_path / where)
    assert "\n" not in str(caught.value)


def test_only_the_folder_of_reports_is_made(database, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert write_report(database, "n=99", "reports/report.html").is_file()
    with pytest.raises(OutputError, match="there is no folder new: make it, or write to another"):
        write_report(database, "n=99", "new/report.html")
    assert [path.name for path in tmp_path.iterdir()] == ["reports"]


def test_a_database_is_never_overwritten(database, database_file):
    before = database_file.read_bytes()
    with pytest.raises(OutputError, match="it is a database: make room, or name another file"):
        write_report(database, "n=99", database_file)
    assert database_file.read_bytes() == before


def test_data_is_plain(database):
    assert asdict(fetch(database, "grid=hex n=8", limit=1))["total"] == 16
