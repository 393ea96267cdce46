import operator
import re
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from store_samples import circuits, record
from test_store_verdicts import COLLIDES

from hcsearch.basics.errors import HcsearchError, QueryError
from hcsearch.basics.vocabulary import DESIGN_STATUSES, STATUSES, Verdict, Way
from hcsearch.designs.circuit import Circuit
from hcsearch.designs.grid import GRIDS, Array, grid_named, parse_array
from hcsearch.search.enumeration import search_all
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.search.stages.order import check_keep
from hcsearch.store import find_design, open_database, open_readonly, save_scores, schema, select, select_sql
from hcsearch.store.columns import VIEWS, column_names
from hcsearch.store.conditions import with_column_names
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
            connection.execute(schema.run.update().where(schema.run.c.id == 1).values(target="é'\"%"))
        save_scores(database, {k: (k * 7 % 10) / 4 - 1 for k in range(1, 46) if k % 4})
        names = dict(select(database, "untwisted", columns="id,circuit").rows)
        words = [None, "deploys", None, "movable"]
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
    selected = select(reader, "grid=hex n=12 untwisted dof<=6", columns="id").rows
    expected = [r["id"] for r in rows(reader) if r["grid"] == "hex" and r["untwisted"] and r["dof"] is not None]
    assert [row[0] for row in selected] == expected
    assert expected


TEXTS = st.sampled_from(["hex", "12", "é'\"%", "deploys", "locked", "'", "x' OR '1'='1", "%", "NULL", "0", "-1"])
NUMBERS = st.one_of(
    st.integers(-3, 14).map(str),
    st.sampled_from(
        ["0.25", "-.5", "1e0", "+2", "99999999999999999999", "9" * 310, "-" + "9" * 310, "1e999", "-1e999", "007"]
    ),
)


@st.composite
def terms(draw, view):
    quantity = draw(st.sampled_from(VIEWS[view]))
    # equal arrays and circuits are congruent ones: see below
    signs = ["<", "<=", ">", ">="] if quantity.name in ("array", "circuit") else sorted(OPERATORS)
    sign = draw(st.sampled_from(signs))
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


@st.composite
def trees(draw, depth=3):
    """Queries as nested tuples: a term, ("not", tree), ("and", trees) or ("or", trees)."""
    kind = draw(st.sampled_from(["term", "not", "and", "or"])) if depth else "term"
    if kind == "term":
        return draw(terms("designs"))
    if kind == "not":
        return kind, draw(trees(depth - 1))
    return kind, draw(st.lists(trees(depth - 1), min_size=2, max_size=3))


def written(draw, tree, above=""):
    """A tree as text, with brackets where they are needed, and sometimes where not."""
    spaces = st.sampled_from([" ", "  ", "\n"])
    if tree[0] not in ("not", "and", "or"):
        text, needed = "".join(tree), False
    elif tree[0] == "not":
        text, needed = (
            draw(st.sampled_from(["not", "NOT", "Not"])) + draw(spaces) + written(draw, tree[1], "not"),
            False,
        )
    else:
        words = {"and": ["", "and", "AND"], "or": ["or", "OR"]}[tree[0]]
        parts = [written(draw, part, tree[0]) for part in tree[1]]
        text = parts[0]
        for part in parts[1:]:
            text += f"{draw(spaces)}{draw(st.sampled_from(words))}{draw(spaces)}{part}"
        needed = above == "not" or (above == "and" and tree[0] == "or")
    return f"({draw(st.sampled_from(['', ' ']))}{text})" if needed or draw(st.integers(0, 4)) == 0 else text


def naive(row, tree):
    """Whether a row satisfies a tree; None where a value is not known (Kleene's logic, which SQL has)."""
    if tree[0] == "not":
        inner = naive(row, tree[1])
        return None if inner is None else not inner
    if tree[0] not in ("and", "or"):
        return None if row[tree[0]] is None else holds(row, *tree)
    truths = [naive(row, part) for part in tree[1]]
    decided = tree[0] == "or"
    return decided if decided in truths else None if None in truths else not decided


