import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hcsearch.basics.errors import QueryError
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.store import count_rows, open_database, open_readonly, select, select_page
from hcsearch.store.columns import column_names
from tests.judging import judge


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    path = str(tmp_path_factory.mktemp("pages") / "designs.sqlite")
    with open_database(path, create=True) as writing:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist"), writing)
        judge(writing, [("hex:0234435011", 1, "movable", None, None)])
        judge(writing, [("hex:0234435011", 4, "locked", None, None)], "solar", key="p#0/2")
    with open_readonly(path) as opened:
        yield opened


VIEWS = st.sampled_from(("designs", "foldings", "motions", "deployments", "runs"))


@st.composite
def asked(draw):
    view = draw(VIEWS)
    names = st.sampled_from(column_names(view))
    terms = draw(st.lists(st.tuples(st.sampled_from(("", "-")), names), max_size=3))
    query = draw(st.sampled_from(("", "untwisted", "status=movable", "not status=movable")))
    return {
        "query": query if view in ("designs", "foldings") else "",
        "view": view,
        "sort": ",".join(sign + name for sign, name in terms),
        "scene": draw(st.sampled_from(("default", "solar"))),
    }


@given(asked(), st.integers(0, 130), st.integers(0, 130))
@settings(max_examples=60)
def test_a_page_is_a_part_of_what_is_selected(database, asked, skip, count):
    everything = select(database, **asked)
    page = select_page(database, **asked, skip=skip, count=count)
    assert page.columns == everything.columns
    assert page.rows == everything.rows[skip : skip + count]


@given(asked(), st.integers(0, 130))
@settings(max_examples=30)
def test_counts_stop_at_a_number(database, asked, most):
    del asked["sort"]
    assert count_rows(database, **asked, most=most) == min(most, len(select(database, **asked).rows))


def test_a_statement_that_takes_too_long_is_ended_and_the_next_one_is_not(database, monkeypatch):
    monkeypatch.setattr(
        "hcsearch.store.queries.PROGRESS_HANDLER_STEPS", 10
    )  # as 120 designs take less than its usual number
    with pytest.raises(QueryError, match="takes more than 0 s: narrow it"):
        select_page(database, sort="-symmetry", seconds=0)
    with pytest.raises(QueryError, match="takes more than 0 s: narrow it"):
        count_rows(database, "untwisted", most=1000, seconds=0)
    assert len(select_page(database, count=200).rows) == 120


def test_places_beyond_all_numbers_are_empty(database):
    assert select_page(database, skip=10**30).rows == ()
