import operator
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from store_samples import circuits, record
from test_store_verdicts import COLLIDES

from hcsearch.errors import QueryError
from hcsearch.grid import GRIDS
from hcsearch.pipeline import check_keep
from hcsearch.store import open_database, open_readonly, save_scores, schema, select, select_sql
from hcsearch.store.columns import VIEWS, column_names
from tests.judging import judge

NAMED = sorted((Path(__file__).parents[2] / "db").glob("*.sql"))
OPERATORS = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@pytest.fixture(scope="module")
def reader(tmp_path_factory):
    """Designs with every kind of value and NULL in numbers, reals and texts."""
    place = str(tmp_path_factory.mktemp("queries") / "designs.sqlite")
    with open_database(place, create=True) as database:
        record(database, circuits(1, 40))
        record(database, circuits(41, 5), until="circuits")
        with database.writing() as connection:
            for k in range(1, 46):
                values = {
                    "status": [None, "undecided", "locked", "undecided"][k % 4],
                    "best_crease": [None, 3][k % 2],
                    "array": ["hex", "12", "é'\"%"][k % 3],
                }
                connection.execute(schema.design.update().where(schema.design.c.id == k).values(values))
            connection.execute(schema.folding.update().values(dof=schema.folding.c.design_id % 5))
        save_scores(database, {k: (k * 7 % 10) / 4 - 1 for k in range(1, 46) if k % 4})
        names = dict(select(database, "untwisted", columns="id,circuit").rows)
        words = [None, "deploys", None, "collides"]
        judge(database, [(names[k], 3, words[k % 4], k / 8 if k % 4 == 1 else None, 0.5) for k in names if k % 2])
        # another scene, to be told from `default` everywhere
        judge(database, [(name, 3, "undecided", None, None) for name in names.values()], "solar")
        save_scores(database, dict.fromkeys(range(1, 46), 5.0), "solar")
    with open_readonly(place) as opened:
        yield opened


def rows(database, view="designs"):
    result = select(database, view=view)
    return [dict(zip(result.columns, row, strict=True)) for row in result.rows]


def holds(row, name, sign, value):
    """The naive reading of one term."""
    if row[name] is None:
        return False
    return OPERATORS[sign](row[name], value if isinstance(row[name], str) else float(value))


def test_the_example_of_the_manual(reader):
    found = select(reader, "grid=hex n=12 untwisted dof<=6", columns="id").rows
    expected = [r["id"] for r in rows(reader) if r["grid"] == "hex" and r["untwisted"] and r["dof"] is not None]
    assert [row[0] for row in found] == expected
    assert expected


TEXTS = st.sampled_from(["hex", "12", "é'\"%", "deploys", "locked", "'", "x' OR '1'='1", "%", "NULL", "0", "-1"])
NUMBERS = st.one_of(
    st.integers(-3, 14).map(str),
    st.sampled_from(["0.25", "-.5", "1e0", "+2", "99999999999999999999", "1e999", "-1e999", "007"]),
)


@st.composite
def terms(draw, view):
    quantity = draw(st.sampled_from(VIEWS[view]))
    sign = draw(st.sampled_from(sorted(OPERATORS)))
    if quantity.words and sign in ("=", "!="):
        return quantity.name, sign, draw(st.sampled_from(quantity.words))
    return quantity.name, sign, draw(TEXTS if quantity.kind == "text" else NUMBERS)


@pytest.mark.parametrize("view", ["designs", "foldings"])
def test_terms_agree_with_a_naive_filter(reader, view):
    table = rows(reader, view)
    seen = set()

    @given(st.lists(terms(view), max_size=3))
    @settings(max_examples=150, deadline=None, derandomize=True)
    def check(conditions):
        conditions = [(name, sign, value.replace(" ", "")) for name, sign, value in conditions]
        query = " ".join(map("".join, conditions))
        expected = tuple(tuple(row.values()) for row in table if all(holds(row, *term) for term in conditions))
        assert select(reader, query, view=view).rows == expected
        seen.add(len(expected))

    check()
    assert len(seen) > 3  # not only all rows or none


