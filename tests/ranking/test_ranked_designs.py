"""Designs of a database in the order of their scores, and the column `score`."""

import sqlite3
from contextlib import closing

import pytest
from naive_ranks import front, score

from hcsearch.basics.errors import DatabaseError, QueryError, SceneError
from hcsearch.designs.grid import GRIDS
from hcsearch.search.enumeration import PolygonSearch
from hcsearch.search.pipeline import Plan, run_into
from hcsearch.search.ranking import rank_designs, save_ranks
from hcsearch.store import open_database, open_readonly, schema, select
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.web.report.data import fetch_report_data

CRITERIA = [quantity for quantity in RANKING_CRITERIA if quantity.weight]
NAMES = [quantity.name for quantity in CRITERIA]
BETTER = [quantity.better for quantity in CRITERIA]
HALVES = [quantity.half for quantity in CRITERIA]


def as_dicts(ranked):
    return [dict(zip(ranked.result.columns, row, strict=True)) for row in ranked.result.rows]


def stored(database, query=""):
    return dict(select(database, query, columns="id,score").rows)


def test_criteria_of_a_design(reader):
    """Ten panels: 5:1, and hinges at all creases but two; where nothing unfolds there is neither."""
    columns = "n,deployment_ratio,hinges"
    assert set(select(reader, "untwisted", columns=columns).rows) == {(10, 5, 8)}
    assert set(select(reader, "untwisted=0", columns=columns).rows) == {(10, None, None)}
    assert len(select(reader, "deployment_ratio>4.5 hinges<=8").rows) == 25


def test_ranks_scores_and_front_are_those_of_the_plain_formulas(reader):
    weights = {"dof": 3, "symmetry": 0.5}
    ranked = rank_designs(reader, "n=10", weights)
    rows = as_dicts(ranked)
    values = [[row[name] for name in NAMES] for row in rows]
    assert len(values) == len(select(reader, "untwisted status!=locked").rows) > 10
    assert {row["min_clearance"] is None for row in rows} == {True, False}
    # what is movable without springs has a margin, and no clearance
    kinds = {(row["needed_margin"] is None, row["min_clearance"] is None) for row in rows}
    assert kinds == {(True, True), (False, True), (False, False)}
    shares = [weights.get(name, 1) for name in NAMES]
    assert [row["score"] for row in rows] == pytest.approx([score(row, shares, BETTER, HALVES) for row in values])
    assert [row["pareto"] for row in rows] == front(values, BETTER)
    scores = [row["score"] for row in rows]
    assert scores == sorted(scores, reverse=True)
    assert [row["rank"] for row in rows] == [1 + sum(other > mine for other in scores) for mine in scores]
    assert len({row["rank"] for row in rows}) < len(rows), "no two designs tie, so ties are not tried"
    ties = [(row["rank"], row["id"]) for row in rows]
    assert ties == sorted(ties)


def test_who_cannot_deploy_is_left_out(reader):
    ranked = rank_designs(reader)
    cannot = [row[0] for row in select(reader, "deployable=0", columns="id", sort="id").rows]
    assert list(ranked.unranked_ids) == cannot
    assert len(cannot) + len(ranked.result.rows) == 120
    assert rank_designs(reader, "status=locked").result.rows == ()


def test_criteria_without_weight_are_not_shown_and_decide_nothing(reader):
    only = dict.fromkeys(NAMES, 0) | {"deploy_time": 2}
    rows = as_dicts(rank_designs(reader, "", only))
    assert list(rows[0]) == ["rank", "id", "circuit", "score", "pareto", "deploy_time"]
    best = min(row["deploy_time"] for row in rows if row["deploy_time"] is not None)
    assert [row["id"] for row in rows if row["pareto"]] == [row["id"] for row in rows if row["deploy_time"] == best]
    assert {row["rank"] for row in rows if row["pareto"]} == {1}


def test_a_query_or_weights_that_cannot_be(reader):
    with pytest.raises(QueryError, match="no column 'size'"):
        rank_designs(reader, "size=3")
    with pytest.raises(QueryError, match="no criterion 'n'"):
        rank_designs(reader, "", {"n": 1})


def test_before_any_folding_is_known_symmetry_alone_counts(tmp_path):
    with open_database(str(tmp_path / "d.sqlite"), create=True) as database:
        run_into(Plan(PolygonSearch(GRIDS["hex"], 6), "circuits"), database)
        rows = as_dicts(rank_designs(database))
    assert len(rows) == 4
    symmetries = [row["symmetry"] for row in rows]
    assert symmetries == sorted(symmetries, reverse=True)
    assert [row["pareto"] for row in rows] == [int(s == symmetries[0]) for s in symmetries]