def test_and_or_not_and_brackets_agree_with_a_naive_reading(reader):
    table = rows(reader)
    seen = set()

    @given(st.data(), trees())
    @settings(max_examples=120, deadline=None, derandomize=True)
    def check(data, tree):
        tree = without_spaces(tree)
        expected = tuple(tuple(row.values()) for row in table if naive(row, tree))
        assert select(reader, written(data.draw, tree)).rows == expected
        seen.add(len(expected))

    check()
    assert len(seen) > 6


def without_spaces(tree):
    if tree[0] == "not":
        return "not", without_spaces(tree[1])
    if tree[0] in ("and", "or"):
        return tree[0], [without_spaces(part) for part in tree[1]]
    return tuple(part.replace(" ", "") for part in tree)


@pytest.mark.parametrize(
    ("query", "same"),
    [
        ("id<3 or id>43", ("id", {1, 2, 44, 45})),
        ("id<9 id>4 or id=1", ("id", {1, 5, 6, 7, 8})),
        ("id=1 or id>4 and id<9", ("id", {1, 5, 6, 7, 8})),
        ("(id=1 or id>4)id<9", ("id", {1, 5, 6, 7, 8})),
        ("(id=1)or(id=2)", ("id", {1, 2})),
        ("NOT id>2", ("id", {1, 2})),
        ("not not id<=2", ("id", {1, 2})),
        ("not(id>2 or id=1)", ("id", {2})),
        ("not id>2 id!=1", ("id", {2})),
        ("ID <= 2", ("id", {1, 2})),
        ("(Panels = 12 or PANELS=13) Circuit>x", ("id", set())),
        ("untwisted Or id<2 aNd id<4", ("id", {1, 3, 6, 9, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39})),
    ],
)
def test_words_and_brackets_by_example(reader, query, same):
    name, values = same
    assert {row[0] for row in select(reader, query, columns=name).rows} == values


@pytest.mark.parametrize(
    ("query", "same"),
    [
        ("degrees of freedom <= 6", "dof<=6"),
        ("Time  to FLAT<1", "deploy_time<1"),
        ("untwisted foldings>1", "n_untwisted>1"),
        ("untwisted (foldings>1)", "untwisted (n_foldings>1)"),
        ("not Two-Stack", "not two_stack"),
        ("clearance > 1 clearance<9", "min_clearance>1 min_clearance<9"),
        ("circuit=foldings", "circuit=foldings"),
        ("freedoms, merged>=2", "dof_merged>=2"),
        ("dofs<=6 xdof<6", "dofs<=6 xdof<6"),
        ("\u017ftatus=locked", "\u017ftatus=locked"),
        (" " * 9 + "n" + " " * 9, " " * 9 + "n" + " " * 9),
    ],
)
def test_labels_of_pages_are_names_of_columns(query, same):
    assert with_column_names(query, "designs") == same


@pytest.mark.parametrize("view", VIEWS)
def test_every_label_stands_for_its_own_column(view):
    for quantity in VIEWS[view]:
        for text in (quantity.name, quantity.title, quantity.title.upper()):
            assert with_column_names(f"{text} = 1", view) == f"{quantity.name}=1"


def test_what_is_unknown_satisfies_neither_a_condition_nor_its_opposite(reader):
    assert select(reader, "not status=locked").rows == select(reader, "status!=locked").rows
    assert select(reader, "status=locked or not status=locked").rows == select(reader, "status>a").rows
    assert 0 < len(select(reader, "not deployable or deployable").rows) < 45


def test_brackets_within_a_value_belong_to_it(reader):
    for query, count in (("target=a(b)c", 0), ("(target!=a(b))", 4), ("not(target=(x))", 4), ("target!=(x)OR(1=1)", 4)):
        assert len(select(reader, query, view="runs").rows) == count


@pytest.fixture(scope="module")
def stored_arrays(tmp_path_factory):
    """Designs of real circuits: of 10 hexagons, and on rectangles of squares and of rectangles."""
    place = str(tmp_path_factory.mktemp("arrays") / "designs.sqlite")
    with open_database(place, create=True) as database:
        for grid, n in (("hex", 10), ("square", 8), ("rectangle", 8), ("triangle", 6)):
            run_into(Plan(search_all(GRIDS[grid], n, "all"), "twist"), database)
    with open_readonly(place) as opened:
        yield opened


