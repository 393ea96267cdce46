import csv
import html
import io
import json
import re
import shutil
from urllib.parse import quote
from wsgiref.validate import validator

import pytest

from hcsearch.store import format_rows, open_readonly, select, stream
from hcsearch.store.columns import VIEWS
from hcsearch.web.report.data import BEST_FIRST_ORDER
from tests.report.pages import column, data_of
from tests.serve.asking import Asking

pytestmark = pytest.mark.extra


@pytest.fixture(scope="module")
def database(database_file):
    with open_readonly(str(database_file)) as opened:
        yield opened


def drawn(answer):
    """The data from which a page draws its cards."""
    return data_of(answer.text)


def ids(answer):
    return column(drawn(answer), "designs", "id")


def shown(answer):
    return html.unescape(" ".join(re.search("<output.*?>(.*?)</output>", answer.text, re.DOTALL)[1].split()))


def test_the_first_address_leads_to_the_designs(asking):
    answer = asking("/")
    assert (answer.status, answer.headers["Location"]) == (302, "/designs")


def test_pages_together_are_what_a_query_selects_in_its_order(asking, database):
    for query, sort in (("", ""), ("two_stack", "-symmetry,min_twist"), ("status=movable", ""), ("n=12", "id")):
        listed = []
        for page in range(1, 5):
            answer = asking(f"/designs?q={quote(query)}&sort={sort}&page={page}")
            assert answer.status == 200
            if 'id="data"' in answer.text:
                listed += ids(answer)
        order = sort or BEST_FIRST_ORDER
        assert listed == [row[0] for row in select(database, query, columns="id", sort=order).rows]


def test_a_page_says_where_in_how_many_it_is(asking, monkeypatch):
    assert shown(asking("/designs")) == "1 to 48 of 120"
    assert shown(asking("/designs?page=3")) == "97 to 120 of 120"
    assert shown(asking("/designs?page=4")) == "120"
    assert "ends before this page" in asking("/designs?page=4").text
    assert 'rel="next" href="/designs?q=n=10&amp;page=3"' in asking("/designs?q=n=10&page=2").text
    monkeypatch.setattr("hcsearch.web.serve.listing.MAX_COUNTED_ROWS", 50)
    many = asking("/designs?q=n<11")
    assert shown(many) == "1 to 48 of more than 50"
    assert 'rel="next"' in many.text


def test_every_view_is_a_table_with_what_its_rows_hold(asking, database):
    for view in VIEWS:
        answer = asking(f"/{view}?as=table")
        assert answer.status == 200
        rows = re.findall("<tr><?(?!<th).*?</tr>", answer.text, re.DOTALL)[1:]
        assert len(rows) == min(100, len(select(database, view=view).rows))
    assert 'href="/designs/1"' in asking("/foldings").text + asking("/designs?as=table").text


def test_csv_and_json_are_those_of_queries(asking, database):
    for style in ("csv", "json"):
        for query, rest in (("untwisted", {}), ("", {"sort": "-symmetry", "limit": 7}), ("", {"columns": "id,grid"})):
            more = "".join(f"&{name}={value}" for name, value in rest.items())
            answer = asking(f"/designs.{style}?q={query}{more}")
            with stream(database, query, **{"sort": BEST_FIRST_ORDER, **rest}) as rows:
                assert answer.text == "".join(format_rows(rows, style))
    assert answer.headers["Content-Type"].startswith("application/json")
    assert asking("/designs.csv").headers["Content-Disposition"] == "attachment; filename=designs.csv"


def test_rows_of_a_page_are_those_that_the_page_shows(asking):
    read = list(csv.DictReader(io.StringIO(asking("/designs.csv?sort=-id&page=2").text)))
    assert [int(row["id"]) for row in read] == ids(asking("/designs?sort=-id&page=2"))
    few = json.loads(asking("/designs.json?sort=-id&page=2&columns=id&limit=3").text)
    assert few == [{"id": int(row["id"])} for row in read[:3]]


def test_verdicts_are_those_of_the_scene_that_is_named(asking, number):
    here = drawn(asking(f"/designs?q=id={number}"))
    solar = drawn(asking(f"/designs?q=id={number}&scene=solar"))
    assert (here["designs"]["status"]["all"], solar["designs"]["status"]["all"]) == ("movable", "locked")
    assert (here["pages"], solar["pages"]) == ("/designs/{id}", "/designs/{id}?scene=solar")
    assert asking("/designs?scene=lunar").status == 400
    assert "solar" in asking("/designs?scene=lunar").text


def test_what_is_wrong_with_a_query_stands_beside_it(asking):
    answer = asking("/designs?q=symetry%3E1")
    assert answer.status == 400
    assert "did you mean symmetry" in answer.text
    assert 'value="symetry&gt;1"' in answer.text
    assert asking("/designs.csv?q=symetry%3E1").status == 400
    answer = asking("/designs?q=(n%3C%3D+12")
    assert (answer.status, 'value="(n&lt;= 12"' in answer.text) == (400, True)
    assert asking("/designs.csv?q=(n%3C%3D+12").status == 400


def test_conditions_that_the_page_names_can_be_asked(asking):
    named = re.search("hcsearch query</code>:(.*?) satisfies", asking("/designs").text, re.DOTALL)[1]
    words = re.findall("<code>(.*?)</code>", named, re.DOTALL)
    assert len(words) > 3
    for word in words:
        assert asking(f"/designs?as=table&q={quote(' '.join(html.unescape(word).split()))}").status == 200, word