@pytest.mark.parametrize("name", [q.name for q in VIEWS["designs"] if q.kind == "boolean"])
def test_bare_names(reader, name):
    assert select(reader, name).rows == select(reader, f"{name}=1").rows
    assert 0 < len(select(reader, name).rows) < 45


def test_null_satisfies_no_condition(reader):
    for sign in OPERATORS:
        assert not select(reader, f"n_foldings{sign}0 id>40").rows
        assert all(status for (status,) in select(reader, f"status{sign}locked", columns="status").rows)
    assert len(select(reader, "id>40").rows) == 5


@given(st.text(max_size=30))
@settings(max_examples=200)
def test_any_text_is_a_query_or_a_refusal(reader, text):
    try:
        found = select(reader, text).rows
    except QueryError:
        found = ()
    assert len(found) in (0, 45) or text.split()


@given(st.text(st.characters(exclude_categories=["Z", "C"]), max_size=30))
@settings(max_examples=100)
def test_any_value_is_only_compared(reader, value):
    if value and value[0] not in "=<>!":
        expected = sum(row["array"] == value for row in rows(reader)[:45])
        assert len(select(reader, f"array={value}").rows) == expected
        assert len(select(reader, f"array!={value}").rows) == 45 - expected


@pytest.mark.parametrize("value", ["';DROP", "x'--", '"', "1)OR(1=1", "\\", "?", ":a", "%s", "\udcff", "NULL"])
def test_injections_are_values(reader, value):
    assert select(reader, f"array={value}").rows == ()
    assert len(select(reader, f"array!={value}").rows) == 45


@pytest.mark.parametrize(
    ("query", "part"),
    [
        ("foo=1", "choose from id, grid"),
        ("untwistd", "did you mean untwisted"),
        ("kutzbch<3", "did you mean kutzbach"),
        ("ID=1", "no column 'ID'"),
        ("n", "not a yes/no column"),
        ("n = 12", "without spaces"),
        ("n==12", "= != < <= > >="),
        ("n<>12", "= != < <= > >="),
        ("grid==hex", "= != < <= > >="),
        ("grid=", "no value"),
        ("n=twelve", "compared with a number, not with 'twelve'"),
        ("n=12,", "compared with a number"),
        ("n=nan", "compared with a number"),
        ("n=inf", "compared with a number"),
        ("n=1_0", "compared with a number"),
        ("n=١٢", "compared with a number"),
        ("untwisted=yes", "compared with 1 or 0"),
        ("=1", "cannot read '=1'"),
        ("n=1;", "compared with a number"),
        ("1=1", "cannot read"),
        ("n=12 OR n=13", "no column 'OR'"),
        ("grid", "not a yes/no column"),
        ("grid=hexagon", "grid is never 'hexagon' (did you mean hex?): it is one of triangle, square, rectangle, hex"),
        ("grid!=hexx", "did you mean hex?"),
        ("status=deploy", "did you mean deploys"),
        ("status=open", "one of deploys, undecided, collides, locked, twisted, no_folding"),
        ("rowid=1", "no column 'rowid'"),
        ("best_crease=1", "no column 'best_crease'"),
        ("n=6 " * 1500, "cannot be run"),
    ],
)
def test_nonsense_is_refused_with_a_remedy(reader, query, part):
    with pytest.raises(QueryError) as caught:
        select(reader, query)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_names_are_refused(reader):
    with pytest.raises(QueryError, match=r"did you mean designs.*choose one of designs, foldings"):
        select(reader, view="design")
    with pytest.raises(QueryError, match="no column 'scor' in designs"):
        select(reader, sort="-scor")
    with pytest.raises(QueryError, match="no column 'x' in designs"):
        select(reader, columns="id,x")
    with pytest.raises(QueryError, match="negative"):
        select(reader, limit=-1)


