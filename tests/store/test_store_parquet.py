"""Parquet files hold what the query gave; they need pyarrow, so these tests run with the slow ones."""

import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from store_samples import as_rows, begin, circuits, record

from hcsearch.basics.errors import QueryError
from hcsearch.store import Result, open_database, open_readonly, result_files, save_rows, select, stream, stream_sql
from hcsearch.store.columns import DESIGN_QUANTITIES

pytestmark = pytest.mark.extra

INTEGERS = st.none() | st.integers(-(2**63), 2**63 - 1)
REALS = st.none() | st.floats(allow_nan=False)
TEXTS = st.none() | st.text(st.characters(exclude_categories=["Cs"]))
COLUMNS = {"integer": INTEGERS, "boolean": st.none() | st.sampled_from([0, 1]), "real": REALS, "text": TEXTS}
BYTES = st.none() | st.binary(max_size=5)


@st.composite
def tables(draw):
    """Kinds of columns and rows of such values."""
    kinds = draw(st.lists(st.sampled_from(sorted(COLUMNS)), min_size=1, max_size=4))
    rows = draw(st.lists(st.tuples(*(COLUMNS[kind] for kind in kinds)), max_size=9))
    return Result(tuple(f"c{k}" for k in range(len(kinds))), tuple(rows)), tuple(kinds)


def saved(path, result, kinds=None, chunk=2):
    """What a reader finds in the file of a result: schema and rows."""
    import pyarrow.parquet

    save_rows(as_rows(result, kinds, chunk), "parquet", path)
    table = pyarrow.parquet.read_table(path)
    return table, [tuple(row.values()) for row in table.to_pylist()]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("parquet") / "out.parquet"


@given(tables(), st.integers(1, 4))
@settings(max_examples=60)
def test_round_trip_of_known_kinds(place, table, chunk):
    result, kinds = table
    stored, rows = saved(place, result, kinds, chunk)
    assert rows == list(result.rows)
    types = {"integer": "int64", "boolean": "int64", "real": "double", "text": "string"}
    assert [str(kind) for kind in stored.schema.types] == [types[kind] for kind in kinds]


@given(st.lists(st.tuples(INTEGERS, REALS, TEXTS, BYTES, st.none()), max_size=9), st.integers(1, 4))
@settings(max_examples=60)
def test_round_trip_of_kinds_to_be_found(place, rows, chunk):
    """As after --sql: a column that begins with NULLs, or is nothing else."""
    result = Result(("i", "r", "t", "b", "n"), tuple(rows))
    table, back = saved(place, result, None, chunk)
    assert back == rows
    expected = ("int64", "double", "string", "binary")
    for kind, name, at in zip(table.schema.types, expected, range(4), strict=False):
        assert str(kind) == ("null" if all(row[at] is None for row in rows) else name)
    assert str(table.schema.types[4]) == "null"


@pytest.mark.parametrize(
    ("values", "kind", "expected"),
    [
        ([None, 1, 2.5], "double", [None, 1.0, 2.5]),
        ([1, "x", None], "string", ["1", "x", None]),
        ([2**63, 1], "string", [str(2**63), "1"]),
        ([b"\xff", "x"], "string", ["ff", "x"]),
        ([float("inf"), 2**60 + 1], "double", [float("inf"), float(2**60 + 1)]),
    ],
)
def test_mixtures(place, values, kind, expected):
    table, rows = saved(place, Result(("x",), tuple((value,) for value in values)), None, 1)
    assert str(table.schema.types[0]) == kind
    assert [value for (value,) in rows] == expected


def test_rows_are_written_in_groups(place, monkeypatch):
    import pyarrow.parquet

    monkeypatch.setattr(result_files, "_GROUP", 4)
    result = Result(("n",), tuple((k,) for k in range(10)))
    assert saved(place, result, ("integer",), 3)[1] == list(result.rows)
    assert pyarrow.parquet.ParquetFile(place).metadata.num_row_groups == 3


@pytest.fixture
def reader(path):
    with open_database(str(path), create=True) as database:
        record(database, circuits(1, 1500), until="circuits")
        record(database, circuits(1501, 1500), prefix="q")
        begin(database)
    with open_readonly(str(path)) as opened:
        yield opened


def test_a_query_and_sql_give_the_same_file(reader, tmp_path):
    import pyarrow.parquet

    with stream(reader) as rows:
        save_rows(rows, "parquet", tmp_path / "a.parquet")
    with stream_sql(reader, "SELECT * FROM designs ORDER BY id") as rows:
        save_rows(rows, "parquet", tmp_path / "b.parquet")
    both = [pyarrow.parquet.read_table(tmp_path / name) for name in ("a.parquet", "b.parquet")]
    assert [tuple(row.values()) for row in both[0].to_pylist()] == list(select(reader).rows)
    assert both[0].to_pylist() == both[1].to_pylist()
    assert both[0].schema.names == [quantity.name for quantity in DESIGN_QUANTITIES]
    # The first chunks have no foldings: NULL there, integers after them.
    assert str(both[1].schema.field("n_foldings").type) == "int64"


def test_columns_of_one_name_are_refused(place):
    with pytest.raises(QueryError, match="parquet cannot hold: rename"):
        saved(place, Result(("n", "n"), ((1, 2),)))


def test_command_line(reader, path, tmp_path):
    words = [sys.executable, "-m", "hcsearch", "query", "n_foldings=2", "--db", str(path), "--format", "parquet"]
    done = subprocess.run([*words, "--output", "o.parquet"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "o.parquet\n"
    import pyarrow.parquet

    assert pyarrow.parquet.read_table(tmp_path / "o.parquet").num_rows == 1000
    assert [file for file in Path(tmp_path).iterdir() if file.name.endswith(".part")] == []
