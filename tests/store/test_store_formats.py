import csv
import io
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from store_samples import as_rows

from hcsearch.basics.errors import QueryError
from hcsearch.store import FORMATS, Result, format_rows

TEXTS = [style for style in FORMATS if style != "parquet"]

RESULT = Result(
    ("id", "score", "circuit", "status"),
    ((1, 0.5, "hex:0123", None), (20, None, 'a "b", c', "locked")),
)
CELLS = st.one_of(st.none(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), st.text())
RESULTS = st.integers(1, 4).flatmap(
    lambda width: st.builds(
        Result,
        st.lists(st.text(min_size=1), min_size=width, max_size=width, unique=True).map(tuple),
        st.lists(st.tuples(*[CELLS] * width), max_size=5).map(tuple),
    )
)


def format_result(result, style, chunk=2):
    """The text of a result that comes in chunks."""
    return "".join(format_rows(as_rows(result, chunk=chunk), style))


def test_table():
    assert format_result(RESULT, "table") == (
        "  id    score  circuit    status\n"
        "----  -------  ---------  --------\n"
        "   1      0.5  hex:0123   -\n"
        '  20        -  a "b", c   locked\n'
    )


def test_markdown():
    assert format_result(Result(("a|b", "n"), (("x|y", 12), (None, None))), "markdown") == (
        "| a\\|b   |   n |\n|:-------|----:|\n| x\\|y   |  12 |\n| -      |   - |\n"
    )


def test_csv():
    assert format_result(RESULT, "csv") == ('id,score,circuit,status\n1,0.5,hex:0123,\n20,,"a ""b"", c",locked\n')


def test_json():
    assert json.loads(format_result(RESULT, "json")) == [
        {"id": 1, "score": 0.5, "circuit": "hex:0123", "status": None},
        {"id": 20, "score": None, "circuit": 'a "b", c', "status": "locked"},
    ]


@pytest.mark.parametrize("style", TEXTS)
def test_integers_beside_null_stay_integers(style):
    text = format_result(Result(("n", "m"), ((12, None), (None, 10**15), (0, 7))), style)
    assert "12" in text
    assert str(10**15) in text
    assert "." not in text


@pytest.mark.parametrize("style", TEXTS)
def test_texts_that_look_like_numbers_stay_texts(style):
    assert "0123" in format_result(Result(("circuit",), (("0123",), ("1e5",))), style)
    assert "1e5" in format_result(Result(("circuit",), (("0123",), ("1e5",))), style)


@pytest.mark.parametrize(("style", "lines"), [("table", 2), ("csv", 1), ("json", 1), ("markdown", 2)])
def test_no_rows(style, lines):
    text = format_result(Result(("id", "n"), ()), style)
    assert text.endswith("\n")
    assert text.count("\n") == lines
    assert ("id" in text) == (style != "json")


@pytest.mark.parametrize("style", TEXTS)
def test_values_that_only_sql_knows(style):
    text = format_result(Result(("x", "y"), ((b"\x01\xff", float("inf")),)), style)
    assert "01ff" in text
    assert "inf" in text
    if style == "json":
        assert json.loads(text) == [{"x": "01ff", "y": "inf"}]


def test_json_needs_different_names():
    with pytest.raises(QueryError, match="rename one with AS"):
        format_result(Result(("n", "n"), ((1, 2),)), "json")
    assert format_result(Result(("n", "n"), ((1, 2),)), "csv") == "n,n\n1,2\n"


def test_unknown_format():
    with pytest.raises(QueryError, match="choose one of table, csv, json, markdown, parquet"):
        format_result(RESULT, "xml")


def test_parquet_is_no_text():
    with pytest.raises(QueryError, match="name a file for it with --output FILE"):
        format_result(RESULT, "parquet")


@given(RESULTS, st.sampled_from(TEXTS), st.integers(1, 6))
def test_chunks_do_not_show(result, style, chunk):
    assert format_result(result, style, chunk) == format_result(result, style, 100)


@given(RESULTS)
def test_json_round_trip(result):
    rows = json.loads(format_result(result, "json"))
    assert rows == [dict(zip(result.columns, row, strict=True)) for row in result.rows]


@given(RESULTS)
def test_csv_round_trip(result):
    header, *rows = csv.reader(io.StringIO(format_result(result, "csv"), newline=""))
    assert tuple(header) == result.columns
    assert [tuple(row) for row in rows] == [
        tuple("" if value is None else str(value) for value in row) for row in result.rows
    ]


@given(RESULTS)
def test_a_row_is_a_line(result):
    assert format_result(result, "table").count("\n") == 2 + len(result.rows)
    assert format_result(result, "markdown").count("\n") == 2 + len(result.rows)
