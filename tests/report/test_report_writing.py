import shutil
from dataclasses import asdict

import pytest

from hcsearch.basics.errors import OutputError, QueryError, SceneError
from hcsearch.designs.grid import GRIDS, parse_array
from hcsearch.designs.records import Trial
from hcsearch.scenes import Scene
from hcsearch.search.enumeration import ArraySearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import open_database, open_readonly, select
from hcsearch.web.report.data import fetch_report_data
from hcsearch.web.report.page_files import write_report
from hcsearch.web.report.templating import scene_option_text
from tests.judging import judge


@pytest.fixture
def database(database_file):
    with open_readonly(str(database_file)) as opened:
        yield opened


def counts(data):
    return {stage.label: stage.count for stage in data.funnel}


def test_the_funnel_counts_what_the_query_selects(database):
    assert counts(fetch_report_data(database, "grid=hex n=8", limit=None)) == {
        "fixed circuits": 123,
        "arrays": 14,
        "non-isomorphic circuits": 16,
        "two-stack": 2,
        "untwisted": 1,
        "movable": None,
        "deployed by springs": None,
    }
    untwisted = fetch_report_data(database, "grid=hex n=8 untwisted", limit=None)
    assert [stage.count for stage in untwisted.funnel][1:] == [1, 1, 1, 1, None, None]


def test_stages_that_have_not_run_are_not_known(database):
    data = fetch_report_data(database, "grid=hex n=10", limit=5)
    assert list(counts(data).values())[2:] == [120, None, None, None, None]
    assert data.census == [(None, None, 120)]
    assert (len(data.designs), data.total) == (5, 120)


def test_twisted_designs_alone_are_known_not_to_deploy(database):
    funnel = counts(fetch_report_data(database, "grid=hex n=8 untwisted=0", limit=None))
    assert (funnel["movable"], funnel["deployed by springs"]) == (0, 0)


def test_the_best_designs_come_first_with_their_foldings(database):
    data = fetch_report_data(database, "grid=hex n=8", limit=3)
    assert [(d["untwisted"], d["two_stack"]) for d in data.designs] == [(1, 1), (0, 1), (0, 0)]
    assert sorted(data.foldings) == sorted(d["id"] for d in data.designs if d["two_stack"])
    assert all(len(data.foldings[d["id"]]) == d["n_foldings"] for d in data.designs[:2])


def test_the_page_says_what_was_searched_and_what_was_left_out(database):
    data = fetch_report_data(database, "grid=rectangle", limit=None)
    meta = dict(data.meta)
    assert (meta["grid"], meta["n"], meta["array"], meta["kept"]) == (
        "rectangle",
        "16",
        "rectangle:f.f.f.f",
        "untwisted",
    )
    assert data.title == "16 thick rectangles in one array"
    assert data.sentence == "All 4 designs fold without twist; their motion has not been searched for."
    assert data.size == (60, 30)
    assert "kept only untwisted designs" in data.notes[0]
    assert not fetch_report_data(database, "grid=hex n=8", limit=None).notes


def test_a_report_of_no_designs_is_refused(database, tmp_path):
    data = fetch_report_data(database, "n=99", limit=None)
    assert set(counts(data).values()) == {0}
    with pytest.raises(QueryError, match="no design satisfies 'n=99': n is from 8 to 16 here"):
        write_report(database, "n=99", tmp_path / "new" / "none.html")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def scenes(database_file, tmp_path):
    """That database, judged in four scenes; its own is called `flat`, another one has panels of 80 x 20."""
    path = shutil.copy(database_file, tmp_path)
    with open_database(str(path), create=False) as opened:
        number, name = select(opened, "grid=hex n=8 untwisted", columns="id,circuit").rows[0]
        (crease,) = select(opened, f"design_id={number} untwisted", columns="crease", view="foldings").rows[0]
        judge(opened, [(name, crease, "deploys", 0.5, 1.25)])
        result = "constrained", "undecided", "moving at 1 s", None, None, None, 0.0, 0.0
        tried = Trial(0, "flat", "", *result, "dormand-prince", ("base",), 0.4)
        judge(opened, [(name, crease, "undecided", None, None)], "flat", [tried])
        judge(opened, [(name, crease, "movable", None, None)], "driven")
        judge(opened, [], "long")
        four = ArraySearch(parse_array(GRIDS["rectangle"], "4x4"))
        run_into(Plan(four, "twist", keep="untwisted", scene=Scene("long", panel=(0.080, 0.020, 0.006))), opened)
    with open_readonly(str(path)) as opened:
        yield opened