def test_a_number_finds_its_design(asking, number):
    assert ids(asking(f"/designs?q=n=10+(%23{number})")) == [number]
    assert asking(f"/designs?q=%23{number}x").status == 400


def test_a_list_without_rows_has_no_script_that_draws_them(asking):
    answer = asking("/designs?q=id=99999")
    assert ("Nothing fits." in answer.text, "cards.js" in answer.text) == (True, False)


def test_a_scene_is_named_where_rows_depend_on_it(asking):
    for view in VIEWS:
        assert ("<dt>scene</dt>" in asking(f"/{view}").text) == (view in ("designs", "foldings"))


def test_head_has_the_headers_and_no_body(asking):
    for address in ("/designs", "/designs.csv", "/designs.json", "/nothing"):
        head, full = asking(address, "HEAD"), asking(address)
        assert head.body == b""
        assert (head.status, head.headers["Content-Type"]) == (full.status, full.headers["Content-Type"])


def test_pages_load_scripts_and_styles_from_here_alone(asking):
    page = asking("/designs")
    for address in re.findall('(?:src|href)="(/static/[^"]*)"', page.text):
        answer = asking(address)
        assert answer.status == 200
        assert "immutable" in answer.headers["Cache-Control"]
    assert not re.findall('(?:src|href)="[a-z]*:?//|<script>|<style|style=|onclick', page.text)
    assert "script-src 'self'" in page.headers["Content-Security-Policy"]
    assert page.headers["X-Content-Type-Options"] == "nosniff"


def test_answers_keep_to_the_interface(asking):
    strict = Asking(validator(asking.application))
    for address in ("/", "/designs", "/designs.csv", "/designs.json?limit=3", "/runs", "/nothing", "/designs?q=x"):
        assert strict(address).status < 500
        assert strict(address, "HEAD").body == b""


def test_counts_and_pages_follow_the_database(tmp_path):
    from hcsearch.designs.grid import GRIDS
    from hcsearch.search.enumeration import PolygonSearch
    from hcsearch.search.pipeline import Plan, run_into
    from hcsearch.store import open_database
    from hcsearch.web.serve.application import Application

    path = str(tmp_path / "growing.sqlite")
    with open_database(path, create=True) as writing:
        run_into(Plan(PolygonSearch(GRIDS["square"], 14), "circuits"), writing)
        with open_readonly(path) as reading:
            asking = Asking(Application(reading, path))
            before = shown(asking("/designs"))
            run_into(Plan(PolygonSearch(GRIDS["hex"], 8), "circuits"), writing)
            assert (before, shown(asking("/designs"))) == ("1 to 48 of 86", "1 to 48 of 102")


def test_another_file_in_place_of_the_database_is_refused(database_file, tmp_path, number):
    from hcsearch.web.serve.application import Application

    path = tmp_path / "designs.sqlite"
    shutil.copy(database_file, path)
    with open_readonly(str(path)) as opened:
        asking = Asking(Application(opened, str(path)))
        assert asking("/designs").status == 200
        shutil.copy(database_file, tmp_path / "other.sqlite")
        (tmp_path / "other.sqlite").replace(path)
        for address in ("/designs", "/designs.csv", f"/designs/{number}"):
            answer = asking(address)
            assert (answer.status, "replaced by another program" in answer.text) == (500, True)


def test_streams_are_limited_and_given_back(asking):
    started = [asking.application._streams.start(asking.application.database, *rows()) for _ in range(3)]
    assert asking("/designs.csv").status == 503
    assert asking("/designs").status == 200
    for few in ("page=2", "limit=500", "limit=0"):
        assert asking(f"/designs.csv?{few}").status == 200
    for one in started:
        one.close()
    assert asking("/designs.csv").status == 200


def rows():
    from hcsearch.web.serve.requests import ListRequest

    return ListRequest("designs"), "csv", ""


def test_a_fault_is_reported_in_the_terminal_and_not_on_the_page(asking, monkeypatch, capsys):
    def fails(*_: object) -> None:
        raise RuntimeError("<b>secret</b>")

    monkeypatch.setattr("hcsearch.web.serve.application.read_list_request", fails)
    answer = asking("/designs")
    assert (answer.status, "secret" in answer.text) == (500, False)
    assert "RuntimeError: <b>secret</b>" in capsys.readouterr().err


def test_the_scene_of_the_server_is_the_one_that_addresses_leave_out(database, database_file, number):
    from hcsearch.web.serve.application import Application

    asking = Asking(Application(database, str(database_file), scene="solar"))
    usual, other = asking("/designs"), asking("/designs?scene=default")
    assert (drawn(usual)["scene"], drawn(usual)["pages"]) == ("solar", "/designs/{id}")
    assert (drawn(other)["scene"], drawn(other)["pages"]) == ("default", "/designs/{id}?scene=default")
    assert 'href="/designs?page=2"' in usual.text
    assert 'href="/designs?scene=default&amp;page=2"' in other.text


def test_a_zero_is_a_zero_in_tables_and_an_error_what_it_is():
    from hcsearch.web.serve.template_pages import _cell

    assert [_cell(value, "least_gap") for value in (-9e-14, 1 / 3, None, 7)] == ["0", "0.3333", "-", "7"]
    assert _cell(4.2e-12, "energy_error") == "4.2e-12"
