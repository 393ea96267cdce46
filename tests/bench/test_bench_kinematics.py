import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch.motion.paths.following import DEFAULT_PATH_LIMITS, PathLimits, follow_path
from hcsearch.shape.linkage import Linkage
from hcsearch_bench.kinematics import extremes, path_methods
from hcsearch_bench.kinematics.path_methods import CostRow, KnownUnit, fit_costs, measure_costs, ring


def silent(_):
    pass


def test_known_motions_are_closed_and_of_their_length():
    unit = KnownUnit("II")
    states = [unit.at(first) for first in np.linspace(0.3, 2.0, 400)]
    assert max(np.abs(unit.linkage.closure(state)[0]).max() for state in states) < 1e-13
    chords = np.linalg.norm(np.diff(states, axis=0), axis=1).sum()
    assert unit.length(0.3, 2.0) == pytest.approx(chords, rel=1e-5)
    assert unit.off_path(np.array(states)) < 1e-14
    assert unit.off_path(states[0] + 1e-3 * unit.legs) == pytest.approx(1e-3)


def test_opening_and_folding_are_first_order_motions():
    unit = KnownUnit("I")
    for state, way in ((unit.linkage.folded, unit.opening()), (unit.linkage.flat, unit.folding())):
        assert np.abs(unit.linkage.closure(state)[1] @ way).max() < 1e-13


def test_a_path_row_has_its_errors(monkeypatch):
    monkeypatch.setattr(path_methods, "METHODS", ("hermite",))
    monkeypatch.setattr(path_methods, "QUICK_STEPS", (0.8,))
    monkeypatch.setattr(path_methods, "QUICK_TOLERANCES", (1e-2,))
    rows = path_methods.measure_paths(["II"], quick=True, repeats=1, say=silent)
    closed = [row for row in rows if row.corrections == "closed"]
    assert [row.method for row in closed] == ["hermite", "increment", "hermite"]
    assert all(row.off_path < 1e-9 and row.residual < 1e-12 for row in closed)
    assert (closed[-1].outcome, closed[-1].at_end) == ("flat", 0.0)
    (open_row,) = [row for row in rows if row.corrections == "0"]
    assert open_row.off_path is None or open_row.off_path > 1e-6


def test_slopes_of_exact_powers():
    rows = [CostRow(n, n - 2, 3.0 * n, 0.5 * n**0.5, 2.0) for n in (10, 20, 50, 100, 200, 500)]
    assert [row.power for row in fit_costs(rows)] == pytest.approx([1.0, 0.5, 0.0])


def test_rings_fold_into_two_stacks():
    for columns in (3, 4, 10):
        linkage = ring(columns)
        assert linkage.n_panels == 2 * columns - 2  # two pairs are rigid
        assert np.abs(linkage.closure(linkage.folded)[0]).max() < 1e-13
    (row,) = measure_costs([10], say=silent)
    assert min(row.closure_us, row.bend_us, row.svd_us) > 0


def test_corners_are_shaken_as_one():
    unit = KnownUnit("II")
    shaken = extremes.shaken(unit.pattern, 1e-6)
    assert len(shaken.hinges) == len(unit.pattern.hinges)
    moved = np.array([c for facet in shaken.facets for c in facet])
    still = np.array([c for facet in unit.pattern.facets for c in facet])
    assert 1e-8 < np.abs(moved - still).max() < 1e-5
    assert Linkage(shaken).n_hinges == 24


def scene(error, limits=DEFAULT_PATH_LIMITS):
    unit = KnownUnit("II")
    return extremes.ExtremeScene(
        "some",
        "scene",
        unit.linkage,
        lambda: follow_path(unit.linkage, unit.linkage.folded, unit.opening(), limits=limits),
        error,
    )


def test_verdicts():
    good = extremes.judge(scene(lambda path: 1e-9))
    assert (good.verdict, good.outcome, good.rank) == ("accurate", "flat", "decided")
    assert good.bound < extremes.ACCURATE
    short = extremes.judge(scene(lambda path: 1e-9, PathLimits(max_steps=2)))
    assert (short.verdict, short.bound, short.error) == ("refused", None, None)
    assert short.reason.startswith("out of budget: 2 steps were not enough")


def test_a_scene_that_claims_more_than_is_true_is_an_error():
    with pytest.raises(HcsearchError, match=r"off by 1.0e-03 rad where it claims .*; report this"):
        extremes.judge(scene(lambda path: 1e-3))


def test_numbers_that_are_not_finite_are_an_error():
    row = SimpleNamespace(group="a", scene="b", residual=math.nan, error=None, bound=None)
    with pytest.raises(HcsearchError, match="not finite"):
        extremes._check(row, SimpleNamespace(angles=np.zeros((1, 2))))


def test_every_kind_of_extreme_gets_its_verdict():
    rows = extremes.measure_extremes(quick=True, say=silent)
    assert {row.group for row in rows} == {
        *("thickness", "base angle", "open chains", "loops"),
        *("singular start", "nearly parallel hinges", "units of length"),
    }
    assert {row.verdict for row in rows} == {"accurate", "degraded", "refused"}
    for row in rows:
        assert math.isfinite(row.residual)
        assert bool(row.reason) == (row.verdict != "accurate")
        assert row.error is None or row.error <= 10 * row.bound + extremes.ACCURATE
    verdicts = {row.scene: row.verdict for row in rows}
    assert verdicts["unit II, 1e-09 of the base"] == "refused"
    assert verdicts["unit II, 45 degrees"] == "accurate"
    assert verdicts["unit II, corners moved by 1e-06 of the base"] == "refused"


@pytest.mark.slow
def test_the_whole_bench(tmp_path):
    arguments = ["bench", "kinematics", "--quick", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    tables = {"paths", "branches", "descents", "costs", "slopes", "extremes"}
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"{name}.csv" for name in tables} | {"all.json", "kinematics.md", "machine.json", "paths.png"}
    data = json.loads((tmp_path / "all.json").read_text())
    assert set(data) == tables | {"machine"}
    assert all(row["within"] == 1 for row in data["branches"] if row["stops"] == "yes")
