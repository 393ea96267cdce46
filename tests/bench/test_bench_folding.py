import json

import pytest
from click.testing import CliRunner

from hcsearch.basics.errors import HcsearchError
from hcsearch.cli import hcsearch
from hcsearch_bench import folding
from hcsearch_bench.run.job import JobResult
from hcsearch_bench.subjects.polygons import count_polygons, join_polygons, list_polygons
from tests import golden


def silent(_):
    pass


@pytest.mark.parametrize("keep", folding.KEEPS)
@pytest.mark.parametrize("job", [join_polygons, count_polygons])
def test_jobs_find_the_designs(job, keep):
    row = job("hex", 12, keep, 1)
    assert row["designs"] == golden.FOLDABLE["hex", 12][2 + folding.KEEPS.index(keep)]
    assert row["seconds"] > 0


def test_a_way_that_is_late_is_not_tried_again(monkeypatch):
    tried = []

    def run_job(job, limit, *, n, **_):
        tried.append((job, n))
        designs = {"designs": 5, "seconds": 1.0, "runs": 1}
        return JobResult(100.0, "over 1 s", late=True) if job is list_polygons else JobResult(50.0, row=designs)

    monkeypatch.setattr(folding, "run_job", run_job)
    rows = folding.measure_folding({"hex": (10, 12)}, limit=1, repeats=1, say=silent)
    assert [(row.n, row.keep, row.filter_s, row.join_s) for row in rows] == [
        (n, keep, None, 1.0) for n in (10, 12) for keep in folding.KEEPS
    ]
    assert [n for job, n in tried if job is list_polygons] == [10]


@pytest.mark.parametrize("result", [JobResult(1.0, row={"designs": 6}), JobResult(1.0, "failed: KeyError")])
def test_wrong_numbers_and_failed_jobs_are_errors(monkeypatch, result):
    counted = JobResult(1.0, row={"designs": 5, "seconds": 1.0, "runs": 1})
    late = JobResult(1.0, "over 1 s", late=True)
    results = {list_polygons: late, join_polygons: result, count_polygons: counted}
    monkeypatch.setattr(folding, "run_job", lambda job, *_, **__: results[job])
    with pytest.raises(HcsearchError, match=r"hex n=10.*; report this"):
        folding.measure_folding({"hex": (10,)}, limit=1, repeats=1, say=silent)


@pytest.mark.slow
def test_the_whole_bench(tmp_path):
    arguments = ["bench", "folding", "--quick", "--output", str(tmp_path), "--json", str(tmp_path / "all.json")]
    assert CliRunner().invoke(hcsearch, arguments, catch_exceptions=False).exit_code == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"all.json", "folding.csv", "folding.md", "folding.png", "machine.json"}
    rows = json.loads((tmp_path / "all.json").read_text())["folding"]
    assert len(rows) == 2 * sum(map(len, folding.QUICK.values()))
    assert all(row["filter_s"] and row["join_s"] and row["count_s"] for row in rows)