ARRAYS = [
    ("array=3-4-3", "hex", "3-4-3"),
    ("grid=hex array=3-4-3", "hex", "3-4-3"),
    ("array=hex:e.f.7", "hex", "3-4-3"),
    ("(array=3-4-3)", "hex", "3-4-3"),
    ("array=4x2 grid=square", "square", "4x2"),
    ("(array=2x4 and grid=square)", "square", "4x2"),
    ("grid=square (n=8 or n=4) not not array=2x4", "square", "4x2"),
    ("grid=rectangle array=4x2", "rectangle", "4x2"),
    ("grid=rectangle array=2x4", "rectangle", "2x4"),
    ("grid=triangle array=t4 or grid=triangle n=6 array=h1", "triangle", "h1"),
]


@pytest.mark.parametrize(("query", "grid", "spec"), ARRAYS)
def test_array_specifications_find_congruent_arrays(stored_arrays, query, grid, spec):
    notation = parse_array(grid_named(grid), spec).canonical().notation
    expected = [row for row in rows(stored_arrays) if row["array"] == notation]
    assert expected
    assert [row[0] for row in select(stored_arrays, query, columns="id").rows] == [row["id"] for row in expected]


def test_arrays_on_any_grid_and_all_others(stored_arrays, tmp_path):
    table = rows(stored_arrays)
    both = {"square:f.f", parse_array(GRIDS["rectangle"], "4x2").canonical().notation}
    selected = {row[0] for row in select(stored_arrays, "array=4x2", columns="array").rows}
    assert selected == both
    others = select(stored_arrays, "array!=4x2", columns="id").rows
    assert len(others) == sum(row["array"] not in both for row in table)
    (tmp_path / "cells.txt").write_text("".join(f"{x} {y}\n" for x in (5, 6) for y in range(4)))
    cells = f"grid=square array=@{tmp_path / 'cells.txt'}"
    assert {row[0] for row in select(stored_arrays, cells, columns="array").rows} == {"square:f.f"}


@pytest.mark.parametrize("spec", ["4-3-3", "3-3-4", "2-3-3-2"])
def test_every_image_of_an_array_is_the_same_array(stored_arrays, spec):
    array = parse_array(GRIDS["hex"], spec)
    turned = [[array.grid.cell(isometry(point)) for point in array.points] for isometry in array.grid.point_group]
    texts = {Array.from_cells(array.grid, cells).notation for cells in turned}
    expected = [(row["id"],) for row in rows(stored_arrays) if row["array"] == array.canonical().notation]
    assert len(texts) > 1
    for text in texts:
        assert list(select(stored_arrays, f"array={text}", columns="id").rows) == expected


def test_circuits_are_found_in_any_position_order_and_direction(stored_arrays):
    for row in rows(stored_arrays)[::7]:
        circuit = Circuit.from_notation(row["circuit"])
        n, m = circuit.n, circuit.grid.directions
        mirrored = [(-d) % m for d in circuit.word]
        backwards = [(d + m // 2) % m for d in circuit.word[::-1]]
        for word in (circuit.word[3:] + circuit.word[:3], mirrored, backwards):
            text = f"{circuit.grid.name}:{''.join(map(str, word))}"
            assert select(stored_arrays, f"circuit={text}", columns="id").rows == ((row["id"],),)
            assert find_design(stored_arrays, text)["id"] == row["id"]
        assert len(select(stored_arrays, f"n={n} circuit!={row['circuit']}").rows) == sum(
            other["n"] == n and other["id"] != row["id"] for other in rows(stored_arrays)
        )


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("array=4-4", None),
        ("array=six", "no grid has an array 'six': write 6x5, 3-4-3, p5x4, t5, h3, s1, @file or an array's notation"),
        ("grid=square array=3-4-3", "the square grid has no array '3-4-3': use 6x5"),
        ("grid=square (array=3-4-3 or n=4)", "the square grid has no array '3-4-3'"),
        ("grid=square array=hex:e.f.7", "'hex:e.f.7' is not on the grid square: name the grid hex"),
        ("grid=hex array=3-5", "differs by more than one"),
        ("array=hex:zz", "no grid has an array 'hex:zz'"),
        ("grid=hex array!=hex:zz", "malformed array notation 'hex:zz'"),
        ("array=900x900", "larger than 20000 cells"),
        ("array=@nowhere.txt", "cannot read the cells in nowhere.txt"),
        ("array=@/dev/zero", "it is a pipe or a device"),
        ("circuit=17", "unknown grid '17'"),
        ("circuit=hex:012", "does not close or meets a panel twice"),
        ("array=", "no value in 'array='"),
        ("array=\udcff", r"no grid has an array '\udcff'"),
    ],
)
def test_arrays_and_circuits_that_cannot_be_read_are_refused(stored_arrays, query, message):
    if message is None:
        assert select(stored_arrays, query).rows == ()
        return
    with pytest.raises(HcsearchError) as caught:
        select(stored_arrays, query)
    assert message in str(caught.value)
    assert str(caught.value).isprintable()