def test_scores_are_stored_for_the_ranked_alone(path):
    with open_database(str(path), create=False) as database:
        ranked = rank_designs(database, "symmetry=1")
        save_ranks(database, ranked)
        assert {k: v for k, v in stored(database).items() if v is not None} == {
            row["id"]: row["score"] for row in as_dicts(ranked)
        }
        others = rank_designs(database, "symmetry>1", {"dof": 9})
        save_ranks(database, others)
        assert {k: v for k, v in stored(database).items() if v is not None} == {
            row["id"]: row["score"] for row in (*as_dicts(ranked), *as_dicts(others))
        }


def test_other_weights_overwrite_and_who_is_locked_by_now_loses_its_score(path):
    outcome = schema.outcome
    with open_database(str(path), create=False) as database:
        save_ranks(database, rank_designs(database))
        before = stored(database)
        best = max((k for k, v in before.items() if v is not None), key=before.__getitem__)
        with database.writing() as connection:
            locked = outcome.update().values(status="locked")
            connection.execute(locked.where(outcome.c.design_id == best, outcome.c.scene == "default"))
        again = rank_designs(database, "", {"dof": 5})
        save_ranks(database, again)
        after = stored(database)
    assert after[best] is None
    assert {k for k, v in after.items() if v is not None} == {k for k, v in before.items() if v is not None} - {best}
    assert {row["id"]: row["score"] for row in as_dicts(again)}.items() <= after.items()
    assert after != before


def test_the_same_scores_again_write_nothing(path):
    with open_database(str(path), create=False) as database:
        save_ranks(database, rank_designs(database))
    content = path.read_bytes()
    with open_database(str(path), create=False) as database:
        save_ranks(database, rank_designs(database))
    assert path.read_bytes() == content


def test_a_later_search_keeps_the_scores(path):
    with open_database(str(path), create=False) as database:
        save_ranks(database, rank_designs(database))
        before = stored(database)
        run_into(Plan(PolygonSearch(GRIDS["hex"], 10), "twist", keep="untwisted"), database)
        run_into(Plan(PolygonSearch(GRIDS["hex"], 8), "twist"), database)
        assert stored(database, "n=10") == before


def test_each_scene_has_ranks_and_scores_of_its_own(path):
    with open_database(str(path), create=False) as database:
        save_ranks(database, rank_designs(database))
        before = stored(database)
        ranked = rank_designs(database, "deployable", scene="solar")
        save_ranks(database, ranked, "solar")
        assert stored(database) == before
        rows = as_dicts(ranked)
        brighter = dict(select(database, columns="id,score", scene="solar").rows)
    assert {k: v for k, v in brighter.items() if v is not None} == {row["id"]: row["score"] for row in rows}
    deploying = [k for k, v in before.items() if v is not None]
    assert sorted(row["id"] for row in rows) == deploying
    assert {row["deploy_time"] for row in rows} == {0.5}
    assert min(row["min_clearance"] for row in rows) == 1.0
    assert [row["rank"] for row in rows] == sorted(row["rank"] for row in rows)


def test_a_scene_that_was_never_run_has_no_ranks(reader):
    with pytest.raises(SceneError, match=r"no verdicts of the scene 'moon' in .*: default, solar; name one"):
        rank_designs(reader, scene="moon")


def test_a_failure_within_the_transaction_leaves_the_old_scores(path):
    with open_database(str(path), create=False) as database:
        ranked = rank_designs(database)
        with database.writing() as connection:
            last = ranked.result.rows[-1][1]
            connection.exec_driver_sql(
                f"CREATE TRIGGER no BEFORE INSERT ON score WHEN new.design_id = {last}"
                " BEGIN SELECT RAISE(ABORT, 'no'); END"
            )
        with pytest.raises(Exception, match="no"):
            save_ranks(database, ranked)
        assert set(stored(database).values()) == {None}


def test_a_writer_elsewhere_is_told_and_hinders_no_reading(path):
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with open_database(str(path), create=False, timeout=0.1) as database:
            ranked = rank_designs(database)
            with pytest.raises(DatabaseError, match="locked by another program: wait"):
                save_ranks(database, ranked)
            other.execute("COMMIT")
            save_ranks(database, ranked)
            assert len(ranked.result.rows) == len(select(database, "score>=0").rows)


def test_a_read_only_database_takes_no_scores(reader):
    with pytest.raises(DatabaseError, match="read-only"):
        save_ranks(reader, rank_designs(reader))


def test_stored_scores_lead_queries_and_the_report(path):
    with open_database(str(path), create=False) as database:
        ranked = rank_designs(database)
        save_ranks(database, ranked)
    order = [row[1] for row in ranked.result.rows]
    with open_readonly(str(path)) as reader:
        assert [row[0] for row in select(reader, columns="id", sort="-score", limit=len(order)).rows] == order
        assert [design["id"] for design in fetch_report_data(reader, "untwisted", len(order)).designs] == order