def naive_order(table, sort, identity):
    """Sort stably from the last key to the first, each time with NULL last."""
    ordered = sorted(table, key=lambda row: [row[name] for name in identity])
    for term in reversed(sort.split(",")):
        name = term.removeprefix("-")
        known = [row for row in ordered if row[name] is not None]
        # Equal keys keep their order, also backwards.
        known.sort(key=lambda row, name=name: row[name], reverse=term.startswith("-"))
        ordered = known + [row for row in ordered if row[name] is None]
    return ordered


@pytest.mark.parametrize(
    "sort", ["score", "-score", "-score,n_foldings", "array,-score", "-status,-id", "dof", "-dof,array"]
)
def test_order_with_null_last_and_ties_by_id(reader, sort):
    found = [row[0] for row in select(reader, columns="id", sort=sort).rows]
    assert found == [row["id"] for row in naive_order(rows(reader), sort, ["id"])]


@pytest.mark.parametrize("sort", ["twist", "-twist,crease", "-design_id"])
def test_order_of_foldings(reader, sort):
    found = select(reader, columns="design_id,crease", sort=sort, view="foldings").rows
    ordered = naive_order(rows(reader, "foldings"), sort, ["design_id", "crease"])
    assert found == tuple((row["design_id"], row["crease"]) for row in ordered)


def test_columns_and_limit(reader):
    result = select(reader, columns="n, id", limit=2)
    assert (result.columns, result.rows) == (("n", "id"), ((12, 1), (12, 2)))
    assert select(reader, columns=["id"], limit=2).rows == ((1,), (2,))
    assert select(reader, limit=0).rows == ()
    assert select(reader).columns == column_names("designs")
    assert len(select(reader, limit=1000).rows) == 45


def test_one_table_of_quantities():
    for view, quantities in VIEWS.items():
        names = [quantity.name for quantity in quantities]
        assert len(set(names)) == len(names), view
        assert all(re.fullmatch(r"[a-z_]+", name) for name in names)
        assert all(
            quantity.meaning and quantity.kind in ("integer", "boolean", "real", "text") for quantity in quantities
        )


def test_words_are_those_that_the_program_and_the_schema_know():
    words = {(view, quantity.name): quantity.words for view in VIEWS for quantity in VIEWS[view] if quantity.words}
    assert set(words["designs", "grid"]) == set(words["runs", "grid"]) == set(GRIDS)
    for (view, name), known in words.items():
        if name == "status":
            table = schema.metadata.tables[view.removesuffix("s")]
            (check,) = (c for c in table.constraints if c.name == f"ck_{table.name}_status")
            assert set(re.findall(r"'(\w+)'", str(check.sqltext))) == set(known)
    for keep in words["runs", "keep"]:
        check_keep(keep, "twist")


def test_kinds_are_those_of_the_stored_values(reader):
    kinds = {"integer": int, "boolean": int, "real": float, "text": str}
    for view in VIEWS:
        for row in rows(reader, view):
            for quantity in VIEWS[view]:
                value = row[quantity.name]
                assert value is None or type(value) is kinds[quantity.kind], quantity.name
                assert quantity.kind != "boolean" or value in (0, 1, None)


@pytest.mark.parametrize("file", [file for file in NAMED if file.name != "schema.sql"], ids=lambda file: file.stem)
def test_named_queries_run(path, database, file):
    record(database, circuits(1, 3))
    record(database, ["hex:999999"], prefix="q", creases=[[2, 3]], twists=[[0, 0]])
    judge(database, [("hex:999999", 2, "collides", None, None)], trials=[COLLIDES])
    with open_readonly(str(path)) as reader:
        result = select_sql(reader, file.read_text())
    assert result.rows
    assert len(set(result.columns)) == len(result.columns)


def test_there_are_named_queries():
    assert len(NAMED) > 3