def test_a_report_shows_the_verdicts_of_its_scene(scenes, tmp_path):
    reports = {
        scene: fetch_report_data(scenes, "grid=hex n=8", limit=1, scene=scene)
        for scene in ("default", "driven", "flat")
    }
    shown = {
        scene: [data.designs[0][name] for name in ("status", "deploy_time", "needed_margin")]
        + [counts(data)[name] for name in ("movable", "deployed by springs")]
        for scene, data in reports.items()
    }
    assert shown == {
        "default": ["deploys", 1.25, 0.01, 1, 1],
        "driven": ["movable", None, 0.01, 1, None],  # no springs were tried
        "flat": ["undecided", None, None, 0, 0],
    }
    statuses = [{row["status"] for rows in data.foldings.values() for row in rows} for data in reports.values()]
    assert [words - {"twisted"} for words in statuses] == [{"deploys"}, {"movable"}, {"undecided"}]
    assert [dict(data.meta)["scene"] for data in reports.values()] == ["default", "driven", "flat"]
    assert fetch_report_data(scenes, "deployable", limit=None).total == 1
    assert fetch_report_data(scenes, "deployable", limit=None, scene="driven").total == 1
    assert fetch_report_data(scenes, "deployable", limit=None, scene="flat").total == 0
    for scene, timed, moves in (("default", True, True), ("driven", False, True), ("flat", False, False)):
        page = write_report(scenes, "grid=hex n=8", tmp_path / "page.html", scene=scene).read_text(encoding="utf-8")
        assert ('"deploy_time":[1.25,null' in page, '"needed_margin":[0.01,null' in page) == (timed, moves)
    with pytest.raises(SceneError, match=r"no verdicts of the scene 'moon' in .*: default, driven, flat, long; name"):
        write_report(scenes, "grid=hex n=8", tmp_path / "moon.html", scene="moon")
    assert not (tmp_path / "moon.html").exists()


def test_panels_are_drawn_as_large_as_in_the_scene(scenes):
    sizes = [
        fetch_report_data(scenes, "grid=rectangle", limit=None, scene=scene).size
        for scene in ("flat", "long", "default")
    ]
    assert sizes == [(60, 30), (80, 20), None]  # `default` was not run, and the others do not agree


def test_numbers_of_a_scene_without_results_are_not_known(scenes):
    data = fetch_report_data(scenes, "grid=hex n=8", limit=None, scene="long")
    assert list(counts(data).values())[-3:] == [1, None, None]
    assert data.notes[0].startswith(
        "No motion was searched for in the scene long: --scene names one with results (default,"
    )
    assert not fetch_report_data(scenes, "grid=hex n=8", limit=None).notes


def test_commands_name_the_scene_and_the_file_that_holds_it(database, database_file, monkeypatch):
    where = fetch_report_data(database, "grid=hex n=8", limit=1).database_option
    assert where == f" --db {database_file}"
    assert scene_option_text("solar, hinged", where) == f" --scene 'solar, hinged' --db {database_file}"
    assert scene_option_text("default", where) == ""
    monkeypatch.setenv("HCSEARCH_DB", str(database_file))
    assert fetch_report_data(database, "grid=hex n=8", limit=1).database_option == ""


def test_values_of_a_query_are_data(database):
    data = fetch_report_data(database, "circuit>x'OR'1'='1", limit=None)
    assert data.total == 0
    with pytest.raises(QueryError, match="nosuch"):
        fetch_report_data(database, "nosuch=1", limit=None)


def test_a_report_is_written(database, tmp_path):
    path = write_report(database, "grid=hex n=8", tmp_path / "report.html", limit=10, title="Eight <hexagons>")
    text = path.read_text(encoding="utf-8")
    assert '"count":10,' in text
    assert "first 10 of 16 designs" in text
    assert "<h1>Eight &lt;hexagons&gt;</h1>" in text


def test_bytes_of_a_command_line_that_are_no_text_are_no_crash(database, tmp_path):
    assert write_report(database, "circuit>\udcff", tmp_path / "report.html").is_file()
    with pytest.raises(QueryError, match="no design satisfies") as caught:
        write_report(database, "circuit<\udcff", tmp_path / "none.html")
    str(caught.value).encode()


@pytest.mark.parametrize("where", ["file/report.html", "", "bad\0name"])
def test_a_path_that_cannot_be_written_is_one_clear_line(database, tmp_path, where):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"cannot write|there is no folder|is a folder") as caught:
        write_report(database, "grid=hex n=8", tmp_path / where)
    assert "\n" not in str(caught.value)


def test_only_the_folder_of_reports_is_made(database, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert write_report(database, "n=8", "reports/report.html").is_file()
    with pytest.raises(OutputError, match="there is no folder new: make it, or write to another"):
        write_report(database, "n=8", "new/report.html")
    assert [path.name for path in tmp_path.iterdir()] == ["reports"]


def test_a_database_is_never_overwritten(database, database_file):
    before = database_file.read_bytes()
    with pytest.raises(OutputError, match="it is a database: make room, or name another file"):
        write_report(database, "n=8", database_file)
    assert database_file.read_bytes() == before


def test_data_is_plain(database):
    assert asdict(fetch_report_data(database, "grid=hex n=8", limit=1))["total"] == 16
