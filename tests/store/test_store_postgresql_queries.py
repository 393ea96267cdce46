"""Every kind of query prints the same from a PostgreSQL server as from an SQLite file."""

import re

import pytest
from click.testing import CliRunner
from store_samples import circuits, record

from hcsearch.basics.errors import QueryError
from hcsearch.cli import hcsearch
from hcsearch.store import (
    count_rows,
    find_design,
    open_database,
    open_readonly,
    save_scores,
    schema,
    select,
    select_page,
)
from tests.judging import judge

pytestmark = pytest.mark.extra

QUERIES = [
    *([], ["untwisted"], ["n_foldings>=0 score>=-0.5"], ["id>=99999999999999999999"], ["score<1e999 id!=2.5"]),
    *(["circuit<hex:05"], ["circuit>=hex:05 array>hex:array3"], ["deployable=0"], ["status=locked"], ["array>x'--"]),
    *(["status=movable needed_margin<=0.01"], ["flat_pairs=rigid", "-s", "-least_gap,id"], ["status=undecided"]),
    *(["not (untwisted or id<9) and id<99"], ["array=4-4-4 or not status=locked"], ["n_foldings>=0 not(not(score>0))"]),
    *(["-s", "score"], ["-s", "-score,array"], ["-s", "-status,-id"], ["-s", "circuit"], ["-s", "-array,circuit"]),
    *(["--scene", "solar"], ["deployable", "--scene", "solar", "-s", "-score,min_clearance"]),
    *(["--limit", "3"], ["--limit", "0"], ["-c", "score,dof,min_clearance,status", "-s", "-dof"]),
    ["--sql", "SELECT min_twist, count(*) AS k FROM designs GROUP BY min_twist ORDER BY k, min_twist"],
    ["--sql", "SELECT sum(n_fixed) AS a, avg(id) AS b, 0.5 AS c, 7.0 / 2 AS d, max(score) AS e FROM designs"],
    ["--sql", "SELECT n > 3 AS a, n < 3 AS b, 'a:b %s %(x)s;' AS c, NULL AS d FROM designs LIMIT 2"],
    ["--sql", "SELECT * FROM runs -- all of them"],
    ["--sql", "SELECT * FROM motions ORDER BY scene, design_id, crease"],
    ["--sql", "SELECT circuit, array_symmetry FROM designs ORDER BY circuit DESC LIMIT 5;"],
    ["--sql", 'SELECT DISTINCT "array" FROM designs ORDER BY "array"'],
    ["--sql", "SELECT id, crease, twist FROM designs JOIN foldings ON design_id = id ORDER BY id, crease"],
]


@pytest.fixture(scope="module")
def filled(server, tmp_path_factory):
    """The same designs, with every kind of value, on the server and in a file."""
    name = server.create_database()
    places = server.url(name), str(tmp_path_factory.mktemp("filled") / "designs.sqlite")
    for place in places:
        with open_database(place, create=True) as database:
            for chunk in range(3):
                record(database, circuits(1 + 700 * chunk, 700), prefix=str(chunk))
            record(database, ["hex:a.b", "hex:ab", "hex:A.c", "hex:-z"], prefix="x", until="circuits")
            with database.writing() as connection:
                table, folding = schema.design, schema.folding
                for k in range(11):
                    values = {"best_crease": [None, 3][k % 2], "status": [None, "undecided", "locked"][k % 3]}
                    connection.execute(table.update().where(table.c.id % 11 == k).values(values))
                connection.execute(folding.update().values(dof=folding.c.design_id % 5))
            named = dict(select(database, "untwisted", columns="id,circuit").rows)
            words = ("undecided", "deploys", "locked", "movable")
            judge(database, [(named[k], 3, words[k % 4], 1e-7, k / 7) for k in named if k % 5])
            judge(database, [(named[k], 3, words[-k % 4], k / 3, None) for k in named if k % 2], "solar")
            save_scores(database, {k: k % 11 / 7 - 1 for k in range(1, 2101) if k % 4})
            save_scores(database, {k: k % 7 / 11 for k in range(1, 2101) if k % 3}, "solar")
            with database.writing() as connection:
                connection.execute(schema.run.update().values(started="2026-01-01T00:00:00+00:00"))
    yield places
    server.drop_database(name)


@pytest.mark.parametrize("words", QUERIES, ids=lambda words: " ".join(words)[:40] or "all")
def test_every_query_prints_what_sqlite_prints(filled, words):
    for style in ("csv", "json", "table", "markdown"):
        done = [CliRunner().invoke(hcsearch, ["query", "--db", p, *words, "--format", style]) for p in filled]
        assert done[0].exception is None
        assert done[0].output == done[1].output
        assert done[0].output


def test_find_design_and_report(filled, tmp_path):
    with open_readonly(filled[0]) as remote, open_readonly(filled[1]) as local:
        for text in ("3", "hex:a.b", "hex:023757"):
            assert find_design(remote, text) == find_design(local, text)
    pages = []
    for number, place in enumerate(filled):
        for scene in ("default", "solar"):
            output = tmp_path / f"{number} {scene}.html"
            words = ["report", "id<4", "--db", place, "--output", str(output), "--scene", scene]
            assert CliRunner().invoke(hcsearch, words).exception is None
            # but the time, and the option of commands that names a file
            pages.append(re.sub(r'\d\d:\d\d UTC|"where":".*?"', "", output.read_text()))
    assert pages[:2] == pages[2:]
    assert pages[0] != pages[1]


def test_pages_and_counts_are_those_of_a_file(filled):
    with open_readonly(filled[0]) as on_server, open_readonly(filled[1]) as in_file:
        for scene in ("default", "solar"):
            for query, sort in (("", "-score,array"), ("untwisted", "circuit"), ("needed_margin<1", "")):
                asked = {"query": query, "scene": scene}
                pages = [select_page(one, **asked, sort=sort, skip=600, count=90) for one in (on_server, in_file)]
                assert pages[0] == pages[1]
                assert count_rows(on_server, **asked, most=1000) == count_rows(in_file, **asked, most=1000)
        with pytest.raises(QueryError, match=r"takes more than 0\.001 s: narrow it"):
            select_page(on_server, "not (score<1 and id<3)", sort="-score,-least_gap", skip=2000, seconds=0.001)