@given(st.text(max_size=30))
@settings(max_examples=200)
def test_any_text_is_a_query_or_a_refusal(reader, text):
    try:
        selected = select(reader, text).rows
    except HcsearchError:
        selected = ()
    assert len(selected) in (0, 45) or text.split()


@given(st.text(st.characters(exclude_categories=["Z", "C"], exclude_characters="()"), max_size=30))
@settings(max_examples=100)
def test_any_value_is_only_compared(reader, value):
    if value and value[0] not in "=<>!":
        expected = sum(row["target"] == value for row in rows(reader, "runs"))
        assert len(select(reader, f"target={value}", view="runs").rows) == expected
        assert len(select(reader, f"target!={value}", view="runs").rows) == 4 - expected


@pytest.mark.parametrize("value", ["';DROP", "x'--", '"', "(1)OR(1=1)", "\\", "?", ":a", "%s", "\udcff", "NULL"])
def test_injections_are_values(reader, value):
    assert select(reader, f"target={value}", view="runs").rows == ()
    assert len(select(reader, f"target!={value}", view="runs").rows) == 4


@pytest.mark.parametrize(
    ("query", "part"),
    [
        ("foo=1", "choose from id, grid"),
        ("untwistd", "did you mean untwisted"),
        ("kutzbch<3", "did you mean kutzbach"),
        ("n", "not a yes/no column"),
        ("n==12", "'n==12' is no comparison: write n=12"),
        ("n<>12", "'n<>12' is no comparison: write n!=12"),
        ("grid==hex", "'grid==hex' is no comparison: write grid=hex"),
        ("grid=", "no value"),
        ("n=twelve", "compared with a number, not with 'twelve'"),
        ("n=12, untwisted", "'n=12,' ends in ',': separate conditions by spaces"),
        ("n=nan", "compared with a number"),
        ("n=inf", "compared with a number"),
        ("n=1_0", "compared with a number"),
        ("n=١٢", "compared with a number"),
        ("untwisted=yes", "compared with 1 or 0"),
        ("=1", "cannot read '=1'"),
        ("n=1;", "'n=1;' ends in ';'"),
        ("1=1", "cannot read"),
        ("n=12 XOR n=13", "no column 'XOR'"),
        ("or n=12", "a condition is missing before 'or'"),
        ("n=12 or", "a condition is missing at the end"),
        ("n=12 or or n=13", "a condition is missing before 'or'"),
        ("n=12 and", "a condition is missing at the end"),
        ("not", "a condition is missing at the end"),
        ("not or n=1", "a condition is missing before 'or'"),
        ("()", "a condition is missing before ')'"),
        ("(n=12", "a bracket is not closed"),
        ("(n=12))", "a bracket closes where none is open"),
        (")", "a condition is missing before ')'"),
        ("n=12)", "a bracket closes where none is open"),
        ("n=12)or(n=13", "a bracket closes where none is open"),
        ("n=12) or (n=13", "a bracket closes where none is open"),
        ("not=1", "no column 'not'"),
        ("(" * 2000 + "n=12" + ")" * 2000, "more than 15 deep"),
        ("not " * 2000 + "n=12", "more than 15 deep"),
        ("(" * 100_000, "more than 15 deep"),
        ("grid", "not a yes/no column"),
        ("grid=hexagon", "grid is never 'hexagon' (did you mean hex?): it is one of triangle, square, rectangle, hex"),
        ("grid!=hexx", "did you mean hex?"),
        ("status=deploy", "did you mean deploys"),
        ("status=open", "one of deploys, movable, undecided, locked, twisted, no_folding"),
        ("status=collides", "one of deploys, movable, undecided, locked, twisted, no_folding"),
        ("flat_pairs=either", "one of rigid, hinged, merged"),
        ("rowid=1", "no column 'rowid'"),
        ("best_crease=1", "no column 'best_crease'"),
        ("n=6 " * 501, "the query has 501 conditions: give 500 at most"),
        ("n=6 or " * 1500 + "n=6", "the query has 1501 conditions"),
    ],
)
def test_nonsense_is_refused_with_a_remedy(reader, query, part):
    with pytest.raises(QueryError) as caught:
        select(reader, query)
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_longest_and_deepest_queries_can_be_run(reader):
    assert len(select(reader, "id>0 " * 500).rows) == 45
    assert len(select(reader, "id<0 or " * 499 + "id>0").rows) == 45
    assert len(select(reader, "(" * 15 + "id>0" + ")" * 15).rows) == 45
    assert len(select(reader, "(id<0 or id>0 and not " * 7 + "id>0" + ")" * 7).rows) == 0
    assert len(select(reader, "id<0 or id>0 and (" * 15 + "id>0" + ")" * 15).rows) == 45


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
    """Sort stably from the last key to the first, words in their own order, each time with NULL last."""

    def worth(value):
        return DESIGN_STATUSES.index(value) if value in DESIGN_STATUSES else value

    ordered = sorted(table, key=lambda row: [row[name] for name in identity])
    for term in reversed(sort.split(",")):
        name = term.removeprefix("-")
        known = [row for row in ordered if row[name] is not None]
        # Equal keys keep their order, also backwards.
        known.sort(key=lambda row, name=name: worth(row[name]), reverse=term.startswith("-"))
        ordered = known + [row for row in ordered if row[name] is None]
    return ordered


