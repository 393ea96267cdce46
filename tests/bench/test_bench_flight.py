"""The bench `flight`: what passes does so by its figures, frequencies are those of MuJoCo, and it is saved."""

import pytest

from hcsearch_bench.flight.flight import FLIGHT
from hcsearch_bench.flight.passing_rows import BEST, best_rows

pytestmark = pytest.mark.extra


@pytest.fixture(scope="module")
def report():
    said = []
    return FLIGHT.run(quick=True, say=said.append), said


def test_designs_that_pass_have_the_margins_that_the_standard_asks_for(report):
    results, said = report[0].results, report[1]
    assert said == ["hex 8", "frequencies"]
    (count,) = results.counts
    assert count.designs >= count.moving >= count.with_springs >= count.clear >= count.passing
    assert count.passing == len(results.passing) == 1
    for row in results.passing:
        assert min(row.margin, row.failed) >= 7.5 * (1.0 - 1e-9)
        assert row.clearance >= 3.0
        assert 0.0 <= row.least <= row.preload


def test_the_best_have_the_highest_frequencies(report):
    (row,) = report[0].results.passing
    rows = [type(row)(**{**vars(row), "hz": float(hz)}) for hz in range(BEST + 5)]
    assert [one.hz for one in best_rows(rows)] == [float(hz) for hz in range(BEST + 4, 4, -1)]


def test_frequencies_are_those_of_mujoco(report):
    for row in report[0].results.frequencies:
        assert abs(row.ratio) < 1e-9
        assert row.others < 1e-9
        assert row.freedoms > 1


def test_it_is_saved(report, tmp_path):
    report[0].save(tmp_path)
    page = (tmp_path / "flight.md").read_text(encoding="utf-8")
    assert page.startswith("# Measured: designs that pass")
    assert (tmp_path / "flight" / "flight_passing.csv").read_text().count("\n") == 2
