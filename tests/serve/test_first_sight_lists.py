"""What stands above a list, its facets, and its columns."""

import csv
import html
import io
import re

import pytest

from hcsearch.store import open_readonly, select
from hcsearch.web.report.data import BEST_FIRST_ORDER
from tests.report.pages import column, data_of
from tests.serve.conftest import MOVES

pytestmark = pytest.mark.extra


def ids(answer):
    return column(data_of(answer.text), "designs", "id")


def heads(answer):
    found = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', answer.text)
    return [html.unescape(re.sub("<[^>]*>", "", text)).strip() for text in found]


def test_a_list_begins_with_a_sentence_and_the_best_design(asking, number):
    answer = asking("/designs")
    assert "<h1>Ten thick hexagons</h1>" in answer.text
    assert '<p class="lead">1 of 120 designs opens by motors; springs have not been tried.</p>' in answer.text
    assert ids(answer)[0] == number
    assert data_of(answer.text)["first"] == 0
    assert 'id="first"' in answer.text
    assert 'id="first"' not in asking("/designs?page=2").text
    assert '<option value="" selected>best first</option>' in answer.text
    assert '<option value="">best first</option>' in asking("/designs?sort=-id").text


def test_long_lists_come_as_stored_and_are_not_counted(asking, monkeypatch):
    monkeypatch.setattr("hcsearch.web.serve.listing.MAX_COUNTED_ROWS", 50)
    answer = asking("/designs?q=n=10 id>0")
    assert ids(answer) == list(range(1, 49))
    assert '<option value="" selected>as stored</option>' in answer.text
    assert ("<h1>Designs</h1>" in answer.text, 'class="lead"' in answer.text) == (True, False)


def test_facets_filter_with_the_query_in_lists_and_files(asking, database_file):
    with open_readonly(str(database_file)) as database:
        array = next(row[0] for row in select(database, f"circuit={MOVES}", columns="array").rows)
        either = select(
            database, "(id>9 or id<4) (status=movable or status=twisted)", columns="id", sort=BEST_FIRST_ORDER
        )
        on_array = select(database, f"array={array} status=movable", columns="id")
    answer = asking("/designs?q=id>9 or id<4&status=movable,twisted")
    assert ids(answer) == [row[0] for row in either.rows][:48]
    rows = csv.DictReader(io.StringIO(asking("/designs.csv?q=id>9 or id<4&status=movable,twisted").text))
    assert [int(row["id"]) for row in rows] == [row[0] for row in either.rows]
    assert ids(asking(f"/designs?array={array}&status=movable")) == [row[0] for row in on_array.rows]
    link = re.search('<a class="chip fold s-twisted" href="([^"]*)" aria-current="true">', answer.text)[1]
    assert html.unescape(link) == "/designs?q=id>9%20or%20id<4&status=movable"
    assert 'name="status" value="movable,twisted"' in answer.text


def test_facets_count_the_designs_that_fit_all_else(asking, database_file):
    text = asking("/designs?status=movable").text
    counts = {name: int(count) for name, count in re.findall(r'fold s-(\w+)"[^>]*>[^<]*<small>(\d+)<', text)}
    with open_readonly(str(database_file)) as database:
        assert counts == {
            status: len(select(database, f"status={status}", columns="id").rows)
            for status in ("movable", "twisted", "no_folding")
        }


@pytest.mark.parametrize(
    "address",
    [
        "/designs?status=a)or(id=1",
        "/designs?n=1 2",
        "/foldings?status=locked",
        "/designs?n=x",
        "/designs?q=n=8) or (n=10&n=10",
    ],
)
def test_what_is_no_facet_is_refused(asking, address):
    assert asking(address).status == 400


def test_columns_are_chosen_for_tables_and_files(asking):
    answer = asking("/designs?as=table&columns=id,min_twist")
    assert heads(answer) == ["id", "least twist"]
    assert "/designs.csv?sort=" not in answer.text
    assert 'href="/designs.csv?columns=id,min_twist"' in answer.text
    assert heads(asking("/designs?as=table"))[:2] == ["id", "status"]
    assert heads(asking("/deployments"))[:1] in ([], ["design id"])
    assert asking("/designs?columns=nosuch").status == 400
    cards = asking("/designs?columns=min_twist").text
    assert 'data-columns="min_twist"' in cards
    assert 'href="/designs.csv?columns=id,circuit,array,status,min_twist"' in cards


def test_heads_of_columns_begin_with_the_better_end(asking):
    text = asking("/designs?as=table").text
    assert 'href="/designs?sort=-symmetry&amp;as=table"' in text
    assert 'href="/designs?sort=dof&amp;as=table"' in text
    assert 'href="/designs?sort=symmetry&amp;as=table"' in asking("/designs?as=table&sort=-symmetry").text


def test_landmarks_have_names_of_their_own_and_headings_come_in_order(asking):
    text = asking("/designs").text
    names = re.findall('<nav[^>]* aria-label="([^"]*)"', text)
    assert len(set(names)) == len(names) == 3
    assert re.findall("<h([1-6])", text) == ["1", "2"]


def test_words_of_cards_are_understood(asking):
    assert asking("/designs?q=Degrees of Freedom <= 6 or least twist = 0&as=table").status == 200
    assert "did you mean dof" in html.unescape(asking("/designs?q=doff<=6").text)
