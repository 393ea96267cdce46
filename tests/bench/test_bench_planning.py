"""The bench `planning`: shares follow from its foldings, these from the stages, and it is saved."""

import csv
import sys
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from hcsearch.designs.folding import Folding
from hcsearch.designs.grid import grid_named
from hcsearch.designs.panel_sizes import default_panel
from hcsearch.motion.locks.end_locks import lock_at
from hcsearch.motion.planning.motion_search import plan_motion
from hcsearch.motion.planning.path_proofs import CERTIFIED_MARGINS, Prover
from hcsearch.motion.planning.planner import Planner
from hcsearch.search.enumeration import PolygonSearch
from hcsearch_bench.peers import ompl_search
from hcsearch_bench.planning.folding_rows import (
    SCENE,
    FoldingRow,
    Group,
    budget_rows,
    group_row,
    margin_rows,
    settle,
    thickness_row,
)
from hcsearch_bench.planning.planning import PLANNING
from hcsearch_bench.planning.planning_results import QUICK, QUICK_THICKNESSES, PlanningResults
from hcsearch_bench.planning.search_rows import search_rows
from hcsearch_bench.planning.share_plots import curve, plot_planning
from hcsearch_bench.run.machine import MISSING
from hcsearch_bench.run.work_precision import OURS, UnableError
from tests.planned import joined

SUBJECT = ("square:012233230011:4", "rigid")


def row(result, seconds, margin=None):
    return FoldingRow("some", "a folding", 6.0, result, None if margin is None else "rigid", margin, seconds)


ROWS = [
    row("locked", 0.01),
    row("movable", 0.2, 0.01),
    row("undecided", 5.0),
    row("movable", 1.5, 0.1),
    row("movable", 0.3, 0.02),
]


@pytest.fixture(scope="module")
def report():
    return PLANNING.run(quick=True, say=lambda _: None)


@pytest.fixture
def results(report):
    return report.results


def test_foldings_are_those_of_direct_calls():
    rows = list(settle(Group("hex", "10"), None, 14))
    assert [row.result for row in rows] == ["movable", "locked", "undecided"]
    panel = default_panel("hex")
    for row in rows:
        folding = Folding.from_notation(row.folding)
        linkage = folding.linkage(panel, flat_pairs="hinged")
        locked = any(lock_at(linkage, end).locked for end in (linkage.folded, linkage.flat))
        assert locked == (row.result == "locked")
        motion = None if locked else plan_motion(folding, panel, SCENE.flat_pairs)
        if motion is None or motion.margin is None:
            assert (row.flat_pairs, row.margin_mm) == (None, None)
        else:
            assert (row.flat_pairs, row.margin_mm) == (motion.way, pytest.approx(1e3 * motion.margin))
        assert row.seconds > 0


def test_every_so_many_th_folding_is_taken_over_all_batches(monkeypatch):
    group = Group("hex", "10")
    monkeypatch.setattr("hcsearch_bench.planning.folding_rows._settle", lambda _g, _c, kept, _s: kept.crease.tolist())
    whole = list(settle(group))
    assert len(whole) == 40
    pieces = SimpleNamespace(batches=lambda: PolygonSearch(grid_named("hex"), 10).batches(25))
    monkeypatch.setattr(Group, "search", lambda _: pieces)
    assert list(settle(group)) == whole
    assert list(settle(group, None, 7)) == whole[::7]


def test_counts_of_known_foldings():
    counted = group_row(ROWS)
    assert (counted.foldings, counted.movable, counted.locked, counted.undecided) == (5, 3, 1, 1)
    assert (counted.share, counted.total_s, counted.median_s, counted.most_s) == (0.8, pytest.approx(7.01), 0.3, 5.0)
    assert [(row.settled, row.spent_s) for row in budget_rows(ROWS, (0.01, 1.0, 10.0))] == [
        (1, pytest.approx(0.05)),
        (3, pytest.approx(2.51)),
        (4, pytest.approx(7.01)),
    ]
    assert [(row.movable, row.locked, row.share) for row in margin_rows(ROWS)] == [
        (1, 1, 0.4),
        (2, 1, pytest.approx(0.6)),
        (2, 1, pytest.approx(0.6)),
        (3, 1, 0.8),
    ]
    assert (thickness_row(ROWS).tight, thickness_row(ROWS).share) == (1, 0.8)
    budgets, shares, spent = curve(ROWS)
    assert shares.tolist() == [0.2, 0.4, 0.6, 0.8, 0.8]
    assert spent[-1] == pytest.approx(7.01)
    assert [budget_rows(ROWS, [budget])[0].spent_s for budget in budgets] == pytest.approx(spent.tolist())