@pytest.mark.parametrize(
    "sort", ["score", "-score", "-score,n_foldings", "array,-score", "-status,-id", "status", "dof", "-dof,array"]
)
def test_order_with_null_last_and_ties_by_id(reader, sort):
    ids = [row[0] for row in select(reader, columns="id", sort=sort).rows]
    assert ids == [row["id"] for row in naive_order(rows(reader), sort, ["id"])]


@pytest.mark.parametrize("sort", ["twist", "-twist,crease", "-design_id"])
def test_order_of_foldings(reader, sort):
    selected = select(reader, columns="design_id,crease", sort=sort, view="foldings").rows
    ordered = naive_order(rows(reader, "foldings"), sort, ["design_id", "crease"])
    assert selected == tuple((row["design_id"], row["crease"]) for row in ordered)


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


def checked(table, column):
    """The words that the schema allows in a column."""
    constraints = schema.metadata.tables[table].constraints
    (check,) = (one for one in constraints if one.name == f"ck_{table}_{column}")
    return set(re.findall(r"'(\w+)'", str(check.sqltext)))


def test_words_are_those_that_the_program_and_the_schema_know():
    words = {(view, quantity.name): quantity.words for view in VIEWS for quantity in VIEWS[view] if quantity.words}
    assert set(words["designs", "grid"]) == set(words["runs", "grid"]) == set(GRIDS)
    assert checked("outcome", "status") == checked("verdict", "status") == {*STATUSES}
    # the checks of three older columns also allow a word that no program writes there
    assert {*words["designs", "status"]} == checked("design", "status") - {"collides"} | {*STATUSES}
    assert {*words["foldings", "status"]} == checked("folding", "status") - {"collides"} | {*STATUSES}
    assert {*words["deployments", "status"]} == checked("deployment", "status") - {"locked"} == {*get_args(Verdict)}
    for view in ("designs", "foldings", "motions"):
        assert {*words[view, "flat_pairs"]} == checked("motion", "flat_pairs") == {*get_args(Way)}
    assert {name for _, name in words} >= {"grid", "keep", "status", "flat_pairs"}
    assert not [view for view in ("runs", "units") if (view, "status") in words]
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
def test_named_queries_run(place, database, file):
    record(database, circuits(1, 3))
    record(database, ["hex:999999"], prefix="q", creases=[[2, 3]], twists=[[0, 0]])
    judge(database, [("hex:999999", 2, "movable", None, None)], trials=[COLLIDES])
    with open_readonly(place) as reader:
        result = select_sql(reader, file.read_text())
    assert result.rows
    assert len(set(result.columns)) == len(result.columns)


def test_there_are_named_queries():
    assert len(NAMED) > 3
