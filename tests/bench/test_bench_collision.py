"""The bench of distances: its pairs are what they claim, its proofs prove, and coal agrees."""

import json
import math
import sys
from fractions import Fraction

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.cli import hcsearch
from hcsearch_bench.collision import collision, proximity_rows
from hcsearch_bench.collision.collision import PAIRS
from hcsearch_bench.collision.pair_rows import pair_row
from hcsearch_bench.collision.pairs import FAMILIES, WIDTH
from hcsearch_bench.collision.proofs import bounds, search, settle

TABLES = {"pairs", "deployments", "goals"}
BOX = np.array([[x, y, z] for z in (0.0, 0.5) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))])


def sample(name, n=300):
    (family,) = [own for own in FAMILIES if own.name == name]
    return family.make(np.random.default_rng(1), n)


def gaps(pairs):
    solids, counts = pairs.vertices(), pairs.counts
    return np.array(
        [search(solids[0, k, : counts[0, k]], solids[1, k, : counts[1, k]])[0] for k in range(len(pairs.which))]
    )


def read(folder):
    arguments = ["bench", "collision", "--quick", "--output", str(folder), "--json", str(folder / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    names = {path.name for path in folder.iterdir()}
    assert names == {f"{name}.csv" for name in TABLES} | {"all.json", "collision.md", "machine.json"}
    data = json.loads((folder / "all.json").read_text())
    assert set(data) == TABLES | {"machine"}
    return data


def test_the_command_without_coal(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "coal", None)
    monkeypatch.setattr(collision, "QUICK_PAIRS", 50)
    monkeypatch.setattr(proximity_rows, "QUICK_DEPLOYMENTS", proximity_rows.DEPLOYMENTS[1:2])
    data = read(tmp_path)
    assert [row["kind"] for row in data["pairs"]] == [family.name for family in FAMILIES]
    for row in data["pairs"]:
        assert row["exhaustive"] == 0
        assert row["cold_us"] > 0
        assert row["warm_us"] > 0
        assert row["difference"] is row["coal_us"] is row["coal_loop_us"] is row["beyond"] is None
    (row,) = data["deployments"]
    assert (row["outcome"], row["panels"], row["pairs"], row["facet_pairs"]) == ("flat", 10, 35, 50)
    assert row["difference"] is None
    assert 0 < row["collide"] < 0.1
    assert [goal["at_most"] for goal in data["goals"]] == [0.2, 1.0]


def test_each_kind_of_pairs_is_what_it_is_called():
    assert len({family.name for family in FAMILIES}) == len(FAMILIES)
    for family in FAMILIES:
        pairs = family.make(np.random.default_rng(2), 40)
        identity = pairs.turns @ pairs.turns.transpose(0, 1, 3, 2)
        assert identity == pytest.approx(np.broadcast_to(np.eye(3), identity.shape), abs=1e-14)
        assert np.linalg.det(pairs.turns) == pytest.approx(np.ones((40, 2)))
        # sides as wide as is said
        solids = pairs.vertices()
        assert np.linalg.norm(solids[:, :, 1] - solids[:, :, 0], axis=-1) == pytest.approx(
            np.full((2, 40), pairs.width)
        )
    assert (gaps(sample("hinged")) < 1e-15).all()
    assert (gaps(sample("corners")) < 1e-15).all()
    assert (gaps(sample("same")) < 1e-15).all()
    parallel = gaps(sample("parallel"))
    assert (parallel > 0).any()
    assert parallel.min() < 1e-12
    for name in ("stacked", "coplanar", "edges"):
        apart = gaps(sample(name))
        assert (apart < 1e-14).sum() > 40
        assert (apart > 1e-3).sum() > 10
    for name in ("random", "thin", "tiny"):
        apart = gaps(sample(name))
        assert 0 < (apart <= 0).sum() < 100


def test_exact_bounds_hold_and_meet_where_the_answer_is_right():
    for shift, expected in (((3.0, 0.0, 0.0), 2.0), ((0.25, 0.25, 1.0), 0.5), ((2.0, 2.0, 0.0), math.sqrt(2.0))):
        other = BOX + np.array(shift)
        gap, way, corners = search(BOX, other)
        assert gap == pytest.approx(expected, abs=1e-15)
        assert bounds(BOX, other, way, corners) == pytest.approx((expected, expected), abs=1e-15)
        # of another direction, and of other corners, they are bounds still
        lower, upper = bounds(BOX, other, way + np.array([0.1, 0.2, 0.3]), [0])
        assert lower < expected < upper
        assert bounds(BOX, other, way, []) == (pytest.approx(expected), math.inf)
    gap, way, corners = search(BOX, BOX + 0.25)
    assert gap < 0
    assert bounds(BOX, BOX + 0.25, way, corners) == (0.0, pytest.approx(0.0, abs=1e-15))
    # far below what a float can square
    near = BOX + np.array([0.0, 0.0, 0.5 + float(Fraction(1, 2**50))])
    _, way, corners = search(BOX, near)
    assert bounds(BOX, near, way, corners) == pytest.approx((2.0**-50, 2.0**-50), rel=1e-12)


def test_who_is_right_is_decided():
    pairs = [(BOX, BOX + np.array([3.0, 0.0, 0.0]))] * 3
    verdict = settle(pairs, np.array([2.0, 2.1, 2.0]), np.array([2.1, 2.0, 2.2]), 1.0)
    assert (verdict.beyond, verdict.ours, verdict.theirs) == (3, 2, 1)
    nothing = settle([], np.empty(0), np.empty(0), 1.0)
    assert (nothing.beyond, nothing.ours, nothing.theirs) == (0, 0, 0)


@pytest.mark.extra
@pytest.mark.parametrize("number", range(len(FAMILIES)))
def test_coal_finds_the_same_distance_of_a_million_pairs_or_is_proved_wrong(number):
    family = FAMILIES[number]
    assert PAIRS * len(FAMILIES) > 1_000_000
    row = pair_row(family, PAIRS, 1, seed=100 + number)
    assert row.pairs == PAIRS
    assert row.theirs == 0
    assert row.ours == row.beyond
    # coal's error is one of length, about the tolerance that it is given
    assert row.difference * (WIDTH if family.name != "tiny" else 1e-6 * WIDTH) < 1e-9
    assert row.exhaustive < 1e-4 * PAIRS
    if not row.beyond:
        assert row.difference < 1e-9


@pytest.mark.extra
def test_the_whole_bench(tmp_path):
    data = read(tmp_path)
    assert all(row["ours"] == row["beyond"] and row["theirs"] == 0 for row in data["pairs"])
    assert all(row["coal_us"] > 0 and row["coal_warm_us"] > 0 and row["coal_loop_us"] > 0 for row in data["pairs"])
    for row in data["deployments"]:
        assert row["difference"] < 1e-7
        assert row["ours"] == row["beyond"]
        assert row["coal_facet_us"] > 0