def test_shares_rise_with_work_and_margin(results):
    assert [row.group for row in results.groups] == [group.name for group in QUICK]
    for shown in results.groups:
        own = results.rows_of(shown)
        assert len(own) == shown.foldings == shown.movable + shown.locked + shown.undecided
        work, margins = ([row for row in rows if row.group == shown.group] for rows in (results.work, results.margins))
        for rows in (work, margins):
            assert all(one.share <= two.share for one, two in pairwise(rows))
        assert work[-1].settled == margins[-1].movable + margins[-1].locked == shown.movable + shown.locked
        assert work[-1].spent_s == pytest.approx(shown.total_s)
        sweep = [row for row in results.thicknesses if row.group == shown.group]
        assert [row.thickness_mm for row in sweep] == sorted(1e3 * t for t in (*QUICK_THICKNESSES, 0.006))
        assert sweep[-1].share == shown.share
    for row in results.rows:
        assert (row.result == "movable") == (row.margin_mm is not None) == (row.flat_pairs is not None)
        assert row.margin_mm is None or any(row.margin_mm == pytest.approx(1e3 * play) for play in CERTIFIED_MARGINS)


def test_efforts_settle_more_and_more(results):
    assert [row.efforts for row in results.efforts] == [1, 2, 3]
    for one, two in pairwise(results.efforts):
        assert one.spent_s <= two.spent_s
        assert one.undecided >= two.undecided
    for row in results.efforts:
        assert row.movable + row.locked + row.undecided == row.foldings == 4
        assert row.longest_s <= row.spent_s
    assert results.efforts[-1].movable == 4


def test_it_is_saved_with_its_foldings(report, tmp_path):
    report.save(tmp_path)
    text = (tmp_path / "planning.md").read_text(encoding="utf-8")
    assert text.startswith("# Bench: planning\n")
    with (tmp_path / "foldings.csv").open(encoding="utf-8", newline="") as file:
        saved = list(csv.DictReader(file))
    assert [line["folding"] for line in saved] == [row.folding for row in report.results.rows]
    assert all((tmp_path / f"{table.name}.csv").exists() for table in report.tables)
    assert (tmp_path / "planning.png").stat().st_size > 10_000


def test_a_set_of_which_nothing_is_settled_is_drawn(tmp_path):
    rows = [row("undecided", 1.0)]
    tables = ([group_row(rows)], [], budget_rows(rows), margin_rows(rows), [thickness_row(rows)], [])
    plot_planning(PlanningResults(*tables, rows), tmp_path / "nothing.png")
    assert (tmp_path / "nothing.png").exists()


def test_a_peer_that_is_missing_is_reported(monkeypatch):
    monkeypatch.setitem(sys.modules, "ompl", None)
    own, peer = search_rows(SUBJECT, 1, 5.0)
    assert (own.engine, own.searches, own.met, own.proved) == (OURS, 1, 1, 1)
    assert 0 < own.median_s < 5
    assert (peer.searches, peer.met, peer.median_s, peer.note) == (0, None, None, MISSING)
    with pytest.raises(UnableError, match=MISSING):
        ompl_search.search(Planner(joined(*SUBJECT), 1e-4), 0, 1.0)


@pytest.mark.extra
def test_the_peer_finds_a_path_that_is_proved():
    planner = Planner(joined(*SUBJECT), 1e-4)
    proved = 0
    for seed in range(5):
        states, seconds = ompl_search.search(planner, seed, 5.0)
        assert 0 < seconds < 6
        if states is not None:
            assert states[0] == pytest.approx(planner.space.folded)
            assert np.abs(states[-1]).max() == 0.0
            proved += Prover(planner.linkage).prove(states, [planner.margin]).margin is not None
    assert proved >= 1
